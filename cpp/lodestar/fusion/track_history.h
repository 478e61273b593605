// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "lodestar/fusion/dead_reckoning.h"
#include "lodestar/math/scalar.h"

namespace lodestar::fusion {

/// The last second of dead reckoning, at up to 1000 Hz, so that a late fix can be compared with
/// where dead reckoning was at the fix's own time.
class TrackHistory {
 public:
  static constexpr std::size_t kCapacity = 1024;

  void clear() { count_ = 0; }

  void push(const TrackPoint& point) {
    newest_ = (newest_ + 1) % kCapacity;
    points_[newest_] = point;
    if (count_ < kCapacity) ++count_;
  }

  /// The track at `time_us`, between its neighbours: position to third order (Hermite), the rest to
  /// first. Nothing if that is newer than the newest or older than the oldest point.
  std::optional<TrackPoint> at(std::int64_t time_us) const {
    if (count_ == 0 || time_us > back(0).time_us) return std::nullopt;
    std::size_t age = 0;
    while (age < count_ && back(age).time_us > time_us) ++age;
    if (age == count_) return std::nullopt;
    const TrackPoint& before = back(age);
    if (before.time_us == time_us) return before;
    return between(before, back(age - 1), time_us);
  }

  /// Moves the whole track by (d_lat, d_lon), rad.
  void shift(double d_lat, double d_lon) {
    for (std::size_t age = 0; age < count_; ++age) {
      TrackPoint& point = points_[(newest_ + kCapacity - age) % kCapacity];
      point.lat += d_lat;
      point.lon += d_lon;
    }
  }

 private:
  const TrackPoint& back(std::size_t age) const {
    return points_[(newest_ + kCapacity - age) % kCapacity];
  }

  static TrackPoint between(const TrackPoint& a, const TrackPoint& b, std::int64_t time_us) {
    const double dt = math::seconds(b.time_us - a.time_us);
    const double s = math::seconds(time_us - a.time_us) / dt;
    const auto cubic = [s, dt](double p0, double p1, double rate0, double rate1) {
      const double ends = p0 + s * s * (3.0 - 2.0 * s) * (p1 - p0);
      return ends + s * (1.0 - s) * dt * ((1.0 - s) * rate0 - s * rate1);
    };
    const auto turned = [s](double from, double to) { return from + s * math::wrap_pi(to - from); };
    TrackPoint point;
    point.time_us = time_us;
    point.lat = cubic(a.lat, b.lat, a.rates.x(), b.rates.x());
    point.lon = cubic(a.lon, b.lon, a.rates.y(), b.rates.y());
    point.h = a.h + s * (b.h - a.h);
    point.rates = a.rates + s * (b.rates - a.rates);
    point.attitude = {turned(a.attitude.roll, b.attitude.roll),
                      turned(a.attitude.pitch, b.attitude.pitch),
                      turned(a.attitude.heading, b.attitude.heading)};
    point.v_air_B = a.v_air_B + s * (b.v_air_B - a.v_air_B);
    point.v_air_N = a.v_air_N + s * (b.v_air_N - a.v_air_N);
    return point;
  }

  std::array<TrackPoint, kCapacity> points_{};
  std::size_t newest_ = kCapacity - 1;
  std::size_t count_ = 0;
};

}  // namespace lodestar::fusion
