// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace lodestar::filter {

/// A covariance in factors: P = U diag(D) U', U unit upper triangular. What is kept has half the
/// digits of P to lose, and P can not turn indefinite (Bierman, Factorization Methods for Discrete
/// Sequential Estimation, 1977).
template <int N>
class UdCovariance {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  UdCovariance() : U_(Matrix::Identity()), D_(Vector::Zero()) {}

  /// Factors of the symmetric, positive semi-definite `P` (Bierman, III.4).
  explicit UdCovariance(const Matrix& P) : UdCovariance() {
    Matrix rest = P;
    for (int j = N - 1; j >= 0; --j) {
      D_(j) = rest(j, j) > 0.0 ? rest(j, j) : 0.0;
      if (D_(j) == 0.0) continue;
      for (int i = 0; i < j; ++i) U_(i, j) = rest(i, j) / D_(j);
      for (int k = 0; k < j; ++k) {
        for (int i = 0; i <= k; ++i) rest(i, k) -= U_(i, j) * D_(j) * U_(k, j);
      }
    }
  }

  const Matrix& U() const { return U_; }
  const Vector& D() const { return D_; }
  Matrix matrix() const { return U_ * D_.asDiagonal() * U_.transpose(); }

  /// P <- Phi P Phi' + Gamma diag(q) Gamma', by modified weighted Gram-Schmidt on the rows of
  /// [Phi U, Gamma] (Thornton; Bierman, VI.4).
  template <int M>
  void propagate(const Matrix& Phi, const Eigen::Matrix<double, N, M>& Gamma,
                 const Eigen::Matrix<double, M, 1>& q) {
    Eigen::Matrix<double, N + M, N> rows;  // the rows of [Phi U, Gamma], one per column
    rows.template topRows<N>().noalias() =
        (Phi * U_.template triangularView<Eigen::Upper>()).transpose();
    rows.template bottomRows<M>() = Gamma.transpose();
    Eigen::Matrix<double, N + M, 1> weights;
    weights << D_, q;
    for (int j = N - 1; j >= 0; --j) {
      const Eigen::Matrix<double, N + M, 1> weighted = weights.cwiseProduct(rows.col(j));
      D_(j) = rows.col(j).dot(weighted);
      for (int i = 0; i < j; ++i) {
        U_(i, j) = D_(j) > 0.0 ? rows.col(i).dot(weighted) / D_(j) : 0.0;
        rows.col(i) -= U_(i, j) * rows.col(j);
      }
    }
  }

  /// h' P g.
  double product(const Vector& h, const Vector& g) const {
    const Vector Ut_h = U_.transpose() * h;
    const Vector Ut_g = U_.transpose() * g;
    return Ut_h.dot(D_.cwiseProduct(Ut_g));
  }

  /// Takes in a scalar measurement y = h' x + noise of variance `r` > 0 and returns its gain K, for
  /// x <- x + K (y - h' x) (Bierman, V.3).
  Vector update(const Vector& h, double r) {
    const Vector f = U_.transpose() * h;
    const Vector v = D_.cwiseProduct(f);
    Vector gain = Vector::Zero();
    double alpha = r;
    for (int j = 0; j < N; ++j) {
      const double alpha_before = alpha;
      alpha += f(j) * v(j);
      D_(j) *= alpha_before / alpha;
      const double lambda = -f(j) / alpha_before;
      for (int i = 0; i < j; ++i) {
        const double before = U_(i, j);
        U_(i, j) += lambda * gain(i);
        gain(i) += before * v(j);
      }
      gain(j) = v(j);
    }
    return gain / alpha;
  }

 private:
  Matrix U_;
  Vector D_;
};

}  // namespace lodestar::filter
