// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/sparse_update.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "lodestar/filter/joseph.h"

namespace lodestar::strapdown {
namespace {

constexpr int kN = 12;
using Matrix = Eigen::Matrix<double, kN, kN>;
using Vector = Eigen::Matrix<double, kN, 1>;

/// Two rows, three parts: one matrix, one multiple of the identity, one column.
struct Measurement {
  static constexpr int kRows = 2;
  Eigen::Vector2d innovation{0.7, -1.3};
  Eigen::Vector2d variance{0.5, 2.0};
  Eigen::Matrix<double, 2, 3> wide;
  Eigen::Matrix<double, 2, 1> narrow;

  template <class Visit>
  void visit_H(Visit&& visit) const {
    visit(1, wide);
    visit(6, -0.8);
    visit(10, narrow);
  }

  Eigen::Matrix<double, 2, kN> H() const {
    Eigen::Matrix<double, 2, kN> dense = Eigen::Matrix<double, 2, kN>::Zero();
    dense.middleCols<3>(1) = wide;
    dense.middleCols<2>(6) = -0.8 * Eigen::Matrix2d::Identity();
    dense.col(10) = narrow;
    return dense;
  }
};

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> random_matrix(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  return Eigen::Matrix<double, Rows, Columns>::NullaryExpr([&] { return normal(generator); });
}

Measurement random_measurement(std::mt19937& generator) {
  Measurement m;
  m.wide = random_matrix<2, 3>(generator);
  m.narrow = random_matrix<2, 1>(generator);
  return m;
}

/// What lies above the diagonal is garbage, as in the filter.
Matrix lower_of(const Matrix& P) {
  Matrix lower = Matrix::Constant(1e30);
  lower.triangularView<Eigen::Lower>() = P;
  return lower;
}

Matrix full(const Matrix& lower) { return lower.selfadjointView<Eigen::Lower>(); }

TEST(SparseUpdate, EqualsJosephsForm) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix root = random_matrix<kN, kN>(generator);
    const Measurement m = random_measurement(generator);
    Matrix P = root * root.transpose();
    Matrix lower = lower_of(P);
    const SparseUpdate<kN, Measurement> sparse(lower, m);
    const filter::JosephUpdate<kN, 2> joseph(P, m.H(), m.variance.asDiagonal());
    EXPECT_LT((sparse.S() - joseph.S()).norm(), 1e-12 * joseph.S().norm());
    EXPECT_NEAR(sparse.normalised_square(), joseph.normalised_square(m.innovation), 1e-12);
    const Vector x = sparse.apply(lower);
    const Vector x_joseph = joseph.apply(P, m.innovation);
    EXPECT_LT((x - x_joseph).norm(), 1e-10);
    EXPECT_LT((full(lower) - P).norm(), 1e-11 * root.squaredNorm());
  }
}

TEST(SparseUpdate, AnExcludedRowIsAsIfItHadNotBeenMeasured) {
  std::mt19937 generator(2);
  const Matrix root = random_matrix<kN, kN>(generator);
  const Measurement m = random_measurement(generator);
  Matrix P = root * root.transpose();
  Matrix lower = lower_of(P);
  SparseUpdate<kN, Measurement> sparse(lower, m);
  sparse.exclude(0);
  const Vector x = sparse.apply(lower);
  const Eigen::Matrix<double, 1, kN> H = m.H().row(1);
  const filter::JosephUpdate<kN, 1> one(P, H, Eigen::Matrix<double, 1, 1>(m.variance(1)));
  const Vector x_one = one.apply(P, Eigen::Matrix<double, 1, 1>(m.innovation(1)));
  EXPECT_LT((x - x_one).norm(), 1e-10);
  EXPECT_LT((full(lower) - P).norm(), 1e-11 * root.squaredNorm());
}

TEST(SparseUpdate, WhatIsExpectedLeavesTheInnovation) {
  std::mt19937 generator(3);
  const Measurement m = random_measurement(generator);
  const Vector x = random_matrix<kN, 1>(generator);
  SparseUpdate<kN, Measurement> sparse(Matrix::Identity(), m);
  sparse.expect(m, x);
  EXPECT_LT((sparse.innovation() - (m.innovation - m.H() * x)).norm(), 1e-14);
}

TEST(SparseUpdate, StaysPositiveOverManyPreciseUpdates) {
  // Noise a thousand times smaller than what is known at first, as when a filter starts.
  std::mt19937 generator(4);
  Matrix lower = lower_of(1e3 * Matrix::Identity());
  for (int i = 0; i < 100'000; ++i) {
    Measurement m = random_measurement(generator);
    m.variance *= 1e-3;
    const SparseUpdate<kN, Measurement> sparse(lower, m);
    sparse.apply(lower);
    lower.diagonal().array() += 1e-6;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(full(lower));
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
}

}  // namespace
}  // namespace lodestar::strapdown
