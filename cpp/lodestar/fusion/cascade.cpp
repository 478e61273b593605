// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/cascade.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lodestar/earth/wgs84.h"
#include "lodestar/fusion/uncertainty.h"

namespace lodestar::fusion {
namespace {

using samples::FusionMode;
using samples::Use;

// Beyond this the position error is handed over to dead reckoning: F is linear in it.
constexpr double kLongestError = 200.0;  // m
// A reset beyond this starts the filter anew: what it knew of wind and heading is as doubtful.
constexpr double kFarthest = 20e3;      // m
constexpr double kWindMemory = 3.0;     // s, of the mean of the innovations that is watched
constexpr double kWindResponse = 1.0;   // s, from a change of wind to its innovation
constexpr double kLargestScale = 20.0;  // of sigma, when fixes contradict the filter

}  // namespace

Cascade::Cascade(const CascadeParameters& parameters)
    : parameters_(parameters),
      gate_(parameters.gps_false_rejection),
      vertical_(parameters),
      fix_noise_(parameters.gps_noise),
      wind_watch_(filter::chi_square_threshold(2, parameters.wind_change_false_alarm), kWindMemory),
      reacquisition_(parameters.reacquisition_time) {}

Use Cascade::update(const samples::AirData& air) {
  const Eigen::Vector3d v_air_B = air_velocity_B(air);
  dead_reckoning_.set_air_velocity(v_air_B);
  if (air_seen_) {
    const double noise = air.true_airspeed * parameters_.beta_noise;
    gust_meter_.add(v_air_B.y(), seconds(air.time_us - air_.time_us),
                    noise * noise / parameters_.air_data_rate);
  }
  air_ = air;
  air_seen_ = true;
  if (!vertical_.started() || dead_reckoning_.started()) {
    const double age = seconds(dead_reckoning_.point().time_us - air.time_us);
    vertical_.update_baro(air.baro_altitude, age);
  }
  return Use::kUsed;
}

void Cascade::propagate(const samples::Attitude& sahrs) {
  navigation_.time_us = sahrs.time_us;
  if (!sahrs.valid || !air_seen_) {
    refresh_status();
    navigation_.valid = false;
    return;
  }
  const TrackPoint before = dead_reckoning_.point();
  const bool first = !dead_reckoning_.started();
  if (!first && sahrs.time_us <= before.time_us) return;
  if (!first && sahrs.reset_count != sahrs_.reset_count) {
    sahrs_restarted_ = true;
    heading_reference_.reset();
  }
  sahrs_ = sahrs;

  const TrackPoint& now = dead_reckoning_.advance(sahrs);
  if (!first) {
    const double dt = seconds(now.time_us - before.time_us);
    vertical_.propagate(dt, 0.5 * (before.v_air_N.z() + now.v_air_N.z()));
  }
  dead_reckoning_.set_height(vertical_.baro_height());
  track_.push(now);
  if (first) {
    note_initial_heading();
    start_where_configured();
  } else if (started()) {
    const double elapsed = seconds(now.time_us - steps_.back().point.time_us);
    if (sahrs_restarted_ || elapsed >= parameters_.step) close_step();
  }
  refresh();
}

Use Cascade::update(const samples::GpsFix& fix) {
  const std::optional<TrackPoint> at = track_.at(fix.time_us);
  if (!at) return Use::kHeld;
  if (fix_motion_.stands_still(fix, at->v_air_N.head<2>())) return Use::kGated;
  if (!started()) {
    start_at_fix(fix, *at);
    return Use::kUsed;
  }
  if (steps_.back().point.time_us < dead_reckoning_.point().time_us) close_step();
  const int before = steps_.last_until(fix.time_us);
  if (before < 0) return Use::kHeld;

  Step step = step_at(*at, before);
  const bool passes = compare(fix, step);
  const bool at_once = passes && (!ever_aided_ || fresh(fix.time_us));
  if (!at_once && !reacquisition_.examine(fix.time_us, innovation_, std::sqrt(noise_))) {
    refresh();
    return passes ? Use::kHeld : Use::kGated;
  }
  if (at_once) {
    watch_wind(fix, step.estimate);
    reacquisition_.cancel();
    correct(fix, step, before);
  } else {
    reset(fix, step, before, passes);
  }
  return Use::kUsed;
}

/// The filter at the time of `at`, in the step after `before`.
Step Cascade::step_at(const TrackPoint& at, int before) const {
  const Step& last = steps_[before];
  Step step{at, steps_[std::min(before + 1, steps_.size() - 1)].conditions, last.estimate};
  step.conditions.sahrs_restarted = false;  // that comes at the end of the step, if it does
  step.conditions.heading_error.reset();    // and so does that
  step.estimate.propagate(parameters_, step.conditions, last.point, at);
  return step;
}

/// Sets the innovation and the noise of the fix; true if it passes the gate.
bool Cascade::compare(const samples::GpsFix& fix, const Step& step) {
  const PositionMatrix H = position_measurement();
  const earth::Geodetic fix_position{fix.lat, fix.lon, step.point.h};
  offset_ = earth::displacement_N(step.point.position(), fix_position).head<2>();
  noise_ = fix_noise_.variance(fix.sigma_horizontal);
  innovation_ = offset_ - H * step.estimate.x;
  const Eigen::Matrix2d S = step.estimate.P.projected(H) + noise_ * Eigen::Matrix2d::Identity();
  innovation_sigma_ = S.diagonal().cwiseSqrt();
  return gate_.passes(innovation_.dot(S.inverse() * innovation_), 2);
}

/// Innovations that all point one way are a wind that has changed: it is made as unknown as they
/// are long.
void Cascade::watch_wind(const samples::GpsFix& fix, ErrorEstimate& estimate) {
  const double dt = ever_aided_ ? seconds(fix.time_us - aided_us_) : 0.0;
  const Eigen::Vector2d normalised = innovation_.cwiseQuotient(innovation_sigma_);
  if (!wind_watch_.alarms(normalised, dt)) return;
  estimate.doubt_wind(innovation_.norm() / kWindResponse);
}

/// Takes in a fix that examination has found to be believed, and says by how much that moves the
/// position.
void Cascade::reset(const samples::GpsFix& fix, Step& step, int before, bool passes) {
  const Eigen::Vector2d innovation = innovation_;
  const Eigen::Vector2d error_before = steps_.back().estimate.position_error();
  const Eigen::Vector2d anchored_before = anchored_;
  if (innovation.norm() > kFarthest) {
    start_at_fix(fix, step.point);
    navigation_.reset_delta = innovation;
  } else {
    if (!passes) yield_to_fixes(step.estimate, step.point);
    correct(fix, step, before);
    navigation_.reset_delta =
        steps_.back().estimate.position_error() - error_before + anchored_ - anchored_before;
  }
  ++navigation_.reset_count;
  reacquisition_.cancel();
  wind_watch_.restart();
}

/// Fixes that agree among themselves contradict the filter: it is told to doubt itself as much as
/// they say, in position by their distance, in wind and angles by the speed at which they leave.
void Cascade::yield_to_fixes(ErrorEstimate& estimate, const TrackPoint& at) const {
  const PositionMatrix J = velocity_by_states(parameters_.attitude_error, at, estimate.x);
  const double known = std::sqrt(estimate.P.projected(J).trace());
  const double scale = reacquisition_.drift().norm() / known;
  estimate.loosen(innovation_.cwiseAbs(), std::clamp(scale, 1.0, kLargestScale));
}

/// Takes the fix in at its own time and does the later steps again.
void Cascade::correct(const samples::GpsFix& fix, Step& step, int before) {
  step.estimate.x += step.estimate.P.update(position_measurement(), noise_, innovation_);
  for (int i = steps_.insert(before + 1, step) + 1; i < steps_.size(); ++i) {
    steps_[i].estimate = steps_[i - 1].estimate;
    steps_[i].estimate.propagate(parameters_, steps_[i].conditions, steps_[i - 1].point,
                                 steps_[i].point);
  }
  fix_noise_.add(fix.time_us, offset_ + anchored_, fix.sigma_horizontal);
  note_aided(fix, step.point);
  anchor();
  refresh_sigma();
  refresh();
}

void Cascade::note_aided(const samples::GpsFix& fix, const TrackPoint& at) {
  ever_aided_ = true;
  aided_us_ = fix.time_us;
  if (fix.fix_type != 2) vertical_.update_gps(fix.h - at.h, fix.sigma_vertical);
}

bool Cascade::fresh(std::int64_t time_us) const {
  return ever_aided_ && seconds(time_us - aided_us_) <= parameters_.gps_timeout;
}

StepConditions Cascade::conditions() const {
  const double silence = seconds(sahrs_.time_us - air_.time_us);
  const double turn_rate = std::abs((sahrs_.q_NB * sahrs_.omega_B).z());
  return {angle_variance(parameters_, sahrs_),    gust_meter_.density(), turn_rate,
          silence > parameters_.air_data_timeout, sahrs_restarted_,      std::nullopt};
}

void Cascade::close_step() {
  const Step& last = steps_.back();
  Step step{dead_reckoning_.point(), conditions(), last.estimate};
  if (heading_news_ && heading_reference_) step.conditions.heading_error = heading_error_now();
  heading_news_ = false;
  step.estimate.propagate(parameters_, step.conditions, last.point, step.point);
  steps_.push(step);
  sahrs_restarted_ = false;
  anchor();
  refresh_sigma();
}

/// Hands a long position error over to dead reckoning, with all that is remembered of it: only the
/// split between the two changes. Right to 1 cm over the second that is remembered.
void Cascade::anchor() {
  const Eigen::Vector2d error = steps_.back().estimate.position_error();
  if (error.norm() < kLongestError) return;
  const TrackPoint from = dead_reckoning_.point();
  const earth::Geodetic to = earth::displaced(from.position(), {error.x(), error.y(), 0.0});
  const double d_lat = to.lat - from.lat;
  const double d_lon = math::wrap_pi(to.lon - from.lon);
  anchored_ += error;
  dead_reckoning_.set_position(to.lat, from.lon + d_lon);
  track_.shift(d_lat, d_lon);
  for (int i = 0; i < steps_.size(); ++i) {
    steps_[i].point.lat += d_lat;
    steps_[i].point.lon += d_lon;
    steps_[i].estimate.x.segment<2>(kPositionError.offset) -= error;
  }
}

}  // namespace lodestar::fusion
