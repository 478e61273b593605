// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/smdu_calibration.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace lodestar::sahrs::smdu {

Eigen::Matrix3d Calibration::matrix() const {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m(i, j) += x(state_of_D(i, j));
  }
  return m;
}

Eigen::Matrix<double, 3, kCalibrationStates> jacobian(const Eigen::Vector3d& b_raw) {
  Eigen::Matrix<double, 3, kCalibrationStates> J =
      Eigen::Matrix<double, 3, kCalibrationStates>::Zero();
  J.middleCols<kBias.size>(kBias.offset).setIdentity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) J(i, state_of_D(i, j)) = b_raw(j);
  }
  return J;
}

// An axis of b_cal depends on four of the states, its bias and its row of D. Their covariance,
// averaged over the axes, splits the bias's variance into what comes with the row and what is left.
Spread spread(const StateMatrix& P) {
  Eigen::Matrix4d axis = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 3; ++i) {
    const std::array<int, 4> of = {kBias.offset + i, state_of_D(i, 0), state_of_D(i, 1),
                                   state_of_D(i, 2)};
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) {
        axis(r, c) += P(of[static_cast<std::size_t>(r)], of[static_cast<std::size_t>(c)]) / 3.0;
      }
    }
  }
  const Eigen::Matrix3d row = axis.bottomRightCorner<3, 3>();
  const Eigen::Vector3d with = axis.bottomLeftCorner<3, 1>();
  const double matrix_variance = row.trace() / 3.0;
  double bias_variance = axis(0, 0);
  if (row.determinant() > 0.0) bias_variance -= with.dot(row.inverse() * with);
  return {std::sqrt(std::max(0.0, bias_variance)), std::sqrt(std::max(0.0, matrix_variance))};
}

}  // namespace lodestar::sahrs::smdu
