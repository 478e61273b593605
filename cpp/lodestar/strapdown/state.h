// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"
#include "lodestar/math/state_layout.h"

namespace lodestar::strapdown {

// The error states, true minus estimated. Attitude and air velocity have the right-invariant error
// of the group SE_2(3) (Barrau and Bonnabel, The invariant extended Kalman filter as a stable
// observer, 2017), in N:
//     C_NB true = exp([phi x]) C_NB          air_velocity_N true = exp([phi x]) air_velocity_N + dv
// Airspeed and vanes then do not see the attitude error at all, and what the field can not tell, a
// rotation about itself, is the same direction of phi whatever the estimate.
inline constexpr math::Block kAttitude{0, 3};                            // rad, in N
inline constexpr math::Block kVelocity = math::after(kAttitude, 3);      // m/s, in N
inline constexpr math::Block kHeight = math::after(kVelocity, 1);        // m, as the baro has it
inline constexpr math::Block kBaroHeight = math::after(kHeight, 1);      // m, the same with its lag
inline constexpr math::Block kMotion{0, math::end(kBaroHeight)};         // what moves by itself
inline constexpr math::Block kForceBias = math::after(kMotion, 3);       // m/s^2, in B
inline constexpr math::Block kGyroMatrix = math::after(kForceBias, 9);   // -, column by column
inline constexpr math::Block kGyroBias = math::after(kGyroMatrix, 3);    // rad/s, in B
inline constexpr math::Block kFieldDrift = math::after(kGyroBias, 3);    // nT, in B, Gauss-Markov
inline constexpr math::Block kGust = math::after(kFieldDrift, 3);        // m/s, in B, Gauss-Markov
inline constexpr math::Block kFieldBias = math::after(kGust, 3);         // nT, in B
inline constexpr math::Block kFieldMatrix = math::after(kFieldBias, 9);  // -, column by column
inline constexpr math::Block kAirspeedScale = math::after(kFieldMatrix, 1);   // -
inline constexpr math::Block kAirspeedBias = math::after(kAirspeedScale, 1);  // m/s
inline constexpr math::Block kFlowBias = math::after(kAirspeedBias, 2);       // rad, alpha and beta
inline constexpr math::Block kFlowScale = math::after(kFlowBias, 2);          // -, alpha and beta
// One more, always nought: columns of an even number of doubles stay aligned, and the covariance is
// moved a fifth faster.
inline constexpr math::Block kPadding = math::after(kFlowScale, 1);
inline constexpr int kStates = math::end(kPadding);
static_assert(kStates == 48);

// With GPS, what flies over the ground comes behind.
inline constexpr math::Block kPosition = math::after(kPadding, 2);   // m, north, east
inline constexpr math::Block kWind = math::after(kPosition, 2);      // m/s, north, east
inline constexpr math::Block kGpsError = math::after(kWind, 3);      // m, in N, measured - true
inline constexpr math::Block kBaroBias = math::after(kGpsError, 1);  // m, true height - the baro's
inline constexpr math::Block kMeanWind = math::after(kBaroBias, 2);  // m/s, what wind returns to
inline constexpr math::Block kGroundPadding = math::after(kMeanWind, 2);  // nought, as above
inline constexpr int kGroundStates = math::end(kGroundPadding);
static_assert(kGroundStates == 60);

template <int N>
using StateVectorOf = Eigen::Matrix<double, N, 1>;
template <int N>
using CovarianceOf = Eigen::Matrix<double, N, N>;
using StateVector = StateVectorOf<kStates>;
using Covariance = CovarianceOf<kStates>;

template <int N>
inline constexpr bool kOverGround = N == kGroundStates;

template <int Size, class Vector>
auto part(Vector& x, math::Block block) {
  return x.template segment<Size>(block.offset);
}

/// The rotation of an attitude error: tilt, then heading. To first order it is exp([phi x]); but
/// what gravity and the climb tell of tilt stays true at any error of heading.
inline Eigen::Quaterniond turn_of(const Eigen::Vector3d& phi) {
  return math::exp_quaternion(Eigen::Vector3d(0.0, 0.0, phi.z())) *
         math::exp_quaternion(Eigen::Vector3d(phi.x(), phi.y(), 0.0));
}

/// What the filter holds to be true.
struct Estimate {
  Eigen::Quaterniond q_NB = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d C_NB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d air_velocity_N = Eigen::Vector3d::Zero();  // m/s, v_N - wind_N
  double height = 0.0;                                       // m, on the baro's scale
  double baro_height = 0.0;                                  // m, as the lagging baro has it
  Eigen::Vector3d force_bias_B = Eigen::Vector3d::Zero();    // m/s^2
  Eigen::Matrix3d gyro_matrix = Eigen::Matrix3d::Zero();     // omega = (I - it) measured - bias
  Eigen::Vector3d gyro_bias_B = Eigen::Vector3d::Zero();     // rad/s
  Eigen::Vector3d field_drift_B = Eigen::Vector3d::Zero();   // nT
  Eigen::Vector3d gust_B = Eigen::Vector3d::Zero();          // m/s, added to the air velocity in B
  Eigen::Vector3d field_bias_B = Eigen::Vector3d::Zero();    // nT
  Eigen::Matrix3d field_matrix = Eigen::Matrix3d::Zero();    // measured = (I + it) b + bias + drift
  double airspeed_scale = 0.0;                               // measured = V + scale V + bias
  double airspeed_bias = 0.0;                                // m/s
  Eigen::Vector2d flow_bias = Eigen::Vector2d::Zero();       // rad, alpha and beta
  Eigen::Vector2d flow_scale = Eigen::Vector2d::Zero();  // measured = angle + scale angle + bias

  // Over the ground; unused without GPS.
  double lat = 0.0;                                       // rad
  double lon = 0.0;                                       // rad, not wrapped
  Eigen::Vector2d wind_N = Eigen::Vector2d::Zero();       // m/s, north, east
  Eigen::Vector2d mean_wind_N = Eigen::Vector2d::Zero();  // m/s, what it returns to
  Eigen::Vector3d gps_error = Eigen::Vector3d::Zero();    // m, measured - true
  double baro_bias = 0.0;                                 // m, true height - height

  /// Velocity over the ground (m/s, in N): the air goes neither up nor down.
  Eigen::Vector3d v_N() const {
    return air_velocity_N + Eigen::Vector3d(wind_N.x(), wind_N.y(), 0.0);
  }
  earth::Geodetic position() const { return {lat, lon, height + baro_bias}; }

  /// Velocity of the air at the vanes in B (m/s), gust included.
  Eigen::Vector3d v_air_B() const { return C_NB.transpose() * air_velocity_N + gust_B; }

  /// Folds the errors `x` in.
  template <int N>
  void correct(const Eigen::Matrix<double, N, 1>& x) {
    const Eigen::Quaterniond turn = turn_of(part<3>(x, kAttitude));
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
    if constexpr (kOverGround<N>) {
      displace(part<2>(x, kPosition));
      wind_N += part<2>(x, kWind);
      mean_wind_N += part<2>(x, kMeanWind);
      gps_error += part<3>(x, kGpsError);
      baro_bias += x(kBaroBias.offset);
    }
  }

  /// Wind goes back by `share` of its distance to the mean; ground velocity does not know.
  void return_wind(double share) {
    const Eigen::Vector2d back = share * (mean_wind_N - wind_N);
    wind_N += back;
    air_velocity_N.head<2>() -= back;
  }

  /// Moves the position by `offset` (m, north, east).
  void displace(const Eigen::Vector2d& offset) {
    const earth::Geodetic to = earth::displaced(position(), {offset.x(), offset.y(), 0.0});
    lat = to.lat;
    lon = to.lon;
  }
};

/// The errors `x` that from.correct(x) turns into `to`.
template <int N = kStates>
StateVectorOf<N> error_between(const Estimate& from, const Estimate& to) {
  StateVectorOf<N> x = StateVectorOf<N>::Zero();
  const Eigen::Quaterniond turn = to.q_NB * from.q_NB.conjugate();
  part<3>(x, kAttitude) = math::log_quaternion(turn);
  part<3>(x, kVelocity) = to.air_velocity_N - turn * from.air_velocity_N;
  x(kHeight.offset) = to.height - from.height;
  x(kBaroHeight.offset) = to.baro_height - from.baro_height;
  part<3>(x, kForceBias) = to.force_bias_B - from.force_bias_B;
  Eigen::Map<Eigen::Matrix3d>(x.data() + kGyroMatrix.offset) = to.gyro_matrix - from.gyro_matrix;
  part<3>(x, kGyroBias) = to.gyro_bias_B - from.gyro_bias_B;
  part<3>(x, kFieldDrift) = to.field_drift_B - from.field_drift_B;
  part<3>(x, kGust) = to.gust_B - from.gust_B;
  part<3>(x, kFieldBias) = to.field_bias_B - from.field_bias_B;
  Eigen::Map<Eigen::Matrix3d>(x.data() + kFieldMatrix.offset) = to.field_matrix - from.field_matrix;
  x(kAirspeedScale.offset) = to.airspeed_scale - from.airspeed_scale;
  x(kAirspeedBias.offset) = to.airspeed_bias - from.airspeed_bias;
  part<2>(x, kFlowBias) = to.flow_bias - from.flow_bias;
  part<2>(x, kFlowScale) = to.flow_scale - from.flow_scale;
  if constexpr (kOverGround<N>) {
    part<2>(x, kPosition) =
        earth::displacement_N(from.position(), to.position()).template head<2>();
    part<2>(x, kWind) = to.wind_N - from.wind_N;
    part<2>(x, kMeanWind) = to.mean_wind_N - from.mean_wind_N;
    part<3>(x, kGpsError) = to.gps_error - from.gps_error;
    x(kBaroBias.offset) = to.baro_bias - from.baro_bias;
  }
  return x;
}

}  // namespace lodestar::strapdown
