// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <tuple>

#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/fusion/fusion.h"
#include "lodestar/monitor/ins_monitor.h"
#include "lodestar/navigator/config.h"
#include "lodestar/navigator/frame_clock.h"
#include "lodestar/navigator/pending.h"
#include "lodestar/navigator/sensor_watch.h"
#include "lodestar/sahrs/sahrs.h"
#include "lodestar/sahrs/smdu_calibration_filter.h"
#include "lodestar/samples/health.h"
#include "lodestar/samples/samples.h"

namespace lodestar::navigator {

/// What one frame answers. SAHRS and NAV always, the rest when it is due.
struct Outputs {
  samples::Attitude sahrs;
  samples::Navigation nav;
  samples::InsMonitor ins_monitor;
  bool ins_monitor_due = false;  // ten times a second, and at once on a change of state
  samples::SmduCalibration smdu_calibration;  // refreshed when HEALTH is due
  bool health_due = false;  // once per second of flight time, and on the first frame
};

/// What a flight has made of the calibration of the magnetic detector.
struct CalibrationResult {
  sahrs::smdu::Verdict verdict;
  sahrs::smdu::Checks checks;
  sahrs::smdu::Record record;  // worth storing if the verdict is good
};

/// The flight computer without its shell: timed samples in, timed outputs out.
///
/// It does no I/O, reads no clock, starts no thread and, after construction, allocates and throws
/// nothing. The same samples in the same order give the same outputs, bit for bit.
///
/// EFCS.RATES makes the frames. Any other sample waits for the first frame at or after its time of
/// validity and is then applied in order of time; what is older than 1 s, or still more than 50 ms
/// ahead of the frame, is dropped and counted. Every sample that is not used is counted by channel
/// and reason.
class Navigator {
 public:
  explicit Navigator(const Config& config);

  void offer(const samples::LoadFactor& sample);
  void offer(const samples::MagneticField& sample);
  void offer(const samples::AirData& sample);
  void offer(const samples::GpsFix& sample);
  void offer(const samples::InsSolution& sample);
  // Channels of estimators that this build does not have: checked and counted, then forgotten.
  void offer(const samples::SpecificForce& sample);
  void offer(const samples::GpsObservables& sample);
  void offer(const samples::SarMeasurement& sample);
  void offer(const samples::RadarAltitude& sample);

  /// One frame; valid until the next call. Null if the time of `rates` makes no frame. Rates whose
  /// values are refused make a frame that coasts.
  const Outputs* step(const samples::BodyRates& rates);

  /// A message that never became a sample.
  void count_rejection(samples::Channel channel, samples::Reason reason);

  /// State of the whole at the last frame. The shell adds cycle times, dropped log lines and
  /// version.
  samples::Health health() const;

  /// The calibration of this flight, to be used from the next one on.
  CalibrationResult calibration_result() const;

 private:
  // A load factor at 1000 Hz between two frames at 30 Hz, with as much again for jitter.
  static constexpr std::size_t kDeep = 72;
  static constexpr std::size_t kShallow = 16;

  template <class Sample, std::size_t Capacity>
  struct Input {
    Input(samples::Channel which, double timeout) : channel(which), watch(timeout) {}
    samples::Channel channel;
    SensorWatch<Sample> watch;
    Pending<Sample, Capacity> pending;
    std::int64_t applied_us = kNever;  // time of the last one out
  };

  template <class Sample>
  bool accept(SensorWatch<Sample>& watch, samples::Channel channel, const Sample& sample);
  template <class Sample, std::size_t Capacity>
  void hold(Input<Sample, Capacity>& input, const Sample& sample);

  void start(std::int64_t time_us);
  void start_over();
  void estimate(const samples::BodyRates& rates);
  void coast(std::int64_t time_us);
  template <class... Inputs>
  void apply_in_order(Inputs&... inputs);
  template <class AnyInput>
  void apply_front(AnyInput& input);
  samples::Use apply(const samples::LoadFactor& sample);
  samples::Use apply(const samples::MagneticField& sample);
  samples::Use apply(const samples::AirData& sample);
  samples::Use apply(const samples::GpsFix& sample) { return fusion_.update(sample); }
  samples::Use apply(const samples::InsSolution& sample);
  template <class AnyInput>
  void drop_future(AnyInput& input);
  void publish(std::int64_t time_us, bool first);

  Config config_;
  earth::GeomagneticModel field_model_;  // for its validity
  FrameClock clock_;
  sahrs::Sahrs sahrs_;
  fusion::Fusion fusion_;
  sahrs::smdu::CalibrationFilter calibration_;
  monitor::InsMonitor ins_monitor_;
  samples::Counters counters_{};
  Outputs outputs_;
  std::int64_t rates_us_ = 0;         // time of the last body rates that could be used
  std::int64_t next_health_us_ = 0;   // flight time at which HEALTH is due
  std::int64_t next_monitor_us_ = 0;  // ... and INS.MONITOR
  std::int16_t restarts_ = 0;         // attitude resets before the last start over

  SensorWatch<samples::BodyRates> body_rates_;
  std::tuple<Input<samples::LoadFactor, kDeep>, Input<samples::MagneticField, kShallow>,
             Input<samples::AirData, kShallow>, Input<samples::GpsFix, kShallow>,
             Input<samples::InsSolution, kShallow>>
      inputs_;
  SensorWatch<samples::SpecificForce> specific_force_;
  SensorWatch<samples::GpsObservables> gps_observables_;
  SensorWatch<samples::SarMeasurement> sar_;
  SensorWatch<samples::RadarAltitude> radar_altitude_;
};

}  // namespace lodestar::navigator
