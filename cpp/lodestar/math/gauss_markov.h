// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace lodestar::math {

/// First-order Gauss-Markov process, x' = -x / tau + w, with stationary standard deviation `sigma`
/// (unit of x) and time constant `tau` (s). The spectral density of w is 2 sigma^2 / tau.
struct GaussMarkov {
  double sigma;
  double tau;

  double decay(double dt) const { return std::exp(-dt / tau); }
  double spectral_density() const { return 2.0 * sigma * sigma / tau; }
  /// Variance that the noise of `dt` seconds adds: exact, sigma^2 (1 - exp(-2 dt / tau)).
  double added_variance(double dt) const { return -sigma * sigma * std::expm1(-2.0 * dt / tau); }
};

}  // namespace lodestar::math
