// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace lodestar::math {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180.0;  // rad

/// Roll, pitch and heading (rad), applied in the order heading, pitch, roll (3-2-1).
struct Euler {
  double roll = 0.0;
  double pitch = 0.0;
  double heading = 0.0;
};

/// `angle` (rad) in (-pi, pi].
inline double wrap_pi(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

/// `angle` (rad) in [0, 2 pi).
inline double wrap_2pi(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  if (wrapped >= 0.0) return wrapped < 2.0 * kPi ? wrapped : 0.0;
  const double shifted = wrapped + 2.0 * kPi;
  return shifted < 2.0 * kPi ? shifted : 0.0;  // -1e-20 + 2 pi rounds to 2 pi
}

/// The matrix [v x] with [v x] w = v cross w.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Unit quaternion of the rotation vector `phi` (rad): exact, and smooth through zero.
inline Eigen::Quaterniond exp_quaternion(const Eigen::Vector3d& phi) {
  const double angle_squared = phi.squaredNorm();
  double w = 0.0;
  double scale = 0.0;          // sin(angle / 2) / angle
  if (angle_squared < 1e-3) {  // what these leave out is of the order 1e-19
    const double x = angle_squared;
    w = 1.0 - x / 8.0 * (1.0 - x / 48.0 * (1.0 - x / 120.0));
    scale = 0.5 - x / 48.0 * (1.0 - x / 80.0 * (1.0 - x / 168.0));
  } else {
    const double angle = std::sqrt(angle_squared);
    w = std::cos(0.5 * angle);
    scale = std::sin(0.5 * angle) / angle;
  }
  return Eigen::Quaterniond(w, scale * phi.x(), scale * phi.y(), scale * phi.z());
}

/// Rotation vector (rad), of length at most pi, of the unit quaternion `q`.
inline Eigen::Vector3d log_quaternion(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d vector = sign * q.vec();
  const double sine = vector.norm();
  const double cosine = sign * q.w();
  if (sine < 1e-8) return (2.0 / cosine) * vector;
  return (2.0 * std::atan2(sine, cosine) / sine) * vector;
}

/// Rotation matrix of the rotation vector `phi` (rad): exp([phi x]).
inline Eigen::Matrix3d exp_so3(const Eigen::Vector3d& phi) {
  return exp_quaternion(phi).toRotationMatrix();
}

/// Rotation vector (rad) of `dt` (s) at a body rate that goes from `omega_0` to `omega_1` (rad/s)
/// on a straight line: the trapezoid, and the second term of Magnus' series for C' = C [omega x],
/// which halves the drift in a coning motion.
inline Eigen::Vector3d rotation_vector(const Eigen::Vector3d& omega_0,
                                       const Eigen::Vector3d& omega_1, double dt) {
  return 0.5 * dt * (omega_0 + omega_1) + (dt * dt / 12.0) * omega_0.cross(omega_1);
}

/// C_NB (takes vectors from B to N) of the Euler angles.
inline Eigen::Matrix3d C_NB_from_euler(const Euler& e) {
  const double cr = std::cos(e.roll), sr = std::sin(e.roll);
  const double cp = std::cos(e.pitch), sp = std::sin(e.pitch);
  const double ch = std::cos(e.heading), sh = std::sin(e.heading);
  Eigen::Matrix3d C_NB;
  C_NB << ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr,  //
      sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr,      //
      -sp, cp * sr, cp * cr;
  return C_NB;
}

/// Euler angles of C_NB: roll in (-pi, pi], pitch in [-pi/2, pi/2], heading in [0, 2 pi).
inline Euler euler_from_C_NB(const Eigen::Matrix3d& C_NB) {
  Euler e;
  e.roll = std::atan2(C_NB(2, 1), C_NB(2, 2));
  e.pitch = std::atan2(-C_NB(2, 0), std::hypot(C_NB(2, 1), C_NB(2, 2)));
  const double heading = std::atan2(C_NB(1, 0), C_NB(0, 0));
  e.heading = heading < 0.0 ? heading + 2.0 * kPi : heading;
  if (e.heading >= 2.0 * kPi) e.heading = 0.0;  // -1e-20 + 2 pi rounds to 2 pi
  return e;
}

}  // namespace lodestar::math
