// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// Barometric altitude against the lagging height. The baro's own bias is part of both heights: all
/// that attitude takes from them is how fast they change.
struct BaroMeasurement {
  static constexpr int kRows = 1;
  Eigen::Matrix<double, 1, 1> innovation;  // m
  Eigen::Matrix<double, 1, 1> variance;    // m^2

  template <class Visit>
  void visit_H(Visit&& visit) const {
    visit(kBaroHeight.offset, 1.0);
  }
};

inline BaroMeasurement measure_baro(double baro_altitude, const Estimate& x, double noise_sigma) {
  BaroMeasurement m;
  m.innovation << baro_altitude - x.baro_height;
  m.variance << noise_sigma * noise_sigma;
  return m;
}

}  // namespace lodestar::strapdown
