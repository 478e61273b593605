// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "lodestar/filter/gate.h"
#include "lodestar/fusion/cascade_parameters.h"
#include "lodestar/fusion/dead_reckoning.h"
#include "lodestar/fusion/error_filter.h"
#include "lodestar/fusion/fix_motion.h"
#include "lodestar/fusion/fix_noise.h"
#include "lodestar/fusion/gust_meter.h"
#include "lodestar/fusion/innovation_watch.h"
#include "lodestar/fusion/reacquisition.h"
#include "lodestar/fusion/step_history.h"
#include "lodestar/fusion/track_history.h"
#include "lodestar/fusion/vertical_channel.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"

namespace lodestar::fusion {

/// SAHRS/GPS fusion with SAHRS as a black box (Linköping thesis chapters 3 and 4): dead reckoning
/// on SAHRS and air data at the frame rate, and a filter of its errors, of GPS's and of the wind.
///
/// Per frame: air data, then the attitude, then the fixes whose time has come. Nothing is published
/// as valid before the first fix (or a configured position), air data and a valid attitude.
class Cascade {
 public:
  explicit Cascade(const CascadeParameters& parameters);

  /// Holds until the next. Its time is at most the frame's that follows.
  samples::Use update(const samples::AirData& air);

  /// One frame.
  void propagate(const samples::Attitude& sahrs);

  /// A fix of the last second up to the last frame, compared with dead reckoning at its own time.
  /// kGated: beyond the gate, or standing still in flight. kHeld: under examination after an outage
  /// or a disagreement, or older than what is remembered.
  samples::Use update(const samples::GpsFix& fix);

  /// What another reference, now lost, said of the heading of SAHRS: at `time_us` it was wrong by
  /// `error` (rad, true - SAHRS) to `sigma` (rad). Taken in at the end of the current step, or at
  /// the start of the filter.
  void know_heading_error(double error, double sigma, std::int64_t time_us);

  const samples::Navigation& navigation() const { return navigation_; }

  /// Latest GPS position innovation and its sigma (m, north, east).
  const Eigen::Vector2d& innovation() const { return innovation_; }
  const Eigen::Vector2d& innovation_sigma() const { return innovation_sigma_; }

 private:
  // SAHRS's heading error as it was known once.
  struct HeadingReference {
    std::int64_t time_us = 0;
    double error = 0.0;  // rad
    double sigma = 0.0;  // rad
  };

  bool started() const { return !steps_.empty(); }
  bool fresh(std::int64_t time_us) const;
  StepConditions conditions() const;

  void note_initial_heading();
  KnownAngle heading_error_now() const;
  ErrorEstimate initial_estimate(double position_variance, double gps_covariance) const;
  void start_where_configured();
  void start_at_fix(const samples::GpsFix& fix, const TrackPoint& at);
  void start(double lat, double lon, const ErrorEstimate& estimate);

  void close_step();
  void anchor();
  Step step_at(const TrackPoint& at, int before) const;
  bool compare(const samples::GpsFix& fix, const Step& step);
  void watch_wind(const samples::GpsFix& fix, ErrorEstimate& estimate);
  void yield_to_fixes(ErrorEstimate& estimate, const TrackPoint& at) const;
  void correct(const samples::GpsFix& fix, Step& step, int before);
  void reset(const samples::GpsFix& fix, Step& step, int before, bool passes);
  void note_aided(const samples::GpsFix& fix, const TrackPoint& at);

  void refresh();
  void refresh_status();
  void refresh_sigma();
  samples::FusionMode mode() const;

  CascadeParameters parameters_;
  filter::Gate gate_;
  DeadReckoning dead_reckoning_;
  VerticalChannel vertical_;
  TrackHistory track_;
  StepHistory steps_;
  GustMeter gust_meter_;
  FixMotion fix_motion_;
  FixNoise fix_noise_;
  InnovationWatch wind_watch_;
  Reacquisition reacquisition_;
  samples::Attitude sahrs_;
  samples::AirData air_;
  bool air_seen_ = false;
  bool ever_aided_ = false;
  bool sahrs_restarted_ = false;
  std::int64_t aided_us_ = 0;  // time of the last fix that was used
  std::optional<HeadingReference> heading_reference_;
  bool heading_news_ = false;                           // the filter has yet to take it in
  Eigen::Vector2d anchored_ = Eigen::Vector2d::Zero();  // m, moved into dead reckoning so far
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();    // m, latest fix from dead reckoning
  double noise_ = 0.0;                                  // m^2, of the latest fix, per axis
  Eigen::Vector2d innovation_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d innovation_sigma_ = Eigen::Vector2d::Zero();
  samples::Navigation navigation_;
};

}  // namespace lodestar::fusion
