// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "lodestar/math/rotation.h"
#include "lodestar/samples/samples.h"

namespace lodestar::sahrs::smdu {

/// The latest two solutions of the INS, and its attitude at any time between them.
class InsHistory {
 public:
  /// In order of time.
  void push(const samples::InsSolution& solution) {
    before_ = latest_;
    before_q_NB_ = latest_q_NB_;
    latest_ = solution;
    latest_q_NB_ = Eigen::Quaterniond(
        math::C_NB_from_euler({solution.roll, solution.pitch, solution.heading}));
    if (count_ < 2) ++count_;
  }

  bool empty() const { return count_ == 0; }
  const samples::InsSolution& latest() const { return latest_; }

  /// C_NB at `time_us`, on the shortest way from one solution to the next. False, and `C_NB`
  /// unchanged, if the two do not enclose that time or lie too far apart.
  bool attitude_at(std::int64_t time_us, Eigen::Matrix3d& C_NB) const {
    if (count_ == 0) return false;
    if (time_us == latest_.time_us) {
      C_NB = latest_q_NB_.toRotationMatrix();
      return true;
    }
    const std::int64_t span = latest_.time_us - before_.time_us;
    if (count_ < 2 || time_us > latest_.time_us || time_us < before_.time_us ||
        span > kLongestGap_us) {
      return false;
    }
    const double fraction =
        static_cast<double>(time_us - before_.time_us) / static_cast<double>(span);
    const Eigen::Vector3d turn_B = math::log_quaternion(before_q_NB_.conjugate() * latest_q_NB_);
    C_NB = (before_q_NB_ * math::exp_quaternion(fraction * turn_B)).toRotationMatrix();
    return true;
  }

 private:
  static constexpr std::int64_t kLongestGap_us = 200'000;  // 10 Hz and one lost

  samples::InsSolution before_;
  samples::InsSolution latest_;
  Eigen::Quaterniond before_q_NB_ = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond latest_q_NB_ = Eigen::Quaterniond::Identity();
  int count_ = 0;
};

/// d phi / d (roll, pitch, heading): the small rotation in B that goes with small errors of the
/// Euler angles.
inline Eigen::Matrix3d rotation_from_euler_errors(const Eigen::Matrix3d& C_NB) {
  const Eigen::Vector3d down_B = C_NB.row(2).transpose();
  const double cos_pitch = std::hypot(down_B.y(), down_B.z());
  Eigen::Matrix3d E;
  E.col(0) = Eigen::Vector3d::UnitX();
  E.col(1) = Eigen::Vector3d::UnitY();  // straight up or down, where roll means nothing
  if (cos_pitch > 1e-9) E.col(1) = Eigen::Vector3d(0.0, down_B.z(), -down_B.y()) / cos_pitch;
  E.col(2) = down_B;
  return E;
}

}  // namespace lodestar::sahrs::smdu
