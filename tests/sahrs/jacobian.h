// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "lodestar/sahrs/state.h"

namespace lodestar::sahrs_test {

using StateError = Eigen::Matrix<double, sahrs::kStates, 1>;

/// A step of each state that is small and still far above rounding.
inline StateError jacobian_steps() {
  StateError steps = StateError::Constant(1e-6);                 // rad, rad/s
  steps.segment<3>(sahrs::kFieldBias.offset).setConstant(1e-1);  // nT
  return steps;
}

/// Checks H against the central differences of `innovation(x)`, the innovation that the sensors
/// would cause if the truth were off the estimate by x, to 1e-6 of the largest element.
template <int M, class Innovation>
void expect_jacobian(const sahrs::Measurement<M>& measurement, Innovation innovation) {
  const StateError steps = jacobian_steps();
  Eigen::Matrix<double, M, sahrs::kStates> numeric;
  for (int i = 0; i < sahrs::kStates; ++i) {
    StateError x = StateError::Zero();
    x(i) = steps(i);
    const Eigen::Matrix<double, M, 1> ahead = innovation(x);
    const Eigen::Matrix<double, M, 1> behind = innovation(StateError(-x));
    numeric.col(i) = (ahead - behind) / (2.0 * steps(i));
  }
  const double scale = std::max(1.0, numeric.cwiseAbs().maxCoeff());
  EXPECT_LT((measurement.H - numeric).cwiseAbs().maxCoeff(), 1e-6 * scale)
      << "H\n"
      << measurement.H << "\nnumeric\n"
      << numeric;
}

}  // namespace lodestar::sahrs_test
