// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/reporter.h"

namespace lodestar::app {

void Reporter::watch(const navigator::Outputs& outputs) {
  const std::int64_t time_us = outputs.sahrs.time_us;
  if (outputs.sahrs.mode != sahrs_mode_) {
    sahrs_mode_ = outputs.sahrs.mode;
    log_.note({Event::Kind::kSahrsMode, time_us, static_cast<std::uint8_t>(sahrs_mode_), 0, 0});
  }
  if (outputs.nav.mode != fusion_mode_) {
    fusion_mode_ = outputs.nav.mode;
    log_.note({Event::Kind::kFusionMode, time_us, static_cast<std::uint8_t>(fusion_mode_), 0, 0});
  }
  // In doubt it may change with every solution; the log hears the verdict.
  const samples::InsState ins_state = outputs.ins_monitor.state;
  if (ins_state != ins_state_ && ins_state != samples::InsState::kSuspect) {
    ins_state_ = ins_state;
    log_.note({Event::Kind::kInsState, time_us, static_cast<std::uint8_t>(ins_state), 0, 0});
  }
}

void Reporter::watch(const samples::Health& health, std::int64_t unsent) {
  const bool outside = (health.warning & samples::kWarningFieldModel) != 0;
  if (outside && !outside_) log_.note({Event::Kind::kFieldModel, health.time_us, 0, 0, 0});
  outside_ = outside;
  for (std::uint8_t channel = 0; channel < samples::kChannels; ++channel) {
    for (std::uint8_t reason = 0; reason < samples::kReasons; ++reason) {
      const std::int64_t count = health.counters[channel].rejected[reason];
      const std::int64_t more = count - counters_[channel].rejected[reason];
      if (more > 0) {
        log_.note({Event::Kind::kRejected, health.time_us, channel, reason, more});
      }
    }
  }
  counters_ = health.counters;
  if (unsent > unsent_) {
    log_.note({Event::Kind::kUnsent, health.time_us, 0, 0, unsent - unsent_});
    unsent_ = unsent;
  }
}

}  // namespace lodestar::app
