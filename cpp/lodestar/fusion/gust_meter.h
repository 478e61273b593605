// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace lodestar::fusion {

/// Level of turbulence, from the sideslip velocity: in coordinated flight it is all gust and noise.
/// Gusts are air moving, so airspeed less gust is what carries the aircraft over the ground; to the
/// filter they are noise on the velocity, of a size that differs a hundredfold between days.
///
/// Second differences of means over one second pass over slow errors and average sample noise. For
/// Gauss-Markov gusts of 1 to 5 s (Dryden's at 100 to 500 m/s) they have 0.35 to 0.98 of the gusts'
/// variance.
class GustMeter {
 public:
  /// `noise_density`: of the measured sideslip velocity, (m/s)^2 s.
  void add(double sideslip_velocity, double dt, double noise_density) {
    sum_ += sideslip_velocity * dt;
    span_ += dt;
    if (span_ < kSpan) return;
    const double mean = sum_ / span_;
    const double difference = mean - 2.0 * means_[0] + means_[1];
    const double noise = 6.0 * noise_density / span_;
    if (count_ < 2) {
      ++count_;
    } else {
      variance_ += (difference * difference - noise - variance_) * kSpan / kMemory;
    }
    means_ = {mean, means_[0]};
    sum_ = span_ = 0.0;
  }

  /// Of one component of the gusts, (m/s)^2.
  double variance() const { return std::max(0.0, variance_) / kSeen; }
  /// Spectral density at low frequency of the same, (m/s)^2 s.
  double density() const { return 2.0 * kTau * variance(); }

 private:
  static constexpr double kSpan = 1.0;     // s
  static constexpr double kMemory = 20.0;  // s
  static constexpr double kTau = 2.7;      // s, of gusts: Dryden's 533 m at 200 m/s
  static constexpr double kSeen = 0.71;    // second difference's variance over the gusts'

  double sum_ = 0.0;
  double span_ = 0.0;
  int count_ = 0;
  std::array<double, 2> means_{};
  double variance_ = 0.0;
};

}  // namespace lodestar::fusion
