// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/math/state_layout.h"

// States of the cascade: errors of dead reckoning and of GPS, Linköping thesis eq. 3.9-3.18 and
// 4.16, in metres (3.11), and the deviation of the compass (after 7.2). Every error is
// true - computed, but the GPS error, which is measured - true. So
//   true heading    = SAHRS heading + heading error + deviation
//   true position   = dead-reckoned position + position error
//   true velocity   = C_NB(true angles) v_air_B + wind
//   GPS position    = true position + GPS error + noise

namespace lodestar::fusion {

inline constexpr int kStates = 11;
inline constexpr math::Block kPositionError{0, 2};                        // m, north, east
inline constexpr math::Block kGpsError = math::after(kPositionError, 2);  // m, north, east
inline constexpr math::Block kWind = math::after(kGpsError, 2);           // m/s, north, east
// rad; with AttitudeError::kSmallAngle the rotation about down, east and north, which at heading
// north are the same three.
inline constexpr math::Block kHeadingError = math::after(kWind, 1);
inline constexpr math::Block kPitchError = math::after(kHeadingError, 1);
inline constexpr math::Block kRollError = math::after(kPitchError, 1);
inline constexpr math::Block kDeviation = math::after(kRollError, 2);  // rad, see deviation()
static_assert(math::end(kDeviation) == kStates);

/// All that is wrong with the angles of SAHRS.
inline constexpr math::Block kAngles{kHeadingError.offset, 5};

inline constexpr int kNoises = 14;
inline constexpr math::Block kAirDataNoise{0, 3};                          // alpha, beta, V
inline constexpr math::Block kTrackNoise = math::after(kAirDataNoise, 2);  // north, east
inline constexpr math::Block kGpsNoise = math::after(kTrackNoise, 2);      // north, east
inline constexpr math::Block kWindNoise = math::after(kGpsNoise, 2);       // north, east
inline constexpr math::Block kAngleNoise = math::after(kWindNoise, 3);     // heading, pitch, roll
inline constexpr math::Block kDeviationNoise = math::after(kAngleNoise, 2);
static_assert(math::end(kDeviationNoise) == kNoises);

using StateVector = Eigen::Matrix<double, kStates, 1>;
using StateMatrix = Eigen::Matrix<double, kStates, kStates>;
using NoiseVector = Eigen::Matrix<double, kNoises, 1>;
using NoiseMatrix = Eigen::Matrix<double, kStates, kNoises>;
using PositionMatrix = Eigen::Matrix<double, 2, kStates>;
using AngleMatrix = Eigen::Matrix<double, 3, kStates>;

}  // namespace lodestar::fusion
