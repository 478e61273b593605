// SPDX-License-Identifier: Apache-2.0
#include "lodestar/bus/log_reader.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace lodestar::bus {
namespace {

constexpr std::uint32_t kLongestChannel = 63;  // LCM sends no longer name
constexpr std::size_t kBufferSize = 1 << 18;
constexpr std::size_t kHeaderSize = 28;

std::uint32_t word_at(const std::array<std::uint8_t, kHeaderSize>& header, std::size_t offset) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | header[offset + i];
  return word;
}

}  // namespace

LogReader::LogReader(const std::string& path) : path_(path) {
  file_.reset(std::fopen(path.c_str(), "rb"));
  struct stat status{};
  if (!file_ || fstat(fileno(file_.get()), &status) != 0) {
    throw LogError("cannot read " + path + ": " + std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode)) throw LogError("cannot read " + path + ": not a regular file");
  if (status.st_size == 0) throw LogError(path + ": not an LCM log: the file is empty");
  size_ = static_cast<std::uint64_t>(status.st_size);
  std::setvbuf(file_.get(), nullptr, _IOFBF, kBufferSize);
}

bool LogReader::next(LogEvent& event) {
  event_start_ = offset_;
  if (offset_ == size_) return false;
  const std::size_t known = std::min<std::uint64_t>(kHeaderSize, size_ - offset_);
  std::array<std::uint8_t, kHeaderSize> header{};
  read(header.data(), known);
  if (known >= 4 && word_at(header, 0) != kLogSync) fail("not an LCM log: no event starts here");
  if (known < kHeaderSize) fail("truncated");
  // The event's number, 8 bytes, only counts.
  event.timestamp_us =
      static_cast<std::int64_t>(std::uint64_t{word_at(header, 12)} << 32 | word_at(header, 16));
  const std::uint32_t channel_size = word_at(header, 20);
  const std::uint32_t data_size = word_at(header, 24);
  if (channel_size == 0 || channel_size > kLongestChannel) {
    fail("not an LCM log: a channel name of " + std::to_string(channel_size) + " bytes");
  }
  // Before any memory is asked for: a forged length must not be able to exhaust it.
  if (channel_size + std::uint64_t{data_size} > size_ - offset_) fail("truncated");
  channel_.resize(channel_size);
  read(channel_.data(), channel_size);
  data_.resize(data_size);
  read(data_.data(), data_size);
  event.channel = channel_;
  event.data = data_.data();
  event.size = data_size;
  return true;
}

void LogReader::rewind() {
  std::rewind(file_.get());
  offset_ = 0;
}

void LogReader::read(void* into, std::size_t size) {
  if (std::fread(into, 1, size, file_.get()) != size) fail("truncated");
  offset_ += size;
}

void LogReader::fail(const std::string& what) const {
  throw LogError(path_ + ": " + what + " (event at byte " + std::to_string(event_start_) + " of " +
                 std::to_string(size_) + ")");
}

}  // namespace lodestar::bus
