// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/rotation.h"
#include "lodestar/sahrs/slow_noise.h"
#include "lodestar/sahrs/state.h"

namespace lodestar::sahrs {

/// What the magnetic field's measurement is made of, all at one time.
struct FieldInput {
  Eigen::Vector3d b_B;           // nT, measured and calibrated
  Eigen::Vector3d field_bias_B;  // nT, estimated
  Eigen::Matrix3d C_NB;          // predicted
  Eigen::Vector3d b_N;           // nT, of the field model
};

/// The magnetic field in N axes (SAHRS paper §3.2): innovation = C_NB (b_B - field_bias_B) - b_N.
///
/// With C_true = C_NB exp([phi x]) and b_B = C_true' b_N + bias + v, to first order
///     innovation = [b_N x] C_NB phi + C_NB (bias error + v),
/// as C_NB [C_NB' b_N x] = [b_N x] C_NB. H stands on the model's field, never on the measured one,
/// whose noise would be in both. `white_sigma` (nT) and `slow` (nT^2) are those of one axis.
inline Measurement<3> field_measurement(const FieldInput& in, double white_sigma,
                                        const SlowNoise& slow) {
  Measurement<3> m;
  m.innovation = in.C_NB * (in.b_B - in.field_bias_B) - in.b_N;
  m.H.middleCols<kAttitude.size>(kAttitude.offset) = math::skew(in.b_N) * in.C_NB;
  m.H.middleCols<kFieldBias.size>(kFieldBias.offset) = in.C_NB;
  m.R.diagonal().setConstant(white_sigma * white_sigma + slow.variance);
  m.excess = slow.excess;
  return m;
}

}  // namespace lodestar::sahrs
