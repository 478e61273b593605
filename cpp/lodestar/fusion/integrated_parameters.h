// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/fusion/gps_acceptance.h"
#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"
#include "lodestar/strapdown/ground_parameters.h"

namespace lodestar::fusion {

/// [fusion.integrated]: what GPS and the flight over the ground add to [strapdown].
struct IntegratedParameters : GpsAcceptance {
  strapdown::GroundParameters ground;
  double gps_noise = 1.0;           // m
  double gps_velocity_noise = 0.1;  // m/s
  double gps_drift_false_alarm = 4e-6;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.ground.wind_sigma,
          {"wind_sigma_m_s", "m/s", 0.01, 100.0, "Wind before the flight, per axis"});
    visit(self.ground.wind_tau,
          {"wind_tau_s", "s", 10.0, 1e9,
           "Time in which the wind returns to its mean, but for steps, which move the mean"});
    visit(self.ground.gust_wind_walk,
          {"gust_wind_walk_rts", "1/sqrt(s)", 0.0, 10.0,
           "Least random walk of the wind, over the gusts above 0.1 m/s"});
    visit(self.ground.lost_wind_walk,
          {"lost_wind_walk_rts", "1/sqrt(s)", 1e-6, 10.0, "The same while GPS is lost"});
    visit(self.ground.still_wind_walk,
          {"still_wind_walk_m_s_rts", "m/s/sqrt(s)", 1e-5, 10.0,
           "Least random walk of the wind where nothing speaks against still air; up to "
           "[strapdown] wind_walk_min_m_s_rts"});
    visit(self.ground.still_gust_sigma, {"still_gust_sigma_m_s", "m/s", 0.001, 20.0,
                                         "Least level of gusts, for that of [strapdown]"});
    visit(self.ground.still_after,
          {"still_after_s", "s", 1.0, 1e9,
           "Time in which a change of the wind stops speaking against still air"});
    visit(self.ground.still_lost, {"still_lost_s", "s", 1.0, 1e9,
                                   "Time in which still air is no longer believed without GPS"});
    visit(self.ground.still_false_alarm,
          {"still_false_alarm", "-", 1e-12, 0.5,
           "Probability, at any one time, that good fixes speak against still air"});
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
    visit(self.gps_drift_false_alarm,
          {"gps_drift_false_alarm", "-", 1e-12, 0.1,
           "Probability that ten seconds of good fixes pass for a receiver that is dragged off"});
    describe_acceptance(self, visit);
  }
};

}  // namespace lodestar::fusion
