// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {

/// What the vector measurements say of one moment.
struct AlignmentInput {
  Eigen::Vector3d omega_B;  // rad/s
  Eigen::Vector3d n_B;      // g0
  Eigen::Vector3d v_air_B;  // m/s
  Eigen::Vector3d b_B;      // nT, calibrated
  Eigen::Vector3d b_N;      // nT, of the model
  double gravity;           // m/s^2
};

/// Attitude without any history: down is g0 n_B + omega_B x v_air_B (the equation of motion of the
/// SAHRS paper, §3.2, with V' = 0), heading turns the field into the model's vertical plane.
/// Nothing if what should be gravity is off its size by more than `max_imbalance` (1 = gravity):
/// the aircraft is then manoeuvring; or if the horizontal field is too weak to point anywhere.
std::optional<math::Euler> align(const AlignmentInput& in, double max_imbalance);

}  // namespace lodestar::sahrs
