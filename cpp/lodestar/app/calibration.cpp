// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/calibration.h"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <optional>

#include "lodestar/storage/calibration_file.h"

namespace lodestar::app {
namespace {

std::optional<std::string> text_of(const std::string& path) {
  std::optional<std::string> bytes = storage::read_file(path);
  if (bytes && storage::looks_like_calibration(*bytes)) bytes.reset();
  return bytes;
}

}  // namespace

void use_calibration(navigator::Config& config, const std::string& path) {
  if (path.empty()) return;
  if (const std::optional<std::string> text = text_of(path)) {
    navigator::apply_calibration(config, *text, path);
    return;
  }
  if (std::filesystem::path(path).extension() == ".toml") {  // never one that we write
    throw storage::StorageError("cannot read " + path + ": No such file or directory");
  }
  storage::require_writable(path);
  const storage::LoadedCalibration loaded = storage::load_calibration(path, config.airframe.id);
  if (!loaded.note.empty()) spdlog::warn("{}", loaded.note);
  if (loaded.record) navigator::apply_calibration(config, *loaded.record);
}

void keep_calibration(const navigator::CalibrationResult& result, const std::string& path) {
  if (path.empty() || text_of(path)) return;
  const sahrs::smdu::Checks& c = result.checks;
  const bool good = result.verdict == sahrs::smdu::Verdict::kGood;
  if (good) storage::store_calibration(path, result.record);
  spdlog::info(
      "SMDU calibration: {}, {} ({:.0f} s, gated {:.4f}, residual {:.3f}, correlation {:.3f}, "
      "observability {:.3g})",
      name(result.verdict), good ? "stored in " + path : "not stored", c.duration, c.gated,
      c.residual, c.correlation, c.observability);
}

}  // namespace lodestar::app
