// SPDX-License-Identifier: Apache-2.0
#include "lodestar/filter/ud.h"

#include <gtest/gtest.h>

#include <random>

#include "lodestar/filter/joseph.h"

namespace lodestar::filter {
namespace {

constexpr int kStates = 6;
constexpr int kNoises = 4;
using Vector = Eigen::Matrix<double, kStates, 1>;
using Matrix = Eigen::Matrix<double, kStates, kStates>;

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> random_matrix(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, Rows, Columns> m;
  for (int j = 0; j < Columns; ++j) {
    for (int i = 0; i < Rows; ++i) m(i, j) = normal(generator);
  }
  return m;
}

Matrix random_covariance(std::mt19937& generator) {
  const Matrix root = random_matrix<kStates, kStates>(generator);
  return root * root.transpose();
}

double relative_difference(const Matrix& a, const Matrix& b) { return (a - b).norm() / b.norm(); }

TEST(Ud, FactorsMultiplyBackToTheCovariance) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix P = random_covariance(generator);
    const UdCovariance<kStates> ud(P);
    EXPECT_LT(relative_difference(ud.matrix(), P), 1e-12);
    EXPECT_TRUE(ud.U().isUpperTriangular());
    EXPECT_TRUE(ud.U().diagonal().isOnes());
    EXPECT_GT(ud.D().minCoeff(), 0.0);
  }
}

TEST(Ud, FactorsASingularCovariance) {
  Matrix P = Matrix::Zero();
  P(1, 1) = 4.0;
  P(4, 4) = 9.0;
  P(1, 4) = P(4, 1) = 6.0;  // fully correlated
  const UdCovariance<kStates> ud(P);
  EXPECT_LT((ud.matrix() - P).norm(), 1e-15);
  EXPECT_GE(ud.D().minCoeff(), 0.0);
}

TEST(Ud, PropagatesAsThePlainCovarianceDoes) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix P = random_covariance(generator);
    const Matrix Phi = random_matrix<kStates, kStates>(generator);
    const Eigen::Matrix<double, kStates, kNoises> Gamma =
        random_matrix<kStates, kNoises>(generator);
    const Eigen::Matrix<double, kNoises, 1> q = random_matrix<kNoises, 1>(generator).cwiseAbs2();
    UdCovariance<kStates> ud(P);
    ud.propagate(Phi, Gamma, q);
    const Matrix expected = Phi * P * Phi.transpose() + Gamma * q.asDiagonal() * Gamma.transpose();
    EXPECT_LT(relative_difference(ud.matrix(), expected), 1e-12);
  }
}

TEST(Ud, NoNoiseAndNoUncertaintyStayNone) {
  UdCovariance<kStates> ud;
  ud.propagate<kNoises>(Matrix::Identity(), Eigen::Matrix<double, kStates, kNoises>::Zero(),
                        Eigen::Matrix<double, kNoises, 1>::Zero());
  EXPECT_EQ(ud.matrix(), Matrix::Zero());
  EXPECT_EQ(ud.update(Vector::Ones(), 1.0), Vector::Zero());
}

TEST(Ud, UpdatesAsJosephsFormDoes) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < 50; ++trial) {
    Matrix P = random_covariance(generator);
    const Vector h = random_matrix<kStates, 1>(generator);
    const double r = 0.1 + std::abs(random_matrix<1, 1>(generator)(0));
    UdCovariance<kStates> ud(P);
    EXPECT_NEAR(ud.product(h, h), h.dot(P * h), 1e-12 * h.dot(P * h));
    const Vector gain = ud.update(h, r);
    const JosephUpdate<kStates, 1> joseph(P, h.transpose(), Eigen::Matrix<double, 1, 1>(r));
    const Vector expected = joseph.apply(P, Eigen::Matrix<double, 1, 1>(1.0));
    EXPECT_LT((gain - expected).norm(), 1e-12 * expected.norm());
    EXPECT_LT(relative_difference(ud.matrix(), P), 1e-12);
  }
}

TEST(Ud, AgreesWithJosephsFormOverALongFilter) {
  std::mt19937 generator(4);
  const Matrix Phi = Matrix::Identity() + 0.02 * random_matrix<kStates, kStates>(generator);
  const Eigen::Matrix<double, kStates, kNoises> Gamma = random_matrix<kStates, kNoises>(generator);
  const Eigen::Matrix<double, kNoises, 1> q =
      1e-3 * random_matrix<kNoises, 1>(generator).cwiseAbs2();
  Matrix P = random_covariance(generator);
  UdCovariance<kStates> ud(P);
  for (int step = 0; step < 2000; ++step) {
    const Matrix Q = Gamma * q.asDiagonal() * Gamma.transpose();
    const Matrix propagated = Phi * P * Phi.transpose() + Q;
    P = 0.5 * (propagated + propagated.transpose());
    ud.propagate(Phi, Gamma, q);
    const Vector h = random_matrix<kStates, 1>(generator);
    JosephUpdate<kStates, 1>(P, h.transpose(), Eigen::Matrix<double, 1, 1>(0.5))
        .apply(P, Eigen::Matrix<double, 1, 1>(0.0));
    ud.update(h, 0.5);
  }
  EXPECT_LT(relative_difference(ud.matrix(), P), 1e-9);
}

// Bierman's own example (V.3): two states, the first known to 1/eps, measured twice with noise 1.
// At eps = 1e-9 a plain covariance loses all its digits; the factors keep theirs.
TEST(Ud, SurvivesMeasurementsFarMoreExactThanWhatWasKnown) {
  constexpr double kEpsilon = 1e-9;
  const double prior = 1.0 / (kEpsilon * kEpsilon);
  UdCovariance<2> ud(prior * Eigen::Matrix2d::Identity());
  ud.update({1.0, kEpsilon}, 1.0);
  ud.update({1.0, 1.0}, 1.0);
  // Exact to O(eps): the inverse of [[2, 1 + eps], [1 + eps, 1]] plus the prior's eps^2.
  const Eigen::Matrix2d P = ud.matrix();
  EXPECT_NEAR(P(0, 0), 1.0 + 2.0 * kEpsilon, 1e-6);
  EXPECT_NEAR(P(0, 1), -1.0 - 3.0 * kEpsilon, 1e-6);
  EXPECT_NEAR(P(1, 1), 2.0 + 4.0 * kEpsilon, 1e-6);
  EXPECT_GT(ud.D().minCoeff(), 0.0);
}

}  // namespace
}  // namespace lodestar::filter
