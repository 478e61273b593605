// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/earth/wgs84.h"
#include "lodestar/fusion/dead_reckoning.h"
#include "lodestar/samples/samples.h"

namespace lodestar::fusion {

/// Notices fixes that stay where they are while the aircraft flies: a receiver that repeats itself,
/// or one that is told to be at a fixed place. Seen from dead reckoning those lie on a line as good
/// as any, so that agreement among themselves does not tell them from true ones.
class FixMotion {
 public:
  /// Takes the next fix, with the velocity relative to the air (m/s, north, east) at its time. True
  /// if it repeats the place of the one before bit for bit, or if the fixes of the last seconds
  /// have hardly moved on a way through the air that no wind can undo.
  bool stands_still(const samples::GpsFix& fix, const Eigen::Vector2d& v_air) {
    const bool repeated = seen_ && fix.lat == last_.lat && fix.lon == last_.lon;
    const double span = seconds(fix.time_us - from_.time_us);
    flown_ += (0.5 * seconds(fix.time_us - last_.time_us)) * (v_air + v_air_);
    if (!seen_ || span > kLongestSpan || span < 0.0) {
      still_ = false;
      restart(fix);
    } else if (span >= kSpan) {
      const earth::Geodetic from{from_.lat, from_.lon, from_.h};
      const earth::Geodetic to{fix.lat, fix.lon, from_.h};
      const double moved = earth::displacement_N(from, to).head<2>().norm();
      still_ = flown_.norm() > kLargestWind * span && moved < kFraction * flown_.norm();
      restart(fix);
    }
    last_ = fix;
    v_air_ = v_air;
    seen_ = true;
    return repeated || still_;
  }

 private:
  static constexpr double kSpan = 2.0;          // s, over which motion is measured
  static constexpr double kLongestSpan = 10.0;  // s
  static constexpr double kLargestWind = 60.0;  // m/s
  static constexpr double kFraction = 0.1;      // of the way through the air

  void restart(const samples::GpsFix& fix) {
    from_ = fix;
    flown_.setZero();
  }

  bool seen_ = false;
  bool still_ = false;
  samples::GpsFix last_;
  samples::GpsFix from_;
  Eigen::Vector2d v_air_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d flown_ = Eigen::Vector2d::Zero();  // m, since from_
};

}  // namespace lodestar::fusion
