// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace lodestar::storage {

/// A file that cannot be read or written: one line with its path and what is wrong.
class StorageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// All of a file, or nothing if there is none. Throws StorageError if it is there and cannot be
/// read.
std::optional<std::string> read_file(const std::string& path);

/// Makes `bytes` the content of the file `path`, all or nothing: at whatever moment the process or
/// the power ends, the file is the old one or the new one, and once this returns it is the new one.
/// (A temporary file `path`.part in the same folder, fsync, rename, fsync of the folder.) Throws
/// StorageError; the old file is as it was then.
void replace_file(const std::string& path, std::string_view bytes);

}  // namespace lodestar::storage
