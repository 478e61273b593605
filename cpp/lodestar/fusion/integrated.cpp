// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/integrated.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lodestar/earth/wgs84.h"
#include "lodestar/fusion/dead_reckoning.h"
#include "lodestar/fusion/uncertainty.h"
#include "lodestar/math/scalar.h"

namespace lodestar::fusion {
namespace {

using math::square;
using samples::FusionMode;
using samples::Use;
using strapdown::GpsPosition;
using strapdown::GpsVelocity;
using strapdown::GroundPoint;

constexpr double kUnknown = 1e4;  // m, position before the first fix
constexpr std::int64_t kSigmaStep_us = 100'000;
constexpr double kWatchMemory = 10.0;  // s
constexpr double kNoAir = 10.0;        // s without air data, and there are none
constexpr double kNextFix = 3.0;       // s, between two fixes that make a velocity

// A risk of 1e-5 per hour, spread over the errors of an hour that are independent of each other
// (GPS's slow error stays alike for 150 s): a circle of this many sigma holds a two-dimensional
// Gaussian error but for that.
constexpr double kRiskPerHour = 1e-5;
constexpr double kIndependentPerHour = 24.0;

double protection_multiple() {
  return std::sqrt(-2.0 * std::log(kRiskPerHour / kIndependentPerHour));
}

/// The heading as another reference has it; level, so that heading is the rotation about down.
struct Heading {
  static constexpr int kRows = 1;
  Eigen::Matrix<double, 1, 1> innovation;  // rad
  Eigen::Matrix<double, 1, 1> variance;    // rad^2

  template <class Visit>
  void visit_H(Visit&& visit) const {
    visit(strapdown::kAttitude.offset, Eigen::RowVector3d::UnitZ().eval());
  }
};
using HeadingUpdate = strapdown::SparseUpdate<strapdown::kGroundStates, Heading>;

}  // namespace

Integrated::Integrated(const IntegratedParameters& parameters,
                       const strapdown::Parameters& filter_parameters,
                       const strapdown::GuardLimits& limits, earth::GeomagneticKind field_model,
                       double epoch_year)
    : parameters_(parameters),
      gate_(parameters.gps_false_rejection),
      fix_noise_(parameters.gps_noise),
      watch_(filter::chi_square_threshold(2, parameters.gps_drift_false_alarm), kWatchMemory),
      reacquisition_(parameters.reacquisition_time),
      guard_(filter_parameters, limits, field_model, epoch_year, parameters.ground) {}

void Integrated::propagate(const samples::BodyRates& rates) {
  now_us_ = rates.time_us;
  guard_.propagate(rates);
}

Use Integrated::update(const samples::MagneticField& sample) {
  return guard_.vet(sample) ? guard_.update(sample) : Use::kAssumption;
}

Use Integrated::update(const samples::AirData& sample) {
  air_us_ = now_us_;
  return guard_.update(sample);
}

void Integrated::follow(const samples::Attitude& sahrs) {
  const bool aligned = sahrs.mode != samples::AttitudeMode::kWaiting &&
                       sahrs.mode != samples::AttitudeMode::kRealigning;
  if (aligned && (!guard_.running() || (guard_.lost() && sahrs.valid))) begin(sahrs);
  guard_.finish_frame();
  filter().set_gps_lost(ever_aided_ && !fresh(now_us_));
  refresh();
  headings_.add({now_us_, math::wrap_pi(navigation_.heading - sahrs.heading),
                 filter().heading_corrections()});
}

/// The position goes on as it went while there was no attitude; how far is not quite known.
void Integrated::begin(const samples::Attitude& sahrs) {
  constexpr double kDrift = 0.1;  // of the way
  if (positioned_) {
    const double gap = seconds(now_us_ - flown_us_);
    const Eigen::Vector2d way = gap * navigation_.v_N.head<2>();
    const double drift = 1.0 + kDrift * way.norm();
    filter().displace(way);
    filter().doubt_ground(Eigen::Vector2d::Constant(drift), Eigen::Vector2d::Zero());
    ++navigation_.reset_count;
    navigation_.reset_delta = way;
  }
  guard_.begin(sahrs.q_NB.toRotationMatrix(), sahrs.sigma_B(), now_us_);
  if (!begun_ && parameters_.initial_lat && parameters_.initial_lon) {
    start_at(*parameters_.initial_lat, *parameters_.initial_lon,
             parameters_.initial_position_sigma);
  }
  begun_ = true;
  air_us_ = now_us_;
  last_.reset();
  headings_.restart();
}

void Integrated::start_at(double lat, double lon, double sigma) {
  filter().set_ground_position(lat, lon, sigma);
  positioned_ = true;
}

/// Air data give the air velocity at once. Where none come it begins with the way from one fix to
/// the next.
void Integrated::start_without_air(const samples::GpsFix& fix) {
  if (fix.fix_type == 2) return;  // without height
  const std::optional<samples::GpsFix> before = std::exchange(last_, fix);
  if (!before || seconds(now_us_ - air_us_) < kNoAir) return;
  const double dt = seconds(fix.time_us - before->time_us);
  if (!(dt > 0.0) || dt > kNextFix) return;
  const Eigen::Vector3d way =
      earth::displacement_N({before->lat, before->lon, before->h}, {fix.lat, fix.lon, fix.h});
  filter().start_over_ground(way / dt, fix.h);
  last_.reset();
}

void Integrated::coast(std::int64_t time_us) {
  if (navigation_.valid) {
    const Eigen::Vector3d way = seconds(time_us - navigation_.time_us) * navigation_.v_N;
    const earth::Geodetic to =
        earth::displaced({navigation_.lat, navigation_.lon, navigation_.h}, way);
    navigation_.lat = to.lat;
    navigation_.lon = to.lon;
    navigation_.h = to.h;
  }
  navigation_.time_us = time_us;
}

Use Integrated::update(const samples::GpsFix& fix) {
  if (!guard_.running()) return Use::kHeld;
  if (!filter().has_velocity()) {
    start_without_air(fix);
    return Use::kHeld;
  }
  std::optional<GroundPoint> at = filter().ground_at(fix.time_us);
  if (!at) return Use::kHeld;
  if (fix_motion_.stands_still(fix, at->air_velocity_N.head<2>())) return Use::kGated;
  if (!positioned_) {
    const Eigen::Vector2d since = at->delay.age * at->v_N;
    const earth::Geodetic here =
        earth::displaced({fix.lat, fix.lon, fix.h}, {since.x(), since.y(), 0.0});
    start_at(here.lat, here.lon, kUnknown);
    at = filter().ground_at(fix.time_us);
  }
  PositionUpdate update = compare(fix, *at);
  const bool passed = passes(update, fix.fix_type != 2) && !doubts(fix);
  const bool at_once = passed && (!ever_aided_ || fresh(fix.time_us));
  const bool believed = at_once || reacquisition_.examine(fix.time_us, offset(), std::sqrt(noise_));
  if (!believed) {
    refresh_status();
    return passed ? Use::kHeld : Use::kGated;
  }
  if (at_once) {
    reacquisition_.cancel();
    if (ever_aided_) {
      filter().hear_fix(innovation_.cwiseQuotient(innovation_sigma_),
                        seconds(fix.time_us - aided_us_));
    }
    correct(fix, update);
  } else {
    reset(fix, *at, passed);
  }
  refresh_sigma();
  refresh();
  return Use::kUsed;
}

void Integrated::replace(const samples::Navigation& shown) {
  const Eigen::Vector3d step = earth::displacement_N(
      {shown.lat, shown.lon, shown.h}, {navigation_.lat, navigation_.lon, navigation_.h});
  navigation_.reset_delta = step.head<2>();
  navigation_.reset_count = static_cast<decltype(navigation_.reset_count)>(shown.reset_count + 1);
}

Integrated::PositionUpdate Integrated::compare(const samples::GpsFix& fix, const GroundPoint& at) {
  noise_ = fix_noise_.variance(fix.sigma_horizontal);
  const Eigen::Vector3d variance(noise_, noise_, square(fix.sigma_vertical));
  const GpsPosition m = strapdown::measure_position({fix.lat, fix.lon, fix.h}, at,
                                                    filter().estimate().gps_error, variance);
  PositionUpdate update(filter().covariance(), m);
  innovation_ = update.innovation().head<2>();
  innovation_sigma_ = {update.sigma(0), update.sigma(1)};
  return update;
}

/// Whether fixes have come from one side for a while, though each is within its gate: a receiver
/// that is dragged off slowly. Those after a loss do, and are examined anyway.
bool Integrated::doubts(const samples::GpsFix& fix) {
  if (!fresh(fix.time_us)) {
    watch_.restart();
  } else if (!doubted_) {
    doubted_ = watch_.alarms(innovation_.cwiseQuotient(innovation_sigma_),
                             seconds(fix.time_us - aided_us_));
  }
  return doubted_;
}

/// Whether the horizontal position passes the gate; the height is left out if it does not.
bool Integrated::passes(PositionUpdate& update, bool has_height) {
  const Eigen::Matrix2d S = update.S().topLeftCorner<2, 2>();
  const bool horizontal = gate_.passes(innovation_.dot(S.inverse() * innovation_), 2);
  const bool vertical =
      has_height && (!ever_aided_ || gate_.passes(update.normalised_square(2), 1));
  if (!vertical) update.exclude(2);
  return horizontal;
}

/// Takes in a fix that examination has found to be believed, and says by how much that moves the
/// position.
void Integrated::reset(const samples::GpsFix& fix, const GroundPoint& at, bool passed) {
  const Eigen::Vector2d before = filter().position_corrections();
  const Eigen::Vector2d innovation = innovation_;
  if (!passed) yield_to_fixes();
  PositionUpdate update = compare(fix, at);
  passes(update, fix.fix_type != 2);
  innovation_ = innovation;
  correct(fix, update);
  navigation_.reset_delta = filter().position_corrections() - before;
  ++navigation_.reset_count;
  reacquisition_.cancel();
  watch_.restart();
  doubted_ = false;
}

/// Fixes that agree among themselves contradict the filter: it is told to doubt itself as much as
/// they say, in position by their distance, in wind by the speed at which they leave.
void Integrated::yield_to_fixes() {
  filter().doubt_ground(innovation_.cwiseAbs(), reacquisition_.drift().cwiseAbs());
}

void Integrated::correct(const samples::GpsFix& fix, const PositionUpdate& update) {
  fix_noise_.add(fix.time_us, offset(), fix.sigma_horizontal);
  filter().apply(update);
  if (fix.has_velocity) take_velocity(fix);
  ever_aided_ = true;
  aided_us_ = fix.time_us;
}

void Integrated::take_velocity(const samples::GpsFix& fix) {
  const std::optional<GroundPoint> at = filter().ground_at(fix.time_us);
  const double sigma = std::max(parameters_.gps_velocity_noise, fix.sigma_velocity);
  const GpsVelocity m = strapdown::measure_velocity(fix.v_N.head<2>(), *at, sigma);
  const strapdown::Delayed<GpsVelocity> delayed(m, at->delay);
  strapdown::SparseUpdate<strapdown::kGroundStates, strapdown::Delayed<GpsVelocity>> update(
      filter().covariance(), delayed);
  if (ever_aided_ && !gate_.passes(update.normalised_square(), 2)) return;
  filter().apply(update);
}

/// Since then the heading has been corrected, and may have drifted by what the yaw gyro's bias is
/// unknown by. A contradiction is the other reference's: it has just failed.
void Integrated::know_heading_error(double error, double sigma, std::int64_t time_us) {
  const std::optional<HeadingRecord::Entry> then = headings_.at(time_us);
  if (!guard_.running() || !then) return;
  const double corrected = filter().heading_corrections() - then->corrected;
  const double drift = filter().yaw_bias_sigma() * seconds(now_us_ - time_us);
  Heading m;
  m.innovation(0) = math::wrap_pi(error - then->ahead_of_sahrs - corrected);
  m.variance(0) = square(sigma) + square(drift);
  const HeadingUpdate update(filter().covariance(), m);
  if (gate_.passes(update.normalised_square(), 1)) filter().apply(update);
}

bool Integrated::fresh(std::int64_t time_us) const {
  return ever_aided_ && seconds(time_us - aided_us_) <= parameters_.gps_timeout;
}

void Integrated::refresh_status() {
  if (reacquisition_.stale(navigation_.time_us)) reacquisition_.cancel();
  navigation_.mode = mode();
  navigation_.gps_age = ever_aided_ ? seconds(navigation_.time_us - aided_us_) : -1.0;
  navigation_.valid = started();
}

void Integrated::refresh() {
  navigation_.time_us = now_us_;
  refresh_status();
  if (!guard_.running()) return;
  flown_us_ = now_us_;
  if (now_us_ - sigma_us_ >= kSigmaStep_us) refresh_sigma();
  const strapdown::Estimate x = filter().estimate();
  const math::Euler euler = math::euler_from_C_NB(x.C_NB);
  navigation_.roll = euler.roll;
  navigation_.pitch = euler.pitch;
  navigation_.heading = euler.heading;
  navigation_.v_N = x.v_N();
  navigation_.wind_N << x.wind_N, 0.0;
  navigation_.gps_error = x.gps_error.head<2>();
  navigation_.lat = x.lat;
  navigation_.lon = math::wrap_pi(x.lon);
  navigation_.h = x.height + x.baro_bias;
}

void Integrated::refresh_sigma() {
  sigma_us_ = now_us_;
  const Filter::Matrix& P = filter().covariance();
  const strapdown::Estimate x = filter().estimate();
  constexpr int kPosition = strapdown::kPosition.offset;
  const Eigen::Matrix2d position =
      P.block<2, 2>(kPosition, kPosition).selfadjointView<Eigen::Lower>();
  navigation_.sigma_position.head<2>() = position.diagonal().cwiseSqrt();
  const int height = strapdown::kHeight.offset;
  const int bias = strapdown::kBaroBias.offset;
  navigation_.sigma_position.z() =
      std::sqrt(P(height, height) + 2.0 * P(bias, height) + P(bias, bias));
  const double widest = position.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  navigation_.horizontal_protection_level =
      positioned_ ? protection_multiple() * std::sqrt(widest) : -1.0;

  GroundPoint here;
  here.air_velocity_N = x.air_velocity_N;
  const GpsVelocity seen = strapdown::measure_velocity(Eigen::Vector2d::Zero(), here, 0.0);
  navigation_.sigma_velocity.head<2>() =
      strapdown::SparseUpdate<strapdown::kGroundStates, GpsVelocity>(P, seen)
          .S()
          .diagonal()
          .cwiseSqrt();
  const int down = strapdown::kVelocity.offset + 2;
  navigation_.sigma_velocity.z() = std::sqrt(P(down, down));
  // Gusts are wind that is not in the estimate.
  const Eigen::Vector2d wind = P.diagonal().segment<2>(strapdown::kWind.offset);
  navigation_.sigma_wind = (wind.array() + square(filter().gust_sigma())).sqrt();
  navigation_.sigma_attitude =
      angle_sigma(math::euler_from_C_NB(x.C_NB), filter().attitude_covariance_B());
}

FusionMode Integrated::mode() const {
  if (!started()) return FusionMode::kWaiting;
  if (fresh(navigation_.time_us)) return FusionMode::kAiding;
  return reacquisition_.running() ? FusionMode::kReacquiring : FusionMode::kDeadReckoning;
}

}  // namespace lodestar::fusion
