// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/cascade_model.h"

#include <cmath>

namespace lodestar::fusion {
namespace {

// Convergence of the meridians: a position error north changes the parallel's length, one east is
// carried along as the parallel shrinks.  e' gets (v_e n - v_n e) tan(lat) / r.
double convergence(const TrackPoint& point) {
  return std::tan(point.lat) / (earth::transverse_radius(point.lat) + point.h);
}

}  // namespace

Eigen::Matrix3d velocity_by_air_data(const Eigen::Vector3d& v_air_B) {
  const double V = v_air_B.norm();
  const double uw = std::hypot(v_air_B.x(), v_air_B.z());  // V cos(beta)
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  if (uw < 1e-3) return J;  // at rest the angles mean nothing
  const double tan_beta = v_air_B.y() / uw;
  J.col(0) << -v_air_B.z(), 0.0, v_air_B.x();
  J.col(1) << -v_air_B.x() * tan_beta, uw, -v_air_B.z() * tan_beta;
  J.col(2) = v_air_B / V;
  return J;
}

ErrorDynamics error_dynamics(const CascadeParameters& parameters, const TrackPoint& point,
                             const StateVector& about) {
  const AttitudeError form = parameters.attitude_error;
  ErrorDynamics model{StateMatrix::Zero(), NoiseMatrix::Zero()};
  StateMatrix& F = model.F;
  F.topRows<2>() = velocity_by_states(form, point, about);
  const double tan_over_r = convergence(point);
  const int east = kPositionError.offset + 1;
  F(east, kPositionError.offset) = point.v_air_N.y() * tan_over_r;
  F(east, east) = -point.v_air_N.x() * tan_over_r;
  F.diagonal().segment<2>(kGpsError.offset).setConstant(-1.0 / parameters.gps_error.tau);
  F.diagonal().segment<2>(kWind.offset).setConstant(-1.0 / parameters.wind.tau);
  const Eigen::Matrix3d axes = angle_axes(form, point.attitude.heading);
  const Eigen::Vector3d decay(-1.0 / parameters.heading_error.tau,
                              -1.0 / parameters.pitch_error.tau, -1.0 / parameters.roll_error.tau);
  F.block<3, 3>(kHeadingError.offset, kHeadingError.offset) =
      axes * decay.asDiagonal() * axes.transpose();
  F.diagonal().segment<2>(kDeviation.offset).setConstant(-1.0 / parameters.heading_deviation.tau);

  NoiseMatrix& G = model.G;
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(corrected_attitude(form, point, about));
  G.block<2, 3>(kPositionError.offset, kAirDataNoise.offset) =
      C_NB.topRows<2>() * velocity_by_air_data(point.v_air_B);
  G.block<2, 2>(kPositionError.offset, kTrackNoise.offset).setIdentity();
  G.block<2, 2>(kGpsError.offset, kGpsNoise.offset).setIdentity();
  G.block<2, 2>(kWind.offset, kWindNoise.offset).setIdentity();
  G.block<3, 3>(kHeadingError.offset, kAngleNoise.offset) = axes;
  G.block<2, 2>(kDeviation.offset, kDeviationNoise.offset).setIdentity();
  return model;
}

Eigen::Vector2d position_error_rate(AttitudeError form, const TrackPoint& point,
                                    const StateVector& x) {
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(corrected_attitude(form, point, x));
  const Eigen::Vector2d air_error = (C_NB * point.v_air_B - point.v_air_N).head<2>();
  const Eigen::Vector2d error = x.segment<2>(kPositionError.offset);
  const double east_convergence =
      (point.v_air_N.y() * error.x() - point.v_air_N.x() * error.y()) * convergence(point);
  return x.segment<2>(kWind.offset) + air_error + Eigen::Vector2d(0.0, east_convergence);
}

PositionMatrix velocity_by_states(AttitudeError form, const TrackPoint& point,
                                  const StateVector& x) {
  const math::Euler attitude = corrected_attitude(form, point, x);
  const Eigen::Vector3d v_air_N = math::C_NB_from_euler(attitude) * point.v_air_B;
  PositionMatrix J =
      velocity_by_angles(form, point, x, v_air_N).topRows<2>() * angles_by_states(point);
  J.block<2, 2>(0, kWind.offset).setIdentity();
  return J;
}

PositionMatrix position_measurement() {
  PositionMatrix H = PositionMatrix::Zero();
  H.block<2, 2>(0, kPositionError.offset).setIdentity();
  H.block<2, 2>(0, kGpsError.offset).setIdentity();
  return H;
}

}  // namespace lodestar::fusion
