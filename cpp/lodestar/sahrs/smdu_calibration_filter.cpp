// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/smdu_calibration_filter.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lodestar/filter/joseph.h"
#include "lodestar/math/scalar.h"

namespace lodestar::sahrs::smdu {
namespace {

using math::square;

constexpr double kSecond = 1e6;                   // us
constexpr std::int64_t kPatience_us = 1'000'000;  // of a sample, for the INS to get to its time

StateVector prior_sigma(const FilterParameters& p) {
  StateVector sigma = StateVector::Constant(p.matrix_sigma);
  sigma.segment<kBias.size>(kBias.offset).setConstant(p.bias_sigma);
  return sigma;
}

}  // namespace

CalibrationFilter::CalibrationFilter(const FilterParameters& parameters,
                                     earth::GeomagneticKind field_model, double epoch_year)
    : parameters_(parameters),
      drift_{parameters.drift_sigma, parameters.drift_tau},
      interval_us_(std::llround(kSecond * parameters.interval)),
      epoch_year_(epoch_year),
      field_model_(field_model),
      gate_(parameters.false_rejection) {
  P_.diagonal().segment<kStates.size>(kStates.offset) = prior_sigma(parameters).cwiseAbs2();
  P_.diagonal().segment<kSlowError.size>(kSlowError.offset).setConstant(square(drift_.sigma));
  P_.diagonal().segment<kReference.size>(kReference.offset) = reference_variance(parameters);
}

void CalibrationFilter::fail_ins() { ins_failed_ = ins_failed_ || running_; }

void CalibrationFilter::update(const samples::InsSolution& sample) {
  ins_.push(sample);
  if (!is_waiting_ || sample.time_us < waiting_.time_us) return;
  is_waiting_ = false;
  Eigen::Matrix3d C_NB;
  if (ins_.attitude_at(waiting_.time_us, C_NB)) correct(waiting_, C_NB);
}

void CalibrationFilter::update(const samples::MagneticField& sample) {
  if (!parameters_.enabled || ins_failed_ || ins_.empty()) return;
  const double silence = static_cast<double>(sample.time_us - ins_.latest().time_us) / kSecond;
  if (silence > parameters_.max_ins_silence) fail_ins();
  if (is_waiting_ && sample.time_us - waiting_.time_us < kPatience_us) return;
  if (running_ && sample.time_us - taken_us_ < interval_us_) return;
  if (ins_.latest().v_N.norm() < parameters_.min_ground_speed) return;
  taken_us_ = sample.time_us;
  Eigen::Matrix3d C_NB;
  is_waiting_ = sample.time_us > ins_.latest().time_us;
  if (is_waiting_) {
    waiting_ = sample;
  } else if (ins_.attitude_at(sample.time_us, C_NB)) {
    correct(sample, C_NB);
  }
}

// With b_cal(x) = true field + slow error + white noise for the true x, to first order
//     b_B + slow error - b_cal(x) = J dx - d slow error + reference_jacobian d reference - noise.
// J stands on the raw field that model and estimate predict, never on the measured one, whose noise
// would be in both and would pull D towards zero.
void CalibrationFilter::correct(const samples::MagneticField& sample, const Eigen::Matrix3d& C_NB) {
  if (running_) propagate(static_cast<double>(sample.time_us - used_us_) / kSecond);
  used_us_ = sample.time_us;
  running_ = true;
  const samples::InsSolution& at = ins_.latest();
  const Eigen::Vector3d b_B =
      C_NB.transpose() * field_model_.field_N(at.lat, at.lon, at.h, epoch_year_);
  const Eigen::Matrix3d matrix = estimate_.matrix();
  const Eigen::Vector3d predicted_raw = matrix.inverse() * (b_B + slow_error_B_ - estimate_.bias());
  const Eigen::Vector3d innovation = b_B + slow_error_B_ - (matrix * sample.b_B + estimate_.bias());

  Eigen::Matrix<double, 3, kAll> H;
  H.middleCols<kStates.size>(kStates.offset) = jacobian(predicted_raw);
  H.middleCols<kSlowError.size>(kSlowError.offset) = -Eigen::Matrix3d::Identity();
  H.middleCols<kReference.size>(kReference.offset) = reference_jacobian(C_NB, b_B);
  const Eigen::Matrix3d R = square(parameters_.noise) * Eigen::Matrix3d::Identity();
  const filter::JosephUpdate<kAll, 3> update(P_, H, R);
  const double normalised_square = update.normalised_square(innovation);
  if (!gate_.passes(normalised_square, 3)) {
    ++gated_;
    last_passed_ = false;
    return;
  }
  note(innovation.cwiseQuotient(update.S().diagonal().cwiseSqrt()), normalised_square);
  const Eigen::Matrix<double, kEstimated, 1> correction = update.apply<kEstimated>(P_, innovation);
  estimate_.x += correction.segment<kStates.size>(kStates.offset);
  slow_error_B_ += correction.segment<kSlowError.size>(kSlowError.offset);
}

void CalibrationFilter::propagate(double dt) {
  const double decay = drift_.decay(dt);
  slow_error_B_ *= decay;
  P_.middleRows<kSlowError.size>(kSlowError.offset) *= decay;
  P_.middleCols<kSlowError.size>(kSlowError.offset) *= decay;
  P_.diagonal().segment<kSlowError.size>(kSlowError.offset).array() += drift_.added_variance(dt);
  duration_ += std::min(dt, 2.0 * parameters_.interval);  // a hole is no flight time
}

void CalibrationFilter::note(const Eigen::Vector3d& normalised, double normalised_square) {
  ++used_;
  square_sum_ += normalised_square;
  if (last_passed_) {
    products_ += normalised.dot(last_);
    product_squares_ += normalised.norm() * last_.norm();
  }
  last_ = normalised;
  last_passed_ = true;
}

Calibration CalibrationFilter::calibration() const {
  Calibration calibration = estimate_;
  calibration.P = P_.topLeftCorner<kStates.size, kStates.size>();
  return calibration;
}

Checks CalibrationFilter::checks() const {
  Checks c;
  if (used_ == 0) return c;
  const double used = static_cast<double>(used_);
  c.duration = duration_;
  c.gated = static_cast<double>(gated_) / (used + static_cast<double>(gated_));
  c.residual = square_sum_ / (3.0 * used);
  if (product_squares_ > 0.0) c.correlation = products_ / product_squares_;
  // In units of the prior the information of the flight is inverse(P) - I, and its smallest
  // eigenvalue follows from the largest of P.
  const StateVector unit = prior_sigma(parameters_).cwiseInverse();
  const StateMatrix scaled =
      unit.asDiagonal() * P_.topLeftCorner<kStates.size, kStates.size>() * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<StateMatrix> eigen(scaled, Eigen::EigenvaluesOnly);
  c.observability = 1.0 / eigen.eigenvalues().maxCoeff() - 1.0;
  return c;
}

Verdict CalibrationFilter::verdict() const {
  const FilterParameters& p = parameters_;
  if (!p.enabled) return Verdict::kDisabled;
  if (!running_) return Verdict::kNoReference;
  if (ins_failed_) return Verdict::kInsFailed;
  const Checks c = checks();
  if (c.duration < p.min_duration) return Verdict::kTooShort;
  if (c.gated > p.max_gated) return Verdict::kGated;
  if (c.residual > p.max_residual) return Verdict::kResidual;
  if (std::abs(c.correlation) > p.max_correlation) return Verdict::kNotWhite;
  if (c.observability < p.min_observability) return Verdict::kNotObservable;
  return Verdict::kGood;
}

samples::SmduCalibration CalibrationFilter::status(std::int64_t time_us) const {
  samples::SmduCalibration status;
  status.time_us = time_us;
  status.x = estimate_.x;
  status.sigma = P_.diagonal().segment<kStates.size>(kStates.offset).cwiseSqrt();
  if (!running_) return status;
  status.state = samples::CalibrationState::kRunning;
  if (ins_failed_) status.state = samples::CalibrationState::kRefused;
  if (verdict() == Verdict::kGood) status.state = samples::CalibrationState::kObservable;
  return status;
}

}  // namespace lodestar::sahrs::smdu
