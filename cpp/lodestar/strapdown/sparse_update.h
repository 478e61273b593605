// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace lodestar::strapdown {

// Covariances of this folder keep their lower triangle only: half the work of every update. What
// lies above the diagonal is never read.

/// Columns `offset` to `offset` + Width - 1, whole, of the symmetric matrix whose lower triangle is
/// `P`.
template <int Width, int N>
Eigen::Matrix<double, N, Width> symmetric_columns(const Eigen::Matrix<double, N, N>& P,
                                                  int offset) {
  Eigen::Matrix<double, N, Width> columns = P.template middleCols<Width>(offset);
  for (int j = 0; j < Width; ++j) {
    const int diagonal = offset + j;
    for (int i = 0; i < diagonal; ++i) columns(i, j) = P(diagonal, i);
  }
  return columns;
}

/// One Kalman measurement update of N states by a measurement whose H has few columns that are not
/// zero, in two steps so that each row of the innovation can be gated in between:
///
///     SparseUpdate<N, Measurement> update(P, m);
///     if (!gate.passes(update.normalised_square(0), 1)) update.exclude(0);
///     x = update.apply(P);
///
/// A Measurement has kRows, innovation, variance and visit_H(visit), which calls visit(offset,
/// part) for each part of H: its columns from `offset` on, or a number that stands for that
/// multiple of the identity.
///
/// The covariance follows Joseph's form, (I - K H) P (I - K H)' + K R K', which for the optimal
/// gain K = P H' S^-1 is P - G G' with G = P H' L'^-1 and S = L L'.
template <int N, class Measurement>
class SparseUpdate {
 public:
  static constexpr int M = Measurement::kRows;
  using Covariance = Eigen::Matrix<double, N, N>;
  using Rows = Eigen::Matrix<double, M, 1>;

  SparseUpdate(const Covariance& P, const Measurement& m) : innovation_(m.innovation) {
    PHt_.setZero();
    m.visit_H([&](int offset, const auto& H) {
      if constexpr (std::is_same_v<std::decay_t<decltype(H)>, double>) {
        PHt_ += H * symmetric_columns<M>(P, offset);
      } else {
        constexpr int kWidth = std::decay_t<decltype(H)>::ColsAtCompileTime;
        PHt_ += symmetric_columns<kWidth>(P, offset).lazyProduct(H.transpose());
      }
    });
    S_ = m.variance.asDiagonal();
    m.visit_H([&](int offset, const auto& H) {
      if constexpr (std::is_same_v<std::decay_t<decltype(H)>, double>) {
        S_ += H * PHt_.template middleRows<M>(offset);
      } else {
        constexpr int kWidth = std::decay_t<decltype(H)>::ColsAtCompileTime;
        S_ += H.lazyProduct(PHt_.template middleRows<kWidth>(offset));
      }
    });
  }

  /// Takes from the innovation what an estimated error `x` of the states makes of it.
  void expect(const Measurement& m, const Eigen::Matrix<double, N, 1>& x) {
    m.visit_H([&](int offset, const auto& H) {
      if constexpr (std::is_same_v<std::decay_t<decltype(H)>, double>) {
        innovation_ -= H * x.template segment<M>(offset);
      } else {
        innovation_ -= H * x.template segment<std::decay_t<decltype(H)>::ColsAtCompileTime>(offset);
      }
    });
  }

  /// Covariance of the innovation.
  const Eigen::Matrix<double, M, M>& S() const { return S_; }
  const Rows& innovation() const { return innovation_; }
  double sigma(int row) const { return std::sqrt(S_(row, row)); }
  /// Square of one row over its variance: chi-square of one degree of freedom if all is well.
  double normalised_square(int row) const {
    return innovation_(row) * innovation_(row) / S_(row, row);
  }
  /// nu' S^-1 nu: chi-square of M degrees of freedom.
  double normalised_square() const { return innovation_.dot(S_.llt().solve(innovation_)); }

  /// Leaves a row out, as if it had not been measured.
  void exclude(int row) {
    PHt_.col(row).setZero();
    S_.row(row).setZero();
    S_.col(row).setZero();
    S_(row, row) = 1.0;
    innovation_(row) = 0.0;
  }

  /// Updates `P`, the one given to the constructor; answers the correction of the states.
  Eigen::Matrix<double, N, 1> apply(Covariance& P) const {
    const Eigen::LLT<Eigen::Matrix<double, M, M>> llt(S_);
    Eigen::Matrix<double, N, M> G = PHt_;
    llt.matrixU().template solveInPlace<Eigen::OnTheRight>(G);
    for (int j = 0; j < N; ++j) {
      P.col(j).tail(N - j) -= G.bottomRows(N - j).lazyProduct(G.row(j).transpose());
    }
    const Rows whitened = llt.matrixL().solve(innovation_);
    return G * whitened;
  }

 private:
  Rows innovation_;
  Eigen::Matrix<double, N, M> PHt_;
  Eigen::Matrix<double, M, M> S_;
};

}  // namespace lodestar::strapdown
