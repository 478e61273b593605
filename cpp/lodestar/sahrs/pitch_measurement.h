// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "lodestar/sahrs/slow_noise.h"
#include "lodestar/sahrs/state.h"
#include "lodestar/sahrs/tilt.h"

namespace lodestar::sahrs {

/// What the pitch measurement is made of, all at one time.
struct PitchInput {
  Eigen::Vector3d v_air_B;  // m/s, along alpha and beta
  double climb_rate;        // m/s, up
  Tilt tilt;                // predicted
};

/// Airspeed in the plane in which pitch turns the velocity: hypot(a, c) of `pitch_measurement`.
inline double pitch_plane_airspeed(const PitchInput& in) {
  const double c = in.v_air_B.y() * in.tilt.sin_roll + in.v_air_B.z() * in.tilt.cos_roll;
  return std::sqrt(in.v_air_B.x() * in.v_air_B.x() + c * c);
}

/// Pitch from air data (SAHRS paper §3.2; the estimate of roll is used in it). With no vertical
/// wind
///     climb_rate = a sin(pitch) - c cos(pitch),
///     a = u = V cos(alpha) cos(beta),
///     c = v sin(roll) + w cos(roll) = V (sin(beta) sin(roll) + sin(alpha) cos(beta) cos(roll)),
/// of which pitch = asin(climb_rate / hypot(a, c)) + atan2(c, a). Needs |climb_rate| < hypot(a, c)
/// by a margin, and pitch away from +-90 degrees.
///
/// To first order the innovation is the pitch error, less what the error of roll puts into it, plus
/// the biases of alpha and beta. `alpha_sigma` (rad) is white, `climb_rate` (m^2/s^2) is the error
/// of the rate of climb through the air: the filter's, and the vertical wind.
inline Measurement<1> pitch_measurement(const PitchInput& in, double alpha_sigma,
                                        const SlowNoise& climb_rate) {
  const double sin_roll = in.tilt.sin_roll, cos_roll = in.tilt.cos_roll;
  const double u = in.v_air_B.x(), v = in.v_air_B.y(), w = in.v_air_B.z();
  const double a = u;
  const double c = v * sin_roll + w * cos_roll;
  const double plane_squared = a * a + c * c;
  const double horizontal_squared = plane_squared - in.climb_rate * in.climb_rate;
  const double pitch = std::asin(in.climb_rate / std::sqrt(plane_squared)) + std::atan2(c, a);

  // Partial derivatives of the measured pitch. The velocity turns with alpha in the plane of x and
  // z, with beta out of it.
  const double shared = in.climb_rate / (plane_squared * std::sqrt(horizontal_squared));
  const double d_a = -c / plane_squared - a * shared;
  const double d_c = a / plane_squared - c * shared;
  const double d_roll = d_c * (v * cos_roll - w * sin_roll);
  const double d_alpha = d_c * u * cos_roll - d_a * w;
  const double in_plane = std::sqrt(u * u + w * w);
  const double d_beta = d_c * in_plane * sin_roll - (d_a * u + d_c * w * cos_roll) * v / in_plane;

  Measurement<1> m;
  m.innovation(0) = pitch - std::atan2(in.tilt.sin_pitch, in.tilt.cos_pitch);
  m.H.middleCols<kAttitude.size>(kAttitude.offset) = in.tilt.d_pitch() - d_roll * in.tilt.d_roll();
  m.H(0, kAlphaBias.offset) = d_alpha;
  m.H(0, kBetaBias.offset) = d_beta;
  m.R(0, 0) =
      d_alpha * d_alpha * alpha_sigma * alpha_sigma + climb_rate.variance / horizontal_squared;
  m.excess = climb_rate.excess / horizontal_squared;
  return m;
}

}  // namespace lodestar::sahrs
