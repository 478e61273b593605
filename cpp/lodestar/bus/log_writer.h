// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "lodestar/bus/log_reader.h"

namespace lodestar::bus {

/// Writes an LCM event log. Throws LogError, with the file's name, when the file cannot be opened
/// or the disk is full.
class LogWriter {
 public:
  explicit LogWriter(const std::string& path);

  void write(std::int64_t timestamp_us, std::string_view channel, const void* data,
             std::size_t size);

  /// Everything is on its way to the disk when this returns. No write may follow.
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  File file_;
  std::uint64_t count_ = 0;
};

}  // namespace lodestar::bus
