// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/fusion/cascade_parameters.h"
#include "lodestar/fusion/cascade_states.h"
#include "lodestar/fusion/dead_reckoning.h"

// What the angle states mean, in either form. Angles come in the order heading, pitch, roll
// (Euler errors), or about down, east, north (small angle: the true attitude is that of SAHRS
// turned, in N, by the rotation vector gamma_N; Linköping thesis eq. 7.3-7.6, where gamma_N is its
// first order).

namespace lodestar::fusion {

/// Heading error (rad, true - SAHRS) that the levelled magnetic components leave, from their errors
/// divided by the horizontal field: -sin(heading) x - cos(heading) y (thesis eq. 7.1, from which
/// 7.2 follows with both signs turned). Declination turns x, y into each other and is part of them.
inline Eigen::RowVector2d deviation(double heading) {
  return {-std::sin(heading), -std::cos(heading)};
}

/// The three angles of the form, deviation included (rad).
Eigen::Vector3d angle_errors(const TrackPoint& point, const StateVector& x);

/// d(angle_errors)/dx.
AngleMatrix angles_by_states(const TrackPoint& point);

/// SAHRS angles at `point` corrected by `x` (rad). Euler form: heading not wrapped.
math::Euler corrected_attitude(AttitudeError form, const TrackPoint& point, const StateVector& x);

/// True - SAHRS heading (rad).
double heading_error(AttitudeError form, const TrackPoint& point, const StateVector& x);

/// d(C_NB v_air_B, true)/d(angles), (m/s)/rad: each column is the axis of that angle, in N, crossed
/// with the velocity (thesis eq. 3.18 put together). `v_air_N`: at the corrected attitude.
Eigen::Matrix3d velocity_by_angles(AttitudeError form, const TrackPoint& point,
                                   const StateVector& x, const Eigen::Vector3d& v_air_N);

/// d(true heading, pitch, roll)/dx; near the vertical as at 84 degrees of pitch.
AngleMatrix euler_by_states(AttitudeError form, const TrackPoint& point, const StateVector& x);

/// Axes along which the three angles decay and are driven, in those angles: themselves, or down,
/// right and forward of the level heading in down, east and north.
Eigen::Matrix3d angle_axes(AttitudeError form, double heading);

/// Covariance of the angles (rad^2) from their variances along those axes.
inline Eigen::Matrix3d angle_covariance(AttitudeError form, double heading,
                                        const Eigen::Vector3d& variance) {
  const Eigen::Matrix3d axes = angle_axes(form, heading);
  return axes * variance.asDiagonal() * axes.transpose();
}

/// d(angle along its axis)/d(small rotation in B): what turns P_B of SAHRS into the variances of
/// the angles; near the vertical as at 84 degrees of pitch.
Eigen::Matrix3d angles_by_rotation_B(AttitudeError form, const math::Euler& attitude);

}  // namespace lodestar::fusion
