// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/reacquisition.h"

namespace lodestar::fusion {
namespace {

double seconds(std::int64_t microseconds) { return 1e-6 * static_cast<double>(microseconds); }

}  // namespace

bool Reacquisition::agrees(double dt, const Eigen::Vector2d& offset, double sigma) const {
  if (count_ == 0 || dt <= 0.0 || dt > kLongestPause) return false;
  if (count_ == 1) return (offset - offset_).norm() <= kTolerance * 1.5 * sigma + speed_ * dt;
  // On the line through the last two: noise of three fixes, two of them stretched.
  const double stretch = 1.0 + dt / spacing_;
  return (offset - offset_ - slope_ * dt).norm() <= kTolerance * 1.5 * sigma * stretch;
}

bool Reacquisition::examine(std::int64_t time_us, const Eigen::Vector2d& offset, double sigma) {
  const double dt = seconds(time_us - time_us_);
  if (agrees(dt, offset, sigma)) {
    slope_ = (offset - offset_) / dt;
    spacing_ = dt;
    ++count_;
  } else {
    count_ = 1;
    first_time_us_ = time_us;
    first_offset_ = offset;
  }
  time_us_ = time_us;
  offset_ = offset;
  return count_ >= kFewest && seconds(time_us_ - first_time_us_) >= duration_;
}

Eigen::Vector2d Reacquisition::drift() const {
  const double span = seconds(time_us_ - first_time_us_);
  if (span <= 0.0) return Eigen::Vector2d::Zero();
  return (offset_ - first_offset_) / span;
}

}  // namespace lodestar::fusion
