// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"
#include "lodestar/strapdown/ground_parameters.h"

namespace lodestar::fusion {

/// [fusion.integrated]: what GPS and the flight over the ground add to [strapdown].
struct IntegratedParameters {
  strapdown::GroundParameters ground;
  double gps_noise = 1.0;           // m
  double gps_velocity_noise = 0.1;  // m/s

  // Acceptance of GPS.
  double gps_false_rejection = 1e-5;  // -
  double gps_timeout = 5.0;           // s
  double reacquisition_time = 3.0;    // s

  // What is known at the first frame: set by the navigator from [initial], not by a key here.
  std::optional<double> initial_lat;     // rad
  std::optional<double> initial_lon;     // rad
  double initial_position_sigma = 10.0;  // m

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.ground.wind_sigma,
          {"wind_sigma_m_s", "m/s", 0.01, 100.0, "Wind before the flight, per axis"});
    visit(self.ground.gps_error.sigma,
          {"gps_error_sigma_m", "m", 0.01, 1e3, "Slow error of a GPS position, per axis"});
    visit(self.ground.gps_error.tau,
          {"gps_error_tau_s", "s", 1.0, 1e5, "Time constant of the slow GPS error"});
    visit(self.ground.baro_bias.sigma,
          {"baro_bias_sigma_m", "m", 0.01, 1e4, "Height above the ellipsoid minus baro altitude"});
    visit(self.ground.baro_bias.tau, {"baro_bias_tau_s", "s", 1.0, 1e6, "Its time constant"});
    visit(self.gps_noise,
          {"gps_noise_m", "m", 0.01, 1e3, "White noise of a GPS position, per axis, at least"});
    visit(self.gps_velocity_noise, {"gps_velocity_noise_m_s", "m/s", 0.001, 100.0,
                                    "Noise of a GPS velocity, per axis, at least"});
    visit(self.gps_false_rejection,
          {"gps_false_rejection", "-", 1e-12, 0.1, "Probability that the gate refuses a good fix"});
    visit(self.gps_timeout,
          {"gps_timeout_s", "s", 0.5, 60.0, "Time without a used fix that makes GPS lost"});
    visit(self.reacquisition_time,
          {"reacquisition_time_s", "s", 0.0, 8.0,
           "Time over which fixes must agree among themselves to be believed again"});
  }
};

}  // namespace lodestar::fusion
