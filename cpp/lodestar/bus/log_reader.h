// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace lodestar::bus {

/// A log that cannot be read or written: one line with the file, the place and what is wrong.
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// First word of every event of an LCM log.
inline constexpr std::uint32_t kLogSync = 0xEDA1DA01;

/// One recorded message. `channel` and `data` hold until the next read.
struct LogEvent {
  std::int64_t timestamp_us = 0;  // of its arrival, as the recorder saw it
  std::string_view channel;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

/// Reads an LCM event log and believes none of it. LCM's own reader looks for the next sync word
/// when it is lost and takes a torn end for the end of the file; here either is an error.
class LogReader {
 public:
  /// Throws LogError if the file cannot be opened or is empty.
  explicit LogReader(const std::string& path);

  /// False at the end of the file. Throws LogError, with the offset, on anything that is not a
  /// whole event.
  bool next(LogEvent& event);

  /// Back to the first event.
  void rewind();

 private:
  void read(void* into, std::size_t size);
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  File file_;
  std::uint64_t size_ = 0;         // bytes
  std::uint64_t offset_ = 0;       // of the next byte
  std::uint64_t event_start_ = 0;  // offset of the current event
  std::string channel_;
  std::vector<std::uint8_t> data_;
};

}  // namespace lodestar::bus
