// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/rotation.h"
#include "lodestar/strapdown/delayed.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// What is estimated of the motion over the ground at the time of a fix.
struct GroundPoint {
  earth::Geodetic position;
  Eigen::Vector2d v_N = Eigen::Vector2d::Zero();             // m/s, north, east
  Eigen::Vector3d air_velocity_N = Eigen::Vector3d::Zero();  // m/s, where H is taken
  Delay delay;
};

/// A GPS position, north, east and down of the estimated one (m), with the errors of now: since the
/// fix the position error has grown by `age` times that of ground velocity.
///     innovation = dp - age (dv - v x phi + dw) + gps_error,    down: -dh - baro_bias + gps_error
struct GpsPosition {
  static constexpr int kRows = 3;
  Eigen::Vector3d innovation;  // m
  Eigen::Vector3d variance;    // m^2
  Eigen::Matrix3d H_attitude;
  Eigen::Matrix3d H_velocity;
  Eigen::Matrix<double, 3, 2> H_wind;

  template <class Visit>
  void visit_H(Visit&& visit) const {
    using Column = Eigen::Vector3d;
    using Horizontal = Eigen::Matrix<double, 3, 2>;
    visit(kAttitude.offset, H_attitude);
    visit(kVelocity.offset, H_velocity);
    visit(kWind.offset, H_wind);
    visit(kPosition.offset, Horizontal::Identity().eval());
    visit(kGpsError.offset, 1.0);
    visit(kHeight.offset, (-Column::UnitZ()).eval());
    visit(kBaroBias.offset, (-Column::UnitZ()).eval());
  }
};

inline GpsPosition measure_position(const earth::Geodetic& fix, const GroundPoint& at,
                                    const Eigen::Vector3d& gps_error,
                                    const Eigen::Vector3d& variance) {
  GpsPosition m;
  m.innovation = earth::displacement_N(at.position, fix) - gps_error;
  m.variance = variance;
  const double age = at.delay.age;
  m.H_attitude = age * math::skew(at.air_velocity_N);
  m.H_attitude.row(2).setZero();
  m.H_velocity = Eigen::Vector3d(-age, -age, 0.0).asDiagonal();
  m.H_wind = m.H_velocity.leftCols<2>();
  return m;
}

/// A GPS velocity, north and east (m/s):
///     innovation = dv - v x phi + dw
struct GpsVelocity {
  static constexpr int kRows = 2;
  Eigen::Vector2d innovation;  // m/s
  Eigen::Vector2d variance;    // (m/s)^2
  Eigen::Matrix<double, 2, 3> H_attitude;

  template <class Visit>
  void visit_H(Visit&& visit) const {
    visit(kAttitude.offset, H_attitude);
    visit(kVelocity.offset, 1.0);
    visit(kWind.offset, 1.0);
  }
};

inline GpsVelocity measure_velocity(const Eigen::Vector2d& v_N, const GroundPoint& at,
                                    double sigma) {
  GpsVelocity m;
  m.innovation = v_N - at.v_N;
  m.variance.setConstant(sigma * sigma);
  m.H_attitude = -math::skew(at.air_velocity_N).topRows<2>();
  return m;
}

}  // namespace lodestar::strapdown
