// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "lodestar/math/rotation.h"

namespace lodestar::strapdown {

/// A gyro at the end of its range says the same bit for bit while the aircraft turns faster.
class SaturatedRates {
 public:
  /// Sees body rates (rad/s), `dt` (s) after the last; answers the variance (rad^2, per axis) of
  /// the rotation that they hide.
  double see(const Eigen::Vector3d& omega_B, double dt) {
    bool saturated = false;
    for (std::size_t i = 0; i < repeats_.size(); ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      const bool again = omega_B(axis) == last_B_(axis) && std::abs(omega_B(axis)) > kSlowest;
      repeats_[i] = again ? repeats_[i] + 1 : 0;
      saturated |= repeats_[i] >= kRepeats;
    }
    last_B_ = omega_B;
    return saturated ? kHiddenRate * kHiddenRate * kDuration * dt : 0.0;
  }

 private:
  static constexpr int kRepeats = 3;
  static constexpr double kSlowest = 5.0 * math::kDegree;      // rad/s; no range ends below
  static constexpr double kHiddenRate = 10.0 * math::kDegree;  // rad/s beyond the range
  static constexpr double kDuration = 1.0;                     // s that it lasts

  Eigen::Vector3d last_B_ = Eigen::Vector3d::Zero();
  std::array<int, 3> repeats_{};
};

}  // namespace lodestar::strapdown
