// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/cascade.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lodestar/earth/wgs84.h"

namespace lodestar::fusion {
namespace {

using samples::FusionMode;
using samples::Use;

// Beyond this the position error is handed over to dead reckoning: F is linear in it.
constexpr double kLongestError = 200.0;  // m
// An angle known no better than this is not known; the error model is linear.
constexpr double kLargestAngleVariance = 1.0;  // rad^2
constexpr double kLargestScale = 20.0;         // of sigma, when fixes contradict the filter

double seconds(std::int64_t microseconds) { return 1e-6 * static_cast<double>(microseconds); }

// d(heading, pitch, roll) / d(small rotation in B), near the vertical as at 84 degrees of pitch.
Eigen::Matrix3d euler_by_rotation_B(const samples::Attitude& sahrs) {
  const double sr = std::sin(sahrs.roll), cr = std::cos(sahrs.roll);
  const double sp = std::sin(sahrs.pitch), cp = std::max(0.1, std::cos(sahrs.pitch));
  Eigen::Matrix3d E;
  E << 0.0, sr / cp, cr / cp,  //
      0.0, cr, -sr,            //
      1.0, sr * sp / cp, cr * sp / cp;
  return E;
}

}  // namespace

Cascade::Cascade(const CascadeParameters& parameters)
    : parameters_(parameters),
      gate_(parameters.gps_false_rejection),
      vertical_(parameters),
      reacquisition_(parameters.reacquisition_time, parameters.reacquisition_speed) {}

Use Cascade::update(const samples::AirData& air) {
  dead_reckoning_.set_air_velocity(air_velocity_B(air));
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
  angles_restarted_ |= !first && sahrs.reset_count != sahrs_.reset_count;
  sahrs_ = sahrs;

  const TrackPoint& now = dead_reckoning_.advance(sahrs);
  if (first) {
    note_initial_heading();
    start_where_configured();
  } else {
    const double dt = seconds(now.time_us - before.time_us);
    vertical_.propagate(dt, 0.5 * (before.v_air_N.z() + now.v_air_N.z()));
  }
  dead_reckoning_.set_height(vertical_.baro_height());
  track_.push(now);
  if (started()) {
    const double elapsed = seconds(now.time_us - steps_.back().point.time_us);
    if (angles_restarted_ || elapsed >= parameters_.step) close_step();
  }
  refresh();
}

Use Cascade::update(const samples::GpsFix& fix) {
  const std::optional<TrackPoint> at = track_.at(fix.time_us);
  if (!at) return Use::kHeld;
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
  if (!at_once && !reacquisition_.examine(fix.time_us, innovation_, fix_sigma(fix))) {
    refresh();
    return passes ? Use::kHeld : Use::kGated;
  }
  if (!passes) yield_to_fixes(step.estimate, *at);
  reacquisition_.cancel();
  correct(fix, step, before, !at_once);
  return Use::kUsed;
}

/// The filter at the time of `at`, in the step after `before`.
Step Cascade::step_at(const TrackPoint& at, int before) const {
  const Step& last = steps_[before];
  Step step{at, steps_[std::min(before + 1, steps_.size() - 1)].conditions, last.estimate};
  step.conditions.angles_restarted = false;  // that comes at the end of the step, if it does
  step.estimate.propagate(parameters_, step.conditions, last.point, at);
  return step;
}

/// Sets the innovation; true if it passes the gate.
bool Cascade::compare(const samples::GpsFix& fix, const Step& step) {
  const PositionMatrix H = position_measurement();
  const earth::Geodetic fix_position{fix.lat, fix.lon, step.point.h};
  const Eigen::Vector3d offset_N = earth::displacement_N(step.point.position(), fix_position);
  innovation_ = offset_N.head<2>() - H * step.estimate.x;
  const double sigma = fix_sigma(fix);
  const Eigen::Matrix2d S =
      step.estimate.P.projected(H) + sigma * sigma * Eigen::Matrix2d::Identity();
  innovation_sigma_ = S.diagonal().cwiseSqrt();
  return gate_.passes(innovation_.dot(S.inverse() * innovation_), 2);
}

/// Fixes that agree among themselves contradict the filter: it is told to doubt itself as much as
/// they say, in position by their distance, in wind and angles by the speed at which they leave.
void Cascade::yield_to_fixes(ErrorEstimate& estimate, const TrackPoint& at) const {
  const PositionMatrix J = velocity_by_states(at, estimate.x);
  const double known = std::sqrt(estimate.P.projected(J).trace());
  const double scale = reacquisition_.drift().norm() / known;
  estimate.loosen(innovation_.cwiseAbs(), std::clamp(scale, 1.0, kLargestScale));
}

/// Takes the fix in at its own time and does the later steps again.
void Cascade::correct(const samples::GpsFix& fix, Step& step, int before, bool reset) {
  const Eigen::Vector2d error_before = steps_.back().estimate.position_error();
  const double sigma = fix_sigma(fix);
  step.estimate.x += step.estimate.P.update(position_measurement(), sigma * sigma, innovation_);
  for (int i = steps_.insert(before + 1, step) + 1; i < steps_.size(); ++i) {
    steps_[i].estimate = steps_[i - 1].estimate;
    steps_[i].estimate.propagate(parameters_, steps_[i].conditions, steps_[i - 1].point,
                                 steps_[i].point);
  }
  if (reset) {
    ++navigation_.reset_count;
    navigation_.reset_delta = steps_.back().estimate.position_error() - error_before;
  }
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

/// White noise of a fix (m, per axis): what the receiver states beyond the slow error, which is a
/// state, and no less than configured.
double Cascade::fix_sigma(const samples::GpsFix& fix) const {
  const double slow = parameters_.gps_error.sigma;
  const double stated = fix.sigma_horizontal * fix.sigma_horizontal - slow * slow;
  return std::sqrt(std::max(parameters_.gps_noise * parameters_.gps_noise, stated));
}

void Cascade::start_at_fix(const samples::GpsFix& fix, const TrackPoint& at) {
  const TrackPoint& now = dead_reckoning_.point();
  const Eigen::Vector3d flown_N = earth::displacement_N(at.position(), now.position());
  const earth::Geodetic here = earth::displaced({fix.lat, fix.lon, at.h}, flown_N);
  const double age = seconds(now.time_us - at.time_us);
  // The fix's slow error is now the position's, with the opposite sign.
  const double slow = parameters_.gps_error.sigma * parameters_.gps_error.sigma;
  const double noise = fix_sigma(fix) * fix_sigma(fix);
  const double drift = parameters_.wind.sigma * age;
  ErrorEstimate estimate = initial_estimate(slow + noise + drift * drift, -slow);
  note_aided(fix, at);
  start(here.lat, here.lon, estimate);
}

void Cascade::start_where_configured() {
  if (!parameters_.initial_lat || !parameters_.initial_lon) return;
  const double sigma = parameters_.initial_position_sigma;
  start(*parameters_.initial_lat, *parameters_.initial_lon, initial_estimate(sigma * sigma, 0.0));
}

void Cascade::start(double lat, double lon, const ErrorEstimate& estimate) {
  dead_reckoning_.set_position(lat, lon);
  track_.clear();
  track_.push(dead_reckoning_.point());
  steps_.push({dead_reckoning_.point(), conditions(), estimate});
  refresh_sigma();
  refresh();
}

/// Remembers by how much SAHRS differs from the configured heading; the filter starts later.
void Cascade::note_initial_heading() {
  if (!parameters_.initial_heading) return;
  first_us_ = sahrs_.time_us;
  first_heading_error_ = math::wrap_pi(*parameters_.initial_heading - sahrs_.heading);
}

ErrorEstimate Cascade::initial_estimate(double position_variance, double gps_covariance) const {
  StateVector x = StateVector::Zero();
  StateMatrix P = StateMatrix::Zero();
  const double gps_variance = parameters_.gps_error.sigma * parameters_.gps_error.sigma;
  const double wind_variance = parameters_.wind.sigma * parameters_.wind.sigma;
  P.diagonal().segment<2>(kPositionError.offset).setConstant(position_variance);
  P.diagonal().segment<2>(kGpsError.offset).setConstant(gps_variance);
  P.diagonal().segment<2>(kWind.offset).setConstant(wind_variance);
  P.diagonal().segment<3>(kHeadingError.offset) = angle_variance();
  for (int axis = 0; axis < 2; ++axis) {
    const int position = kPositionError.offset + axis;
    const int gps = kGpsError.offset + axis;
    P(position, gps) = P(gps, position) = gps_covariance;
  }
  if (parameters_.initial_heading) {
    const math::GaussMarkov& model = parameters_.heading_error;
    const double dt = seconds(sahrs_.time_us - first_us_);
    const double sigma = parameters_.initial_heading_sigma * model.decay(dt);
    x(kHeadingError.offset) = first_heading_error_ * model.decay(dt);
    P(kHeadingError.offset, kHeadingError.offset) = sigma * sigma + model.added_variance(dt);
  }
  return {x, ErrorCovariance(parameters_.covariance, P)};
}

/// Stationary variances of the angle errors (rad^2): what SAHRS says of itself, or the floor.
Eigen::Vector3d Cascade::angle_variance() const {
  const Eigen::Matrix3d E = euler_by_rotation_B(sahrs_);
  const Eigen::Vector3d stated = (E * sahrs_.P_B * E.transpose()).diagonal();
  const Eigen::Vector3d floor(parameters_.heading_error.sigma, parameters_.pitch_error.sigma,
                              parameters_.roll_error.sigma);
  return stated.cwiseMax(floor.cwiseAbs2()).cwiseMin(kLargestAngleVariance);
}

StepConditions Cascade::conditions() const {
  const double silence = seconds(sahrs_.time_us - air_.time_us);
  return {angle_variance(), silence > parameters_.air_data_timeout, angles_restarted_};
}

void Cascade::close_step() {
  const Step& last = steps_.back();
  Step step{dead_reckoning_.point(), conditions(), last.estimate};
  step.estimate.propagate(parameters_, step.conditions, last.point, step.point);
  steps_.push(step);
  angles_restarted_ = false;
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
  dead_reckoning_.set_position(to.lat, from.lon + d_lon);
  track_.shift(d_lat, d_lon);
  for (int i = 0; i < steps_.size(); ++i) {
    steps_[i].point.lat += d_lat;
    steps_[i].point.lon += d_lon;
    steps_[i].estimate.x.segment<2>(kPositionError.offset) -= error;
  }
}

void Cascade::refresh_status() {
  if (reacquisition_.stale(navigation_.time_us)) reacquisition_.cancel();
  navigation_.mode = mode();
  navigation_.gps_age = ever_aided_ ? seconds(navigation_.time_us - aided_us_) : -1.0;
  navigation_.valid = started();
}

void Cascade::refresh() {
  refresh_status();
  if (!started()) return;

  const TrackPoint& now = dead_reckoning_.point();
  const StateVector& x = steps_.back().estimate.x;
  math::Euler attitude = corrected_attitude(now, x);
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(attitude);
  if (std::abs(attitude.pitch) > 0.5 * math::kPi) attitude = math::euler_from_C_NB(C_NB);
  navigation_.roll = math::wrap_pi(attitude.roll);
  navigation_.pitch = attitude.pitch;
  navigation_.heading = math::wrap_2pi(attitude.heading);

  const Eigen::Vector2d wind = x.segment<2>(kWind.offset);
  navigation_.wind_N << wind, 0.0;
  navigation_.gps_error = x.segment<2>(kGpsError.offset);
  navigation_.v_N.head<2>() = (C_NB * now.v_air_B).head<2>() + wind;
  navigation_.v_N.z() = now.v_air_N.z() - vertical_.climb_correction();

  const double since_step = seconds(now.time_us - steps_.back().point.time_us);
  const Eigen::Vector2d error =
      x.segment<2>(kPositionError.offset) + since_step * (navigation_.v_N - now.v_air_N).head<2>();
  const earth::Geodetic here = earth::displaced(now.position(), {error.x(), error.y(), 0.0});
  navigation_.lat = here.lat;
  navigation_.lon = math::wrap_pi(here.lon);
  navigation_.h = now.h + vertical_.bias();
}

/// Once per step: sigma hardly changes within one.
void Cascade::refresh_sigma() {
  const TrackPoint& now = dead_reckoning_.point();
  const ErrorEstimate& estimate = steps_.back().estimate;
  const StateMatrix P = estimate.P.matrix();
  const Eigen::Vector3d air_noise(parameters_.alpha_noise, parameters_.beta_noise,
                                  parameters_.airspeed_noise);
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(now.attitude);
  const Eigen::Matrix3d noise_N = C_NB * velocity_by_air_data(now.v_air_B) * air_noise.asDiagonal();
  const Eigen::Vector3d noise_variance = noise_N.rowwise().squaredNorm();

  const double sigma_h = vertical_.sigma_height();
  const Eigen::Vector2d position_variance = P.diagonal().segment<2>(kPositionError.offset);
  navigation_.sigma_position << position_variance.cwiseSqrt(), sigma_h;

  const PositionMatrix J = velocity_by_states(now, estimate.x);
  const Eigen::Vector2d velocity_variance = (J * P * J.transpose()).diagonal();
  const double climb_variance = std::pow(vertical_.sigma_climb_correction(), 2);
  Eigen::Vector3d variance;
  variance << velocity_variance, climb_variance;
  navigation_.sigma_velocity = (variance + noise_variance).cwiseSqrt();

  const double beta_bias = parameters_.beta_bias;
  navigation_.sigma_attitude << std::sqrt(P(kRollError.offset, kRollError.offset)),
      std::sqrt(P(kPitchError.offset, kPitchError.offset)),
      std::sqrt(P(kHeadingError.offset, kHeadingError.offset) + beta_bias * beta_bias);
  // An error of airspeed is wind along the flight path, until the aircraft turns.
  const Eigen::Vector2d along =
      now.v_air_N.head<2>() * (parameters_.airspeed_bias / std::max(1.0, now.v_air_N.norm()));
  const Eigen::Vector2d wind_variance = P.diagonal().segment<2>(kWind.offset);
  navigation_.sigma_wind = (wind_variance + along.cwiseAbs2()).cwiseSqrt();
}

FusionMode Cascade::mode() const {
  if (!started()) return FusionMode::kWaiting;
  if (fresh(navigation_.time_us)) return FusionMode::kAiding;
  return reacquisition_.running() ? FusionMode::kReacquiring : FusionMode::kDeadReckoning;
}

}  // namespace lodestar::fusion
