// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lodestar/strapdown/whiteness.h"

namespace lodestar::strapdown {

/// How fast the wind changes, learnt from the innovations of the air data: a level that stays, and
/// what is above it while the wind steps.
///
/// The level that stays follows the sign of what it sees, by a small step each time, so that it is
/// hardly moved by a step of wind, however large, and in living air does not come and go with its
/// own noise: a level that does is too low half of the time, and attitude then follows the wind.
class WindLevel {
 public:
  static constexpr std::size_t kRows = 3;  // airspeed, alpha, beta

  /// `walk` at the start and its bounds (m/s/sqrt(s)); `adaptation` (s): in which a step dies away
  /// e-fold; `base_adaptation` (s): in which the level that stays can change e-fold.
  WindLevel(double walk, double walk_min, double walk_max, double adaptation,
            double base_adaptation)
      : log_min_(2.0 * std::log(walk_min)),
        log_max_(2.0 * std::log(walk_max)),
        log_base_(log_min_),
        log_density_(2.0 * std::log(std::clamp(walk, walk_min, walk_max))),
        start_(std::exp(log_density_)),
        adaptation_(adaptation),
        base_adaptation_(base_adaptation) {}

  /// Innovations over their standard deviations, `dt` (s) after the last ones; 0 for a row that is
  /// not to be heard. In `still` air the level that stays falls, whatever they say.
  void learn(const std::array<double, kRows>& normalised, double dt, bool still = false) {
    const double lasting = lasting_.see(normalised, dt) > kMedian && !still ? 1.0 : -1.0;
    log_base_ = std::clamp(log_base_ + dt / base_adaptation_ * lasting, log_min_, log_max_);
    const double now = std::min(sudden_.see(normalised, dt), kLargest);
    const double surprise = kRise * std::max(now - kStep, 0.0) + std::min(now - 1.0, 0.0);
    log_density_ = std::clamp(log_density_ + dt / adaptation_ * surprise, log_base_, log_max_);
  }

  /// The level that stays is no less than `walk` (m/s/sqrt(s)) now.
  void raise(double walk) {
    log_base_ = std::clamp(2.0 * std::log(walk), log_base_, log_max_);
    log_density_ = std::max(log_density_, log_base_);
  }

  /// There is no more than the level that stays.
  void settle() { log_density_ = log_base_; }

  double walk() const { return std::exp(0.5 * log_density_); }
  /// What of it is a step of wind: what is above the level of the start, and far above the one that
  /// lasts.
  double step() const {
    constexpr double kFar = 3.0;
    const double lasting = std::max(kFar * kFar * std::exp(log_base_), start_);
    return std::sqrt(std::max(std::exp(log_density_) - lasting, 0.0));
  }

 private:
  static constexpr double kStep = 3.0;      // from where on it is a step: white noise is rarely
  static constexpr double kRise = 3.0;      // faster than a step dies away
  static constexpr double kLargest = 30.0;  // from calm to a squall in a second

  static constexpr double kMedian = 0.789;  // of chi-square with three degrees of freedom, over 3

  Whiteness<kRows> sudden_{1.0};
  Whiteness<kRows> lasting_{10.0};
  double log_min_;
  double log_max_;
  double log_base_;
  double log_density_;
  double start_;  // m^2/s^3
  double adaptation_;
  double base_adaptation_;
};

}  // namespace lodestar::strapdown
