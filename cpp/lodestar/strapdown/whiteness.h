// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace lodestar::strapdown {

/// Whether innovations are white, by their mean over a while: what a change of wind leaves in them
/// is not large at any moment but of one sign for seconds, as no noise and no gust is.
template <std::size_t Rows>
class Whiteness {
 public:
  /// `memory` (s) of the mean.
  explicit Whiteness(double memory) : memory_(memory) {}

  /// Square of the mean over what it is for white noise: 1 on average if all is well, and then
  /// chi-square with `Rows` degrees of freedom over `Rows`. `normalised`: innovations over their
  /// standard deviations, `dt` (s) after the last ones; 0 where no time has passed.
  double see(const std::array<double, Rows>& normalised, double dt) {
    const double weight = dt / (memory_ + dt);
    if (!(weight > 0.0)) return 0.0;
    const double white_variance = weight / (2.0 - weight);
    double sum = 0.0;
    for (std::size_t row = 0; row < Rows; ++row) {
      mean_[row] += weight * (normalised[row] - mean_[row]);
      sum += mean_[row] * mean_[row];
    }
    return sum / (Rows * white_variance);
  }

 private:
  double memory_;
  std::array<double, Rows> mean_{};
};

}  // namespace lodestar::strapdown
