// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

#include "lodestar/bus/codec.h"
#include "lodestar/samples/validity.h"
#include "wire_samples.h"

// Decodes whatever it is given: byte 0 chooses the channel, the rest is the message. Beyond what a
// sanitizer sees, it stops on a message that was taken but differs in size or fingerprint from a
// good one of its channel.

namespace {

using lodestar::bus::Bytes;
using lodestar::samples::Channel;
using lodestar::samples::Reason;

[[noreturn]] void stop(const char* what) {
  std::fprintf(stderr, "fuzz_codec: %s\n", what);
  std::abort();
}

const Bytes& good_message(Channel channel) {
  static const std::vector<Bytes> messages = [] {
    std::vector<Bytes> all;
    for (const Channel each : lodestar::bus::all_channels()) {
      all.push_back(lodestar::bus::wire_message(each));
    }
    return all;
  }();
  return messages[static_cast<std::size_t>(channel)];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto channel = static_cast<Channel>(data[0] % lodestar::samples::kChannels);
  // A copy of exactly that size: a read beyond it is seen by the address sanitizer.
  const Bytes message(data + 1, data + size);
  const auto decoded = lodestar::bus::decode(channel, message.data(), message.size());
  if (decoded.index() != 0) {
    const Bytes& good = good_message(channel);
    if (decoded.index() != static_cast<std::size_t>(channel) + 1) stop("sample of another channel");
    if (message.size() != good.size()) stop("took a message of the wrong size");
    if (std::memcmp(message.data(), good.data(), 8) != 0) stop("took a foreign fingerprint");
  }
  std::visit(
      [](const auto& sample) {
        if constexpr (!std::is_same_v<decltype(sample), const Reason&>) {
          (void)lodestar::samples::refusal(sample);
        }
      },
      decoded);
  return 0;
}
