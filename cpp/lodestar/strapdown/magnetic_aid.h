// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/rotation.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// The magnetic field in body axes against the model's field `b_N` (nT in N):
///     b_B = (I + field_matrix) C_NB' b_N + field_bias + field_drift + noise
/// With C_NB true = exp([phi x]) C_NB the true field in B is C_NB' (b_N + b_N x phi), to first
/// order.
struct MagneticMeasurement {
  static constexpr int kRows = 3;
  Eigen::Vector3d innovation;  // nT, measured minus predicted
  Eigen::Vector3d variance;    // nT^2
  Eigen::Matrix3d H_attitude;  // nT/rad
  Eigen::Vector3d b_B;         // nT, predicted without the sensor's errors

  template <class Visit>
  void visit_H(Visit&& visit) const {
    visit(kAttitude.offset, H_attitude);
    visit(kFieldDrift.offset, 1.0);
    visit(kFieldBias.offset, 1.0);
    for (int j = 0; j < 3; ++j) visit(kFieldMatrix.offset + 3 * j, b_B(j));
  }
};

inline MagneticMeasurement measure_field(const Eigen::Vector3d& b_B, const Estimate& x,
                                         const Eigen::Vector3d& b_N, double noise_sigma) {
  MagneticMeasurement m;
  const Eigen::Matrix3d response = Eigen::Matrix3d::Identity() + x.field_matrix;
  m.b_B = x.C_NB.transpose() * b_N;
  m.innovation = b_B - response * m.b_B - x.field_bias_B - x.field_drift_B;
  m.variance.setConstant(noise_sigma * noise_sigma);
  m.H_attitude = response * (x.C_NB.transpose() * math::skew(b_N));
  return m;
}

}  // namespace lodestar::strapdown
