// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"
#include "lodestar/math/state_layout.h"

/// Calibration of the magnetic detector (SMDU): b_cal = (I + D) b_raw + bias (SAHRS paper §5).
namespace lodestar::sahrs::smdu {

// The twelve states x of a calibration, in the order of SMDU.CALIBRATION.
inline constexpr math::Block kBias{0, 3};                             // nT
inline constexpr math::Block kScale = math::after(kBias, 3);          // D_xx, D_yy, D_zz
inline constexpr math::Block kMisalignment = math::after(kScale, 6);  // D_xy xz, yx yz, zx zy
inline constexpr int kCalibrationStates = math::end(kMisalignment);
static_assert(kCalibrationStates == 12);

using StateVector = Eigen::Matrix<double, kCalibrationStates, 1>;
using StateMatrix = Eigen::Matrix<double, kCalibrationStates, kCalibrationStates>;

/// Where the element (row, column) of D lies in x.
constexpr int state_of_D(int row, int column) {
  if (row == column) return kScale.offset + row;
  return kMisalignment.offset + 2 * row + (column < row ? column : column - 1);
}

/// A calibration and how well it is known.
struct Calibration {
  StateVector x = StateVector::Zero();
  StateMatrix P = StateMatrix::Zero();  // covariance of x

  Eigen::Vector3d bias() const { return x.segment<kBias.size>(kBias.offset); }
  /// I + D.
  Eigen::Matrix3d matrix() const;
  StateVector sigma() const { return P.diagonal().cwiseSqrt(); }
};

/// d b_cal / d x at the raw field `b_raw` (nT).
Eigen::Matrix<double, 3, kCalibrationStates> jacobian(const Eigen::Vector3d& b_raw);

/// The covariance of x in the two numbers that SAHRS starts from, as if bias and matrix were
/// independent and alike in every axis and element.
struct Spread {
  double bias;    // nT, 1 sigma of the bias once the matrix is known
  double matrix;  // 1 sigma of an element of D
};
Spread spread(const StateMatrix& P);

/// Why a calibration is not worth storing, in the order in which it is asked.
enum class Verdict : std::uint8_t {
  kGood,
  kDisabled,       // switched off
  kNoReference,    // detector and INS were never seen together in flight
  kInsFailed,      // the INS failed, or fell silent, after it had been used
  kTooShort,       // too little time with samples
  kGated,          // too many samples contradict the rest
  kResidual,       // what is left is larger than its sigma
  kNotWhite,       // what is left is alike from sample to sample
  kNotObservable,  // too little of the sphere was seen to tell the states apart
};
inline constexpr const char* kVerdictNames[] = {
    "good",           "disabled",           "no INS reference",   "INS failed",    "too short",
    "too many gated", "residual too large", "residual not white", "not observable"};

inline const char* name(Verdict verdict) {
  return kVerdictNames[static_cast<std::size_t>(verdict)];
}

/// What the verdict stands on.
struct Checks {
  double duration = 0.0;       // s, of samples used
  double gated = 0.0;          // share of the samples that the gate kept out
  double residual = 0.0;       // mean square of the normalised innovation; ideally 1
  double correlation = 0.0;    // of the normalised innovation with the one before; ideally 0
  double observability = 0.0;  // see FilterParameters::min_observability
};

/// [smdu_calibration_filter]: the in-flight calibration by the INS, and what a stored one may have
/// changed by until it is used.
struct FilterParameters {
  static constexpr double kDegree = math::kDegree;

  bool enabled = true;
  double interval = 0.25;          // s
  double min_ground_speed = 30.0;  // m/s

  // What is known beforehand.
  double bias_sigma = 2000.0;  // nT
  double matrix_sigma = 0.02;  // -

  // Errors of a sample.
  double noise = 80.0;                       // nT
  double drift_sigma = 60.0;                 // nT
  double drift_tau = 60.0;                   // s
  double ins_tilt_sigma = 0.05 * kDegree;    // rad
  double ins_heading_sigma = 0.1 * kDegree;  // rad
  double field_model_sigma = 30.0;           // nT
  double false_rejection = 1e-4;             // -

  // What makes a good flight.
  double max_ins_silence = 5.0;      // s
  double min_duration = 600.0;       // s
  double max_gated = 0.02;           // -
  double max_residual = 1.5;         // -
  double max_correlation = 0.1;      // -
  double min_observability = 100.0;  // -

  // What may change from one flight to the next.
  double change_bias_sigma = 75.0;      // nT
  double change_matrix_sigma = 0.0005;  // -

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.enabled, {"enabled", "-", 0.0, 1.0, "Calibrate the SMDU by the INS in flight"});
    visit(self.interval, {"interval_s", "s", 0.01, 10.0, "Time between the samples it takes"});
    visit(self.min_ground_speed, {"min_ground_speed_m_s", "m/s", 0.0, 500.0,
                                  "INS speed from which it takes them: what stands around on the "
                                  "ground is magnetic, too"});
    describe_errors(self, visit);
    describe_checks(self, visit);
  }

 private:
  template <class Self, class Visitor>
  static void describe_errors(Self& self, Visitor&& visit) {
    visit(self.bias_sigma,
          {"bias_sigma_nT", "nT", 1.0, 1e5, "Bias before the flight, 1 sigma per axis"});
    visit(self.matrix_sigma, {"matrix_sigma", "-", 1e-5, 0.5,
                              "Scale and misalignment before it, 1 sigma per matrix element"});
    visit(self.noise, {"noise_nT", "nT", 0.1, 1e5, "White noise of the field, per axis"});
    visit(self.drift_sigma,
          {"drift_sigma_nT", "nT", 0.1, 1e5, "Slow error of the field, 1 sigma per axis"});
    visit(self.drift_tau, {"drift_tau_s", "s", 0.1, 1e5, "Its correlation time"});
    visit(self.ins_tilt_sigma, {"ins_tilt_sigma_deg", "deg", 0.0, 20.0,
                                "Roll and pitch error of the INS, which lasts, 1 sigma", kDegree});
    visit(self.ins_heading_sigma, {"ins_heading_sigma_deg", "deg", 0.0, 20.0,
                                   "Heading error of the INS, which lasts, 1 sigma", kDegree});
    visit(self.field_model_sigma, {"field_model_sigma_nT", "nT", 0.0, 1e4,
                                   "Error of the field model, which lasts, 1 sigma per axis"});
    visit(self.false_rejection,
          {"false_rejection", "-", 1e-12, 0.1, "Probability that the gate rejects a good sample"});
  }

  template <class Self, class Visitor>
  static void describe_checks(Self& self, Visitor&& visit) {
    visit(self.max_ins_silence,
          {"max_ins_silence_s", "s", 0.3, 600.0, "Silence after which the INS counts as failed"});
    visit(self.min_duration,
          {"min_duration_s", "s", 10.0, 1e5, "Least flight time with samples of both"});
    visit(self.max_gated, {"max_gated", "-", 0.0, 1.0, "Largest share of gated samples"});
    visit(self.max_residual,
          {"max_residual", "-", 1.0, 100.0, "Largest mean square of the normalised innovation"});
    visit(self.max_correlation, {"max_correlation", "-", 0.0, 1.0,
                                 "Largest correlation of an innovation with the one before"});
    visit(self.min_observability,
          {"min_observability", "-", 0.0, 1e9,
           "Least information of the flight, in units of that before it, in any direction of x"});
    visit(self.change_bias_sigma, {"change_bias_sigma_nT", "nT", 0.0, 1e5,
                                   "Change of the bias until a stored calibration is used"});
    visit(self.change_matrix_sigma,
          {"change_matrix_sigma", "-", 0.0, 0.2, "Change of a matrix element until then"});
  }
};

}  // namespace lodestar::sahrs::smdu
