// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/gauss_markov.h"

namespace lodestar::strapdown {

/// What is known of wind, GPS and baro before the flight; declared where GPS is.
struct GroundParameters {
  double wind_sigma = 15.0;                   // m/s, per axis
  double wind_tau = 200.0;                    // s, in which wind returns to its mean
  double lost_wind_walk = 0.1;                // 1/sqrt(s), least walk without GPS over the gusts
  math::GaussMarkov gps_error{5.0, 150.0};    // m, per axis; s
  math::GaussMarkov baro_bias{20.0, 1000.0};  // m, true height - baro altitude; s
};

}  // namespace lodestar::strapdown
