// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

namespace lodestar::sahrs {

/// Value and rate of a noisy signal: a second-order filter of bandwidth `bandwidth` (rad/s) and
/// damping 0.7. Where the increment of the rate is known from elsewhere (vertical acceleration, for
/// the rate of climb) the filter is complementary: the rate then has no lag, and the signal serves
/// only to hold the integral.
///
/// A sensor that lags by a first-order `lag` (s) is compared with the estimate lagged likewise, so
/// that the rate is that of now. Stable for every lag, and for steps up to 1 / bandwidth.
class RateFilter {
 public:
  /// `max_residual`: once settled, a sample further off is an outlier and left out; if that goes on
  /// for 1 s, the filter starts anew.
  explicit RateFilter(double bandwidth, double lag = 0.0,
                      double max_residual = std::numeric_limits<double>::infinity())
      : bandwidth_(bandwidth), lag_(lag), max_residual_(max_residual) {}

  void restart(double value) {
    value_ = value;
    lagged_ = value;
    rate_ = 0.0;
    age_ = 0.0;
    outlying_ = 0.0;
  }

  /// A sample `value`, `dt` (s) after the last one, while the rate grew by `rate_increment`.
  void update(double value, double dt, double rate_increment = 0.0) {
    predict(dt, rate_increment);
    age_ += dt;
    const double residual = value - lagged_;
    if (settled() && !(std::abs(residual) <= max_residual_)) {
      outlying_ += dt;
      if (outlying_ > kPatience) restart(value);
      return;
    }
    outlying_ = 0.0;
    const double step = 2.0 * kDamping * bandwidth_ * dt * residual;
    value_ += step;
    lagged_ += step;
    rate_ += bandwidth_ * bandwidth_ * dt * residual;
  }

  double value() const { return value_; }
  double rate() const { return rate_; }
  /// What is left of the start has decayed to a few percent.
  bool settled() const { return age_ * bandwidth_ > 4.0; }

 private:
  static constexpr double kDamping = 0.7;
  static constexpr double kPatience = 1.0;  // s

  void predict(double dt, double rate_increment) {
    value_ += (rate_ + 0.5 * rate_increment) * dt;
    rate_ += rate_increment;
    // Exact for the lag's answer to a ramp of this step's rate.
    const double decay = lag_ > 0.0 ? std::exp(-dt / lag_) : 0.0;
    lagged_ = value_ - lag_ * rate_ + (lagged_ - value_ + rate_ * (dt + lag_)) * decay;
  }

  double bandwidth_;
  double lag_;
  double max_residual_;
  double value_ = 0.0;
  double lagged_ = 0.0;
  double rate_ = 0.0;
  double age_ = 0.0;       // s since the start
  double outlying_ = 0.0;  // s since the last sample that was not left out
};

}  // namespace lodestar::sahrs
