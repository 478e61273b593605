// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lodestar/math/rotation.h"
#include "lodestar/math/state_layout.h"

namespace lodestar::strapdown {

// The error states, true minus estimated, of attitude and air velocity in the sense of the
// right-invariant error of the group SE_2(3) (Barrau and Bonnabel, The invariant extended Kalman
// filter as a stable observer, 2017), both in N:
//     C_NB true = exp([phi x]) C_NB          air_velocity_N true = exp([phi x]) air_velocity_N + dv
// With it the airspeed, alpha and beta do not see the attitude error at all, the field sees it by a
// matrix that only rotates, and neither depends on how wrong the attitude is: a filter that starts
// with a large error is not overconfident for it.
inline constexpr math::Block kAttitude{0, 3};                          // rad, in N
inline constexpr math::Block kVelocity = math::after(kAttitude, 3);    // m/s, in N
inline constexpr math::Block kHeight = math::after(kVelocity, 1);      // m, as the baro has it
inline constexpr math::Block kBaroHeight = math::after(kHeight, 1);    // m, the same with its lag
inline constexpr math::Block kMotion{0, math::end(kBaroHeight)};       // what moves by itself
inline constexpr math::Block kForceBias = math::after(kMotion, 3);     // m/s^2, in B
inline constexpr math::Block kGyroMatrix = math::after(kForceBias, 9); // -, column by column
inline constexpr math::Block kGyroBias = math::after(kGyroMatrix, 3);  // rad/s, in B
inline constexpr math::Block kFieldDrift = math::after(kGyroBias, 3);  // nT, in B, Gauss-Markov
inline constexpr math::Block kGust = math::after(kFieldDrift, 3);      // m/s, in B, Gauss-Markov
inline constexpr math::Block kFieldBias = math::after(kGust, 3);       // nT, in B
inline constexpr math::Block kFieldMatrix = math::after(kFieldBias, 9);    // -, column by column
inline constexpr math::Block kAirspeedScale = math::after(kFieldMatrix, 1);  // -
inline constexpr math::Block kAirspeedBias = math::after(kAirspeedScale, 1);  // m/s
inline constexpr math::Block kFlowBias = math::after(kAirspeedBias, 2);  // rad, alpha and beta
inline constexpr math::Block kFlowScale = math::after(kFlowBias, 2);     // -, alpha and beta
inline constexpr int kStates = math::end(kFlowScale);
static_assert(kStates == 47);

using StateVector = Eigen::Matrix<double, kStates, 1>;
using Covariance = Eigen::Matrix<double, kStates, kStates>;

template <int Size, class Vector>
auto part(Vector& x, math::Block block) {
  return x.template segment<Size>(block.offset);
}

/// What the filter holds to be true.
struct Estimate {
  Eigen::Quaterniond q_NB = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d C_NB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d air_velocity_N = Eigen::Vector3d::Zero();  // m/s, v_N - wind_N
  double height = 0.0;                                       // m, on the baro's scale
  double baro_height = 0.0;                                  // m, as the lagging baro has it
  Eigen::Vector3d force_bias_B = Eigen::Vector3d::Zero();    // m/s^2
  Eigen::Matrix3d gyro_matrix = Eigen::Matrix3d::Zero();  // omega = (I - it) measured - bias
  Eigen::Vector3d gyro_bias_B = Eigen::Vector3d::Zero();  // rad/s
  Eigen::Vector3d field_drift_B = Eigen::Vector3d::Zero();  // nT
  Eigen::Vector3d gust_B = Eigen::Vector3d::Zero();         // m/s, added to the air velocity in B
  Eigen::Vector3d field_bias_B = Eigen::Vector3d::Zero();   // nT
  Eigen::Matrix3d field_matrix = Eigen::Matrix3d::Zero();  // measured = (I + it) b + bias + drift
  double airspeed_scale = 0.0;  // measured = (1 + scale) V + bias
  double airspeed_bias = 0.0;   // m/s
  Eigen::Vector2d flow_bias = Eigen::Vector2d::Zero();   // rad, alpha and beta
  Eigen::Vector2d flow_scale = Eigen::Vector2d::Zero();  // measured = (1 + scale) angle + bias

  /// Velocity of the air at the vanes in B (m/s), gust included.
  Eigen::Vector3d v_air_B() const { return C_NB.transpose() * air_velocity_N + gust_B; }

  /// Folds the errors `x` in.
  void correct(const StateVector& x) {
    const Eigen::Quaterniond turn = math::exp_quaternion(part<3>(x, kAttitude));
    q_NB = (turn * q_NB).normalized();
    C_NB = q_NB.toRotationMatrix();
    air_velocity_N = turn * air_velocity_N + part<3>(x, kVelocity);
    height += x(kHeight.offset);
    baro_height += x(kBaroHeight.offset);
    force_bias_B += part<3>(x, kForceBias);
    gyro_matrix += Eigen::Map<const Eigen::Matrix3d>(x.data() + kGyroMatrix.offset);
    gyro_bias_B += part<3>(x, kGyroBias);
    field_drift_B += part<3>(x, kFieldDrift);
    gust_B += part<3>(x, kGust);
    field_bias_B += part<3>(x, kFieldBias);
    field_matrix += Eigen::Map<const Eigen::Matrix3d>(x.data() + kFieldMatrix.offset);
    airspeed_scale += x(kAirspeedScale.offset);
    airspeed_bias += x(kAirspeedBias.offset);
    flow_bias += part<2>(x, kFlowBias);
    flow_scale += part<2>(x, kFlowScale);
  }
};

}  // namespace lodestar::strapdown
