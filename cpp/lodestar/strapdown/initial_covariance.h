// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/strapdown/ground_parameters.h"
#include "lodestar/strapdown/parameters.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// What is known of the sensors before the flight. Of attitude nothing is; velocity and height
/// start with the first air data.
template <int N = kStates>
CovarianceOf<N> initial_covariance(const Parameters& p) {
  StateVectorOf<N> sigma = StateVectorOf<N>::Zero();
  part<3>(sigma, kAttitude).setConstant(math::kPi);
  part<3>(sigma, kForceBias).setConstant(p.load_bias_sigma * samples::kStandardGravity);
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      sigma(kGyroMatrix.offset + 3 * j + i) =
          i == j ? p.gyro_scale_sigma : p.gyro_misalignment_sigma;
    }
  }
  part<3>(sigma, kGyroBias).setConstant(std::hypot(p.gyro_bias_sigma, p.gyro_drift.sigma));
  part<3>(sigma, kFieldDrift).setConstant(p.field_drift.sigma);
  part<3>(sigma, kGust).setConstant(p.gust_sigma);
  part<3>(sigma, kFieldBias).setConstant(p.field_bias_sigma);
  part<9>(sigma, kFieldMatrix).setConstant(p.field_matrix_sigma);
  sigma(kAirspeedScale.offset) = p.airspeed_scale_sigma;
  sigma(kAirspeedBias.offset) = p.airspeed_bias_sigma;
  part<2>(sigma, kFlowBias).setConstant(p.flow_bias_sigma);
  part<2>(sigma, kFlowScale).setConstant(p.flow_scale_sigma);
  return sigma.cwiseAbs2().asDiagonal();
}

/// What is known over the ground before the first fix, but for the position: that is set.
inline void start_ground(CovarianceOf<kGroundStates>& P, const GroundParameters& p) {
  auto diagonal = P.diagonal();
  for (const int from : {kWind.offset, kMeanWind.offset}) {
    for (int axis = 0; axis < 2; ++axis) {
      P(from + axis, kWind.offset + axis) = p.wind_sigma * p.wind_sigma;  // one is the other
    }
  }
  part<2>(diagonal, kMeanWind) = part<2>(diagonal, kWind);
  part<3>(diagonal, kGpsError).setConstant(p.gps_error.sigma * p.gps_error.sigma);
  diagonal(kBaroBias.offset) = p.baro_bias.sigma * p.baro_bias.sigma;
}

/// Forgets what was known of some states, and their correlation with all others.
template <int N>
void forget(CovarianceOf<N>& P, math::Block block) {
  P.block(block.offset, 0, block.size, math::end(block)).setZero();
  P.block(block.offset, block.offset, N - block.offset, block.size).setZero();
}

/// The attitude is known anew, to `P_N` (rad^2 in N).
template <int N>
void restart_attitude(CovarianceOf<N>& P, const Eigen::Matrix3d& P_N) {
  forget<N>(P, kAttitude);
  P.template block<3, 3>(kAttitude.offset, kAttitude.offset) = P_N;
}

/// The heights are known anew, as one baro altitude at airspeed `V` (m/s) tells them.
template <int N>
void restart_heights(CovarianceOf<N>& P, const Parameters& p, double V) {
  const double lag_sigma = 0.1 * V * p.baro_lag;  // of height against the lagging one
  for (const math::Block block : {kHeight, kBaroHeight}) forget<N>(P, block);
  P(kHeight.offset, kHeight.offset) = p.baro_noise * p.baro_noise + lag_sigma * lag_sigma;
  P(kBaroHeight.offset, kBaroHeight.offset) = p.baro_noise * p.baro_noise;
}

/// Velocity, heights and gust are known anew, as well as one sample of air data at airspeed `V`
/// (m/s) tells them, but for the sensor's own errors: wide, the next samples make it narrow.
template <int N>
void restart_velocity(CovarianceOf<N>& P, const Parameters& p, double gust_sigma, double V) {
  constexpr double kWide = 3.0;
  const double angle_sigma = std::hypot(p.flow_bias_sigma, p.flow_noise);
  const double velocity_sigma =
      kWide * std::max({p.airspeed_bias_sigma + p.airspeed_scale_sigma * V + p.airspeed_noise,
                        angle_sigma * V, gust_sigma});
  for (const math::Block block : {kVelocity, kGust}) forget<N>(P, block);
  auto diagonal = P.diagonal();
  part<3>(diagonal, kVelocity).setConstant(velocity_sigma * velocity_sigma);
  part<3>(diagonal, kGust).setConstant(gust_sigma * gust_sigma);
  restart_heights<N>(P, p, V);
}

}  // namespace lodestar::strapdown
