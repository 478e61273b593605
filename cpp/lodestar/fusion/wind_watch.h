// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace lodestar::fusion {

/// Notices that the wind has changed. Innovations of a filter that is right are white; those of one
/// whose wind is wrong all point the same way. So their mean over a few seconds tells a change of
/// wind long before one of them is beyond the gate, and the steady level of the wind's process
/// noise can stay that of steady wind.
class WindWatch {
 public:
  explicit WindWatch(double threshold) : threshold_(threshold) {}

  void restart() {
    mean_.setZero();
    variance_ = 0.0;
  }

  /// The next innovation in units of its own standard deviation, `dt` (s) after the last. True if
  /// the mean is beyond the threshold (chi-square, 2 degrees of freedom); the watch then starts
  /// anew.
  bool changed(const Eigen::Vector2d& normalised, double dt) {
    const double keep = std::exp(-dt / kMemory);
    mean_ = keep * mean_ + (1.0 - keep) * normalised;
    variance_ = keep * keep * variance_ + (1.0 - keep) * (1.0 - keep);
    if (mean_.squaredNorm() <= threshold_ * variance_) return false;
    restart();
    return true;
  }

 private:
  static constexpr double kMemory = 3.0;  // s

  double threshold_;
  double variance_ = 0.0;  // of the mean, if the innovations are white
  Eigen::Vector2d mean_ = Eigen::Vector2d::Zero();
};

}  // namespace lodestar::fusion
