// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "lodestar/filter/gate.h"
#include "lodestar/fusion/fix_motion.h"
#include "lodestar/fusion/fix_noise.h"
#include "lodestar/fusion/heading_record.h"
#include "lodestar/fusion/innovation_watch.h"
#include "lodestar/fusion/integrated_parameters.h"
#include "lodestar/fusion/reacquisition.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"
#include "lodestar/strapdown/guarded_filter.h"

namespace lodestar::fusion {

/// One filter for attitude, wind and position: the strapdown family with GPS inside. The wind stays
/// while the air velocity turns, so that every turn tells heading from wind.
///
/// Per frame: body rates, then the samples in the order of their time, then the attitude of SAHRS,
/// from which it starts and starts again, then the fixes whose time has come.
class Integrated {
 public:
  using Filter = strapdown::GroundFilter;

  Integrated(const IntegratedParameters& parameters, const strapdown::Parameters& filter_parameters,
             const strapdown::GuardLimits& limits, earth::GeomagneticKind field_model,
             double epoch_year);

  /// Where the aircraft is, roughly: see GuardedFilter.
  void set_position(double lat, double lon, double h) { guard_.set_position(lat, lon, h); }

  /// Before the start: there are no gusts, as far as is known.
  void presume_calm_air() { filter().presume_calm_air(); }
  /// Goes on in place of another whose output was `shown`, and counts that as a reset.
  void replace(const samples::Navigation& shown);

  void propagate(const samples::BodyRates& rates);
  samples::Use update(const samples::LoadFactor& sample) { return guard_.update(sample); }
  samples::Use update(const samples::MagneticField& sample);  // calibrated
  samples::Use update(const samples::AirData& sample);

  /// Ends the frame. Starts from the attitude of SAHRS where there is none of its own.
  void follow(const samples::Attitude& sahrs);

  /// A frame without rates: the output moves on as it went.
  void coast(std::int64_t time_us);

  /// A fix of the last second up to the last frame, compared at its own time. kGated: beyond the
  /// gate. kHeld: under examination after an outage or a disagreement, or older than what is
  /// remembered.
  samples::Use update(const samples::GpsFix& fix);

  /// What another reference, now lost, said of the heading of SAHRS: it is wrong by `error` (rad,
  /// true - SAHRS) to `sigma` (rad), at `time_us`.
  void know_heading_error(double error, double sigma, std::int64_t time_us);

  const samples::Navigation& navigation() const { return navigation_; }

  /// Latest GPS position innovation and its sigma (m, north, east).
  const Eigen::Vector2d& innovation() const { return innovation_; }
  const Eigen::Vector2d& innovation_sigma() const { return innovation_sigma_; }

  const Filter& filter() const { return guard_.filter(); }

 private:
  using PositionUpdate = strapdown::SparseUpdate<strapdown::kGroundStates, strapdown::GpsPosition>;

  Filter& filter() { return guard_.filter(); }
  bool started() const { return positioned_ && guard_.running() && filter().has_velocity(); }
  void begin(const samples::Attitude& sahrs);
  void start_at(double lat, double lon, double sigma);
  void start_without_air(const samples::GpsFix& fix);
  PositionUpdate compare(const samples::GpsFix& fix, const strapdown::GroundPoint& at);
  /// Of the latest fix from the track as it would be without any correction (m, north, east): what
  /// corrections do to the position says nothing of the fixes.
  Eigen::Vector2d offset() const { return innovation_ + filter().position_corrections(); }
  bool passes(PositionUpdate& update, bool has_height);
  bool doubts(const samples::GpsFix& fix);
  void reset(const samples::GpsFix& fix, const strapdown::GroundPoint& at, bool passed);
  void yield_to_fixes();
  void correct(const samples::GpsFix& fix, const PositionUpdate& update);
  void take_velocity(const samples::GpsFix& fix);
  bool fresh(std::int64_t time_us) const;
  void refresh_status();
  void refresh();
  void refresh_sigma();
  samples::FusionMode mode() const;

  IntegratedParameters parameters_;
  filter::Gate gate_;
  FixMotion fix_motion_;
  FixNoise fix_noise_;
  InnovationWatch watch_;
  Reacquisition reacquisition_;
  strapdown::GuardedFilter<strapdown::kGroundStates> guard_;

  std::int64_t now_us_ = 0;
  std::int64_t flown_us_ = 0;  // the last frame with an attitude
  std::int64_t sigma_us_ = 0;
  HeadingRecord headings_;
  std::int64_t air_us_ = 0;              // the last air data, or the last start
  std::optional<samples::GpsFix> last_;  // fix, while there is no velocity
  bool begun_ = false;                   // once at least
  bool positioned_ = false;              // a position is known
  bool ever_aided_ = false;
  bool doubted_ = false;  // fixes come from one side: they are under examination
  std::int64_t aided_us_ = 0;
  double noise_ = 1.0;  // m^2, of the latest fix
  Eigen::Vector2d innovation_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d innovation_sigma_ = Eigen::Vector2d::Zero();
  samples::Navigation navigation_;
};

}  // namespace lodestar::fusion
