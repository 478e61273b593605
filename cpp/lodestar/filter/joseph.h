// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

namespace lodestar::filter {

/// One Kalman measurement update of N states by M measurements, z = H x + v with v of covariance R,
/// in two steps so that the innovation can be gated in between:
///
///     const JosephUpdate<N, M> update(P, H, R);
///     if (gate.passes(update.normalised_square(innovation), M)) x += update.apply(P, innovation);
///
/// The covariance follows Joseph's form, (I - K H) P (I - K H)' + K R K', which is right for any
/// gain K and symmetric to the last bit. M is small: S is inverted in closed form up to 4.
///
/// `apply<E>` with E < N estimates the first E states only; the others are considered (Schmidt,
/// 1966): their uncertainty, and its correlation with the estimated states, enter S and P, but
/// their own estimate and covariance stay as they are.
template <int N, int M>
class JosephUpdate {
 public:
  using Covariance = Eigen::Matrix<double, N, N>;
  using Innovation = Eigen::Matrix<double, M, 1>;

  JosephUpdate(const Covariance& P, const Eigen::Matrix<double, M, N>& H,
               const Eigen::Matrix<double, M, M>& R)
      : PHt_(P.lazyProduct(H.transpose())), S_(H.lazyProduct(PHt_) + R), S_inverse_(S_.inverse()) {}

  /// Covariance of the innovation.
  const Eigen::Matrix<double, M, M>& S() const { return S_; }

  /// nu' S^-1 nu: chi-square with M degrees of freedom if all is well.
  double normalised_square(const Innovation& nu) const { return nu.dot(S_inverse_ * nu); }

  /// Updates `P`, the one given to the constructor; answers the correction of the estimated states.
  template <int E = N>
  Eigen::Matrix<double, E, 1> apply(Covariance& P, const Innovation& nu) const {
    const Eigen::Matrix<double, E, M> K = PHt_.template topRows<E>().lazyProduct(S_inverse_);
    // Joseph's form, multiplied out: P - K T' - T K' with T = P H' - K S / 2.
    Eigen::Matrix<double, N, M> T = PHt_;
    T.template topRows<E>() -= 0.5 * K.lazyProduct(S_);
    const Eigen::Matrix<double, E, N> KTt = K.lazyProduct(T.transpose());
    const Eigen::Matrix<double, E, E> estimated = KTt.template leftCols<E>();
    P.template topLeftCorner<E, E>() -= estimated + estimated.transpose();
    if constexpr (E < N) {
      P.template topRightCorner<E, N - E>() -= KTt.template rightCols<N - E>();
      P.template bottomLeftCorner<N - E, E>() = P.template topRightCorner<E, N - E>().transpose();
    }
    return K * nu;
  }

 private:
  Eigen::Matrix<double, N, M> PHt_;
  Eigen::Matrix<double, M, M> S_;
  Eigen::Matrix<double, M, M> S_inverse_;
};

}  // namespace lodestar::filter
