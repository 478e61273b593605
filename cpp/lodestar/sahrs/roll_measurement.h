// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "lodestar/sahrs/slow_noise.h"
#include "lodestar/sahrs/state.h"
#include "lodestar/sahrs/tilt.h"

namespace lodestar::sahrs {

/// What the roll measurement is made of, all at one time.
struct RollInput {
  Eigen::Vector3d omega_B;  // rad/s, bias removed
  double normal_force;      // m/s^2, g0 n_z
  Eigen::Vector3d v_air_B;  // m/s
  Tilt tilt;                // predicted
};

/// 1 sigma of what is new in each sample.
struct RollNoise {
  double omega;         // rad/s per axis
  double normal_force;  // m/s^2
};

/// The two components of gravity (m/s^2) whose ratio is the tangent of roll.
struct Balance {
  double lateral;
  double normal;

  double size() const {
    return std::sqrt(lateral * lateral + normal * normal);
  }  // g cos(pitch) if all is well
};

/// Rows y and z of the equation of motion in B, V' = -omega x V + g (-n + C_NB' e_3), with V' = 0
/// and n_y = 0 (SAHRS paper §3.2), where V = (u, v, w) and omega = (p, q, r):
///     g cos(pitch) sin(roll) = r u - p w,    g cos(pitch) cos(roll) = g n_z - q u + p v.
inline Balance balance(const RollInput& in) {
  const double u = in.v_air_B.x(), v = in.v_air_B.y(), w = in.v_air_B.z();
  const double p = in.omega_B.x(), q = in.omega_B.y(), r = in.omega_B.z();
  return {r * u - p * w, in.normal_force - q * u + p * v};
}

/// Roll from load factor and rates: roll = atan2(lateral, normal) of the `balance`. Meaningless
/// where both are small; needs pitch away from +-90 degrees.
///
/// To first order the innovation is the roll error, plus what the errors of the gyro biases and of
/// alpha and beta put into omega x V. The first is the largest by far: V/g, 18 degrees of roll for
/// 1 degree/s at 180 m/s. `unsteady` (m^2/s^4 per axis) is what was neglected: n_y and V'.
inline Measurement<1> roll_measurement(const RollInput& in, const RollNoise& noise,
                                       const SlowNoise& unsteady) {
  const Balance b = balance(in);
  const double size_squared = b.lateral * b.lateral + b.normal * b.normal;
  const double d_lateral = b.normal / size_squared;
  const double d_normal = -b.lateral / size_squared;
  const double u = in.v_air_B.x(), v = in.v_air_B.y(), w = in.v_air_B.z();
  const double p = in.omega_B.x(), q = in.omega_B.y(), r = in.omega_B.z();
  const Eigen::RowVector3d d_omega(d_normal * v - d_lateral * w, -d_normal * u, d_lateral * u);
  // V turns with alpha in the plane of x and z, with beta out of it.
  const double in_plane = std::sqrt(u * u + w * w);
  const Eigen::RowVector3d d_v(-d_normal * q + d_lateral * r, d_normal * p, -d_lateral * p);
  const Eigen::Vector3d v_by_alpha(-w, 0.0, u);
  const Eigen::Vector3d v_by_beta(-u * v / in_plane, in_plane, -w * v / in_plane);

  Measurement<1> m;
  // The difference of two angles, as the angle between two directions: no wrapping.
  m.innovation(0) = std::atan2(b.lateral * in.tilt.cos_roll - b.normal * in.tilt.sin_roll,
                               b.normal * in.tilt.cos_roll + b.lateral * in.tilt.sin_roll);
  m.H.middleCols<kAttitude.size>(kAttitude.offset) = in.tilt.d_roll();
  m.H.middleCols<kGyroBias.size>(kGyroBias.offset) = d_omega;
  m.H(0, kAlphaBias.offset) = d_v * v_by_alpha;
  m.H(0, kBetaBias.offset) = d_v * v_by_beta;
  m.R(0, 0) = d_omega.squaredNorm() * noise.omega * noise.omega +
              d_normal * d_normal * noise.normal_force * noise.normal_force +
              unsteady.variance / size_squared;
  m.excess = unsteady.excess / size_squared;
  return m;
}

}  // namespace lodestar::sahrs
