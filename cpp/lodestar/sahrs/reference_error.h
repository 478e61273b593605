// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "lodestar/math/rotation.h"
#include "lodestar/sahrs/smdu_calibration.h"

namespace lodestar::sahrs::smdu {

// What may be wrong with the field that a calibration believes in, b_B = C_NB' b_N of INS and field
// model, and lasts: INS roll, pitch and heading (rad), field model in N (nT). A good part of it can
// never be told from x, so it is considered, not estimated (see filter::JosephUpdate).
inline constexpr int kReferenceErrors = 6;

inline Eigen::Matrix<double, kReferenceErrors, 1> reference_variance(const FilterParameters& p) {
  Eigen::Matrix<double, kReferenceErrors, 1> sigma;
  sigma << p.ins_tilt_sigma, p.ins_tilt_sigma, p.ins_heading_sigma,
      Eigen::Vector3d::Constant(p.field_model_sigma);
  return sigma.cwiseAbs2();
}

/// d phi / d (roll, pitch, heading): the small rotation in B that goes with small errors of the
/// Euler angles.
inline Eigen::Matrix3d rotation_from_euler_errors(const Eigen::Matrix3d& C_NB) {
  const Eigen::Vector3d down_B = C_NB.row(2).transpose();
  const double cos_pitch = std::hypot(down_B.y(), down_B.z());
  Eigen::Matrix3d E;
  E.col(0) = Eigen::Vector3d::UnitX();
  E.col(1) = Eigen::Vector3d::UnitY();  // straight up or down, where roll means nothing
  if (cos_pitch > 1e-9) E.col(1) = Eigen::Vector3d(0.0, down_B.z(), -down_B.y()) / cos_pitch;
  E.col(2) = down_B;
  return E;
}

/// How `b_B` (nT), less the true field in B, depends on these errors, to first order: with
/// C_NB(INS) = C_NB exp([phi x]) it is b_B x phi, and C_NB' times the error of the model.
inline Eigen::Matrix<double, 3, kReferenceErrors> reference_jacobian(const Eigen::Matrix3d& C_NB,
                                                                     const Eigen::Vector3d& b_B) {
  Eigen::Matrix<double, 3, kReferenceErrors> H;
  H << math::skew(b_B) * rotation_from_euler_errors(C_NB), C_NB.transpose();
  return H;
}

}  // namespace lodestar::sahrs::smdu
