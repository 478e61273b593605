// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

#include "lodestar/fusion/fix_line.h"

namespace lodestar::fusion {

/// White noise of GPS positions, measured on the fixes themselves: what a receiver states is mostly
/// its slow error, and a filter that takes one for the other either trusts noise or wastes fixes.
/// The estimate starts at what the receiver states and stays between that and a floor.
class FixNoise {
 public:
  explicit FixNoise(double floor_sigma) : floor_(floor_sigma * floor_sigma) {}

  /// Variance (m^2, per axis) of the noise of a fix of which the receiver states `stated_sigma`
  /// (m).
  double variance(double stated_sigma) const {
    const double most = std::max(floor_, stated_sigma * stated_sigma);
    return weight_ == 0 ? most : std::clamp(mean_, floor_, most);
  }

  /// A fix that was used, by its `offset` (m, north, east) from dead reckoning.
  void add(std::int64_t time_us, const Eigen::Vector2d& offset, double stated_sigma) {
    if (weight_ == 0) {
      mean_ = variance(stated_sigma);
      weight_ = kFirstWeight;
    }
    if (line_.size() == 2 && line_.continues(time_us)) {
      const FixLine::Residual residual = line_.residual(time_us, offset);
      const double seen = 0.5 * residual.value.squaredNorm() / residual.noise_gain;
      weight_ = std::min(weight_ + 1, kLongestWeight);
      mean_ += (std::min(seen, kLargest * mean_) - mean_) / weight_;
    }
    line_.push(time_us, offset);
  }

 private:
  static constexpr int kFirstWeight = 4;     // residuals that the receiver's word is worth
  static constexpr int kLongestWeight = 60;  // residuals
  static constexpr double kLargest = 25.0;   // a residual counts up to this, in units of the mean

  double floor_;
  double mean_ = 0.0;
  int weight_ = 0;
  FixLine line_;
};

}  // namespace lodestar::fusion
