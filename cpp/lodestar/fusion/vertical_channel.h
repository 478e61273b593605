// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/filter/gate.h"
#include "lodestar/fusion/cascade_parameters.h"

namespace lodestar::fusion {

/// Height and climb: baro altitude smoothed by the climb that attitude and air data give, and the
/// bias of baro altitude against GPS height.
///
/// Two filters of two states each. Climb: baro altitude h_baro and the error c of the climb rate,
///   h_baro' = -v_air_d + c,  c Gauss-Markov;  baro(t) = h_baro(t - lag) + noise.
/// Bias: b of baro altitude (true - baro) and slow error g of GPS height (measured - true),
///   GPS height - h_baro = b + g + noise,  both Gauss-Markov.
class VerticalChannel {
 public:
  explicit VerticalChannel(const CascadeParameters& parameters);

  bool started() const { return started_; }

  /// Moves on by `dt` (s) at `v_air_d` (m/s, down).
  void propagate(double dt, double v_air_d);

  /// A baro altitude (m) that is `age` (s) older than the state.
  void update_baro(double baro_altitude, double age);

  /// A GPS height that is `above_baro` (m) above the h_baro of its own time; `sigma` (m) is what
  /// the receiver states.
  void update_gps(double above_baro, double sigma);

  double baro_height() const { return climb_(0); }          // m
  double bias() const { return bias_(0); }                  // m
  double climb_correction() const { return climb_(1); }     // m/s, up
  double sigma_height() const;                              // m
  double climb_variance() const { return P_climb_(1, 1); }  // (m/s)^2, of the correction

 private:
  static constexpr int kPatience = 3;  // refused heights in a row before the bias starts anew

  CascadeParameters parameters_;
  filter::Gate gate_;
  bool started_ = false;
  int refused_ = 0;
  double v_air_d_ = 0.0;                             // m/s
  Eigen::Vector2d climb_ = Eigen::Vector2d::Zero();  // h_baro (m), c (m/s)
  Eigen::Matrix2d P_climb_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d bias_ = Eigen::Vector2d::Zero();  // b, g (m)
  Eigen::Matrix2d P_bias_ = Eigen::Matrix2d::Zero();
};

}  // namespace lodestar::fusion
