// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/fusion/attitude_error.h"
#include "lodestar/fusion/cascade_parameters.h"
#include "lodestar/fusion/cascade_states.h"
#include "lodestar/fusion/dead_reckoning.h"

// How the errors of dead reckoning and of GPS grow, Linköping thesis eq. 3.9-3.18 and 4.16.

namespace lodestar::fusion {

/// d(v_air_B)/d(alpha, beta, V): m/s per rad, rad and m/s.
Eigen::Matrix3d velocity_by_air_data(const Eigen::Vector3d& v_air_B);

/// x' = F x + G w at one instant, linearised about angle errors `about` (those of the estimate, or
/// zero). First columns of G: alpha, beta (rad) and V (m/s); the others drive their states alone.
struct ErrorDynamics {
  StateMatrix F;
  NoiseMatrix G;
};
ErrorDynamics error_dynamics(const CascadeParameters& parameters, const TrackPoint& point,
                             const StateVector& about);

/// Rate of the position error (m/s, north, east), not linearised in the angle errors.
Eigen::Vector2d position_error_rate(AttitudeError form, const TrackPoint& point,
                                    const StateVector& x);

/// d(true velocity north, east)/dx at the corrected angles.
PositionMatrix velocity_by_states(AttitudeError form, const TrackPoint& point,
                                  const StateVector& x);

/// GPS position - dead-reckoned position = H x + noise.
PositionMatrix position_measurement();

}  // namespace lodestar::fusion
