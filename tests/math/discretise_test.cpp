// SPDX-License-Identifier: Apache-2.0
#include "lodestar/math/discretise.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace lodestar::math {
namespace {

using Matrix4 = Eigen::Matrix4d;

const Matrix4 kF = (Matrix4() << 0.0, 1.0, 0.0, 0.0,  //
                    -0.5, -0.2, 1.0, 0.0,             //
                    0.0, 0.0, -0.1, 0.3,              //
                    0.4, 0.0, -0.3, -0.1)
                       .finished();
const Matrix4 kDensity = Eigen::Vector4d(0.0, 1.0, 2.0, 0.5).asDiagonal();

Matrix4 exponential(const Matrix4& A) {
  Matrix4 sum = Matrix4::Identity();
  Matrix4 term = sum;
  for (int n = 1; n < 30; ++n) {
    term = term * A / n;
    sum += term;
  }
  return sum;
}

/// The integral of exp(F s) density exp(F s)' over s from 0 to dt, by Simpson's rule.
Matrix4 exact_noise(double dt) {
  constexpr int kIntervals = 200;
  Matrix4 sum = Matrix4::Zero();
  for (int i = 0; i <= kIntervals; ++i) {
    const Matrix4 Phi = exponential(kF * (dt * i / kIntervals));
    const double weight = i == 0 || i == kIntervals ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    sum += weight * Phi * kDensity * Phi.transpose();
  }
  return sum * dt / (3.0 * kIntervals);
}

double transition_error(double dt) { return (transition<4>(kF, dt) - exponential(kF * dt)).norm(); }
double noise_error(double dt) {
  return (process_noise<4>(kF, kDensity, dt) - exact_noise(dt)).norm();
}

TEST(Transition, IsTheExponentialToSecondOrder) {
  // What is left is of third order: an eighth for half the step.
  EXPECT_NEAR(transition_error(0.02) / transition_error(0.01), 8.0, 0.1);
  EXPECT_LT(transition_error(0.01), 1e-6);
}

TEST(Transition, OverNoTimeIsTheIdentity) {
  EXPECT_EQ((transition<4>(kF, 0.0)), Matrix4(Matrix4::Identity()));
}

TEST(ProcessNoise, IsTheIntegralToSecondOrder) {
  EXPECT_NEAR(noise_error(0.02) / noise_error(0.01), 8.0, 0.1);
  EXPECT_LT(noise_error(0.01), 1e-6);
}

TEST(ProcessNoise, IsPositiveSemiDefinite) {
  for (const double dt : {1e-4, 0.01, 1.0, 10.0}) {
    const Matrix4 Q = process_noise<4>(kF, kDensity, dt);
    EXPECT_LT((Q - Q.transpose()).norm(), 1e-14 * Q.norm());
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix4>(Q).eigenvalues().minCoeff(),
              -1e-14 * Q.norm());
  }
}

TEST(ProcessNoise, OfARandomWalkIsDensityTimesTime) {
  const Matrix4 Q = process_noise<4>(Matrix4::Zero(), kDensity, 0.3);
  EXPECT_LT((Q - 0.3 * kDensity).norm(), 1e-15);
}

}  // namespace
}  // namespace lodestar::math
