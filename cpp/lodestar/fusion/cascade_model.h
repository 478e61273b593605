// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/fusion/cascade_parameters.h"
#include "lodestar/fusion/dead_reckoning.h"
#include "lodestar/math/state_layout.h"

// Errors of dead reckoning and of GPS, Linköping thesis eq. 3.9-3.18 and 4.16, in metres (3.11).
// Every error is true - computed, but the GPS error, which is measured - true. So
//   true heading    = SAHRS heading + heading error
//   true position   = dead-reckoned position + position error
//   true velocity   = C_NB(true angles) v_air_B + wind
//   GPS position    = true position + GPS error + noise

namespace lodestar::fusion {

inline constexpr int kStates = 9;
inline constexpr math::Block kPositionError{0, 2};                         // m, north, east
inline constexpr math::Block kGpsError = math::after(kPositionError, 2);   // m, north, east
inline constexpr math::Block kWind = math::after(kGpsError, 2);            // m/s, north, east
inline constexpr math::Block kHeadingError = math::after(kWind, 1);        // rad
inline constexpr math::Block kPitchError = math::after(kHeadingError, 1);  // rad
inline constexpr math::Block kRollError = math::after(kPitchError, 1);     // rad
static_assert(math::end(kRollError) == kStates);

inline constexpr int kNoises = 12;
inline constexpr math::Block kAirDataNoise{0, 3};                          // alpha, beta, V
inline constexpr math::Block kTrackNoise = math::after(kAirDataNoise, 2);  // north, east
inline constexpr math::Block kGpsNoise = math::after(kTrackNoise, 2);      // north, east
inline constexpr math::Block kWindNoise = math::after(kGpsNoise, 2);       // north, east
inline constexpr math::Block kAngleNoise = math::after(kWindNoise, 3);     // heading, pitch, roll
static_assert(math::end(kAngleNoise) == kNoises);

using StateVector = Eigen::Matrix<double, kStates, 1>;
using StateMatrix = Eigen::Matrix<double, kStates, kStates>;
using NoiseVector = Eigen::Matrix<double, kNoises, 1>;
using NoiseMatrix = Eigen::Matrix<double, kStates, kNoises>;
using PositionMatrix = Eigen::Matrix<double, 2, kStates>;

/// SAHRS angles at `point` corrected by the angle errors of `x` (rad; heading not wrapped).
math::Euler corrected_attitude(const TrackPoint& point, const StateVector& x);

/// d(C_NB v_air_B)/d(heading, pitch, roll), (m/s)/rad: each column is the axis of that angle, in N,
/// crossed with the velocity (thesis eq. 3.18 put together).
Eigen::Matrix3d velocity_by_angles(const math::Euler& attitude, const Eigen::Vector3d& v_air_N);

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
Eigen::Vector2d position_error_rate(const TrackPoint& point, const StateVector& x);

/// d(true velocity north, east)/dx at the corrected angles.
PositionMatrix velocity_by_states(const TrackPoint& point, const StateVector& x);

/// GPS position - dead-reckoned position = H x + noise.
PositionMatrix position_measurement();

}  // namespace lodestar::fusion
