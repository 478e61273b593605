// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace lodestar::sahrs {

/// A measurement error that stays alike over many samples, in a filter that takes each sample's
/// error for new.
///
/// A first-order Gauss-Markov error of `variance` and time constant tau has the spectral density
/// 2 tau variance at low frequency; white samples of R every `interval` have R interval. The filter
/// gets as much out of the one as out of the other if R = variance 2 tau / interval, so the update
/// uses variance + excess, while one sample by itself, and its gate, knows of variance only. Tau
/// need not be longer than the memory of the filter.
struct SlowNoise {
  double variance;
  double excess;

  static SlowNoise of(double sigma, double tau, double interval) {
    const double variance = sigma * sigma;
    return {variance, variance * (std::max(1.0, 2.0 * tau / interval) - 1.0)};
  }

  SlowNoise operator+(const SlowNoise& other) const {
    return {variance + other.variance, excess + other.excess};
  }
  SlowNoise operator*(double factor) const { return {variance * factor, excess * factor}; }
};

}  // namespace lodestar::sahrs
