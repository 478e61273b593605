// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "lodestar/fusion/gps_acceptance.h"
#include "lodestar/math/gauss_markov.h"
#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"

namespace lodestar::fusion {

enum class CovarianceForm { kJoseph, kUd };
inline constexpr const char* kCovarianceFormNames[] = {"joseph", "ud"};

enum class Linearisation { kExtended, kLinearised };
inline constexpr const char* kLinearisationNames[] = {"extended", "linearised"};

/// What the three angle states are: errors of heading, pitch and roll, or the small rotation in N.
enum class AttitudeError { kEuler, kSmallAngle };
inline constexpr const char* kAttitudeErrorNames[] = {"euler", "small_angle"};

/// [fusion.cascade]: dead reckoning on SAHRS and air data, corrected by GPS. Time constants and the
/// levels of wind and GPS error are those of Linköping thesis §3.3.3.
struct CascadeParameters : GpsAcceptance {
  CovarianceForm covariance = CovarianceForm::kJoseph;
  Linearisation linearisation = Linearisation::kExtended;
  AttitudeError attitude_error = AttitudeError::kEuler;
  double step = 0.1;  // s

  // Errors of SAHRS; the levels are floors under what SAHRS says of itself.
  math::GaussMarkov heading_error{0.3 * math::kDegree, 100.0};
  math::GaussMarkov pitch_error{0.4 * math::kDegree, 30.0};
  math::GaussMarkov roll_error{0.6 * math::kDegree, 10.0};

  // Compass deviation: slow errors of the levelled magnetic components over the horizontal field.
  math::GaussMarkov heading_deviation{0.0, 1000.0};  // rad, s
  // What a standard-rate turn (3 deg/s) adds to the process noise, as a multiple of it.
  double heading_turn_gain = 0.0;
  double wind_turn_gain = 0.0;

  math::GaussMarkov wind{7.0, 4000.0};      // m/s, s
  math::GaussMarkov gps_error{5.0, 150.0};  // m, s
  double gps_noise = 1.0;                   // m

  // Air data: noise of one sample, independent at `air_data_rate`, and slow errors.
  double air_data_rate = 30.0;               // Hz
  double airspeed_noise = 0.5;               // m/s
  double alpha_noise = 0.1 * math::kDegree;  // rad
  double beta_noise = 0.1 * math::kDegree;   // rad
  double airspeed_bias = 1.0;                // m/s
  double beta_bias = 0.2 * math::kDegree;    // rad
  double air_data_timeout = 1.0;             // s
  double air_data_lost_noise = 2.0;          // (m/s)/sqrt(s)

  // Height.
  math::GaussMarkov baro_bias{20.0, 1000.0};         // m, s
  double baro_noise = 0.5;                           // m
  double baro_lag = 0.3;                             // s
  math::GaussMarkov vertical_rate_error{1.2, 10.0};  // m/s, s

  // Acceptance of GPS.
  double wind_change_false_alarm = 3e-3;  // -

  bool use_initial_heading = true;

  // What is known at the first frame: set by the navigator from [initial], not by a key here.
  std::optional<double> initial_heading;               // rad
  double initial_heading_sigma = 0.1 * math::kDegree;  // rad

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.covariance, {"covariance", kCovarianceFormNames, 2,
                            "How the covariance is carried; both give the same answers"});
    visit(self.linearisation, {"linearisation", kLinearisationNames, 2,
                               "About the corrected (extended) or the raw SAHRS values"});
    visit(self.attitude_error, {"attitude_error", kAttitudeErrorNames, 2,
                                "Angle states: Euler errors, or one small rotation in N"});
    visit(self.use_initial_heading, {"use_initial_heading", "-", 0.0, 1.0,
                                     "Start the heading error from [initial] heading_deg"});
    visit(self.step, {"step_s", "s", 0.05, 1.0, "Step of the error model"});
    describe_errors(self, visit);
    describe_heading_model(self, visit);
    describe_air_data(self, visit);
    describe_height(self, visit);
    visit(self.wind_change_false_alarm,
          {"wind_change_false_alarm", "-", 1e-12, 0.5,
           "Probability, per fix, that a steady wind is taken for a changed one"});
    describe_acceptance(self, visit);
  }

 private:
  template <class Self, class Visitor>
  static void describe_errors(Self& self, Visitor&& visit) {
    using math::kDegree;
    visit(self.heading_error.sigma, {"heading_error_sigma_deg", "deg", 0.01, 90.0,
                                     "Heading error of SAHRS, at least", kDegree});
    visit(self.heading_error.tau,
          {"heading_error_tau_s", "s", 1.0, 1e5, "Time constant of the heading error"});
    visit(self.pitch_error.sigma,
          {"pitch_error_sigma_deg", "deg", 0.01, 90.0, "Pitch error of SAHRS, at least", kDegree});
    visit(self.pitch_error.tau,
          {"pitch_error_tau_s", "s", 1.0, 1e5, "Time constant of the pitch error"});
    visit(self.roll_error.sigma,
          {"roll_error_sigma_deg", "deg", 0.01, 90.0, "Roll error of SAHRS, at least", kDegree});
    visit(self.roll_error.tau,
          {"roll_error_tau_s", "s", 1.0, 1e5, "Time constant of the roll error"});
    visit(self.wind.sigma, {"wind_sigma_m_s", "m/s", 0.01, 100.0, "Wind, per axis"});
    visit(self.wind.tau, {"wind_tau_s", "s", 1.0, 1e6, "Time constant of the wind"});
    visit(self.gps_error.sigma,
          {"gps_error_sigma_m", "m", 0.01, 1e3, "Slow error of a GPS position, per axis"});
    visit(self.gps_error.tau,
          {"gps_error_tau_s", "s", 1.0, 1e5, "Time constant of the slow GPS error"});
    visit(self.gps_noise,
          {"gps_noise_m", "m", 0.01, 1e3, "White noise of a GPS position, per axis"});
  }

  template <class Self, class Visitor>
  static void describe_heading_model(Self& self, Visitor&& visit) {
    using math::kDegree;
    visit(self.heading_deviation.sigma,
          {"heading_deviation_sigma_deg", "deg", 0.0, 45.0,
           "Heading error as a compass has it, sine and cosine of heading; 0: none", kDegree});
    visit(self.heading_deviation.tau,
          {"heading_deviation_tau_s", "s", 1.0, 1e6, "Its time constant"});
    visit(self.heading_turn_gain, {"heading_turn_gain", "-", 0.0, 1e4,
                                   "Process noise of the heading error that a turn of 3 deg/s "
                                   "adds, as a multiple of that of straight flight"});
    visit(self.wind_turn_gain, {"wind_turn_gain", "-", 0.0, 1e4, "The same of the wind"});
  }

  template <class Self, class Visitor>
  static void describe_air_data(Self& self, Visitor&& visit) {
    using math::kDegree;
    visit(self.air_data_rate, {"air_data_rate_hz", "Hz", 1.0, 1000.0,
                               "Rate at which the noise of air data is independent"});
    visit(self.airspeed_noise,
          {"airspeed_noise_m_s", "m/s", 0.0, 50.0, "Noise of one sample of true airspeed"});
    visit(self.alpha_noise,
          {"alpha_noise_deg", "deg", 0.0, 20.0, "Noise of one sample of angle of attack", kDegree});
    visit(self.beta_noise,
          {"beta_noise_deg", "deg", 0.0, 20.0, "Noise of one sample of sideslip", kDegree});
    visit(self.airspeed_bias, {"airspeed_bias_m_s", "m/s", 0.0, 50.0,
                               "Constant error of true airspeed: part of the wind's sigma"});
    visit(self.beta_bias, {"beta_bias_deg", "deg", 0.0, 20.0,
                           "Constant error of sideslip: part of the heading's sigma", kDegree});
    visit(self.air_data_timeout,
          {"air_data_timeout_s", "s", 0.05, 60.0, "Silence after which air data are only held"});
    visit(self.air_data_lost_noise, {"air_data_lost_noise", "(m/s)/sqrt(s)", 0.0, 100.0,
                                     "Growth of the velocity error while they are"});
  }

  template <class Self, class Visitor>
  static void describe_height(Self& self, Visitor&& visit) {
    visit(self.baro_bias.sigma,
          {"baro_bias_sigma_m", "m", 0.01, 1e4, "Height above the ellipsoid minus baro altitude"});
    visit(self.baro_bias.tau, {"baro_bias_tau_s", "s", 1.0, 1e6, "Its time constant"});
    visit(self.baro_noise, {"baro_noise_m", "m", 0.01, 100.0, "Noise of one baro altitude"});
    visit(self.baro_lag, {"baro_lag_s", "s", 0.0, 5.0, "Lag of baro altitude"});
    visit(self.vertical_rate_error.sigma,
          {"vertical_rate_error_sigma_m_s", "m/s", 0.01, 100.0,
           "Error of the climb rate that attitude and air data give"});
    visit(self.vertical_rate_error.tau,
          {"vertical_rate_error_tau_s", "s", 0.1, 1e5, "Its time constant"});
  }
};

}  // namespace lodestar::fusion
