// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace lodestar::strapdown {

/// How fast the wind changes, learnt from the innovations of the air data. What a change of wind
/// leaves in them is not large at any moment but of one sign for seconds, as no noise and no gust
/// is. While the mean of a second is larger than white innovations have it the level rises, while
/// it is smaller it falls.
class WindLevel {
 public:
  static constexpr int kRows = 3;  // airspeed, alpha, beta

  /// `walk` at the start and its bounds (m/s/sqrt(s)); `adaptation` (s): time to change it e-fold
  /// when the mean's variance is three times what is expected.
  WindLevel(double walk, double walk_min, double walk_max, double adaptation)
      : log_density_(2.0 * std::log(std::clamp(walk, walk_min, walk_max))),
        log_min_(2.0 * std::log(walk_min)),
        log_max_(2.0 * std::log(walk_max)),
        adaptation_(adaptation) {}

  /// Innovations over their standard deviations, `dt` (s) after the last ones; 0 for a row that is
  /// not to be heard.
  void learn(const std::array<double, kRows>& normalised, double dt) {
    const double weight = dt / (kMemory + dt);
    const double white_variance = weight / (2.0 - weight);
    double sum = 0.0;
    for (std::size_t row = 0; row < normalised.size(); ++row) {
      mean_[row] += weight * (normalised[row] - mean_[row]);
      sum += mean_[row] * mean_[row];
    }
    const double surprise = std::min(sum / (kRows * white_variance), kLargest) - 1.0;
    log_density_ = std::clamp(log_density_ + dt / adaptation_ * surprise, log_min_, log_max_);
  }

  double walk() const { return std::exp(0.5 * log_density_); }

 private:
  static constexpr double kMemory = 1.0;    // s
  static constexpr double kLargest = 30.0;  // from calm to a squall in a second

  double log_density_;
  double log_min_;
  double log_max_;
  double adaptation_;
  std::array<double, kRows> mean_{};
};

}  // namespace lodestar::strapdown
