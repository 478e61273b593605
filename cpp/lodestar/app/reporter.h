// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "lodestar/app/event_log.h"
#include "lodestar/navigator/navigator.h"
#include "lodestar/samples/health.h"

namespace lodestar::app {

/// Turns what changed from frame to frame, and from HEALTH to HEALTH, into events.
class Reporter {
 public:
  explicit Reporter(EventLog& log) : log_(log) {}

  /// After each frame: changes of mode, and of what is thought of the INS.
  void watch(const navigator::Outputs& outputs);

  /// With each HEALTH: leaving the geomagnetic model's validity, messages rejected, and outputs not
  /// sent, since the last one.
  void watch(const samples::Health& health, std::int64_t unsent);

 private:
  EventLog& log_;
  samples::AttitudeMode sahrs_mode_ = samples::AttitudeMode::kWaiting;
  samples::FusionMode fusion_mode_ = samples::FusionMode::kWaiting;
  samples::InsState ins_state_ = samples::InsState::kNone;
  bool outside_ = false;  // the geomagnetic model's validity
  samples::Counters counters_{};
  std::int64_t unsent_ = 0;
};

}  // namespace lodestar::app
