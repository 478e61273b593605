// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "lodestar/math/gauss_markov.h"
#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"

namespace lodestar::sahrs {

/// Names of the forms: VelocitySahrs and PaperSahrs.
inline constexpr const char* kFormNames[] = {"velocity", "paper"};

/// What the measurements take for granted, in the order of
/// HEALTH.assumption_rejects. The first that fails is the one counted.
enum class Assumption : std::uint8_t {
  kAirspeed,        // the aircraft flies, and the air data are fresh
  kClimbRate,       // the filter of the rate of climb has settled
  kSteadyVelocity,  // the air velocity in B hardly changes
  kSideslip,        // |beta| is small
  kLateralLoad,     // |n_y| is small
  kBodyRate,        // |omega| is bounded
  kPitchAngle,      // pitch is away from +-90 degrees
  kBalance,         // load factor and centripetal force leave a vector of gravity's size
  kFieldStrength,   // the field is as strong as the model has it
  kLiveFlow,        // airspeed, alpha and beta are not frozen
};
inline constexpr int kAssumptions = 10;
inline constexpr const char* kAssumptionNames[kAssumptions] = {
    "airspeed",  "climb rate",  "steady velocity", "sideslip",       "lateral load",
    "body rate", "pitch angle", "balance",         "field strength", "live flow"};

/// [smdu_calibration]: b_cal = matrix b_raw + bias (SAHRS paper §5: matrix = I + D).
struct FieldCalibration {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();  // nT
  std::optional<double> bias_sigma;                // nT
  std::optional<double> matrix_sigma;              // -

  /// The field (nT) of what was measured.
  Eigen::Vector3d apply(const Eigen::Vector3d& raw_B) const { return matrix * raw_B + bias; }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.bias, {"bias_nT", "nT", -200e3, 200e3, "Added to the raw field"});
    visit(self.matrix, {"matrix", "-", -2.0, 2.0, "Multiplies the raw field, three rows"});
    visit(self.bias_sigma,
          {"bias_sigma_nT", "nT", 0.1, 1e5,
           "Bias that it leaves, 1 sigma per axis; unset: as SAHRS's own section has it"});
    visit(self.matrix_sigma,
          {"matrix_sigma", "-", 0.0, 0.2,
           "Scale and misalignment that it leaves, 1 sigma per matrix element; unset: likewise"});
  }
};

/// [sahrs]: the sensors' errors as a fighter's suite has them, and what its measurements assume.
struct Parameters {
  static constexpr double kDegree = math::kDegree;
  static constexpr double kG0 = samples::kStandardGravity;

  samples::SahrsForm form = samples::SahrsForm::kVelocity;

  // Gyros.
  double gyro_noise = 0.0065 * kDegree;                 // rad/s/sqrt(Hz)
  math::GaussMarkov gyro_bias{0.2 * kDegree, 13000.0};  // rad/s, s
  double gyro_scale_sigma = 0.003;                      // -
  double gyro_misalignment_sigma = 0.2 * kDegree;       // rad
  double gyro_gap_noise = 30.0 * kDegree;               // rad/s/sqrt(s)

  // Magnetic field.
  double field_noise = 80.0;                  // nT
  math::GaussMarkov field_drift{60.0, 10.0};  // nT, s
  math::GaussMarkov field_bias{500.0, 1e6};   // nT, s
  double field_matrix_sigma = 0.003;          // -

  // Air data.
  double alpha_noise = 0.1 * kDegree;       // rad
  double alpha_bias_sigma = 0.3 * kDegree;  // rad
  double beta_bias_sigma = 0.3 * kDegree;   // rad
  double baro_lag = 0.3;                    // s
  double climb_filter_bandwidth = 1.0;      // rad/s
  double climb_rate_sigma = 0.2;            // m/s
  double vertical_wind_sigma = 1.0;         // m/s
  double vertical_wind_length = 400.0;      // m

  // Load factor.
  double load_noise = 0.02 * kG0;                      // m/s^2
  math::GaussMarkov neglected_force{0.01 * kG0, 2.0};  // m/s^2, s

  // What the pitch and roll measurements take for granted.
  double min_airspeed = 60.0;             // m/s
  double max_speed_rate = 0.3 * kG0;      // m/s^2
  double max_flow_rate = 0.4 * kG0;       // m/s^2
  double max_sideslip = 5.0 * kDegree;    // rad
  double max_lateral_load = 0.1;          // g0
  double max_body_rate = 20.0 * kDegree;  // rad/s
  double max_pitch = 60.0 * kDegree;      // rad
  double max_imbalance = 0.15;            // of gravity
  double max_field_strength_error = 0.1;  // of the model's field

  double false_rejection = 1e-4;                    // -
  double max_valid_tilt_sigma = 5.0 * kDegree;      // rad
  double max_valid_heading_sigma = 10.0 * kDegree;  // rad

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.form, {"form", kFormNames, 2,
                      "Velocity-aided, with the parameters of [strapdown], or as in the paper"});
    describe_sensors(self, visit);
    describe_checks(self, visit);
  }

 private:
  template <class Self, class Visitor>
  static void describe_sensors(Self& self, Visitor&& visit) {
    visit(self.gyro_noise, {"gyro_noise_deg_s_rthz", "deg/s/sqrt(Hz)", 1e-6, 10.0,
                            "White noise of the body rates", kDegree});
    visit(self.gyro_bias.sigma, {"gyro_bias_sigma_deg_s", "deg/s", 1e-6, 10.0,
                                 "Bias of the body rates, 1 sigma", kDegree});
    visit(self.gyro_bias.tau,
          {"gyro_bias_tau_s", "s", 10.0, 1e9,
           "Time constant of that bias: with in-run drift of sigma d over T, T (sigma / d)^2"});
    visit(self.gyro_scale_sigma,
          {"gyro_scale_sigma", "-", 0.0, 0.2, "Scale-factor error of the body rates, 1 sigma"});
    visit(self.gyro_misalignment_sigma, {"gyro_misalignment_sigma_deg", "deg", 0.0, 10.0,
                                         "Misalignment of the gyro axes, 1 sigma", kDegree});
    visit(self.gyro_gap_noise,
          {"gyro_gap_noise_deg_s_rts", "deg/s/sqrt(s)", 0.0, 1e3,
           "Random walk of the body rates while samples are missing", kDegree});
    visit(self.field_noise,
          {"field_noise_nT", "nT", 0.1, 1e5, "White noise of the field, per axis"});
    visit(self.field_drift.sigma,
          {"field_drift_sigma_nT", "nT", 0.0, 1e5, "Slow error of the field, 1 sigma per axis"});
    visit(self.field_drift.tau, {"field_drift_tau_s", "s", 0.01, 1e3,
                                 "Time over which it stays alike, or 10 s if that is less"});
    visit(self.field_bias.sigma, {"field_bias_sigma_nT", "nT", 0.1, 1e5,
                                  "Bias of the field left after calibration, 1 sigma per axis"});
    visit(self.field_bias.tau, {"field_bias_tau_s", "s", 10.0, 1e9, "Time constant of that bias"});
    visit(self.field_matrix_sigma,
          {"field_matrix_sigma", "-", 0.0, 0.2,
           "Scale and misalignment left after calibration, 1 sigma per matrix element"});
    visit(self.alpha_noise,
          {"alpha_noise_deg", "deg", 1e-3, 20.0, "White noise of alpha", kDegree});
    visit(self.alpha_bias_sigma,
          {"alpha_bias_sigma_deg", "deg", 0.0, 20.0, "Bias of alpha, 1 sigma", kDegree});
    visit(self.beta_bias_sigma,
          {"beta_bias_sigma_deg", "deg", 0.0, 20.0, "Bias of beta, 1 sigma", kDegree});
    visit(self.baro_lag, {"baro_lag_s", "s", 0.0, 5.0, "First-order lag of the baro altitude"});
    visit(self.climb_filter_bandwidth,
          {"climb_filter_bandwidth_rad_s", "rad/s", 0.05, 2.0,
           "Bandwidth of the filter that makes the rate of climb of altitude and load factor"});
    visit(self.climb_rate_sigma,
          {"climb_rate_sigma_m_s", "m/s", 1e-3, 50.0, "Error of the rate of climb, 1 sigma"});
    visit(self.vertical_wind_sigma,
          {"vertical_wind_sigma_m_s", "m/s", 0.0, 50.0, "Vertical wind, 1 sigma"});
    visit(self.vertical_wind_length, {"vertical_wind_length_m", "m", 1.0, 1e4,
                                      "Way through the air over which it stays alike"});
    visit(self.load_noise,
          {"load_noise_g", "g0", 1e-4, 10.0, "White noise of the load factor", kG0});
    visit(self.neglected_force.sigma,
          {"neglected_force_sigma_g", "g0", 1e-4, 10.0,
           "What the roll measurement neglects (n_y, change of the air velocity in B), 1 sigma",
           kG0});
    visit(self.neglected_force.tau,
          {"neglected_force_tau_s", "s", 0.01, 100.0, "Time over which that stays alike"});
  }

  template <class Self, class Visitor>
  static void describe_checks(Self& self, Visitor&& visit) {
    visit(self.min_airspeed, {"min_airspeed_m_s", "m/s", 1.0, 500.0,
                              "Airspeed from which air data give pitch and roll"});
    visit(self.max_speed_rate,
          {"max_speed_rate_g", "g0", 1e-3, 10.0, "Largest |dV/dt| for roll", kG0});
    visit(self.max_flow_rate, {"max_flow_rate_g", "g0", 1e-3, 10.0,
                               "Largest V |dalpha/dt| and V |dbeta/dt| for roll", kG0});
    visit(self.max_sideslip,
          {"max_sideslip_deg", "deg", 0.1, 45.0, "Largest |beta| for pitch and roll", kDegree});
    visit(self.max_lateral_load,
          {"max_lateral_load_g", "g0", 1e-3, 10.0, "Largest |n_y| for roll"});
    visit(self.max_body_rate,
          {"max_body_rate_deg_s", "deg/s", 0.1, 1000.0, "Largest |omega| for roll", kDegree});
    visit(self.max_pitch,
          {"max_pitch_deg", "deg", 1.0, 85.0, "Largest |pitch| for pitch and roll", kDegree});
    visit(self.max_imbalance,
          {"max_imbalance", "-", 1e-3, 0.9,
           "Largest error in the size of gravity, as load factor and rates have it, for roll"});
    visit(
        self.max_field_strength_error,
        {"max_field_strength_error", "-", 1e-3, 10.0,
         "Largest error in the strength of the field, less its bias, for its direction to count"});
    visit(self.false_rejection, {"false_rejection", "-", 1e-12, 0.1,
                                 "Probability that the gate rejects a good measurement"});
    visit(self.max_valid_tilt_sigma, {"max_valid_tilt_sigma_deg", "deg", 0.01, 90.0,
                                      "Sigma of tilt up to which the attitude is valid", kDegree});
    visit(self.max_valid_heading_sigma,
          {"max_valid_heading_sigma_deg", "deg", 0.01, 180.0,
           "Sigma of heading up to which the attitude is valid", kDegree});
  }
};

}  // namespace lodestar::sahrs
