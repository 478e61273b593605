// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

#include "lodestar/math/scalar.h"

// What GPS fixes say of each other, without a filter. As seen from dead reckoning, fixes of one
// second or so lie on a line: wind and heading error hardly change meanwhile.

namespace lodestar::fusion {

/// The line through the last two fixes, and where the next should lie on it.
class FixLine {
 public:
  static constexpr double kLongestPause = 3.0;  // s, between two fixes of a line

  struct Residual {
    Eigen::Vector2d value;  // m, off the line
    double noise_gain;      // its variance over that of one fix
  };

  int size() const { return size_; }
  void restart() { size_ = 0; }
  std::int64_t time_us() const { return time_us_; }

  /// Whether a fix at `time_us` continues the line.
  bool continues(std::int64_t time_us) const {
    const double dt = seconds_since(time_us);
    return size_ > 0 && dt > 0.0 && dt <= kLongestPause;
  }

  /// Of a fix at `offset` (m, north, east) from dead reckoning; only if size() > 1 and it
  /// continues.
  Residual residual(std::int64_t time_us, const Eigen::Vector2d& offset) const {
    const double s = seconds_since(time_us) / spacing_;
    return {offset - offset_ - s * (offset_ - offset_before_), 1.0 + (1.0 + s) * (1.0 + s) + s * s};
  }

  void push(std::int64_t time_us, const Eigen::Vector2d& offset) {
    size_ = continues(time_us) ? std::min(size_ + 1, 2) : 1;
    spacing_ = seconds_since(time_us);
    time_us_ = time_us;
    offset_before_ = offset_;
    offset_ = offset;
  }

 private:
  double seconds_since(std::int64_t time_us) const { return math::seconds(time_us - time_us_); }

  int size_ = 0;
  double spacing_ = 0.0;  // s
  std::int64_t time_us_ = 0;
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d offset_before_ = Eigen::Vector2d::Zero();
};

}  // namespace lodestar::fusion
