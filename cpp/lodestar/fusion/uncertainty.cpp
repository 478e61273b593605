// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/uncertainty.h"

#include <algorithm>
#include <cmath>

namespace lodestar::fusion {
namespace {

// An angle known no better than this is not known; the error model is linear.
constexpr double kLargestAngleVariance = 1.0;  // rad^2

/// Variance north, east (m^2/s^2) that one sample of air data puts into the published velocity.
Eigen::Vector2d sample_variance(const CascadeParameters& parameters, const TrackPoint& point) {
  const Eigen::Vector3d sigma(parameters.alpha_noise, parameters.beta_noise,
                              parameters.airspeed_noise);
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(point.attitude);
  const Eigen::Matrix3d noise_N = C_NB * velocity_by_air_data(point.v_air_B) * sigma.asDiagonal();
  return noise_N.topRows<2>().rowwise().squaredNorm();
}

}  // namespace

Eigen::Vector3d angle_sigma(const math::Euler& attitude, const Eigen::Matrix3d& P_B) {
  const Eigen::Matrix3d E = angles_by_rotation_B(AttitudeError::kEuler, attitude);
  const Eigen::Vector3d variance = (E * P_B * E.transpose()).diagonal();
  return Eigen::Vector3d(variance.z(), variance.y(), variance.x()).cwiseSqrt();
}

Eigen::Vector3d angle_variance(const CascadeParameters& parameters,
                               const samples::Attitude& sahrs) {
  const Eigen::Matrix3d E =
      angles_by_rotation_B(parameters.attitude_error, {sahrs.roll, sahrs.pitch, sahrs.heading});
  const Eigen::Vector3d stated = (E * sahrs.P_B * E.transpose()).diagonal();
  const Eigen::Vector3d floor(parameters.heading_error.sigma, parameters.pitch_error.sigma,
                              parameters.roll_error.sigma);
  return stated.cwiseMax(floor.cwiseAbs2()).cwiseMin(kLargestAngleVariance);
}

void state_sigma(const CascadeParameters& parameters, const TrackPoint& point,
                 const ErrorEstimate& estimate, const StepConditions& conditions,
                 double gust_variance, samples::Navigation& navigation) {
  const StateMatrix P = estimate.P.matrix();
  const Eigen::Vector2d position = P.diagonal().segment<2>(kPositionError.offset);
  navigation.sigma_position.head<2>() = position.cwiseSqrt();

  // Gusts go through into the published velocity, and are wind that is not in the estimate.
  const PositionMatrix J = velocity_by_states(parameters.attitude_error, point, estimate.x);
  const Eigen::Vector2d velocity =
      (J * P * J.transpose()).diagonal() + sample_variance(parameters, point);
  navigation.sigma_velocity.head<2>() = (velocity.array() + gust_variance).sqrt();

  // An error of airspeed is wind along the flight path, until the aircraft turns.
  const double speed = std::max(1.0, point.v_air_N.norm());
  const Eigen::Vector2d along = point.v_air_N.head<2>() * (parameters.airspeed_bias / speed);
  const Eigen::Vector2d wind = P.diagonal().segment<2>(kWind.offset) + along.cwiseAbs2();
  navigation.sigma_wind = (wind.array() + gust_variance).sqrt();

  // As far as heading is corrected, it is by the direction of the air velocity, sideslip error
  // included.
  const AngleMatrix E = euler_by_states(parameters.attitude_error, point, estimate.x);
  const Eigen::Vector3d angles = (E * P * E.transpose()).diagonal();
  const double deviation = parameters.heading_deviation.sigma;
  const double uncorrected = conditions.angle_variance(0) + deviation * deviation;
  const double corrected = std::max(0.0, 1.0 - angles(0) / uncorrected);
  const double beta_error = corrected * parameters.beta_bias;
  navigation.sigma_attitude << std::sqrt(angles(2)), std::sqrt(angles(1)),
      std::sqrt(angles(0) + beta_error * beta_error);
}

}  // namespace lodestar::fusion
