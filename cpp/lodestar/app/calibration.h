// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "lodestar/navigator/navigator.h"

namespace lodestar::app {

/// Puts the calibration in the file `path` in the place of the configuration's: one that an earlier
/// flight or a ground swing has stored, or a text (TOML) with a section [smdu_calibration]. Nothing
/// changes if there is no file yet, which is logged, and if `path` is empty. Throws
/// std::runtime_error, in one line, if the file is refused and there is no good previous one, or
/// if nothing could be stored there later.
void use_calibration(navigator::Config& config, const std::string& path);

/// At the end of a flight: stores its calibration in `path` if the verdict is good, and logs the
/// verdict. A text is a person's own and stays as it is. Throws storage::StorageError.
void keep_calibration(const navigator::CalibrationResult& result, const std::string& path);

}  // namespace lodestar::app
