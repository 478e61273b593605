// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <type_traits>

#include "lodestar/math/rotation.h"
#include "lodestar/strapdown/history.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// How the errors changed since a measurement was valid, to first order in its age.
struct Delay {
  double age = 0.0;  // s
  double gravity = 0.0;
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();         // rad/s, mean since then
  Eigen::Matrix3d C_NB = Eigen::Matrix3d::Identity();        // mean since then
  Eigen::Vector3d air_velocity_N = Eigen::Vector3d::Zero();  // m/s, then
};

/// From `then` to `now`, `age` (s) later, under `gravity` (m/s^2).
inline Delay delay_since(const Moment& then, const Estimate& now, double age, double gravity) {
  Delay delay;
  delay.age = age;
  delay.gravity = gravity;
  const Eigen::Matrix3d C_then = then.q_NB.toRotationMatrix();
  delay.C_NB = 0.5 * (C_then + now.C_NB);
  delay.omega_B =
      math::log_quaternion(then.q_NB.conjugate() * now.q_NB) / std::max(delay.age, 1e-3);
  delay.air_velocity_N = then.air_velocity_N;
  return delay;
}

/// A measurement of some time ago, in terms of the errors of now:
///     phi(then) = phi + age C (gyro_bias + gyro_matrix omega)
///     dv(then)  = dv - age g x phi + age v x C (gyro_bias + gyro_matrix omega) + age C force_bias
///     dbaro(then) = dbaro + age dv_down
template <class Measurement>
struct Delayed {
  static constexpr int kRows = Measurement::kRows;
  using Block = Eigen::Matrix<double, kRows, 3>;

  Delayed(const Measurement& m, const Delay& d)
      : measurement(m), innovation(m.innovation), variance(m.variance), omega_B(d.omega_B) {
    Eigen::Matrix<double, kRows, kMotion.size> H;
    H.setZero();
    m.visit_H([&H](int offset, const auto& part_of_H) {
      if constexpr (std::is_same_v<std::decay_t<decltype(part_of_H)>, double>) {
        if (offset < kMotion.size)
          H.template middleCols<kRows>(offset).diagonal().array() += part_of_H;
      } else {
        constexpr int kWidth = std::decay_t<decltype(part_of_H)>::ColsAtCompileTime;
        if (offset < kMotion.size) H.template middleCols<kWidth>(offset) += part_of_H;
      }
    });
    const Block H_attitude = H.template middleCols<3>(kAttitude.offset);
    const Block H_velocity = H.template middleCols<3>(kVelocity.offset);
    attitude = -d.age * d.gravity * H_velocity * math::skew(Eigen::Vector3d::UnitZ());
    velocity = Block::Zero();
    velocity.col(2) = d.age * H.col(kBaroHeight.offset);
    force_bias = d.age * H_velocity * d.C_NB;
    gyro_bias = d.age * (H_attitude + H_velocity * math::skew(d.air_velocity_N)) * d.C_NB;
  }

  template <class Visit>
  void visit_H(Visit&& visit) const {
    measurement.visit_H(visit);
    visit(kAttitude.offset, attitude);
    visit(kVelocity.offset, velocity);
    visit(kForceBias.offset, force_bias);
    visit(kGyroBias.offset, gyro_bias);
    for (int j = 0; j < 3; ++j) {
      const Block scaled = omega_B(j) * gyro_bias;
      visit(kGyroMatrix.offset + 3 * j, scaled);
    }
  }

  const Measurement& measurement;
  Eigen::Matrix<double, kRows, 1> innovation;
  Eigen::Matrix<double, kRows, 1> variance;
  Eigen::Vector3d omega_B;
  Block attitude;
  Block velocity;
  Block force_bias;
  Block gyro_bias;
};

}  // namespace lodestar::strapdown
