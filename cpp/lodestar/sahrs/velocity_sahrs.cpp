// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/velocity_sahrs.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lodestar/earth/wgs84.h"
#include "lodestar/strapdown/air_data_aid.h"

namespace lodestar::sahrs {
namespace {

constexpr double kLongestBridge = 0.5;            // s without body rates that are bridged
constexpr double kLongestFrame = 0.05;            // s; a longer frame has lost samples
constexpr std::int64_t kOldest_us = 1'000'000;    // age up to which a sample comes
constexpr std::int64_t kFresh_us = 500'000;       // a sample this old still speaks of now
constexpr std::int64_t kCoasting_us = 2'000'000;  // without any measurement: coasting

constexpr std::int64_t kPatience_us = 10'000'000;     // with a field that is not believed
constexpr double kDoubt = 0.5 * math::kDegree;        // rad/s that sigma then grows by
constexpr double kLost = 30.0 * math::kDegree;        // sigma beyond which linear filtering ends
constexpr std::int64_t kLongestWait_us = 10'000'000;  // for straight flight to align in
constexpr double kClimbBandwidth = 1.0;               // rad/s, for the alignment only
constexpr double kCoarse = 2.0 * math::kDegree;       // heading worse than this is refined
constexpr std::int64_t kLongestHold_us = 150'000'000;
constexpr double kFine = 1.0 * math::kDegree;  // until it is as good as that
constexpr double kAgain = 1.5;                 // of sigma, to start again with

double seconds(std::int64_t later_us, std::int64_t earlier_us) {
  return 1e-6 * static_cast<double>(later_us - earlier_us);
}

double square(double x) { return x * x; }

strapdown::Parameters with_airspeed(strapdown::Parameters parameters, double min_airspeed) {
  parameters.min_airspeed = min_airspeed;
  return parameters;
}

}  // namespace

VelocitySahrs::VelocitySahrs(const Parameters& parameters,
                             const strapdown::Parameters& filter_parameters,
                             const FieldCalibration& calibration,
                             earth::GeomagneticKind field_model, double epoch_year)
    : parameters_(parameters),
      calibration_(calibration),
      epoch_year_(epoch_year),
      field_model_(field_model),
      filter_(with_airspeed(filter_parameters, parameters.min_airspeed)),
      climb_(kClimbBandwidth, filter_parameters.baro_lag) {}

void VelocitySahrs::set_position(double lat, double lon, double h) {
  b_N_ = field_model_.field_N(lat, lon, h, epoch_year_);
  gravity_ = earth::gravity(lat, h);
  filter_.set_place(lat, h, b_N_);
}

void VelocitySahrs::start(const math::Euler& attitude, const Eigen::Vector3d& sigma_B,
                          std::int64_t time_us) {
  now_us_ = time_us;
  begin(math::C_NB_from_euler(attitude), sigma_B, time_us);
}

void VelocitySahrs::begin(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B,
                          std::int64_t time_us) {
  filter_.start(C_NB, sigma_B, time_us);
  coarse_ = sigma_B.maxCoeff() > kCoarse;
  if (coarse_) filter_.hold_linearisation();
  started_us_ = time_us;
  last_used_us_ = time_us;
  field_used_us_ = time_us;
  state_ = State::kRunning;
  lost_ = lost_tilt_ = false;
}

void VelocitySahrs::propagate(const samples::BodyRates& sample) {
  const double dt = have_rates_ ? seconds(sample.time_us, now_us_) : 0.0;
  have_rates_ = true;
  now_us_ = sample.time_us;
  omega_B_ = sample.omega_B;
  field_refused_ = false;
  if (state_ == State::kRunning && dt > kLongestBridge) {
    state_ = State::kRealigning;
    alignment_.restart();
  }
  if (needs_alignment()) alignment_.observe_rates(filter_.corrected(omega_B_), now_us_);
  if (state_ != State::kRunning) return;
  // Between two known ends the rate did what it liked: the integral of a Brownian bridge.
  const double bridged =
      dt > kLongestFrame ? square(parameters_.gyro_gap_noise) * dt * dt * dt / 12.0 : 0.0;
  const double hidden = bridged + saturated_rates_.see(sample.omega_B, dt);
  filter_.propagate(sample, hidden);
  if (coarse_) refine_alignment();
}

// What the sensors seemed to err by while the attitude was off by degrees is not to be trusted, and
// less so its sigma: only the attitude is kept.
void VelocitySahrs::refine_alignment() {
  const bool fine = filter_.attitude_variance_N().z() < square(kFine);
  if (!fine && now_us_ - started_us_ <= kLongestHold_us) return;
  const Eigen::Vector3d variance_B = filter_.attitude_covariance_B().diagonal();
  filter_.start_again(kAgain * variance_B.cwiseSqrt());
  started_us_ = now_us_;
  coarse_ = !fine;
  if (coarse_) filter_.hold_linearisation();
}

samples::Use VelocitySahrs::update(const samples::LoadFactor& sample) {
  load_us_ = sample.time_us;
  have_load_ = true;
  if (needs_alignment() && have_air_ && sample.time_us - air_.time_us <= kFresh_us) {
    alignment_.observe_load(sample.n_B, strapdown::air_velocity_B(air_), sample.time_us);
    try_alignment();
  }
  if (state_ != State::kRunning) return samples::Use::kHeld;
  return filter_.update(sample);
}

samples::Use VelocitySahrs::update(const samples::MagneticField& sample) {
  samples::MagneticField field = sample;
  field.b_B = calibration_.matrix * sample.b_B + calibration_.bias;
  const bool strong = strong_enough(field.b_B);
  suspicion_.see(strong, sample.time_us);
  if (!strong) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kFieldStrength)];
    field_refused_ = true;
    return samples::Use::kAssumption;
  }
  if (needs_alignment()) alignment_.observe_field(field.b_B, sample.time_us);
  const std::int64_t before_us = field_us_;
  have_field_ = true;
  field_us_ = sample.time_us;
  if (state_ != State::kRunning || lost_) return samples::Use::kHeld;
  const samples::Use use = filter_.update(field);
  note(use, sample.time_us);
  if (use == samples::Use::kUsed) field_used_us_ = sample.time_us;
  if (use == samples::Use::kGated) doubt_heading(before_us);
  return use;
}

// A field of another strength is that of something near the detector. It neither turns the attitude
// nor speaks against it, and for a while no more does one of the right strength that the gate keeps
// out: what is fixed to the aircraft adds to the field at one heading and takes from it at another.
bool VelocitySahrs::strong_enough(const Eigen::Vector3d& b_B) const {
  const strapdown::Estimate x = filter_.estimate();
  const double strength = (b_B - x.field_bias_B - x.field_drift_B).norm();
  return std::abs(strength / b_N_.norm() - 1.0) <= parameters_.max_field_strength_error;
}

// A field that contradicts the heading for a moment is a disturbance. If it goes on, either may be
// wrong, and in the long run there is no other reference: sigma grows until the field is believed.
void VelocitySahrs::doubt_heading(std::int64_t before_us) {
  if (field_us_ - field_used_us_ < kPatience_us) return;
  if (suspicion_.lasts(field_us_)) return;
  const double sigma = std::sqrt(filter_.attitude_variance_N().z());
  filter_.doubt_heading(2.0 * sigma * kDoubt * std::min(seconds(field_us_, before_us), 1.0));
}

samples::Use VelocitySahrs::update(const samples::AirData& sample) {
  if (needs_alignment()) {
    const double dt = have_air_ ? seconds(sample.time_us, air_.time_us) : 0.0;
    if (dt > 0.0 && dt <= kLongestBridge) {
      climb_.update(sample.baro_altitude, dt);
    } else {
      climb_.restart(sample.baro_altitude);
    }
  }
  air_ = sample;
  have_air_ = true;
  if (state_ != State::kRunning || lost_tilt_) return samples::Use::kHeld;
  const samples::Use use = filter_.update(sample);
  note(use, sample.time_us);
  if (filter_.frozen_flow() != 0) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kLiveFlow)];
  }
  return use;
}

void VelocitySahrs::note(samples::Use use, std::int64_t time_us) {
  if (use == samples::Use::kUsed) last_used_us_ = std::max(last_used_us_, time_us);
  if (use == samples::Use::kAssumption) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kAirspeed)];
  }
}

void VelocitySahrs::try_alignment() {
  if (!have_field_ || !climb_.settled() || suspicion_.lasts(now_us_)) return;
  const std::int64_t oldest_us = std::min(field_us_, air_.time_us);
  if (now_us_ - oldest_us > kOldest_us || std::abs(air_.beta) > parameters_.max_sideslip ||
      air_.true_airspeed < filter_.parameters().min_airspeed) {
    return;
  }
  const std::optional<Aligned> aligned =
      alignment_.solve({climb_.rate(), b_N_, gravity_, 3.0 * filter_.parameters().gyro_bias_sigma,
                        parameters_.max_imbalance});
  if (!aligned) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kBalance)];
    return;
  }
  if (alignable_us_ == 0) alignable_us_ = now_us_;
  if (!aligned->averaged && now_us_ - alignable_us_ < kLongestWait_us) return;
  alignable_us_ = 0;
  align_to(*aligned);
}

void VelocitySahrs::align_to(const Aligned& aligned) {
  const bool again = state_ != State::kWaiting;
  const Eigen::Quaterniond before = attitude_.q_NB;
  const double age = seconds(now_us_, load_us_);
  filter_.correct_gyro_bias(aligned.gyro_bias_B);
  begin(math::C_NB_from_euler(aligned.attitude) *
            math::exp_so3(age * (aligned.omega_B - aligned.gyro_bias_B)),
        aligned.sigma_B, now_us_);
  alignment_.restart();
  if (again) {
    ++attitude_.reset_count;
    attitude_.reset_delta_B = math::log_quaternion(before.conjugate() * filter_.estimate().q_NB);
  }
}

void VelocitySahrs::finish_frame() {
  const strapdown::Estimate x = filter_.estimate();
  attitude_.time_us = now_us_;
  attitude_.q_NB = x.q_NB;
  const math::Euler euler = math::euler_from_C_NB(x.C_NB);
  attitude_.roll = euler.roll;
  attitude_.pitch = euler.pitch;
  attitude_.heading = euler.heading;
  attitude_.P_B = filter_.attitude_covariance_B();
  attitude_.omega_B = filter_.corrected(omega_B_);
  attitude_.gyro_bias_B = x.gyro_bias_B;
  attitude_.field_bias_B = x.field_bias_B + x.field_drift_B;
  attitude_.used = filter_.used();
  constexpr int kField = 7 << strapdown::VelocityFilter::kFieldX;
  attitude_.rejected = filter_.rejected() | (field_refused_ ? kField : 0);
  const Eigen::Vector3d variance_N = filter_.attitude_variance_N();
  const bool certain =
      std::max(variance_N.x(), variance_N.y()) <= square(parameters_.max_valid_tilt_sigma) &&
      variance_N.z() <= square(parameters_.max_valid_heading_sigma);
  lost_tilt_ = std::max(variance_N.x(), variance_N.y()) > square(kLost);
  lost_ = lost_tilt_ || variance_N.z() > square(kLost);
  attitude_.valid = state_ == State::kRunning && certain;
  attitude_.mode = mode(certain);
}

samples::AttitudeMode VelocitySahrs::mode(bool certain) const {
  using samples::AttitudeMode;
  if (state_ == State::kWaiting) return AttitudeMode::kWaiting;
  if (state_ == State::kRealigning) return AttitudeMode::kRealigning;
  if (now_us_ - last_used_us_ > kCoasting_us) return AttitudeMode::kCoasting;
  return certain ? AttitudeMode::kRunning : AttitudeMode::kAligning;
}

}  // namespace lodestar::sahrs
