// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"
#include "lodestar/math/scalar.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"
#include "lodestar/strapdown/air_data_aid.h"

namespace lodestar::fusion {

using math::seconds;
using strapdown::air_velocity_B;

/// One instant of dead reckoning: what SAHRS and the air data say, and where that leads.
struct TrackPoint {
  std::int64_t time_us = 0;
  double lat = 0.0;                                   // rad
  double lon = 0.0;                                   // rad, not wrapped
  double h = 0.0;                                     // m, from baro altitude
  Eigen::Vector2d rates = Eigen::Vector2d::Zero();    // rad/s, of lat and lon
  math::Euler attitude;                               // SAHRS
  Eigen::Vector3d v_air_B = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d v_air_N = Eigen::Vector3d::Zero();  // m/s, C_NB v_air_B

  earth::Geodetic position() const { return {lat, lon, h}; }
};

/// Position from SAHRS attitude and air data, in still air: v_N = C_NB v_air_B, integrated over the
/// WGS84 radii by the trapezoidal rule (the exact form of Linköping thesis eq. 5.1-5.2). Not within
/// 11 km of the poles, where there is no north to fly by: the track stops there.
class DeadReckoning {
 public:
  /// Air data hold until the next come.
  void set_air_velocity(const Eigen::Vector3d& v_air_B) { v_air_B_ = v_air_B; }

  void set_position(double lat, double lon) {
    point_.lat = within_limit(lat);
    point_.lon = lon;
    point_.rates = earth::position_rates(point_.lat, point_.h, point_.v_air_N).head<2>();
  }

  void set_height(double h) { point_.h = h; }

  /// Moves on to the time of `sahrs`; the first call only takes its time.
  const TrackPoint& advance(const samples::Attitude& sahrs) {
    const double dt = started_ ? seconds(sahrs.time_us - point_.time_us) : 0.0;
    const Eigen::Vector2d before = point_.rates;
    point_.time_us = sahrs.time_us;
    point_.attitude = {sahrs.roll, sahrs.pitch, sahrs.heading};
    point_.v_air_B = v_air_B_;
    point_.v_air_N = sahrs.q_NB * v_air_B_;
    const double lat_ahead = within_limit(point_.lat + before.x() * dt);
    point_.rates = earth::position_rates(lat_ahead, point_.h, point_.v_air_N).head<2>();
    point_.lat = within_limit(point_.lat + 0.5 * (before.x() + point_.rates.x()) * dt);
    point_.lon += 0.5 * (before.y() + point_.rates.y()) * dt;
    started_ = true;
    return point_;
  }

  bool started() const { return started_; }
  const TrackPoint& point() const { return point_; }

 private:
  static constexpr double kLargestLatitude = 89.9 * math::kDegree;

  static double within_limit(double lat) {
    return std::clamp(lat, -kLargestLatitude, kLargestLatitude);
  }

  TrackPoint point_;
  Eigen::Vector3d v_air_B_ = Eigen::Vector3d::Zero();
  bool started_ = false;
};

}  // namespace lodestar::fusion
