// SPDX-License-Identifier: Apache-2.0
#include "lodestar/math/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <vector>

namespace lodestar::math {
namespace {

/// Rotation vectors of every kind: none, tiny, about each axis, random, and nearly half a turn.
class Rotation : public testing::Test {
 protected:
  Rotation() {
    std::mt19937 generator(1);
    std::normal_distribution<double> normal;
    vectors_.push_back(Eigen::Vector3d::Zero());
    for (int i = 0; i < 3; ++i) vectors_.push_back(Eigen::Vector3d::Unit(i));
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d direction =
          Eigen::Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
      for (const double angle : {1e-300, 1e-15, 1e-9, 0.0316, 0.0317, 0.1, 2.0, kPi - 1e-9}) {
        vectors_.push_back(angle * direction);
      }
    }
  }

  std::vector<Eigen::Vector3d> vectors_;
};

TEST_F(Rotation, TheExponentialIsAUnitQuaternion) {
  for (const Eigen::Vector3d& phi : vectors_) {
    EXPECT_NEAR(exp_quaternion(phi).norm(), 1.0, 1e-15);
  }
}

TEST_F(Rotation, TheExponentialIsThatOfAxisAndAngle) {
  for (const Eigen::Vector3d& phi : vectors_) {
    if (phi.norm() < 1e-12) continue;  // Eigen's axis of a vector this short is rounding
    const Eigen::AngleAxisd expected(phi.norm(), phi.normalized());
    EXPECT_LT((exp_so3(phi) - expected.toRotationMatrix()).norm(), 1e-14) << phi.transpose();
  }
}

TEST_F(Rotation, TheExponentialOfAMatrixIsItsPowerSeries) {
  for (const Eigen::Vector3d& phi : vectors_) {
    Eigen::Matrix3d term = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d sum = term;
    for (int n = 1; n < 40; ++n) {
      term = term * skew(phi) / n;
      sum += term;
    }
    EXPECT_LT((exp_so3(phi) - sum).norm(), 1e-13) << phi.transpose();
  }
}

TEST_F(Rotation, TheLogarithmUndoesTheExponential) {
  for (const Eigen::Vector3d& phi : vectors_) {
    const Eigen::Vector3d back = log_quaternion(exp_quaternion(phi));
    EXPECT_LE((back - phi).norm(), 1e-14 * std::max(1e-280, phi.norm()) + 1e-15 * phi.norm());
  }
}

TEST_F(Rotation, BothQuaternionsOfARotationHaveOneLogarithm) {
  for (const Eigen::Vector3d& phi : vectors_) {
    const Eigen::Quaterniond q = exp_quaternion(phi);
    const Eigen::Quaterniond minus_q(-q.coeffs());
    EXPECT_EQ(log_quaternion(q), log_quaternion(minus_q));
    EXPECT_LE(log_quaternion(minus_q).norm(), kPi);
  }
}

TEST_F(Rotation, EulerAnglesGiveTheMatrixBack) {
  for (const Eigen::Vector3d& phi : vectors_) {
    const Eigen::Matrix3d C_NB = exp_so3(phi);
    const Euler e = euler_from_C_NB(C_NB);
    EXPECT_LT((C_NB_from_euler(e) - C_NB).norm(), 1e-14);
    EXPECT_GT(e.roll, -kPi - 1e-15);
    EXPECT_LE(e.roll, kPi);
    EXPECT_LE(std::abs(e.pitch), kPi / 2);
    EXPECT_GE(e.heading, 0.0);
    EXPECT_LT(e.heading, 2.0 * kPi);
  }
}

TEST(EulerAngles, AreAppliedAsHeadingThenPitchThenRoll) {
  const Euler e{0.3, -0.4, 2.0};
  const Eigen::Matrix3d expected = (Eigen::AngleAxisd(e.heading, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(e.pitch, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(e.roll, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  EXPECT_LT((C_NB_from_euler(e) - expected).norm(), 1e-15);
}

TEST(EulerAngles, HaveTheSignsThatAPilotReads) {
  const Eigen::Vector3d nose(1.0, 0.0, 0.0);
  const Eigen::Vector3d right_wing(0.0, 1.0, 0.0);
  const Eigen::Vector3d east(0.0, 1.0, 0.0);
  const Eigen::Vector3d down(0.0, 0.0, 1.0);
  EXPECT_LT((C_NB_from_euler({0.0, 0.0, kPi / 2}) * nose - east).norm(), 1e-15);
  EXPECT_LT((C_NB_from_euler({0.0, kPi / 2, 0.0}) * nose + down).norm(), 1e-15);
  EXPECT_LT((C_NB_from_euler({kPi / 2, 0.0, 0.0}) * right_wing - down).norm(), 1e-15);
}

TEST(EulerAngles, AreFiniteAndRightStraightUpAndStraightDown) {
  for (const double pitch : {kPi / 2, -kPi / 2}) {
    const Eigen::Matrix3d C_NB = C_NB_from_euler({0.7, pitch, 1.1});
    const Euler e = euler_from_C_NB(C_NB);
    // Roll and heading are one angle there, and the sine of pitch is flat: half the digits remain.
    EXPECT_NEAR(e.pitch, pitch, 1e-7);
    EXPECT_LT((C_NB_from_euler(e) - C_NB).norm(), 1e-7);
  }
}

TEST(Wrapping, KeepsTheDirectionAndTheHalfOpenInterval) {
  for (const double angle : {0.0, 1.0, -1.0, kPi, -kPi, 3.0 * kPi, -1e-20, 2.0 * kPi, -7.5, 1e3}) {
    EXPECT_NEAR(std::cos(wrap_pi(angle)), std::cos(angle), 1e-12) << angle;
    EXPECT_NEAR(std::sin(wrap_2pi(angle)), std::sin(angle), 1e-12) << angle;
    EXPECT_GT(wrap_pi(angle), -kPi);
    EXPECT_LE(wrap_pi(angle), kPi);
    EXPECT_GE(wrap_2pi(angle), 0.0);
    EXPECT_LT(wrap_2pi(angle), 2.0 * kPi);
  }
}

TEST(Skew, IsTheCrossProduct) {
  const Eigen::Vector3d a(1.0, -2.0, 3.0);
  const Eigen::Vector3d b(0.5, 4.0, -1.0);
  EXPECT_EQ(skew(a) * b, a.cross(b));
}

}  // namespace
}  // namespace lodestar::math
