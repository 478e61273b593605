// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace lodestar::sahrs {

/// Roll and pitch by their sines and cosines, and how they change with a small rotation phi about
/// the body axes, C_NB exp([phi x]).
struct Tilt {
  double sin_roll, cos_roll, sin_pitch, cos_pitch;

  explicit Tilt(const Eigen::Matrix3d& C_NB)
      : sin_pitch(-C_NB(2, 0)),
        cos_pitch(std::sqrt(C_NB(2, 1) * C_NB(2, 1) + C_NB(2, 2) * C_NB(2, 2))) {
    // At +-90 degrees of pitch roll is any; nothing that uses it is valid there.
    const double inverse = cos_pitch > 0.0 ? 1.0 / cos_pitch : 0.0;
    sin_roll = C_NB(2, 1) * inverse;
    cos_roll = C_NB(2, 2) * inverse;
  }

  Eigen::RowVector3d d_roll() const {
    const double tan_pitch = sin_pitch / cos_pitch;
    return {1.0, sin_roll * tan_pitch, cos_roll * tan_pitch};
  }
  Eigen::RowVector3d d_pitch() const { return {0.0, cos_roll, -sin_roll}; }
};

}  // namespace lodestar::sahrs
