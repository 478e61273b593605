// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/attitude_error.h"

#include <algorithm>
#include <cmath>

namespace lodestar::fusion {
namespace {

constexpr double kSmallestCosine = 0.1;  // of pitch

// gamma_N (rad): north, east, down.
Eigen::Vector3d small_rotation(const TrackPoint& point, const StateVector& x) {
  return angle_errors(point, x).reverse();
}

Eigen::Matrix3d turned(const TrackPoint& point, const StateVector& x) {
  return math::exp_so3(small_rotation(point, x)) * math::C_NB_from_euler(point.attitude);
}

// Left Jacobian of SO(3): exp(gamma + d) is exp(J d) exp(gamma), d small.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& gamma) {
  const double angle = gamma.norm();
  double first = 0.5 - angle * angle / 24.0;          // (1 - cos) / angle^2
  double second = 1.0 / 6.0 - angle * angle / 120.0;  // (angle - sin) / angle^3
  if (angle > 1e-2) {
    first = (1.0 - std::cos(angle)) / (angle * angle);
    second = (angle - std::sin(angle)) / (angle * angle * angle);
  }
  const Eigen::Matrix3d S = math::skew(gamma);
  return Eigen::Matrix3d::Identity() + first * S + second * S * S;
}

// Rotation in N by each angle: its columns are the axes.
Eigen::Matrix3d rotation_by_angles(AttitudeError form, const TrackPoint& point,
                                   const StateVector& x) {
  if (form == AttitudeError::kSmallAngle) {
    return left_jacobian(small_rotation(point, x)).rowwise().reverse();
  }
  const math::Euler attitude = corrected_attitude(form, point, x);
  const double ch = std::cos(attitude.heading), sh = std::sin(attitude.heading);
  const double cp = std::cos(attitude.pitch), sp = std::sin(attitude.pitch);
  Eigen::Matrix3d axes;
  axes.col(0) << 0.0, 0.0, 1.0;
  axes.col(1) << -sh, ch, 0.0;
  axes.col(2) << ch * cp, sh * cp, -sp;
  return axes;
}

// d(heading, pitch, roll)/d(small rotation in N).
Eigen::Matrix3d euler_by_rotation_N(const math::Euler& attitude) {
  const double ch = std::cos(attitude.heading), sh = std::sin(attitude.heading);
  const double cp = std::max(kSmallestCosine, std::cos(attitude.pitch));
  const double tan_pitch = std::sin(attitude.pitch) / cp;
  Eigen::Matrix3d E;
  E << ch * tan_pitch, sh * tan_pitch, 1.0,  //
      -sh, ch, 0.0,                          //
      ch / cp, sh / cp, 0.0;
  return E;
}

}  // namespace

Eigen::Vector3d angle_errors(const TrackPoint& point, const StateVector& x) {
  Eigen::Vector3d angles = x.segment<3>(kHeadingError.offset);
  angles(0) += deviation(point.attitude.heading).dot(x.segment<2>(kDeviation.offset));
  return angles;
}

AngleMatrix angles_by_states(const TrackPoint& point) {
  AngleMatrix J = AngleMatrix::Zero();
  J.block<3, 3>(0, kHeadingError.offset).setIdentity();
  J.block<1, 2>(0, kDeviation.offset) = deviation(point.attitude.heading);
  return J;
}

math::Euler corrected_attitude(AttitudeError form, const TrackPoint& point, const StateVector& x) {
  if (form == AttitudeError::kSmallAngle) return math::euler_from_C_NB(turned(point, x));
  const Eigen::Vector3d angles = angle_errors(point, x);
  return {point.attitude.roll + angles(2), point.attitude.pitch + angles(1),
          point.attitude.heading + angles(0)};
}

double heading_error(AttitudeError form, const TrackPoint& point, const StateVector& x) {
  if (form == AttitudeError::kEuler) return angle_errors(point, x)(0);
  return math::wrap_pi(corrected_attitude(form, point, x).heading - point.attitude.heading);
}

Eigen::Matrix3d velocity_by_angles(AttitudeError form, const TrackPoint& point,
                                   const StateVector& x, const Eigen::Vector3d& v_air_N) {
  Eigen::Matrix3d J = rotation_by_angles(form, point, x);
  for (int i = 0; i < 3; ++i) J.col(i) = J.col(i).cross(v_air_N).eval();
  return J;
}

AngleMatrix euler_by_states(AttitudeError form, const TrackPoint& point, const StateVector& x) {
  const AngleMatrix J = angles_by_states(point);
  if (form == AttitudeError::kEuler) return J;
  return euler_by_rotation_N(corrected_attitude(form, point, x)) *
         rotation_by_angles(form, point, x) * J;
}

Eigen::Matrix3d angle_axes(AttitudeError form, double heading) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (form == AttitudeError::kEuler) return axes;
  const double ch = std::cos(heading), sh = std::sin(heading);
  axes.bottomRightCorner<2, 2>() << ch, sh, -sh, ch;
  return axes;
}

Eigen::Matrix3d angles_by_rotation_B(AttitudeError form, const math::Euler& attitude) {
  if (form == AttitudeError::kSmallAngle) {
    return math::C_NB_from_euler({attitude.roll, attitude.pitch, 0.0}).colwise().reverse();
  }
  const double sr = std::sin(attitude.roll), cr = std::cos(attitude.roll);
  const double sp = std::sin(attitude.pitch),
               cp = std::max(kSmallestCosine, std::cos(attitude.pitch));
  Eigen::Matrix3d E;
  E << 0.0, sr / cp, cr / cp,  //
      0.0, cr, -sr,            //
      1.0, sr * sp / cp, cr * sp / cp;
  return E;
}

}  // namespace lodestar::fusion
