// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/sahrs/parameters.h"
#include "lodestar/sahrs/state.h"

namespace lodestar::sahrs {

/// How the errors grow:
///     phi' = -[omega_B x] phi - b_g + w_g,   b' = -b / tau + w_b   for every bias b,
/// phi being the rotation of C_true = C_NB exp([phi x]) and b true minus estimated. Attitude and
/// its coupling to the gyro bias move with every frame; what changes over a minute or more moves in
/// steps of 0.1 s.
class ErrorModel {
 public:
  explicit ErrorModel(const Parameters& parameters) : parameters_(parameters) {}

  /// Covariance before anything is known but the attitude, to `attitude_sigma_B` (rad).
  Covariance initial(const Eigen::Vector3d& attitude_sigma_B) const;

  /// Forgets what `P` knew of the attitude, in favour of `attitude_sigma_B` (rad).
  static void restart_attitude(Covariance& P, const Eigen::Vector3d& attitude_sigma_B);

  /// Folds the estimated rotation `turn_B` (rad) into the attitude: the error is counted from there
  /// on, exp(-[turn x]) exp([(turn + phi) x]) = exp([G phi x]) with G = I - [turn x] / 2. Below
  /// 1 mrad G is the identity to all that matters.
  static void fold_in(Covariance& P, const Eigen::Vector3d& turn_B);

  /// One frame of `dt` (s): `omega_B` (rad/s) is the mean rate, bias removed; `b_B` (nT) the field.
  void propagate(Covariance& P, const Eigen::Vector3d& omega_B, const Eigen::Vector3d& b_B,
                 double dt);

 private:
  void step_slow_errors(Covariance& P, const Eigen::Vector3d& b_B);

  Parameters parameters_;
  double slow_time_ = 0.0;                                 // s since the last slow step
  Eigen::Vector3d slow_turn_B_ = Eigen::Vector3d::Zero();  // rad, turned since then
};

}  // namespace lodestar::sahrs
