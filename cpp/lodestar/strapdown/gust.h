// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "lodestar/math/gauss_markov.h"

namespace lodestar::strapdown {

/// How strong the gusts are, learnt from the innovations of the air data: while these are larger
/// than the filter expects the level rises, while they are smaller it falls. In calm air a level
/// that stays high would waste the airspeed and the vanes, in turbulence one that stays low would
/// bend attitude after every gust.
class GustLevel {
 public:
  /// `sigma` at the start and its bounds (m/s); `adaptation` (s): time to change it e-fold when the
  /// innovations' variance is twice what is expected.
  GustLevel(double sigma, double sigma_min, double sigma_max, double adaptation)
      : log_variance_(2.0 * std::log(std::clamp(sigma, sigma_min, sigma_max))),
        log_min_(2.0 * std::log(sigma_min)),
        log_max_(2.0 * std::log(sigma_max)),
        adaptation_(adaptation) {}

  /// `normalised_square`: mean over the rows of innovation squared over expected variance; `dt` (s)
  /// since the last one. In `still` air the level falls where innovations hardly tell it.
  void learn(double normalised_square, double dt, bool still = false) {
    const double surprise = std::min(normalised_square, kLargest) - (still ? kStill : 1.0);
    log_variance_ = std::clamp(log_variance_ + dt / adaptation_ * surprise, log_min_, log_max_);
  }

  /// The level is `sigma` (m/s), within its bounds.
  void set(double sigma) { log_variance_ = std::clamp(2.0 * std::log(sigma), log_min_, log_max_); }

  double sigma() const { return std::exp(0.5 * log_variance_); }

 private:
  static constexpr double kStill = 1.03;    // of what is expected, and the level stays
  static constexpr double kLargest = 10.0;  // one outlier is not a storm

  double log_variance_;
  double log_min_;
  double log_max_;
  double adaptation_;
};

}  // namespace lodestar::strapdown
