// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/sahrs/smdu_calibration_filter.h"

namespace lodestar::sahrs_test {

using math::kDegree;
using namespace sahrs::smdu;  // NOLINT: what these tests are about

/// How a synthetic flight differs from what the filter takes for granted.
struct CalibrationFlight {
  double duration = 2400.0;           // s
  double bank_max = 60.0 * kDegree;   // rad
  double pitch_max = 10.0 * kDegree;  // rad
  bool turns = true;
  double drift_factor = 1.0;    // of the detector's slow error
  double white_factor = 1.0;    // of its noise
  double bias_sigma = 500.0;    // nT
  double matrix_sigma = 0.003;  // -
  double speed = 200.0;         // m/s
  double ins_offset = 0.0;      // s, of the INS's time from the detector's
};

/// Attitudes of turns and straight legs, an INS with a lasting error, a detector with a slow one.
class CalibrationSimulator {
 public:
  CalibrationSimulator(unsigned seed, const CalibrationFlight& flight,
                       const FilterParameters& errors)
      : flight_(flight), errors_(errors), random_(seed) {
    earth::GeomagneticModel model(earth::GeomagneticKind::kIgrf14);
    b_N_ = model.field_N(kLat, kLon, kHeight, kYear) + normal3(errors.field_model_sigma);
    for (int i = 0; i < kCalibrationStates; ++i) {
      truth_.x(i) = normal(i < kBias.size ? flight.bias_sigma : flight.matrix_sigma);
    }
    ins_error_ = {normal(errors.ins_tilt_sigma), normal(errors.ins_tilt_sigma),
                  normal(errors.ins_heading_sigma)};
    slow_ = normal3(flight.drift_factor * errors.drift_sigma);
    heading_ = uniform(0.0, 2.0 * math::kPi);
  }

  bool over() const { return time_ >= flight_.duration; }

  void step(double dt = 0.125) {
    time_ += dt;
    if (time_ >= leg_end_) choose_leg();
    bank_ += (bank_command_ - bank_) * dt / 2.0;
    pitch_ += (pitch_command_ - pitch_) * dt / 3.0;
    heading_ += dt * 9.81 / 200.0 * std::tan(bank_);
    const math::GaussMarkov drift{flight_.drift_factor * errors_.drift_sigma, errors_.drift_tau};
    slow_ = drift.decay(dt) * slow_ + normal3(std::sqrt(drift.added_variance(dt)));
  }

  std::int64_t time_us() const { return std::llround(1e6 * time_); }
  Eigen::Matrix3d C_NB() const { return math::C_NB_from_euler({bank_, pitch_, heading_}); }
  const Eigen::Vector3d& b_N() const { return b_N_; }

  samples::MagneticField magnetic_field() {
    const Eigen::Vector3d b_cal = C_NB().transpose() * b_N_ + slow_;
    const Eigen::Vector3d b_raw = truth_.matrix().inverse() * (b_cal - truth_.bias());
    return {time_us(), b_raw + normal3(flight_.white_factor * errors_.noise), true};
  }

  samples::InsSolution ins() {
    samples::InsSolution s;
    s.time_us = time_us() + std::llround(1e6 * flight_.ins_offset);
    s.roll = bank_ + ins_error_.x();
    s.pitch = pitch_ + ins_error_.y();
    s.heading = math::wrap_2pi(heading_ + ins_error_.z());
    s.lat = kLat;
    s.lon = kLon;
    s.h = kHeight;
    s.v_N = {flight_.speed, 0.0, 0.0};
    return s;
  }

  const Calibration& truth() const { return truth_; }

  static constexpr double kLat = 58.0 * kDegree;
  static constexpr double kLon = 16.0 * kDegree;
  static constexpr double kHeight = 3000.0;
  static constexpr double kYear = 2026.5;

 private:
  void choose_leg() {
    const bool turn = flight_.turns && uniform(0.0, 1.0) < 0.6;
    const double side = uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    bank_command_ = turn ? side * uniform(0.3, 1.0) * flight_.bank_max : 0.0;
    pitch_command_ = uniform(-1.0, 1.0) * flight_.pitch_max;
    leg_end_ = time_ + uniform(20.0, turn ? 60.0 : 120.0);
  }
  double normal(double sigma) { return sigma * gaussian_(random_); }
  Eigen::Vector3d normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Calibration truth_;
  CalibrationFlight flight_;
  FilterParameters errors_;
  std::mt19937_64 random_;
  std::normal_distribution<double> gaussian_;
  Eigen::Vector3d b_N_, ins_error_, slow_;
  double time_ = 0.0, leg_end_ = 0.0, heading_ = 0.0;
  double bank_ = 0.0, bank_command_ = 0.0, pitch_ = 0.0, pitch_command_ = 0.0;
};

inline CalibrationFilter make_filter(const FilterParameters& parameters = {}) {
  return CalibrationFilter(parameters, earth::GeomagneticKind::kIgrf14,
                           CalibrationSimulator::kYear);
}

/// One step of the simulator into the filter, the detector ahead of the INS as on the bus.
inline void feed(CalibrationSimulator& simulator, CalibrationFilter& filter) {
  simulator.step();
  filter.update(simulator.magnetic_field());
  filter.update(simulator.ins());
}

inline void fly(CalibrationSimulator& simulator, CalibrationFilter& filter) {
  while (!simulator.over()) feed(simulator, filter);
}

/// Error of `estimate`, squared in units of its covariance: chi-square of twelve degrees.
inline double normalised_error(const Calibration& estimate, const Calibration& truth) {
  const StateVector error = estimate.x - truth.x;
  return error.dot(estimate.P.ldlt().solve(error));
}

}  // namespace lodestar::sahrs_test
