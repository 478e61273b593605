// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "lodestar/math/rotation.h"
#include "lodestar/math/scalar.h"
#include "lodestar/samples/outputs.h"

namespace lodestar::monitor {

/// Attitude by the gyros of SAHRS alone, free of what its other sensors correct.
class GyroAttitude {
 public:
  /// One frame. `tau` (s): memory of turned().
  void propagate(const samples::Attitude& sahrs, double tau) {
    const double dt = math::seconds(sahrs.time_us - time_us_);
    if (time_us_ != 0 && dt > 0.0 && dt < kLongest) {
      const Eigen::Vector3d turn = 0.5 * dt * (omega_B_ + sahrs.omega_B);
      q_GB_ = (q_GB_ * math::exp_quaternion(turn)).normalized();
      turned_ = turned_ * std::exp(-dt / tau) + turn.norm();
    }
    time_us_ = sahrs.time_us;
    omega_B_ = sahrs.omega_B;
  }

  const Eigen::Quaterniond& q_GB() const { return q_GB_; }
  /// How far it has turned of late, rad: what scale factors and misalignments err with.
  double turned() const { return turned_; }

 private:
  static constexpr double kLongest = 0.5;  // s; a longer frame is a gap

  std::int64_t time_us_ = 0;
  Eigen::Vector3d omega_B_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_GB_ = Eigen::Quaterniond::Identity();
  double turned_ = 0.0;
};

/// Where an attitude was of late, carried on by gyros: what departs from it has turned as the
/// aircraft has not.
class GyroReference {
 public:
  void restart() { set_ = false; }

  /// Rotation (rad, in N) from where the gyros have it to `q_NB`; from the first call on.
  Eigen::Vector3d departure(const Eigen::Quaterniond& q_NB, const Eigen::Quaterniond& q_GB) {
    if (!set_) q_NG_ = q_NB * q_GB.conjugate();
    set_ = true;
    return math::log_quaternion(q_NB * (q_NG_ * q_GB).conjugate());
  }

  /// Follows `q_NB` by `share` of the way.
  void follow(const Eigen::Quaterniond& q_NB, const Eigen::Quaterniond& q_GB, double share) {
    q_NG_ = (math::exp_quaternion(share * departure(q_NB, q_GB)) * q_NG_).normalized();
  }

 private:
  bool set_ = false;
  Eigen::Quaterniond q_NG_ = Eigen::Quaterniond::Identity();
};

}  // namespace lodestar::monitor
