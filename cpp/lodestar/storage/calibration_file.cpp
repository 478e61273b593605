// SPDX-License-Identifier: Apache-2.0
#include "lodestar/storage/calibration_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <variant>

namespace lodestar::storage {
namespace {

using sahrs::smdu::Record;
using sahrs::smdu::Refusal;

std::string previous_of(const std::string& path) { return path + ".previous"; }

std::string complaint(const std::string& path, Refusal refusal, const std::string& airframe) {
  std::string text = path + ": " + name(refusal);
  if (refusal == Refusal::kAirframe) text += " than '" + airframe + "'";
  return text;
}

}  // namespace

LoadedCalibration load_calibration(const std::string& path, const std::string& airframe) {
  LoadedCalibration loaded;
  std::string reason;
  bool there = false;
  for (const std::string& candidate : {path, previous_of(path)}) {
    const std::optional<std::string> bytes = read_file(candidate);
    if (!bytes) {
      if (reason.empty()) reason = candidate + ": missing";
      continue;
    }
    there = true;
    auto decoded = sahrs::smdu::decode(*bytes, airframe);
    if (const Refusal* refusal = std::get_if<Refusal>(&decoded)) {
      const std::string one = complaint(candidate, *refusal, airframe);
      reason = candidate == path ? one : reason + "; " + one;
      continue;
    }
    loaded.record = std::get<Record>(std::move(decoded));
    if (candidate != path) loaded.note = reason + "; the previous one is used, " + candidate;
    return loaded;
  }
  if (there) throw StorageError(reason);
  loaded.note = path + ": not there yet; the SMDU is not calibrated in this flight";
  return loaded;
}

void store_calibration(const std::string& path, const Record& record) {
  if (const std::optional<std::string> old = read_file(path)) {
    if (std::holds_alternative<Record>(sahrs::smdu::decode(*old, record.airframe))) {
      replace_file(previous_of(path), *old);
    } else if (std::rename(path.c_str(), (path + ".refused").c_str()) != 0) {
      throw StorageError("cannot move " + path + " aside: " + std::strerror(errno));
    }
  }
  replace_file(path, sahrs::smdu::encode(record));
}

void require_writable(const std::string& path) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw StorageError("cannot store a calibration in " + folder + ": " + std::strerror(errno));
  }
}

bool looks_like_calibration(const std::string& bytes) {
  return bytes.find('\0') != std::string::npos ||
         bytes.compare(0, sahrs::smdu::kRecordMagic.size(), sahrs::smdu::kRecordMagic) == 0;
}

}  // namespace lodestar::storage
