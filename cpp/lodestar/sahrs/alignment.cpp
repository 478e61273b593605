// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/alignment.h"

#include <Eigen/Geometry>
#include <cmath>

#include "lodestar/samples/samples.h"

namespace lodestar::sahrs {

std::optional<math::Euler> align(const AlignmentInput& in, double max_imbalance) {
  constexpr double kWeakestField = 1000.0;  // nT, horizontal
  const Eigen::Vector3d gravity_B =
      samples::kStandardGravity * in.n_B + in.omega_B.cross(in.v_air_B);
  const double size = gravity_B.norm();
  if (!(std::abs(size / in.gravity - 1.0) <= max_imbalance)) return std::nullopt;

  math::Euler attitude;
  attitude.roll = std::atan2(gravity_B.y(), gravity_B.z());
  attitude.pitch = std::atan2(-gravity_B.x(), std::hypot(gravity_B.y(), gravity_B.z()));
  const Eigen::Vector3d b_level = math::C_NB_from_euler(attitude) * in.b_B;  // heading still 0
  if (std::hypot(b_level.x(), b_level.y()) < kWeakestField) return std::nullopt;
  attitude.heading =
      math::wrap_2pi(std::atan2(in.b_N.y(), in.b_N.x()) - std::atan2(b_level.y(), b_level.x()));
  return attitude;
}

}  // namespace lodestar::sahrs
