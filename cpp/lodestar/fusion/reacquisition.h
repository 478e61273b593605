// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace lodestar::fusion {

/// Examines fixes that the filter may not take as they come: after an outage, or beyond the gate.
/// Fixes that agree among themselves for long enough are believed, whatever the filter says, so
/// that a wrong filter can not lock GPS out; fixes that contradict each other are not.
class Reacquisition {
 public:
  /// Seconds of agreement that it takes, and the most (m/s) that offsets may change at first.
  Reacquisition(double duration, double speed) : duration_(duration), speed_(speed) {}

  bool running() const { return count_ > 0; }
  /// The fixes that were under examination stopped coming.
  bool stale(std::int64_t now_us) const {
    return running() && now_us - time_us_ > static_cast<std::int64_t>(1e6 * kLongestPause);
  }
  void cancel() { count_ = 0; }

  /// Takes the next fix by its `offset` (m, north, east) from the coasting filter; a fix alone is
  /// known to `sigma` (m, per axis). True once the fixes are to be believed.
  bool examine(std::int64_t time_us, const Eigen::Vector2d& offset, double sigma);

  /// Velocity (m/s) at which the examined fixes leave the filter.
  Eigen::Vector2d drift() const;

 private:
  static constexpr int kFewest = 3;
  static constexpr double kLongestPause = 3.0;  // s
  static constexpr double kTolerance = 5.0;     // sigma

  bool agrees(double dt, const Eigen::Vector2d& offset, double sigma) const;

  double duration_;
  double speed_;
  int count_ = 0;
  std::int64_t first_time_us_ = 0;
  std::int64_t time_us_ = 0;
  Eigen::Vector2d first_offset_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d slope_ = Eigen::Vector2d::Zero();
  double spacing_ = 0.0;  // s, between the last two
};

}  // namespace lodestar::fusion
