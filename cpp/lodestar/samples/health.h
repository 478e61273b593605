// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "lodestar/samples/counters.h"
#include "lodestar/samples/outputs.h"

namespace lodestar::samples {

enum class SensorState : std::int8_t { kNeverSeen = 0, kGood = 1, kStale = 2, kStuck = 3 };

/// Bits of Health::warning.
inline constexpr std::int8_t kWarningFieldModel = 1;  // outside the geomagnetic model's validity
inline constexpr std::int8_t kWarningRealtime = 2;    // realtime scheduling was refused

/// Time that frames took, filled by the live shell; zero in replay, which reads no clock.
struct CycleTimes {
  double mean = 0.0;                         // s, of the last second
  double p99 = 0.0;                          // s
  double max = 0.0;                          // s
  std::array<std::int64_t, 16> histogram{};  // frames since start of [2^k, 2^(k+1)) us
};

/// HEALTH: see lcm_types/health_t.lcm.
struct Health {
  static constexpr int kAssumptions = 10;
  static constexpr int kInnovations = 10;
  std::int64_t time_us = 0;
  Counters counters{};
  std::array<SensorState, kChannels> sensor_state{};
  CycleTimes cycle{};
  SahrsForm sahrs_form = SahrsForm::kVelocity;
  AttitudeMode sahrs_mode = AttitudeMode::kWaiting;
  FusionFilter fusion_filter = FusionFilter::kIntegrated;
  FusionMode fusion_mode = FusionMode::kWaiting;
  AttitudeMode ahrs_mode = AttitudeMode::kWaiting;
  std::array<std::int64_t, kAssumptions> assumption_rejects{};
  std::array<double, kInnovations> innovation{};        // see lcm_types/health_t.lcm
  std::array<double, kInnovations> innovation_sigma{};  // same units
  std::int64_t calibration_id = 0;
  std::int64_t config_hash = 0;
  std::int64_t log_dropped = 0;
  std::int8_t warning = 0;
  std::array<char, 16> build_version{};
};

}  // namespace lodestar::samples
