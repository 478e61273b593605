// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/error_model.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "lodestar/math/discretise.h"
#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {
namespace {

using math::kDegree;
const Eigen::Vector3d kField_B(12000.0, -3000.0, 50000.0);  // nT

Covariance random_covariance() {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  Covariance root;
  for (int j = 0; j < kStates; ++j) {
    for (int i = 0; i < kStates; ++i) root(i, j) = normal(generator);
  }
  const Covariance P = root * root.transpose();
  return 0.5 * (P + P.transpose());
}

TEST(ErrorModel, PropagatesAttitudeAndGyroBiasAsTheGeneralFormDoes) {
  Parameters parameters;
  parameters.gyro_noise = 1e-3;
  const Eigen::Vector3d omega_B(0.5, -0.3, 0.2);
  const double dt = 1.0 / 60.0;
  Covariance F = Covariance::Zero();
  F.block<3, 3>(kAttitude.offset, kAttitude.offset) = -math::skew(omega_B);
  F.block<3, 3>(kAttitude.offset, kGyroBias.offset) = -Eigen::Matrix3d::Identity();
  Covariance density = Covariance::Zero();
  density.diagonal().head<3>().setConstant(1e-6);
  const Covariance P = random_covariance();
  const Covariance Phi = math::transition<kStates>(F, dt);
  const Covariance expected =
      Phi * P * Phi.transpose() + math::process_noise<kStates>(F, density, dt);
  Covariance answer = P;
  ErrorModel(parameters).propagate(answer, omega_B, kField_B, dt);
  // The general transition is of second order: (omega dt)^3 / 6 is left of the exact rotation.
  EXPECT_LT((answer - expected).norm(), 1e-6 * expected.norm());
}

TEST(ErrorModel, KeepsTheCovarianceSymmetricToTheLastBitAndPositive) {
  ErrorModel model((Parameters()));
  Covariance P = model.initial({0.1, 0.1, 0.2});
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 60 * 600; ++k) {
    const Eigen::Vector3d omega_B(normal(generator), normal(generator), normal(generator));
    model.propagate(P, omega_B, kField_B, 1.0 / 60.0);
    if (k % 100 == 0) ErrorModel::fold_in(P, 0.05 * omega_B);
  }
  EXPECT_EQ(P, Covariance(P.transpose()));
  // Units differ by 1e6: scaled to ones on the diagonal.
  const Eigen::Matrix<double, kStates, 1> scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const Covariance scaled = scale.asDiagonal() * P * scale.asDiagonal();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Covariance>(scaled).eigenvalues().minCoeff(), 0.0);
}

TEST(ErrorModel, AnUnknownGyroBiasTurnsTheAttitudeInStep) {
  Parameters parameters;
  parameters.gyro_scale_sigma = parameters.gyro_misalignment_sigma = parameters.gyro_noise = 0.0;
  parameters.gyro_bias = {0.2 * kDegree, 1e9};
  ErrorModel model(parameters);
  Covariance P = model.initial(Eigen::Vector3d::Zero());
  for (int k = 0; k < 600; ++k) {
    model.propagate(P, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 1.0 / 60.0);
  }
  EXPECT_NEAR(std::sqrt(P(2, 2)), 2.0 * kDegree, 1e-6 * kDegree);
  EXPECT_NEAR(P(2, kGyroBias.offset + 2), -2.0 * kDegree * 0.2 * kDegree, 1e-9);
}

TEST(ErrorModel, AScaleFactorErrorGrowsOverATurnAsItWould) {
  Parameters parameters;
  parameters.gyro_noise = parameters.gyro_misalignment_sigma = 0.0;
  parameters.gyro_bias.sigma = 0.0;
  parameters.gyro_scale_sigma = 0.01;
  // Slow or fast: 1 % of the angle turned, for a turn of 90 degrees; the root of it beyond.
  for (const double rate : {10.0 * kDegree, 90.0 * kDegree}) {
    ErrorModel model(parameters);
    Covariance P = model.initial(Eigen::Vector3d::Zero());
    const double dt = 0.01;
    const int steps = static_cast<int>(std::lround(90.0 * kDegree / rate / dt));
    for (int k = 0; k < steps; ++k) {
      model.propagate(P, {0.0, 0.0, rate}, Eigen::Vector3d::Zero(), dt);
    }
    // 10 %: the noise of a gyro at rest is kept out by a floor of 1 degree/s.
    EXPECT_NEAR(std::sqrt(P(2, 2)), 0.9 * kDegree, 0.09 * kDegree);
    EXPECT_EQ(P(0, 0), 0.0);
  }
}

TEST(ErrorModel, BiasesStayAtTheirStationaryVariance) {
  const Parameters parameters;
  ErrorModel model(parameters);
  Covariance P = model.initial({0.1, 0.1, 0.1});
  for (int k = 0; k < 6000; ++k) model.propagate(P, Eigen::Vector3d::Zero(), kField_B, 0.1);
  EXPECT_NEAR(std::sqrt(P(kGyroBias.offset, kGyroBias.offset)), parameters.gyro_bias.sigma, 1e-9);
  EXPECT_NEAR(std::sqrt(P(kFieldBias.offset, kFieldBias.offset)), parameters.field_bias.sigma,
              1e-6);
  EXPECT_EQ(P(kAlphaBias.offset, kAlphaBias.offset),
            parameters.alpha_bias_sigma * parameters.alpha_bias_sigma);
}

TEST(ErrorModel, FoldingATurnInCountsTheErrorFromThere) {
  // Errors e about an estimated turn t: log(exp(-t) exp(t + e)) = G e.
  const Eigen::Vector3d turn_B(0.05, -0.03, 0.02);
  Covariance P = random_covariance();
  const Covariance before = P;
  ErrorModel::fold_in(P, turn_B);
  Eigen::Matrix3d G;
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d e = kStep * Eigen::Vector3d::Unit(i);
    G.col(i) =
        (math::log_quaternion(math::exp_quaternion(-turn_B) * math::exp_quaternion(turn_B + e)) -
         math::log_quaternion(math::exp_quaternion(-turn_B) * math::exp_quaternion(turn_B - e))) /
        (2.0 * kStep);
  }
  const Eigen::Matrix3d expected = G * before.topLeftCorner<3, 3>() * G.transpose();
  // First order in the turn: its square over six is left.
  EXPECT_LT((P.topLeftCorner<3, 3>() - expected).norm(), 2e-3 * expected.norm());
  EXPECT_LT((P.topLeftCorner<3, 3>() - expected).norm(),
            0.05 * (before.topLeftCorner<3, 3>() - expected).norm());
  EXPECT_EQ((P.bottomRightCorner<kStates - 3, kStates - 3>()),
            (before.bottomRightCorner<kStates - 3, kStates - 3>()));
}

TEST(ErrorModel, ARestartForgetsTheAttitudeAndKeepsTheBiases) {
  Covariance P = random_covariance();
  const Covariance before = P;
  ErrorModel::restart_attitude(P, {0.1, 0.2, 0.3});
  EXPECT_LT((P.diagonal().head<3>() - Eigen::Vector3d(0.01, 0.04, 0.09)).norm(), 1e-15);
  EXPECT_TRUE((P.topRightCorner<3, kStates - 3>().isZero(0.0)));
  EXPECT_EQ((P.bottomRightCorner<kStates - 3, kStates - 3>()),
            (before.bottomRightCorner<kStates - 3, kStates - 3>()));
}

}  // namespace
}  // namespace lodestar::sahrs
