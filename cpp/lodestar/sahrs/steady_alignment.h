// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {

/// What the vector sensors and the models say of one moment.
struct MomentVectors {
  Eigen::Vector3d omega_B;  // rad/s
  Eigen::Vector3d n_B;      // g0
  Eigen::Vector3d v_air_B;  // m/s
  Eigen::Vector3d b_B;      // nT, calibrated
  Eigen::Vector3d b_N;      // nT, of the model
  double gravity;           // m/s^2
};

/// C_NB without any history: down is g0 n_B + omega_B x v_air_B (the equation of motion of the
/// SAHRS paper, §3.2, with V' = 0), heading turns the field into the model's vertical plane.
/// Nothing if what should be gravity is off its size by more than `max_imbalance` (1 = gravity):
/// the aircraft is then manoeuvring; or if the horizontal field is too weak to point anywhere.
std::optional<Eigen::Matrix3d> attitude_of(const MomentVectors& in, double max_imbalance);

/// Attitude from a few seconds of steady flight, straight or turning, without the gyros' bias in
/// it.
///
/// In one moment, gravity can not be told from the centripetal force that a gyro bias feigns: 0.2
/// deg/s at 190 m/s are 4 deg of roll, and then 12 deg of heading. In steady flight the aircraft
/// turns about the vertical alone, and how fast it does so the magnetic field shows by its own
/// turn.
class SteadyAlignment {
 public:
  void restart() { count_ = 0; }

  /// A sample of all sensors at `time_us`; `in.b_N` and `in.gravity` are those of the place.
  /// Answers the attitude at that time once kDuration of steady flight are behind it. Starts over
  /// by itself when the flight is not steady.
  std::optional<Eigen::Matrix3d> add(std::int64_t time_us, const MomentVectors& in,
                                     double max_imbalance);

 private:
  std::optional<Eigen::Matrix3d> solve(double duration, const MomentVectors& in,
                                       double max_imbalance) const;

  int count_ = 0;
  std::int64_t start_us_ = 0;
  Eigen::Vector3d first_omega_B_ = Eigen::Vector3d::Zero();
  // Sums over the samples, times counted from the first.
  double t_ = 0.0;
  double tt_ = 0.0;
  Eigen::Vector3d omega_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_air_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d b_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d tb_B_ = Eigen::Vector3d::Zero();
};

}  // namespace lodestar::sahrs
