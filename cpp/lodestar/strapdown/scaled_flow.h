// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/math/rotation.h"

namespace lodestar::strapdown {

/// What the scale factors of the air data multiply: airspeed (m/s), alpha and beta (rad) of the
/// estimate, followed with play.
///
/// Where flow is steady, a scale factor and the bias beside it are known together only. What the
/// estimate then does is noise, and its errors are in the innovation with the opposite sign: a
/// scale factor that multiplies them is regressed on noise and drawn towards -1, which is to say
/// that flow does not matter, by as much as its sigma in minutes (errors in variables, regression
/// dilution: Fuller, Measurement Error Models, 1987), and pitch goes with it. A flow that keeps
/// still until the estimate has moved by more than its noise can be has nothing to regress on, and
/// is wrong by no more than the play: 2 % of 0.3 deg.
class ScaledFlow {
 public:
  /// Follows `flow` (airspeed, alpha, beta); answers what is to be multiplied.
  const Eigen::Vector3d& follow(const Eigen::Vector3d& flow) {
    if (kept_.isZero()) kept_ = flow;  // the first one
    const Eigen::Vector3d play(kSpeedPlay * flow.x(), kAnglePlay, kAnglePlay);
    kept_ = kept_.cwiseMax(flow - play).cwiseMin(flow + play);
    return kept_;
  }

  static constexpr double kSpeedPlay = 0.01;                 // of the airspeed
  static constexpr double kAnglePlay = 0.3 * math::kDegree;  // rad

 private:
  Eigen::Vector3d kept_ = Eigen::Vector3d::Zero();
};

}  // namespace lodestar::strapdown
