// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "lodestar/math/rotation.h"
#include "lodestar/sahrs/rate_filter.h"

namespace lodestar::sahrs {

/// What the sensors and models say at the moment of the alignment.
struct AlignmentInput {
  double climb_rate;     // m/s, up
  Eigen::Vector3d b_N;   // nT, of the field model
  double gravity;        // m/s^2
  double max_gyro_bias;  // rad/s, the most that may be taken for bias
  double max_imbalance;  // of gravity
};

struct Aligned {
  math::Euler attitude;         // rad
  Eigen::Vector3d sigma_B;      // rad, what to expect of it
  Eigen::Vector3d omega_B;      // rad/s, as observed
  Eigen::Vector3d gyro_bias_B;  // rad/s, part of that
  bool averaged;                // over nearly straight flight
};

/// Attitude from nothing but a few seconds of vector measurements.
///
/// Down is g0 n + omega x V (the equation of motion of the SAHRS paper, §3.2, with V' = 0), pitch
/// is then made that of the air data, and heading turns the field into the model's vertical plane.
///
/// A gyro bias of 0.2 degrees/s tilts down by 4 degrees at 180 m/s, and that turns heading by 12
/// where the field dips by 72. But in flight that is nearly straight the aircraft turns about down
/// only, the field says how fast, b_B' = rate (b_B x down), and what the gyros read beyond that is
/// bias. All vectors stand still in B then, and are averaged. In a turn the field's rate says less
/// of the bias than the bias spoils, and in a manoeuvre nothing: the vectors are then taken as they
/// are, and the bias as nought.
class Alignment {
 public:
  void restart();
  void observe_rates(const Eigen::Vector3d& omega_B, std::int64_t time_us);  // rad/s
  void observe_field(const Eigen::Vector3d& b_B, std::int64_t time_us);      // nT, calibrated
  /// `n_B` (g0) while the air velocity is `v_air_B` (m/s).
  void observe_load(const Eigen::Vector3d& n_B, const Eigen::Vector3d& v_air_B,
                    std::int64_t time_us);

  /// Nothing before some seconds were observed; in manoeuvres, which show in what should be gravity
  /// being off its size; and where the field is too vertical to point anywhere.
  std::optional<Aligned> solve(const AlignmentInput& in) const;

 private:
  /// A vector, and its value and rate smoothed over a second or two.
  struct VectorFilter {
    std::array<RateFilter, 3> axes{RateFilter(1.0), RateFilter(1.0), RateFilter(1.0)};
    Eigen::Vector3d latest = Eigen::Vector3d::Zero();
    bool started = false;
    std::int64_t time_us = 0;

    void update(const Eigen::Vector3d& value, std::int64_t at_us);
    bool settled() const { return started && axes[0].settled(); }
    Eigen::Vector3d value() const;  // smoothed
    Eigen::Vector3d rate() const;
  };

  bool straight(const AlignmentInput& in) const;
  double field_rate(const Eigen::Vector3d& down_B) const;

  VectorFilter turn_B_;     // rad, integral of the rates: its rate is theirs, smoothed
  VectorFilter gravity_B_;  // m/s^2
  VectorFilter field_B_;    // nT
  Eigen::Vector3d omega_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_air_B_ = Eigen::Vector3d::Zero();
};

}  // namespace lodestar::sahrs
