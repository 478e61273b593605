// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/error_model.h"

#include <cmath>

#include "lodestar/math/discretise.h"
#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {
namespace {

constexpr double kSlowStep = 0.1;                    // s
constexpr double kManoeuvre = 90.0 * math::kDegree;  // rad, see turn_noise
constexpr double kRateFloor = 1.0 * math::kDegree;   // rad/s, see turn_noise

Eigen::Block<Covariance, 3, 3> diagonal_block(Covariance& P, math::Block block) {
  return P.block<3, 3>(block.offset, block.offset);
}

/// Variance per second that an error of `sigma` per radian turned adds while turning at `rate`.
/// A scale-factor error adds up over a manoeuvre and comes off again in the next one, the other
/// way. White noise that grows as much over a turn of the angle kManoeuvre has sigma^2 |rate|
/// kManoeuvre per second: (sigma kManoeuvre)^2 over kManoeuvre / |rate|. Below kRateFloor it falls
/// off faster, so that the gyro's own noise does not pass for a turn.
double turn_noise(double sigma, double rate) {
  return sigma * sigma * kManoeuvre * rate * rate / (std::abs(rate) + kRateFloor);
}

using AttitudeRows = Eigen::Matrix<double, kAttitude.size, kStates>;

/// Puts `rows` into P as the rows and columns of the attitude, `attitude` where they cross, made
/// symmetric to the last bit.
void set_attitude_rows(Covariance& P, const AttitudeRows& rows, const Eigen::Matrix3d& attitude) {
  constexpr int kRest = kStates - kAttitude.size;
  P.topLeftCorner<3, 3>() = 0.5 * (attitude + attitude.transpose());
  P.topRightCorner<3, kRest>() = rows.rightCols<kRest>();
  P.bottomLeftCorner<kRest, 3>() = P.topRightCorner<3, kRest>().transpose();
}

void decay(Covariance& P, math::Block block, double factor) {
  P.middleRows<3>(block.offset) *= factor;
  P.middleCols<3>(block.offset) *= factor;
}

}  // namespace

Covariance ErrorModel::initial(const Eigen::Vector3d& attitude_sigma_B) const {
  const Parameters& p = parameters_;
  Covariance P = Covariance::Zero();
  diagonal_block(P, kAttitude).diagonal() = attitude_sigma_B.cwiseAbs2();
  diagonal_block(P, kGyroBias).diagonal().setConstant(p.gyro_bias.sigma * p.gyro_bias.sigma);
  diagonal_block(P, kFieldBias).diagonal().setConstant(p.field_bias.sigma * p.field_bias.sigma);
  P(kAlphaBias.offset, kAlphaBias.offset) = p.alpha_bias_sigma * p.alpha_bias_sigma;
  P(kBetaBias.offset, kBetaBias.offset) = p.beta_bias_sigma * p.beta_bias_sigma;
  return P;
}

void ErrorModel::restart_attitude(Covariance& P, const Eigen::Vector3d& attitude_sigma_B) {
  P.topRows<kAttitude.size>().setZero();
  P.leftCols<kAttitude.size>().setZero();
  diagonal_block(P, kAttitude).diagonal() = attitude_sigma_B.cwiseAbs2();
}

void ErrorModel::fold_in(Covariance& P, const Eigen::Vector3d& turn_B) {
  constexpr double kNegligible = 1e-3;  // rad
  if (turn_B.squaredNorm() < kNegligible * kNegligible) return;
  const Eigen::Matrix3d G = Eigen::Matrix3d::Identity() - 0.5 * math::skew(turn_B);
  const AttitudeRows rows = G.lazyProduct(P.topRows<3>());
  set_attitude_rows(P, rows, rows.leftCols<3>() * G.transpose());
}

void ErrorModel::propagate(Covariance& P, const Eigen::Vector3d& omega_B,
                           const Eigen::Vector3d& b_B, double dt) {
  const Eigen::Matrix3d Phi = math::exp_so3(-dt * omega_B);
  const Eigen::Matrix3d F = -math::skew(omega_B);
  const Eigen::Matrix3d Phi_bias = -dt * (Eigen::Matrix3d::Identity() + 0.5 * dt * F);
  const Eigen::Matrix3d noise =
      Eigen::Matrix3d::Identity() * (parameters_.gyro_noise * parameters_.gyro_noise);
  const AttitudeRows rows =
      Phi.lazyProduct(P.topRows<3>()) + Phi_bias.lazyProduct(P.middleRows<3>(kGyroBias.offset));
  set_attitude_rows(P, rows,
                    rows.leftCols<3>() * Phi.transpose() +
                        rows.middleCols<3>(kGyroBias.offset) * Phi_bias.transpose() +
                        math::process_noise<3>(F, noise, dt));

  slow_time_ += dt;
  slow_turn_B_ += dt * omega_B;
  if (slow_time_ >= kSlowStep) step_slow_errors(P, b_B);
}

void ErrorModel::step_slow_errors(Covariance& P, const Eigen::Vector3d& b_B) {
  const Parameters& p = parameters_;
  const double dt = slow_time_;
  const Eigen::Vector3d omega_B = slow_turn_B_ / dt;
  slow_time_ = 0.0;
  slow_turn_B_.setZero();

  decay(P, kGyroBias, p.gyro_bias.decay(dt));
  decay(P, kFieldBias, p.field_bias.decay(dt));
  diagonal_block(P, kGyroBias).diagonal().array() += p.gyro_bias.added_variance(dt);

  // A residual error of the field's scale and axes is a bias that moves with the field in B.
  const double field_turn = omega_B.cross(b_B.normalized()).norm();  // rad/s
  diagonal_block(P, kFieldBias).diagonal().array() +=
      p.field_bias.added_variance(dt) +
      turn_noise(p.field_matrix_sigma, field_turn) * b_B.squaredNorm() * dt;

  Eigen::Vector3d scale;
  Eigen::Vector3d axes;
  for (int i = 0; i < 3; ++i) {
    scale(i) = turn_noise(p.gyro_scale_sigma, omega_B(i));
    axes(i) = turn_noise(p.gyro_misalignment_sigma, omega_B(i));
  }
  diagonal_block(P, kAttitude).diagonal() +=
      dt * (scale - axes + Eigen::Vector3d::Constant(axes.sum()));
}

}  // namespace lodestar::sahrs
