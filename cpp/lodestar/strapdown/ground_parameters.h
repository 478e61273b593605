// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/gauss_markov.h"

namespace lodestar::strapdown {

/// What is known of wind, GPS and baro before the flight; declared where GPS is.
struct GroundParameters {
  double wind_sigma = 8.0;                    // m/s, per axis
  double wind_tau = 200.0;                    // s, in which wind returns to its mean
  double gust_wind_walk = 0.02;               // 1/sqrt(s), least walk over the gusts
  double lost_wind_walk = 0.1;                // 1/sqrt(s), the same without GPS
  double still_wind_walk = 1e-4;              // m/s/sqrt(s), least walk in still air
  double still_gust_sigma = 0.005;            // m/s, least level of gusts
  double still_after = 1200.0;                // s, after the wind has changed
  double still_lost = 3600.0;                 // s, without GPS
  double still_false_alarm = 0.001;           // that fixes speak against still air
  math::GaussMarkov gps_error{5.0, 150.0};    // m, per axis; s
  math::GaussMarkov baro_bias{20.0, 1000.0};  // m, true height - baro altitude; s
};

}  // namespace lodestar::strapdown
