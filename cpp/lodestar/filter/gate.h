// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "lodestar/math/rotation.h"

namespace lodestar::filter {

/// Probability that a chi-square variable of `dof` degrees of freedom exceeds `x`.
/// Exact: from one or two degrees up by Q_{k+2}(x) = Q_k(x) + (x/2)^{k/2} e^{-x/2} / Gamma(k/2 + 1)
/// (Abramowitz and Stegun, 26.4.4 and 26.4.5).
inline double chi_square_survival(double x, int dof) {
  const double half = 0.5 * x;
  const bool odd = dof % 2 != 0;
  double survival = odd ? std::erfc(std::sqrt(half)) : std::exp(-half);
  double term = odd ? 2.0 * std::sqrt(half / math::kPi) * std::exp(-half) : half * std::exp(-half);
  for (int k = odd ? 3 : 4; k <= dof; k += 2) {
    survival += term;
    term *= x / k;
  }
  return survival;
}

/// The value that a chi-square variable of `dof` degrees of freedom exceeds with probability
/// `exceeded`, in (0, 1): by bisection, right to 1e-12 of itself.
inline double chi_square_threshold(int dof, double exceeded) {
  double low = 0.0;
  double high = 1.0;
  while (chi_square_survival(high, dof) > exceeded) high *= 2.0;
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    (chi_square_survival(middle, dof) > exceeded ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Rejects an innovation that chance alone would make so large with probability
/// `false_rejection` only: nu' S^-1 nu against the chi-square threshold of its dimension.
class Gate {
 public:
  static constexpr int kMaxDimension = 6;

  explicit Gate(double false_rejection) {
    for (int dof = 1; dof <= kMaxDimension; ++dof) {
      thresholds_[static_cast<std::size_t>(dof - 1)] = chi_square_threshold(dof, false_rejection);
    }
  }

  double threshold(int dimension) const {
    return thresholds_[static_cast<std::size_t>(dimension - 1)];
  }

  /// `normalised_square` = nu' S^-1 nu of an innovation of `dimension` components. What is not a
  /// number does not pass.
  bool passes(double normalised_square, int dimension) const {
    return normalised_square <= threshold(dimension);
  }

 private:
  std::array<double, kMaxDimension> thresholds_{};
};

}  // namespace lodestar::filter
