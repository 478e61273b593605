// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace lodestar::sahrs {

/// Value and rate of a noisy signal: a second-order filter of bandwidth `bandwidth` (rad/s) and
/// damping 0.7. Where the increment of the rate is known from elsewhere (vertical acceleration, for
/// the rate of climb) the filter is complementary: the rate then has no lag, and the signal serves
/// only to hold the integral.
///
/// A sensor that lags by a first-order `lag` (s) is compared with the estimate lagged likewise, so
/// that the rate is that of now.
class RateFilter {
 public:
  explicit RateFilter(double bandwidth, double lag = 0.0) : bandwidth_(bandwidth), lag_(lag) {}

  /// A sample `value`, `dt` (s) after the last one, while the rate grew by `rate_increment`.
  void update(double value, double dt, double rate_increment = 0.0) {
    value_ += (rate_ + 0.5 * rate_increment) * dt;
    rate_ += rate_increment;
    // Exact for the lag's answer to a ramp of this step's rate.
    lagged_ = value_ - lag_ * rate_ + (lagged_ - value_ + rate_ * (dt + lag_)) * decay(dt);
    const double residual = value - lagged_;
    value_ += 2.0 * kDamping * bandwidth_ * dt * residual;
    rate_ += bandwidth_ * bandwidth_ * dt * residual;
    age_ += dt;
  }

  void restart(double value) {
    value_ = value;
    lagged_ = value;
    rate_ = 0.0;
    age_ = 0.0;
  }

  double value() const { return value_; }
  double rate() const { return rate_; }
  /// What is left of the start has decayed to a few percent.
  bool settled() const { return age_ * bandwidth_ > 4.0; }

 private:
  static constexpr double kDamping = 0.7;

  double decay(double dt) const { return lag_ > 0.0 ? std::exp(-dt / lag_) : 0.0; }

  double bandwidth_;
  double lag_;
  double value_ = 0.0;
  double lagged_ = 0.0;
  double rate_ = 0.0;
  double age_ = 0.0;
};

}  // namespace lodestar::sahrs
