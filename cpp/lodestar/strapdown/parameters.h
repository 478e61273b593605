// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/gauss_markov.h"
#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"
#include "lodestar/samples/samples.h"

namespace lodestar::strapdown {

/// [strapdown]: the velocity-aided filter family. The defaults are those of a fighter's sensors.
struct Parameters {
  static constexpr double kDegree = math::kDegree;

  // Gyros and load factor.
  double gyro_noise = 0.0065 * kDegree;                 // rad/s/sqrt(Hz)
  double gyro_bias_sigma = 0.2 * kDegree;               // rad/s
  math::GaussMarkov gyro_drift{0.03 * kDegree, 300.0};  // rad/s, s
  double gyro_scale_sigma = 0.003;
  double gyro_misalignment_sigma = 0.2 * kDegree;  // rad
  double load_noise = 0.0026;                      // g0/sqrt(Hz)
  double load_bias_sigma = 0.01;                   // g0

  // Magnetic field. The drift is that of the sensor, 60 nT, and the error of the field model.
  double field_noise = 80.0;                  // nT
  math::GaussMarkov field_drift{55.0, 60.0};  // nT, s
  double field_bias_sigma = 500.0;            // nT
  double field_matrix_sigma = 0.003;

  // Air data.
  double airspeed_noise = 0.5;  // m/s
  double airspeed_scale_sigma = 0.005;
  double airspeed_bias_sigma = 0.5;        // m/s
  double flow_noise = 0.1 * kDegree;       // rad
  double flow_bias_sigma = 0.3 * kDegree;  // rad
  double flow_scale_sigma = 0.02;
  double baro_noise = 0.5;     // m
  double baro_lag = 0.3;       // s
  double min_airspeed = 60.0;  // m/s; declared in [sahrs]

  // The air.
  double wind_walk = 0.1;              // m/s/sqrt(s), at the start
  double wind_walk_min = 0.012;        // m/s/sqrt(s)
  double wind_walk_max = 2.0;          // m/s/sqrt(s)
  double wind_adaptation = 3.0;        // s
  double wind_base_adaptation = 50.0;  // s
  double vertical_wind_ratio = 0.3;    // of the same
  double height_walk = 0.05;           // m/sqrt(s)
  double gust_length = 430.0;          // m
  double gust_sigma = 2.0;             // m/s, at the start
  double gust_sigma_min = 0.02;        // m/s
  double gust_sigma_max = 8.0;         // m/s
  double gust_adaptation = 3.0;        // s

  double gate_false_rejection = 1e-5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.gyro_noise, {"gyro_noise_deg_s_rthz", "deg/s/sqrt(Hz)", 1e-5, 1.0,
                            "White noise of the gyros", kDegree});
    visit(self.gyro_bias_sigma, {"gyro_bias_sigma_deg_s", "deg/s", 0.0, 10.0,
                                 "1 sigma of the gyros' turn-on bias", kDegree});
    visit(self.gyro_drift.sigma, {"gyro_drift_sigma_deg_s", "deg/s", 0.0, 10.0,
                                  "1 sigma of the gyros' in-run bias", kDegree});
    visit(self.gyro_drift.tau,
          {"gyro_drift_tau_s", "s", 1.0, 1e6, "Correlation time of the gyros' in-run bias"});
    visit(self.gyro_scale_sigma,
          {"gyro_scale_sigma", "-", 0.0, 0.1, "1 sigma of the gyros' scale factors"});
    visit(self.gyro_misalignment_sigma, {"gyro_misalignment_sigma_deg", "deg", 0.0, 5.0,
                                         "1 sigma of the gyros' misalignments", kDegree});
    visit(self.load_noise,
          {"load_noise_g_rthz", "g0/sqrt(Hz)", 1e-5, 1.0, "White noise of the load factor"});
    visit(self.load_bias_sigma,
          {"load_bias_sigma_g", "g0", 0.0, 0.5, "1 sigma of the load factor's bias"});
    visit(self.field_noise,
          {"field_noise_nT", "nT", 1.0, 1e5, "White noise of the magnetic field"});
    visit(self.field_drift.sigma,
          {"field_drift_sigma_nT", "nT", 0.0, 1e5, "1 sigma of the magnetic field's slow error"});
    visit(self.field_drift.tau, {"field_drift_tau_s", "s", 0.1, 1e6,
                                 "Correlation time of the magnetic field's slow error"});
    visit(self.field_bias_sigma,
          {"field_bias_sigma_nT", "nT", 0.0, 1e5, "1 sigma of the hard iron left uncalibrated"});
    visit(self.field_matrix_sigma, {"field_matrix_sigma", "-", 0.0, 0.2,
                                    "1 sigma of each soft-iron element left uncalibrated"});
    visit(self.airspeed_noise,
          {"airspeed_noise_m_s", "m/s", 0.01, 20.0, "White noise of the true airspeed"});
    visit(self.airspeed_scale_sigma,
          {"airspeed_scale_sigma", "-", 0.0, 0.2, "1 sigma of the airspeed's scale factor"});
    visit(self.airspeed_bias_sigma,
          {"airspeed_bias_sigma_m_s", "m/s", 0.0, 20.0, "1 sigma of the airspeed's bias"});
    visit(self.flow_noise,
          {"flow_noise_deg", "deg", 0.001, 10.0, "White noise of alpha and beta", kDegree});
    visit(self.flow_bias_sigma,
          {"flow_bias_sigma_deg", "deg", 0.0, 20.0, "1 sigma of alpha's and beta's bias", kDegree});
    visit(self.flow_scale_sigma,
          {"flow_scale_sigma", "-", 0.0, 0.5, "1 sigma of alpha's and beta's scale factor"});
    visit(self.baro_noise, {"baro_noise_m", "m", 0.01, 100.0, "White noise of the baro altitude"});
    visit(self.baro_lag, {"baro_lag_s", "s", 0.0, 5.0, "First-order lag of the baro altitude"});
    visit(self.wind_walk, {"wind_walk_m_s_rts", "m/s/sqrt(s)", 1e-4, 10.0,
                           "Random walk of the horizontal wind, per axis, at the start; then "
                           "estimated"});
    visit(self.wind_walk_min,
          {"wind_walk_min_m_s_rts", "m/s/sqrt(s)", 1e-4, 10.0, "Least level of that random walk"});
    visit(self.wind_walk_max, {"wind_walk_max_m_s_rts", "m/s/sqrt(s)", 1e-4, 10.0,
                               "Greatest level of that random walk"});
    visit(self.wind_adaptation, {"wind_adaptation_s", "s", 0.1, 1e6,
                                 "Time in which that level falls again after a step of wind"});
    visit(self.wind_base_adaptation,
          {"wind_base_adaptation_s", "s", 1.0, 1e6,
           "Time in which the level that lasts between steps of wind is learnt"});
    visit(self.vertical_wind_ratio, {"vertical_wind_ratio", "-", 0.0, 10.0,
                                     "Random walk of the vertical wind over that of the "
                                     "horizontal"});
    visit(self.height_walk, {"height_walk_m_rts", "m/sqrt(s)", 0.0, 10.0,
                             "Random walk of baro altitude against the climb through the air"});
    visit(self.gust_length, {"gust_length_m", "m", 10.0, 5000.0, "Length of the gusts (Dryden)"});
    visit(self.gust_sigma, {"gust_sigma_m_s", "m/s", 0.0, 20.0,
                            "1 sigma of the gusts at the start, then estimated"});
    visit(self.gust_sigma_min, {"gust_sigma_min_m_s", "m/s", 0.001, 20.0, "Least level of gusts"});
    visit(self.gust_sigma_max,
          {"gust_sigma_max_m_s", "m/s", 0.001, 50.0, "Greatest level of gusts"});
    visit(self.gust_adaptation,
          {"gust_adaptation_s", "s", 0.5, 1e6, "Time in which the level of gusts is learnt"});
    visit(self.gate_false_rejection, {"gate_false_rejection", "-", 1e-12, 0.1,
                                      "Chance that the gate rejects a good measurement"});
  }
};

}  // namespace lodestar::strapdown
