// SPDX-License-Identifier: Apache-2.0
#include "lodestar/filter/joseph.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace lodestar::filter {
namespace {

constexpr int kN = 7;
constexpr int kM = 3;
using StateMatrix = Eigen::Matrix<double, kN, kN>;
using StateVector = Eigen::Matrix<double, kN, 1>;

class Joseph : public testing::Test {
 protected:
  Joseph() {
    const StateMatrix root = random<kN, kN>();
    P_ = root * root.transpose();
    P_ = (0.5 * (P_ + P_.transpose())).eval();
    H_ = random<kM, kN>();
    const Eigen::Matrix3d noise_root = random<3, 3>();
    R_ = noise_root * noise_root.transpose();
    nu_ = random<kM, 1>();
  }

  template <int Rows, int Columns>
  Eigen::Matrix<double, Rows, Columns> random() {
    Eigen::Matrix<double, Rows, Columns> m;
    for (int j = 0; j < Columns; ++j) {
      for (int i = 0; i < Rows; ++i) m(i, j) = normal_(generator_);
    }
    return m;
  }

  std::mt19937 generator_{3};
  std::normal_distribution<double> normal_;
  StateMatrix P_;
  Eigen::Matrix<double, kM, kN> H_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d nu_;
};

TEST_F(Joseph, IsTheInformationFormsUpdate) {
  const StateMatrix expected = (P_.inverse() + H_.transpose() * R_.inverse() * H_).inverse();
  const StateVector correction = expected * H_.transpose() * R_.inverse() * nu_;
  StateMatrix P = P_;
  const JosephUpdate<kN, kM> update(P, H_, R_);
  const StateVector answer = update.apply(P, nu_);
  // Two inverses of a random matrix of seven stand against it.
  EXPECT_LT((P - expected).norm(), 1e-9 * expected.norm());
  EXPECT_LT((answer - correction).norm(), 1e-9 * correction.norm());
}

TEST_F(Joseph, LeavesTheCovarianceSymmetricToTheLastBitAndPositive) {
  StateMatrix P = P_;
  for (int i = 0; i < 1000; ++i) {
    JosephUpdate<kN, kM>(P, random<kM, kN>(), R_).apply(P, nu_);
    ASSERT_EQ(P, StateMatrix(P.transpose()));
    P.diagonal().array() += 1e-3;
  }
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<StateMatrix>(P).eigenvalues().minCoeff(), 0.0);
}

TEST_F(Joseph, OfOneAfterTheOtherIsThatOfAllAtOnceForIndependentNoise) {
  const Eigen::Matrix3d R = R_.diagonal().asDiagonal();
  StateMatrix together = P_;
  const StateVector x_together = JosephUpdate<kN, kM>(together, H_, R).apply(together, nu_);
  StateMatrix one_by_one = P_;
  StateVector x = StateVector::Zero();
  for (int i = 0; i < kM; ++i) {
    const Eigen::Matrix<double, 1, kN> h = H_.row(i);
    const Eigen::Matrix<double, 1, 1> residual(nu_(i) - h.dot(x));
    const JosephUpdate<kN, 1> update(one_by_one, h, Eigen::Matrix<double, 1, 1>(R(i, i)));
    x += update.apply(one_by_one, residual);
  }
  EXPECT_LT((one_by_one - together).norm(), 1e-12 * together.norm());
  EXPECT_LT((x - x_together).norm(), 1e-12 * x.norm());
}

TEST_F(Joseph, NormalisesTheInnovationByItsCovariance) {
  const JosephUpdate<kN, kM> update(P_, H_, R_);
  const Eigen::Matrix3d S = H_ * P_ * H_.transpose() + R_;
  EXPECT_LT((update.S() - S).norm(), 1e-13 * S.norm());
  EXPECT_NEAR(update.normalised_square(nu_), nu_.dot(S.inverse() * nu_), 1e-12);
}

TEST_F(Joseph, LeavesConsideredStatesAsTheyAre) {
  constexpr int kEstimated = 5;
  StateMatrix P = P_;
  const JosephUpdate<kN, kM> update(P, H_, R_);
  const Eigen::Matrix<double, kEstimated, 1> correction = update.apply<kEstimated>(P, nu_);
  EXPECT_EQ((P.bottomRightCorner<2, 2>()), (P_.bottomRightCorner<2, 2>()));
  EXPECT_EQ(P, StateMatrix(P.transpose()));
  // Joseph's form with the optimal gain, its rows of the considered states nought.
  const Eigen::Matrix3d S = H_ * P_ * H_.transpose() + R_;
  Eigen::Matrix<double, kN, kM> K = P_ * H_.transpose() * S.inverse();
  K.bottomRows<2>().setZero();
  const StateMatrix I_KH = StateMatrix::Identity() - K * H_;
  const StateMatrix expected = I_KH * P_ * I_KH.transpose() + K * R_ * K.transpose();
  EXPECT_LT((P - expected).norm(), 1e-13 * P_.norm());
  EXPECT_LT((correction - (K * nu_).head<kEstimated>()).norm(), 1e-12);
}

TEST_F(Joseph, AConsideredBiasKeepsSigmaHonestHoweverOftenItIsMeasured) {
  // One state seen through a constant bias of sigma 1: the mean of any number of samples has it.
  Eigen::Matrix2d P = Eigen::Vector2d(100.0, 1.0).asDiagonal();
  const Eigen::RowVector2d h(1.0, 1.0);
  for (int i = 0; i < 10000; ++i) {
    const JosephUpdate<2, 1> update(P, h, Eigen::Matrix<double, 1, 1>(0.01));
    update.apply<1>(P, Eigen::Matrix<double, 1, 1>(0.0));
  }
  EXPECT_NEAR(P(0, 0), 1.0, 0.011);  // 1 % below: the prior of 100 knows that much
  EXPECT_NEAR(P(0, 1), -1.0, 0.011);
}

}  // namespace
}  // namespace lodestar::filter
