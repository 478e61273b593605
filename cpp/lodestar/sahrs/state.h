// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/math/state_layout.h"

namespace lodestar::sahrs {

// The nine states of the SAHRS paper (§3.1), all of them errors, true minus estimated.
inline constexpr math::Block kAttitude{0, 3};                         // rad: C_NB exp([phi x])
inline constexpr math::Block kGyroBias = math::after(kAttitude, 3);   // rad/s, in B
inline constexpr math::Block kFieldBias = math::after(kGyroBias, 3);  // nT, in B
inline constexpr int kEstimated = math::end(kFieldBias);
static_assert(kEstimated == 9);

// Biases of the vanes last a flight, and no R can tell the filter so. They are considered, not
// estimated: the filter carries their correlation with the nine states, so that its gains and its
// sigma are honest about them.
inline constexpr math::Block kAlphaBias = math::after(kFieldBias, 1);  // rad
inline constexpr math::Block kBetaBias = math::after(kAlphaBias, 1);   // rad
inline constexpr int kStates = math::end(kBetaBias);
static_assert(kStates == 11);

using Covariance = Eigen::Matrix<double, kStates, kStates>;

/// One measurement of M components at some pose: innovation (measured minus predicted) and what it
/// is made of, H x + v with v of covariance R.
template <int M>
struct Measurement {
  Eigen::Matrix<double, M, 1> innovation = Eigen::Matrix<double, M, 1>::Zero();
  Eigen::Matrix<double, M, kStates> H = Eigen::Matrix<double, M, kStates>::Zero();
  Eigen::Matrix<double, M, M> R = Eigen::Matrix<double, M, M>::Zero();
  double excess = 0.0;  // more on the diagonal of R in the update; see SlowNoise
};

}  // namespace lodestar::sahrs
