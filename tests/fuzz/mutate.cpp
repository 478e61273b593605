// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "wire_samples.h"

// fuzz_codec [COUNT [SEED]]: hands COUNT mutated messages to the decode target; the same ones each
// time.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using lodestar::bus::Bytes;

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  /// Channel byte and message, with up to six mutations.
  Bytes next() {
    const auto channel =
        static_cast<lodestar::samples::Channel>(below(lodestar::samples::kChannels));
    Bytes input = lodestar::bus::wire_message(channel);
    // Now and then on a channel of another type.
    const std::size_t heard_on = below(8) == 0 ? below(256) : static_cast<std::size_t>(channel);
    input.insert(input.begin(), static_cast<std::uint8_t>(heard_on));
    for (std::size_t mutations = below(7); mutations > 0; --mutations) mutate(input);
    return input;
  }

 private:
  std::size_t below(std::size_t limit) { return random_() % limit; }

  void mutate(Bytes& input) {
    if (input.empty()) return;
    const std::size_t at = below(input.size());
    const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
    switch (below(6)) {
      case 0:
        input[at] ^= static_cast<std::uint8_t>(1u << below(8));
        break;
      case 1:
        input[at] = static_cast<std::uint8_t>(random_());
        break;
      case 2:
        input.resize(at);
        break;
      case 3:
        input.insert(place, below(64), static_cast<std::uint8_t>(random_()));
        break;
      case 4:
        input.erase(place,
                    input.begin() + static_cast<std::ptrdiff_t>(
                                        at + below(std::min<std::size_t>(16, input.size() - at))));
        break;
      default:
        write_extreme(input, at);
    }
  }

  /// Eight bytes that are NaN, infinity, the largest and the smallest numbers.
  void write_extreme(Bytes& input, std::size_t at) {
    static constexpr std::array<std::uint64_t, 8> kExtremes = {
        0x7FF8000000000000, 0x7FF0000000000001, 0x7FF0000000000000, 0xFFF0000000000000,
        0x7FFFFFFFFFFFFFFF, 0x8000000000000000, 0x0000000000000001, 0xFFFFFFFFFFFFFFFF};
    const std::uint64_t value = kExtremes[below(kExtremes.size())];
    for (std::size_t i = 0; i < 8 && at + i < input.size(); ++i) {
      input[at + i] = static_cast<std::uint8_t>(value >> (56 - 8 * i));
    }
  }

  std::mt19937_64 random_;
};

}  // namespace

int main(int argc, char** argv) {
  const long count = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 200'000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  Mutator mutator(seed);
  for (long i = 0; i < count; ++i) {
    const Bytes input = mutator.next();
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("fuzz_codec: %ld messages decoded or refused\n", count);
  return 0;
}
