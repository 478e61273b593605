// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "lodestar/navigator/frame_clock.h"
#include "lodestar/samples/health.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/validity.h"

namespace lodestar::navigator {

// Whether two samples carry the same measured values, bit for bit. A live sensor has noise.
inline bool same_values(const samples::BodyRates& a, const samples::BodyRates& b) {
  return a.omega_B == b.omega_B;
}
inline bool same_values(const samples::LoadFactor& a, const samples::LoadFactor& b) {
  return a.n_B == b.n_B;
}
inline bool same_values(const samples::MagneticField& a, const samples::MagneticField& b) {
  return a.b_B == b.b_B;
}
inline bool same_values(const samples::AirData& a, const samples::AirData& b) {
  return a.true_airspeed == b.true_airspeed && a.alpha == b.alpha && a.beta == b.beta &&
         a.baro_altitude == b.baro_altitude;
}
inline bool same_values(const samples::SpecificForce& a, const samples::SpecificForce& b) {
  return a.f_B == b.f_B;
}
inline bool same_values(const samples::GpsFix& a, const samples::GpsFix& b) {
  return a.lat == b.lat && a.lon == b.lon && a.h == b.h;
}
inline bool same_values(const samples::InsSolution& a, const samples::InsSolution& b) {
  return a.roll == b.roll && a.pitch == b.pitch && a.heading == b.heading;
}
// Ranges and heights on event: two equal ones in a row are no sign of a fault.
inline bool same_values(const samples::GpsObservables&, const samples::GpsObservables&) {
  return false;
}
inline bool same_values(const samples::SarMeasurement&, const samples::SarMeasurement&) {
  return false;
}
inline bool same_values(const samples::RadarAltitude&, const samples::RadarAltitude&) {
  return false;
}

/// Watches one input channel: content, order in time, freezing, silence.
template <class Sample>
class SensorWatch {
 public:
  /// `timeout` (s): silence after which the sensor is stale.
  explicit SensorWatch(double timeout)
      : timeout_us_(static_cast<std::int64_t>(timeout * static_cast<double>(kSecond))) {}

  /// The first reason to refuse `sample`, or nothing; remembers it if it is accepted.
  std::optional<samples::Reason> judge(const Sample& sample) {
    if (const auto reason = samples::refusal(sample)) return reason;
    if (seen_ && sample.time_us <= last_.time_us) return samples::Reason::kTimeBackwards;
    if (seen_ && same_values(sample, last_)) {
      ++repeats_;
    } else {
      repeats_ = 0;
      changed_us_ = sample.time_us;
    }
    last_ = sample;
    seen_ = true;
    if (stuck()) return samples::Reason::kStuck;
    return std::nullopt;
  }

  /// The latest time stamps turned out to be wrong: order counts from `time_us` again.
  void rewind(std::int64_t time_us) { last_.time_us = time_us; }

  /// A new time base: order in time starts again.
  void restart() { seen_ = false; }

  samples::SensorState state(std::int64_t now_us) const {
    if (!seen_) return samples::SensorState::kNeverSeen;
    if (now_us - last_.time_us > timeout_us_) return samples::SensorState::kStale;
    return stuck() ? samples::SensorState::kStuck : samples::SensorState::kGood;
  }

 private:
  // Three samples at least: at 1 Hz two equal fixes are already a second apart.
  bool stuck() const { return repeats_ >= 2 && last_.time_us - changed_us_ >= kSecond; }

  std::int64_t timeout_us_;
  Sample last_;
  bool seen_ = false;
  int repeats_ = 0;
  std::int64_t changed_us_ = 0;
};

}  // namespace lodestar::navigator
