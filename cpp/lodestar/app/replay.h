// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "lodestar/app/stop_signals.h"
#include "lodestar/navigator/navigator.h"

namespace lodestar::app {

struct Replayed {
  std::int64_t messages = 0;  // of input channels
  std::int64_t frames = 0;
  navigator::CalibrationResult calibration{};
};

/// Runs the input channels of the LCM log `input`, in the order of the file, through a session and
/// writes what it sends to the LCM log `output`. An output carries the time stamp of the message
/// that made its frame, so the two logs merge by time stamp. The same input, configuration and
/// build give the same bytes.
///
/// Throws bus::LogError, before `output` is touched, if `input` is damaged or has no EFCS.RATES.
/// A signal ends it early, with what was done until then in `output`.
Replayed replay(const navigator::Config& config, const std::string& input,
                const std::string& output, const StopSignals& stop);

}  // namespace lodestar::app
