// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/gauss_markov.h"
#include "lodestar/math/rotation.h"

namespace lodestar::sahrs_test {

/// Errors of the sensors of a fighter, 1 sigma.
struct SensorErrors {
  double gyro_bias = 0.2 * math::kDegree;                     // rad/s
  math::GaussMarkov gyro_drift{0.03 * math::kDegree, 300.0};  // rad/s
  double gyro_scale = 0.003, gyro_misalignment = 0.2 * math::kDegree;
  double gyro_noise = 0.05 * math::kDegree;                                  // rad/s
  double load_bias = 0.01, load_noise = 0.02;                                // g0
  double field_bias = 500.0, field_noise = 80.0, field_matrix = 0.003;       // nT, nT, -
  math::GaussMarkov field_drift{60.0, 60.0};                                 // nT
  double field_model = 20.0;                                                 // nT
  double airspeed_scale = 0.005, airspeed_bias = 0.5, airspeed_noise = 0.5;  // -, m/s
  double flow_bias = 0.3 * math::kDegree, flow_noise = 0.1 * math::kDegree;  // rad
  double alpha_scale = 0.02;
  double baro_bias = 20.0, baro_noise = 0.5, baro_lag = 0.3;  // m, m, s
  math::GaussMarkov vertical_gust{0.0, 3.0};                  // m/s
};

}  // namespace lodestar::sahrs_test
