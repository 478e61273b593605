// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "lodestar/math/rotation.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// All that was ever corrected, as one element of SE_2(3) and two heights: it turns what was
/// estimated before into what would have been estimated then with what is known now.
struct Corrections {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();
  double height = 0.0;
  double baro_height = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // m, north, east
  double heading = 0.0;                                // rad, sum of all its corrections

  template <int N>
  void add(const Eigen::Matrix<double, N, 1>& x) {
    const Eigen::Quaterniond more = turn_of(part<3>(x, kAttitude));
    turn = (more * turn).normalized();
    velocity_N = more * velocity_N + part<3>(x, kVelocity);
    heading += x(kAttitude.offset + 2);
    height += x(kHeight.offset);
    baro_height += x(kBaroHeight.offset);
    if constexpr (kOverGround<N>) position += part<2>(x, kPosition);
  }
};

/// The motion at the end of a frame, and how it was changing.
struct Moment {
  std::int64_t time_us = 0;
  Eigen::Quaterniond q_NB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d air_velocity_N = Eigen::Vector3d::Zero();  // m/s
  double height = 0.0;                                       // m
  double baro_height = 0.0;                                  // m
  Eigen::Vector3d impulse_N = Eigen::Vector3d::Zero();       // m/s, integral of the force used
  Eigen::Vector3d omega_NB_B = Eigen::Vector3d::Zero();      // rad/s
  Eigen::Vector3d acceleration_N = Eigen::Vector3d::Zero();  // m/s^2
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();         // m/s^2, as used
  double baro_rate = 0.0;                                    // m/s
  Eigen::Vector2d travelled = Eigen::Vector2d::Zero();       // m, north, east, over the ground
  Eigen::Vector2d v_N = Eigen::Vector2d::Zero();             // m/s, north, east, over the ground
  Corrections corrections;                                   // made until then

  /// Moves on by `dt` (s) at the rates of the frame.
  void extrapolate(double dt) {
    q_NB = q_NB * math::exp_quaternion(dt * omega_NB_B);
    height -= dt * air_velocity_N.z();
    travelled += dt * v_N;
    air_velocity_N += dt * acceleration_N;
    impulse_N += dt * force_N;
    baro_height += dt * baro_rate;
  }

  /// Applies the corrections made since, `age` (s) later, under `gravity` (m/s^2).
  void bring_up(const Corrections& now, double age, double gravity) {
    const Eigen::Quaterniond turn = now.turn * corrections.turn.conjugate();
    const Eigen::Vector3d phi = math::log_quaternion(turn);
    q_NB = turn * q_NB;
    air_velocity_N = turn * (air_velocity_N - corrections.velocity_N) + now.velocity_N;
    // The tilt that is corrected now had been bending the velocity since then.
    air_velocity_N -= (age * gravity) * Eigen::Vector3d::UnitZ().cross(phi);
    height += now.height - corrections.height;
    baro_height += now.baro_height - corrections.baro_height;
  }
};

/// The estimate `now` with the motion of a moment.
inline Estimate as_of(const Moment& moment, const Estimate& now) {
  Estimate then = now;
  then.q_NB = moment.q_NB;
  then.C_NB = moment.q_NB.toRotationMatrix();
  then.air_velocity_N = moment.air_velocity_N;
  then.height = moment.height;
  then.baro_height = moment.baro_height;
  return then;
}

/// The moments of the last second, one per frame, so that a measurement is applied at its own time.
class History {
 public:
  static constexpr std::size_t kCapacity = 1024;  // 1 s at 1000 Hz

  void clear() { count_ = 0; }

  Moment& push() {
    newest_ = (newest_ + 1) % kCapacity;
    if (count_ < kCapacity) ++count_;
    return ring_[newest_];
  }

  /// The latest moment not after `time_us`; null if the history does not reach back that far.
  const Moment* before(std::int64_t time_us) const {
    if (count_ == 0 || back(count_ - 1).time_us > time_us) return nullptr;
    std::size_t later = 0;
    std::size_t earlier = count_ - 1;  // back(earlier) is not after time_us
    if (back(0).time_us <= time_us) return &back(0);
    while (earlier - later > 1) {
      const std::size_t middle = later + (earlier - later) / 2;
      (back(middle).time_us > time_us ? later : earlier) = middle;
    }
    return &back(earlier);
  }

 private:
  const Moment& back(std::size_t age) const {
    return ring_[(newest_ + kCapacity - age) % kCapacity];
  }

  std::array<Moment, kCapacity> ring_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace lodestar::strapdown
