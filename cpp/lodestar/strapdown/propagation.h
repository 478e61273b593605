// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// What the motion of one frame rests on besides the gyros and the load factor.
struct Place {
  double gravity = 9.81;                                       // m/s^2
  Eigen::Vector3d earth_rate_N = Eigen::Vector3d::Zero();      // rad/s
  Eigen::Vector3d transport_rate_N = Eigen::Vector3d::Zero();  // rad/s
  double baro_lag = 0.0;                                       // s
  double lat = 0.0;                                            // rad
};

/// One frame: the trapezoid's middle, about which the error equations are written.
struct Step {
  double dt = 0.0;                                           // s
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();         // rad/s, measured, mean of the frame
  Eigen::Matrix3d C_NB = Eigen::Matrix3d::Identity();        // mean of both ends
  Eigen::Vector3d air_velocity_N = Eigen::Vector3d::Zero();  // m/s, mean of both ends
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();             // m/s, the same over the ground
};

/// Spectral densities of what drives the errors.
struct ProcessNoise {
  double gyro = 0.0;           // (rad/s)^2/Hz
  double force = 0.0;          // (m/s^2)^2/Hz, of the load factor
  double wind = 0.0;           // (m/s^2)^2/Hz, horizontal, of the wind's change
  double vertical_wind = 0.0;  // (m/s^2)^2/Hz
  double mean_wind = 0.0;      // (m/s^2)^2/Hz, the part of the wind's change that lasts
  double wind_return = 0.0;    // share of its distance to the mean, in the frame
  double height = 0.0;         // (m/s)^2/Hz, of the baro's scale, and of neglected_climb()
  double gyro_bias = 0.0;      // (rad/s^2)^2/Hz
  // Gauss-Markov states: decay over the frame and variance added in it.
  double field_drift_decay = 1.0;
  double field_drift_variance = 0.0;  // nT^2
  double gust_decay = 1.0;
  Eigen::Vector3d gust_variance = Eigen::Vector3d::Zero();  // (m/s)^2
  double gps_error_decay = 1.0;
  double gps_error_variance = 0.0;  // m^2
  double baro_bias_decay = 1.0;
  double baro_bias_variance = 0.0;  // m^2
};

/// Moves attitude, air velocity and heights over a frame at measured rates `omega_B` (rad/s, mean)
/// and specific force `force_B` (m/s^2, mean, not yet corrected for its bias):
///     C_NB' = C_NB [omega_NB x],   v' = C_NB f + g - (2 omega_IE + omega_EN) x v
///     h' = -v_down,   baro' = (h - baro) / lag
/// v is the velocity over the ground as far as the wind is known; without GPS the wind's own
/// Coriolis acceleration (0.001 m/s^2 in 10 m/s) is left out. The rotation is the exact exponential
/// of the mean rate.
Step move(Estimate& x, const Eigen::Vector3d& omega_B, const Eigen::Vector3d& force_B,
          const Place& place, double dt);

/// P <- Phi P Phi' + Q over `step`. Phi is that of the error equations (to first order in the
/// errors)
///     phi' = C w - omega_IN x phi,    w = -gyro_bias - gyro_matrix omega_B - noise
///     dv'  = [g x] phi + v x (omega_IE x phi) + v x (C w) - (2 omega_IE + omega_EN) x dv
///            - C force_bias - noise
///     dh'  = -dv_down + (v x phi)_down,    dbaro' = (dh - dbaro) / lag
/// to second order in dt. Only the eight motion states and the Gauss-Markov states have rows of
/// their own, so P is moved by columns, never by an N x N product.
///
/// Over the ground also (north and east of)
///     dp' = dv - v x phi + dw + curvature dp,   dw' = (dm - dw) / tau + n,   dm' = part of n
/// and dv' has the Coriolis acceleration of dv + dw, where the wind's change, of both kinds, is the
/// air velocity's with the other sign: ground velocity has none of it. Left out is that phi turns
/// the wind's return, phi x (m - w) / tau.
template <int N>
void propagate(CovarianceOf<N>& P, const Step& step, const Place& place, const ProcessNoise& noise);

/// Spectral density ((m/s)^2/Hz) of the climb that the error equations leave out. True are
/// exp([phi x]) v and its second order, of which the vertical part is phi_down (phi . v) / 2: with
/// 3 deg of heading and 1 deg of bank unknown 0.1 m/s at 200 m/s, which is more than baro and load
/// factor leave open. On a leg where bank and heading err together for a minute it does so too, and
/// when the aircraft then pulls up it would pass for news of both. Not more than what leaves the
/// climb of use for the tilt, should the gyros fail.
template <int N>
double neglected_climb(const CovarianceOf<N>& P, const Eigen::Vector3d& air_velocity_N) {
  constexpr double kLasts = 60.0;  // s
  constexpr double kMost = 0.25;   // (m/s)^2/Hz
  const Eigen::Vector2d v = air_velocity_N.head<2>();
  const double along = v.x() * v.x() * P(0, 0) + v.y() * v.y() * P(1, 1) +
                       2.0 * v.x() * v.y() * P(1, 0);  // variance of phi . v
  const double variance = 0.5 * P(2, 2) * along;       // between its values for rho = 0 and 1
  return std::min(2.0 * kLasts * variance, kMost);
}

/// x <- Phi x with the same Phi, but for the position.
template <int N>
void propagate_error(StateVectorOf<N>& x, const Step& step, const Place& place,
                     const ProcessNoise& noise);

/// Moves the position over a frame at ground velocity `v_N` (m/s, mean); answers by how much (m,
/// north, east).
Eigen::Vector2d move_over_ground(Estimate& x, const Eigen::Vector3d& v_N, double dt);

/// What a correction `phi_N` (rad, in N) of the attitude does to what is known of other vectors;
/// `C_NB`: the attitude. The errors of sensors (biases of force, gyros and field, drift of the
/// field) are kept in B, but what was learnt of them was learnt in N, together with the attitude:
/// their covariance turns, in B, the opposite way. The errors of the air velocity, and of the wind
/// with it, are kept in N, but the air data know them in B: their covariance turns with B. Without
/// it the filter takes its own corrections for turns of the aircraft, in which hard iron, airspeed
/// and sideslip would show (Barrau and Bonnabel, The geometry of navigation problems, 2022).
template <int N>
void turn_errors(CovarianceOf<N>& P, const Eigen::Vector3d& phi_N, const Eigen::Matrix3d& C_NB);

}  // namespace lodestar::strapdown
