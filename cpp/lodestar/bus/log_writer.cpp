// SPDX-License-Identifier: Apache-2.0
#include "lodestar/bus/log_writer.h"

#include <array>
#include <cerrno>
#include <cstring>

namespace lodestar::bus {
namespace {

constexpr std::size_t kBufferSize = 1 << 18;

std::uint8_t* put_word(std::uint8_t* out, std::uint32_t word) {
  for (int shift = 24; shift >= 0; shift -= 8) *out++ = static_cast<std::uint8_t>(word >> shift);
  return out;
}

std::uint8_t* put_long(std::uint8_t* out, std::uint64_t value) {
  return put_word(put_word(out, static_cast<std::uint32_t>(value >> 32)),
                  static_cast<std::uint32_t>(value));
}

}  // namespace

LogWriter::LogWriter(const std::string& path) : path_(path) {
  file_.reset(std::fopen(path.c_str(), "wb"));
  if (!file_) fail();
  std::setvbuf(file_.get(), nullptr, _IOFBF, kBufferSize);
}

void LogWriter::write(std::int64_t timestamp_us, std::string_view channel, const void* data,
                      std::size_t size) {
  std::array<std::uint8_t, 28> header;
  std::uint8_t* out = put_word(header.data(), kLogSync);
  out = put_long(out, count_++);
  out = put_long(out, static_cast<std::uint64_t>(timestamp_us));
  out = put_word(out, static_cast<std::uint32_t>(channel.size()));
  put_word(out, static_cast<std::uint32_t>(size));
  std::FILE* file = file_.get();
  if (std::fwrite(header.data(), header.size(), 1, file) != 1 ||
      std::fwrite(channel.data(), 1, channel.size(), file) != channel.size() ||
      std::fwrite(data, 1, size, file) != size) {
    fail();
  }
}

void LogWriter::close() {
  if (std::fclose(file_.release()) != 0) fail();
}

void LogWriter::fail() const {
  throw LogError("cannot write " + path_ + ": " + std::strerror(errno));
}

}  // namespace lodestar::bus
