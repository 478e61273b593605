// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <random>

#include "lodestar/strapdown/propagation.h"
#include "lodestar/strapdown/state.h"

// Points of flight at which Jacobians are held against central differences.

namespace lodestar::strapdown {

inline Estimate estimate(const math::Euler& attitude, const Eigen::Vector3d& v_air_B) {
  Estimate x;
  x.C_NB = math::C_NB_from_euler(attitude);
  x.q_NB = Eigen::Quaterniond(x.C_NB);
  x.air_velocity_N = x.C_NB * v_air_B;
  x.height = 2500.0;
  x.baro_height = 2490.0;
  x.force_bias_B << 0.05, -0.08, 0.1;
  x.gyro_matrix << 2e-3, -1e-3, 3e-3, 1e-3, -2e-3, 1e-3, -3e-3, 2e-3, 1e-3;
  x.gyro_bias_B << 2e-3, -3e-3, 1e-3;
  x.field_drift_B << 40.0, -50.0, 60.0;
  x.gust_B << 0.5, -1.0, 0.7;
  x.field_bias_B << 400.0, -300.0, 500.0;
  x.field_matrix << 2e-3, -3e-3, 1e-3, 3e-3, 1e-3, -2e-3, 1e-3, 2e-3, -1e-3;
  x.airspeed_scale = 4e-3;
  x.airspeed_bias = -0.4;
  x.flow_bias << 4e-3, -5e-3;
  x.flow_scale << 0.02, -0.015;
  return x;
}

struct FlightPoint {
  const char* name;
  Estimate x;
  Eigen::Vector3d omega_B;  // rad/s
  Eigen::Vector3d force_B;  // m/s^2
};

/// Level, banked, vertical, inverted and rolling; fast and slow; without and with large flow
/// angles.
inline std::array<FlightPoint, 6> flight_points() {
  constexpr double kDegree = math::kDegree;
  using V = Eigen::Vector3d;
  return {{
      {"level", estimate({0.0, 0.05, 0.7}, V(190.0, 0.0, 10.0)), V::Zero(), V(0.5, 0.0, -9.8)},
      {"turn", estimate({60.0 * kDegree, 0.1, 3.0}, V(200.0, 2.0, 15.0)), V(0.0, 0.08, 0.05),
       V(0.3, 0.2, -20.0)},
      {"vertical", estimate({0.3, 90.0 * kDegree, 1.0}, V(150.0, -3.0, 20.0)), V(0.0, 0.25, 0.0),
       V(1.0, 0.0, -45.0)},
      {"inverted", estimate({180.0 * kDegree, -0.3, -2.0}, V(170.0, 0.0, -8.0)), V(2.1, 0.1, -0.1),
       V(0.0, 1.0, 8.0)},
      {"no rates, no force", estimate({1e-9, -1e-9, 1e-9}, V(60.0, 0.0, 0.0)), V::Zero(),
       V::Zero()},
      {"slow and sideways", estimate({-0.5, 0.4, 2.0}, V(12.0, -7.0, 6.0)), V(-0.5, 0.7, 0.9),
       V(-2.0, 3.0, -9.0)},
  }};
}

/// Steps of central differences, of the size of each state's error.
template <int N = kStates>
StateVectorOf<N> steps() {
  StateVectorOf<N> h;
  part<3>(h, kAttitude).setConstant(1e-4);
  part<3>(h, kVelocity).setConstant(1e-2);
  h(kHeight.offset) = h(kBaroHeight.offset) = 1e-1;
  part<3>(h, kForceBias).setConstant(1e-3);
  part<9>(h, kGyroMatrix).setConstant(1e-4);
  part<3>(h, kGyroBias).setConstant(1e-4);
  part<3>(h, kFieldDrift).setConstant(1.0);
  part<3>(h, kGust).setConstant(1e-2);
  part<3>(h, kFieldBias).setConstant(1.0);
  part<9>(h, kFieldMatrix).setConstant(1e-4);
  h(kAirspeedScale.offset) = 1e-4;
  h(kAirspeedBias.offset) = 1e-2;
  part<2>(h, kFlowBias).setConstant(1e-4);
  part<2>(h, kFlowScale).setConstant(1e-4);
  h(kPadding.offset) = 1.0;
  if constexpr (kOverGround<N>) {
    part<2>(h, kPosition).setConstant(1.0);
    part<2>(h, kWind).setConstant(1e-2);
    part<3>(h, kGpsError).setConstant(1.0);
    h(kBaroBias.offset) = 1.0;
    part<2>(h, kMeanWind).setConstant(1e-2);
    part<2>(h, kGroundPadding).setConstant(1.0);
  }
  return h;
}

inline Place sweden() {
  Place place;
  place.gravity = 9.818;
  place.earth_rate_N << 3.9e-5, 0.0, -6.2e-5;
  place.transport_rate_N << 1.1e-5, -2.8e-5, -1.7e-5;
  place.baro_lag = 0.3;
  place.lat = 1.0;
  return place;
}

}  // namespace lodestar::strapdown
