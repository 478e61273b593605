// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "lodestar/fusion/fix_line.h"
#include "lodestar/math/scalar.h"

namespace lodestar::fusion {

/// Examines fixes that the filter may not take as they come: after an outage, or beyond the gate.
/// Fixes that agree among themselves for long enough, on one line as seen from the coasting filter,
/// are believed whatever the filter says, so that a wrong filter can not lock GPS out; fixes that
/// scatter are not.
class Reacquisition {
 public:
  /// `duration`: seconds of agreement that it takes.
  explicit Reacquisition(double duration) : duration_(duration) {}

  bool running() const { return count_ > 0; }
  void cancel() { count_ = 0; }

  /// Takes the next fix by its `offset` (m, north, east) from the filter; one fix alone is known to
  /// `sigma` (m, per axis). True once the fixes are to be believed.
  bool examine(std::int64_t time_us, const Eigen::Vector2d& offset, double sigma) {
    if (count_ > 0 && agrees(time_us, offset, sigma)) {
      ++count_;
    } else {
      line_.restart();
      count_ = 1;
      first_time_us_ = time_us;
      first_offset_ = offset;
    }
    line_.push(time_us, offset);
    drift_.setZero();
    const double span = math::seconds(time_us - first_time_us_);
    if (span > 0.0) drift_ = (offset - first_offset_) / span;
    return count_ >= kFewest && span >= duration_;
  }

  /// Velocity (m/s) at which the examined fixes leave the filter.
  const Eigen::Vector2d& drift() const { return drift_; }

  /// The fixes under examination stopped coming.
  bool stale(std::int64_t now_us) const {
    return running() &&
           static_cast<double>(now_us - line_.time_us()) > 1e6 * FixLine::kLongestPause;
  }

 private:
  static constexpr int kFewest = 3;
  static constexpr double kTolerance = 5.0;  // sigma

  bool agrees(std::int64_t time_us, const Eigen::Vector2d& offset, double sigma) const {
    if (!line_.continues(time_us)) return false;
    if (line_.size() < 2) return true;  // any two make a line
    const FixLine::Residual residual = line_.residual(time_us, offset);
    return residual.value.norm() <= kTolerance * sigma * std::sqrt(residual.noise_gain);
  }

  double duration_;
  int count_ = 0;
  std::int64_t first_time_us_ = 0;
  Eigen::Vector2d first_offset_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d drift_ = Eigen::Vector2d::Zero();
  FixLine line_;
};

}  // namespace lodestar::fusion
