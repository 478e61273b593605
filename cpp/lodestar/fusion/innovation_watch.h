// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace lodestar::fusion {

/// Notices that a filter or what it is told is wrong. Innovations of a filter that is right are
/// white; those of one whose wind has changed, or whose receiver is dragged off, all point the same
/// way. So their mean over some seconds tells it long before one of them is beyond the gate.
class InnovationWatch {
 public:
  /// `threshold` of the mean (chi-square, 2 degrees of freedom), `memory` (s) of the mean.
  InnovationWatch(double threshold, double memory) : threshold_(threshold), memory_(memory) {}

  void restart() {
    mean_.setZero();
    variance_ = 0.0;
  }

  /// The next innovation in units of its own standard deviation, `dt` (s) after the last. True if
  /// the mean is beyond the threshold; the watch then starts anew.
  bool alarms(const Eigen::Vector2d& normalised, double dt) {
    const double keep = std::exp(-dt / memory_);
    mean_ = keep * mean_ + (1.0 - keep) * normalised;
    variance_ = keep * keep * variance_ + (1.0 - keep) * (1.0 - keep);
    if (mean_.squaredNorm() <= threshold_ * variance_) return false;
    restart();
    return true;
  }

 private:
  double threshold_;
  double memory_;
  double variance_ = 0.0;  // of the mean, if the innovations are white
  Eigen::Vector2d mean_ = Eigen::Vector2d::Zero();
};

}  // namespace lodestar::fusion
