// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "lodestar/math/rotation.h"
#include "lodestar/math/scalar.h"

namespace lodestar::sahrs {

/// How the body moved, as integrated from the gyros, at one time. S is the frame that the
/// integration keeps: N but for the corrections of the filter, which turn all of the past alike and
/// so stay out of the history.
struct Pose {
  std::int64_t time_us = 0;
  Eigen::Quaterniond q_SB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // rad/s, as measured
  double climb_integral = 0.0;                        // m/s, integral of the vertical acceleration
};

/// The poses of the last second, one per frame, so that a measurement is applied at its own time.
class PoseHistory {
 public:
  static constexpr std::size_t kCapacity = 1024;  // 1 s at 1000 Hz

  void clear() { count_ = 0; }

  void push(const Pose& pose) {
    newest_ = (newest_ + 1) % kCapacity;
    ring_[newest_] = pose;
    if (count_ < kCapacity) ++count_;
  }

  const Pose& newest() const { return ring_[newest_]; }

  /// The pose at `time_us`, between two frames on the shortest way, after the newest at its rate.
  /// False, and `pose` unchanged, if the history does not reach back that far.
  bool at(std::int64_t time_us, Pose& pose) const {
    if (count_ == 0) return false;
    if (time_us >= newest().time_us) {
      pose = newest();
      if (time_us > pose.time_us) extrapolate(time_us, pose);
      return true;
    }
    if (back(count_ - 1).time_us > time_us) return false;
    std::size_t later = 0;             // back(later) is after time_us
    std::size_t earlier = count_ - 1;  // back(earlier) is not
    while (earlier - later > 1) {
      const std::size_t middle = later + (earlier - later) / 2;
      (back(middle).time_us > time_us ? later : earlier) = middle;
    }
    pose = between(back(earlier), back(later), time_us);
    return true;
  }

 private:
  const Pose& back(std::size_t age) const { return ring_[(newest_ + kCapacity - age) % kCapacity]; }

  static void extrapolate(std::int64_t time_us, Pose& pose) {
    const double dt = math::seconds(time_us - pose.time_us);
    pose.q_SB = pose.q_SB * math::exp_quaternion(dt * pose.omega_B);
    pose.time_us = time_us;
  }

  static Pose between(const Pose& a, const Pose& b, std::int64_t time_us) {
    const double fraction =
        static_cast<double>(time_us - a.time_us) / static_cast<double>(b.time_us - a.time_us);
    const Eigen::Vector3d turn_B = math::log_quaternion(a.q_SB.conjugate() * b.q_SB);
    Pose pose;
    pose.time_us = time_us;
    pose.q_SB = a.q_SB * math::exp_quaternion(fraction * turn_B);
    pose.omega_B = a.omega_B + fraction * (b.omega_B - a.omega_B);
    pose.climb_integral = a.climb_integral + fraction * (b.climb_integral - a.climb_integral);
    return pose;
  }

  std::array<Pose, kCapacity> ring_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace lodestar::sahrs
