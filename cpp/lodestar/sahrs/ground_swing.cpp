// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/ground_swing.h"

#include <algorithm>
#include <cmath>

#include "lodestar/filter/joseph.h"
#include "lodestar/math/scalar.h"

namespace lodestar::sahrs::smdu {
namespace {

using math::square;

constexpr double kSecond = 1e6;  // us

}  // namespace

GroundSwing::GroundSwing(const SwingParameters& parameters, const FilterParameters& errors)
    : parameters_(parameters),
      noise_(errors.noise),
      drift_{errors.drift_sigma, errors.drift_tau},
      interval_us_(std::llround(kSecond * errors.interval)),
      gate_(errors.false_rejection) {
  const auto set = [this](math::Block block, double sigma) {
    P_.diagonal().segment(block.offset, block.size).setConstant(square(sigma));
  };
  set(kSwingBias, errors.bias_sigma);
  set(kCommonScale, parameters.scale_sigma);
  set(kSlowError, errors.drift_sigma);
  set(kElements, parameters.element_sigma);
  P_.diagonal().segment<kReference.size>(kReference.offset) = reference_variance(errors);
}

void GroundSwing::add(std::int64_t time_us, const Eigen::Matrix3d& C_NB,
                      const Eigen::Vector3d& b_raw, const Eigen::Vector3d& b_N) {
  const bool first = used_ + gated_ == 0;
  if (!first && time_us - last_us_ < interval_us_) return;
  const math::Euler attitude = math::euler_from_C_NB(C_NB);
  if (std::max(std::abs(attitude.roll), std::abs(attitude.pitch)) > parameters_.max_tilt) return;
  const double dt = first ? 0.0 : static_cast<double>(time_us - last_us_) / kSecond;
  last_us_ = time_us;
  auto slow_error = x_.segment<kSlowError.size>(kSlowError.offset);
  slow_error *= drift_.decay(dt);
  P_.middleRows<kSlowError.size>(kSlowError.offset) *= drift_.decay(dt);
  P_.middleCols<kSlowError.size>(kSlowError.offset) *= drift_.decay(dt);
  P_.diagonal().segment<kSlowError.size>(kSlowError.offset).array() += drift_.added_variance(dt);

  // As in CalibrationFilter, with D = scale I + elements.
  const Eigen::Vector3d b_B = C_NB.transpose() * b_N;
  const Eigen::Vector3d bias = x_.segment<kSwingBias.size>(kSwingBias.offset);
  const double scale = x_(kCommonScale.offset);
  const Eigen::Vector3d wanted = b_B + slow_error;
  const Eigen::Vector3d innovation = wanted - ((1.0 + scale) * b_raw + bias);
  const Eigen::Vector3d predicted_raw = (wanted - bias) / (1.0 + scale);
  Eigen::Matrix<double, 3, kAll> H = Eigen::Matrix<double, 3, kAll>::Zero();
  H.middleCols<kSwingBias.size>(kSwingBias.offset).setIdentity();
  H.col(kCommonScale.offset) = predicted_raw;
  H.middleCols<kSlowError.size>(kSlowError.offset) = -Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    H.row(i).segment<3>(kElements.offset + 3 * i) = predicted_raw.transpose();
  }
  H.middleCols<kReference.size>(kReference.offset) = reference_jacobian(C_NB, b_B);

  const Eigen::Matrix3d R = square(noise_) * Eigen::Matrix3d::Identity();
  const filter::JosephUpdate<kAll, 3> update(P_, H, R);
  const double normalised_square = update.normalised_square(innovation);
  if (!gate_.passes(normalised_square, 3)) {
    ++gated_;
    return;
  }
  ++used_;
  square_sum_ += normalised_square;
  x_ += update.apply<kEstimated>(P_, innovation);
  const int sector = static_cast<int>(attitude.heading / (2.0 * math::kPi) * kSectors);
  seen_[static_cast<std::size_t>(std::min(sector, kSectors - 1))] = true;
}

Calibration GroundSwing::calibration() const {
  Calibration c;
  Eigen::Matrix<double, kCalibrationStates, kAll> T =
      Eigen::Matrix<double, kCalibrationStates, kAll>::Zero();
  T.block<3, 3>(kBias.offset, kSwingBias.offset).setIdentity();
  T.block<3, 1>(kScale.offset, kCommonScale.offset).setOnes();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T(state_of_D(i, j), kElements.offset + 3 * i + j) = 1.0;
  }
  c.x = T.leftCols<kEstimated>() * x_;
  const StateMatrix P = T * P_ * T.transpose();
  c.P = 0.5 * (P + P.transpose());
  return c;
}

int GroundSwing::sectors() const {
  return static_cast<int>(std::count(seen_.begin(), seen_.end(), true));
}

double GroundSwing::residual() const {
  return used_ == 0 ? 0.0 : square_sum_ / (3.0 * static_cast<double>(used_));
}

double GroundSwing::gated() const {
  const std::int64_t all = used_ + gated_;
  return all == 0 ? 0.0 : static_cast<double>(gated_) / static_cast<double>(all);
}

SwingVerdict GroundSwing::verdict() const {
  const SwingParameters& p = parameters_;
  if (used_ + gated_ == 0) return SwingVerdict::kNoSamples;
  if (gated() > p.max_gated) return SwingVerdict::kGated;
  if (sectors() < p.min_sectors) return SwingVerdict::kHeadings;
  if (residual() > p.max_residual) return SwingVerdict::kResidual;
  const double bias_variance = P_.diagonal().head<2>().maxCoeff();
  const double scale_variance = P_(kCommonScale.offset, kCommonScale.offset);
  if (bias_variance > square(p.max_bias_sigma) || scale_variance > square(p.max_scale_sigma)) {
    return SwingVerdict::kUncertain;
  }
  return SwingVerdict::kGood;
}

}  // namespace lodestar::sahrs::smdu
