// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "lodestar/samples/samples.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// Velocity relative to the air in B (m/s), as the sensors have it.
inline Eigen::Vector3d air_velocity_B(const samples::AirData& sample) {
  return sample.true_airspeed * Eigen::Vector3d(std::cos(sample.alpha) * std::cos(sample.beta),
                                                std::sin(sample.beta),
                                                std::sin(sample.alpha) * std::cos(sample.beta));
}

/// 1 sigma of the noise of an air data computer.
struct AirDataNoise {
  double true_airspeed;  // m/s
  double flow_angle;     // rad
  double baro_altitude;  // m
};

/// Airspeed, alpha and beta of an air velocity in B.
inline Eigen::Vector3d flow_of(const Eigen::Vector3d& w) {
  return {w.norm(), std::atan2(w.z(), w.x()), std::atan2(w.y(), std::hypot(w.x(), w.z()))};
}

/// Airspeed, alpha and beta of an estimate, without the gust.
inline Eigen::Vector3d flow_without_gust(const Estimate& x) {
  return flow_of(x.C_NB.transpose() * x.air_velocity_N);
}

/// True airspeed, alpha and beta against the air velocity in B, w = C_NB' air_velocity, gust added,
/// `scaled` being the flow of w as ScaledFlow follows it:
///     V = |w + gust| + airspeed_scale scaled + airspeed_bias
///     alpha = atan2(w_z, w_x) (of w + gust) + scale scaled + bias,   beta likewise, asin(w_y /
///     |w|)
/// H stands on w without the gust, never on the measured values. Speed and scale factor are known
/// together only, and so are heading and beta's bias: if H followed the noise of the gusts, the
/// directions that nothing tells would turn to and fro, and the filter would run along them, 1.5 %
/// of the airspeed in two minutes of straight flight. The attitude error does not appear: see
/// state.h. And the baro altitude against the lagging height. The baro's own bias is part of both
/// heights: all that attitude takes from them is how fast they change.
struct AirDataMeasurement {
  static constexpr int kRows = 4;
  using Columns = Eigen::Matrix<double, kRows, 3>;
  Eigen::Vector4d innovation;  // m/s, rad, rad, m
  Eigen::Vector4d variance;    // squares of the same
  Columns H_velocity;
  Columns H_gust;
  Columns H_bias;   // airspeed scale and bias, alpha bias
  Columns H_scale;  // beta bias, alpha and beta scale

  template <class Visit>
  void visit_H(Visit&& visit) const {
    visit(kVelocity.offset, H_velocity);
    visit(kGust.offset, H_gust);
    visit(kAirspeedScale.offset, H_bias);
    visit(kFlowBias.offset + 1, H_scale);
    visit(kBaroHeight.offset, Eigen::Matrix<double, kRows, 1>::UnitW().eval());
  }
};
static_assert(kAirspeedBias.offset == kAirspeedScale.offset + 1 &&
              kFlowBias.offset == kAirspeedScale.offset + 2 &&
              kFlowScale.offset == kFlowBias.offset + 2);

inline AirDataMeasurement measure_air(const samples::AirData& sample, const Estimate& x,
                                      const Eigen::Vector3d& scaled, const AirDataNoise& noise) {
  const Eigen::Vector3d w = x.C_NB.transpose() * x.air_velocity_N;
  const Eigen::Vector3d flow = flow_of(w + x.gust_B);
  const double plane_squared = w.x() * w.x() + w.z() * w.z();
  const double plane = std::sqrt(plane_squared);
  const double V = w.norm();

  AirDataMeasurement m;
  m.innovation << sample.true_airspeed - flow.x() - x.airspeed_scale * scaled.x() - x.airspeed_bias,
      math::wrap_pi(sample.alpha - flow.y() - x.flow_scale.x() * scaled.y() - x.flow_bias.x()),
      sample.beta - flow.z() - x.flow_scale.y() * scaled.z() - x.flow_bias.y(),
      sample.baro_altitude - x.baro_height;
  m.variance =
      Eigen::Vector4d(noise.true_airspeed, noise.flow_angle, noise.flow_angle, noise.baro_altitude)
          .cwiseAbs2();
  m.H_gust.row(3).setZero();
  m.H_gust.row(0) = w.transpose() / V;
  m.H_gust.row(1) = Eigen::RowVector3d(-w.z(), 0.0, w.x()) / plane_squared;
  m.H_gust.row(2) =
      Eigen::RowVector3d(-w.y() * w.x(), plane_squared, -w.y() * w.z()) / (V * V * plane);
  m.H_velocity = m.H_gust * x.C_NB.transpose();
  m.H_bias << scaled.x(), 1.0, 0.0,  //
      0.0, 0.0, 1.0,                 //
      0.0, 0.0, 0.0,                 //
      0.0, 0.0, 0.0;
  m.H_scale << 0.0, 0.0, 0.0,  //
      0.0, scaled.y(), 0.0,    //
      1.0, 0.0, scaled.z(),    //
      0.0, 0.0, 0.0;
  return m;
}

}  // namespace lodestar::strapdown
