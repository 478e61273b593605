// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace lodestar::math {

/// Transition matrix of x' = F x over `dt` (s), F constant, to second order: I + F dt + (F dt)^2/2.
template <int N>
Eigen::Matrix<double, N, N> transition(const Eigen::Matrix<double, N, N>& F, double dt) {
  const Eigen::Matrix<double, N, N> Fdt = F * dt;
  return Eigen::Matrix<double, N, N>::Identity() + Fdt + 0.5 * Fdt * Fdt;
}

/// Covariance that white noise of spectral density `GQGt` (unit of x squared per second) leaves
/// after `dt` seconds: dt Phi_half GQGt Phi_half', second order in dt.
template <int N>
Eigen::Matrix<double, N, N> process_noise(const Eigen::Matrix<double, N, N>& F,
                                          const Eigen::Matrix<double, N, N>& GQGt, double dt) {
  const Eigen::Matrix<double, N, N> Phi_half =
      Eigen::Matrix<double, N, N>::Identity() + 0.5 * dt * F;
  return dt * (Phi_half * GQGt * Phi_half.transpose());
}

}  // namespace lodestar::math
