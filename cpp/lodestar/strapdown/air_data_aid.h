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

/// True airspeed, alpha and beta against the air velocity in B, w = C_NB' air_velocity + gust:
///     V = (1 + airspeed_scale) |w| + airspeed_bias
///     alpha = (1 + scale) atan2(w_z, w_x) + bias,   beta = (1 + scale) asin(w_y / |w|) + bias
/// H stands on the predicted w, never on the measured values, whose noise is in the innovation: the
/// airspeed scale would run away. The attitude error does not appear: see state.h.
/// And the baro altitude against the lagging height. The baro's own bias is part of both heights:
/// all that attitude takes from them is how fast they change.
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
                                      const AirDataNoise& noise) {
  const Eigen::Vector3d w = x.v_air_B();
  const double plane_squared = w.x() * w.x() + w.z() * w.z();
  const double plane = std::sqrt(plane_squared);
  const double squared = w.squaredNorm();
  const double V = std::sqrt(squared);
  const double alpha = std::atan2(w.z(), w.x());
  const double beta = std::atan2(w.y(), plane);

  AirDataMeasurement m;
  m.innovation << sample.true_airspeed - (1.0 + x.airspeed_scale) * V - x.airspeed_bias,
      math::wrap_pi(sample.alpha - (1.0 + x.flow_scale.x()) * alpha - x.flow_bias.x()),
      sample.beta - (1.0 + x.flow_scale.y()) * beta - x.flow_bias.y(),
      sample.baro_altitude - x.baro_height;
  m.variance =
      Eigen::Vector4d(noise.true_airspeed, noise.flow_angle, noise.flow_angle, noise.baro_altitude)
          .cwiseAbs2();
  m.H_gust.row(3).setZero();
  m.H_gust.row(0) = (1.0 + x.airspeed_scale) / V * w.transpose();
  m.H_gust.row(1) =
      (1.0 + x.flow_scale.x()) / plane_squared * Eigen::RowVector3d(-w.z(), 0.0, w.x());
  m.H_gust.row(2) = (1.0 + x.flow_scale.y()) / (squared * plane) *
                    Eigen::RowVector3d(-w.y() * w.x(), plane_squared, -w.y() * w.z());
  m.H_velocity = m.H_gust * x.C_NB.transpose();
  m.H_bias << V, 1.0, 0.0,  //
      0.0, 0.0, 1.0,        //
      0.0, 0.0, 0.0,        //
      0.0, 0.0, 0.0;
  m.H_scale << 0.0, 0.0, 0.0,  //
      0.0, alpha, 0.0,         //
      1.0, 0.0, beta,          //
      0.0, 0.0, 0.0;
  return m;
}

}  // namespace lodestar::strapdown
