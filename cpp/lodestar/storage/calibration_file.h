// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "lodestar/sahrs/calibration_record.h"
#include "lodestar/storage/atomic_file.h"

namespace lodestar::storage {

/// What a calibration file and the one before it came to.
struct LoadedCalibration {
  std::optional<sahrs::smdu::Record> record;  // nothing: there is none yet
  std::string note;                           // a line for a person; empty if all is well
};

/// The calibration of `airframe` in `path`, or in `path`.previous if `path` is missing or refused,
/// with a note that says so. Throws StorageError, with the reason, if `path` is there but neither
/// will do.
LoadedCalibration load_calibration(const std::string& path, const std::string& airframe);

/// Stores `record` in `path`. A good file there becomes `path`.previous first, one that is refused
/// is moved to `path`.refused: it never takes the place of a good one. At any moment `path` or
/// `path`.previous is whole. Throws StorageError.
void store_calibration(const std::string& path, const sahrs::smdu::Record& record);

/// Throws StorageError if store_calibration could not write to the folder of `path`.
void require_writable(const std::string& path);

/// Whether `bytes` begin as a calibration file does, and are no text.
bool looks_like_calibration(const std::string& bytes);

}  // namespace lodestar::storage
