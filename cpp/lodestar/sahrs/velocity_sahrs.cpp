// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/velocity_sahrs.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/scalar.h"
#include "lodestar/strapdown/air_data_aid.h"

namespace lodestar::sahrs {
namespace {

using math::seconds;
using math::square;

constexpr double kLongestPause = 0.5;             // s between two baro altitudes of one climb
constexpr std::int64_t kOldest_us = 1'000'000;    // age up to which a sample comes
constexpr std::int64_t kFresh_us = 500'000;       // a sample this old still speaks of now
constexpr std::int64_t kCoasting_us = 2'000'000;  // without any measurement: coasting

constexpr std::int64_t kLongestWait_us = 10'000'000;  // for straight flight to align in
constexpr double kClimbBandwidth = 1.0;               // rad/s, for the alignment only

}  // namespace

strapdown::GuardLimits guard_limits(const Parameters& parameters) {
  return {parameters.min_airspeed, parameters.gyro_gap_noise, parameters.max_field_strength_error};
}

VelocitySahrs::VelocitySahrs(const Parameters& parameters,
                             const strapdown::Parameters& filter_parameters,
                             const FieldCalibration& calibration,
                             earth::GeomagneticKind field_model, double epoch_year)
    : parameters_(parameters),
      calibration_(calibration),
      guard_(filter_parameters, guard_limits(parameters), field_model, epoch_year),
      climb_(kClimbBandwidth, filter_parameters.baro_lag) {}

void VelocitySahrs::start(const math::Euler& attitude, const Eigen::Vector3d& sigma_B,
                          std::int64_t time_us) {
  now_us_ = time_us;
  begin(math::C_NB_from_euler(attitude), sigma_B, time_us);
}

void VelocitySahrs::begin(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B,
                          std::int64_t time_us) {
  guard_.begin(C_NB, sigma_B, time_us);
  state_ = State::kRunning;
}

void VelocitySahrs::propagate(const samples::BodyRates& sample) {
  now_us_ = sample.time_us;
  omega_B_ = sample.omega_B;
  const bool bridged = guard_.propagate(sample);
  if (!bridged) {
    state_ = State::kRealigning;
    alignment_.restart();
  }
  if (needs_alignment()) alignment_.observe_rates(filter().corrected(omega_B_), now_us_);
}

samples::Use VelocitySahrs::update(const samples::LoadFactor& sample) {
  load_us_ = sample.time_us;
  have_load_ = true;
  if (needs_alignment() && have_air_ && sample.time_us - air_.time_us <= kFresh_us) {
    alignment_.observe_load(sample.n_B, strapdown::air_velocity_B(air_), sample.time_us);
    try_alignment();
  }
  return guard_.update(sample);
}

samples::Use VelocitySahrs::update(const samples::MagneticField& sample) {
  samples::MagneticField field = sample;
  field.b_B = calibration_.apply(sample.b_B);
  if (!guard_.vet(field)) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kFieldStrength)];
    return samples::Use::kAssumption;
  }
  if (needs_alignment()) alignment_.observe_field(field.b_B, sample.time_us);
  have_field_ = true;
  field_us_ = sample.time_us;
  return guard_.update(field);
}

samples::Use VelocitySahrs::update(const samples::AirData& sample) {
  if (needs_alignment()) {
    const double dt = have_air_ ? seconds(sample.time_us - air_.time_us) : 0.0;
    if (dt > 0.0 && dt <= kLongestPause) {
      climb_.update(sample.baro_altitude, dt);
    } else {
      climb_.restart(sample.baro_altitude);
    }
  }
  air_ = sample;
  have_air_ = true;
  const samples::Use use = guard_.update(sample);
  if (use == samples::Use::kAssumption) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kAirspeed)];
  }
  if (use != samples::Use::kHeld && filter().frozen_flow() != 0) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kLiveFlow)];
  }
  return use;
}

void VelocitySahrs::try_alignment() {
  if (!have_field_ || !climb_.settled() || guard_.suspects_field()) return;
  const std::int64_t oldest_us = std::min(field_us_, air_.time_us);
  if (now_us_ - oldest_us > kOldest_us || std::abs(air_.beta) > parameters_.max_sideslip ||
      air_.true_airspeed < filter().parameters().min_airspeed) {
    return;
  }
  const std::optional<Aligned> aligned =
      alignment_.solve({climb_.rate(), guard_.field_N(), guard_.gravity(),
                        3.0 * filter().parameters().gyro_bias_sigma, parameters_.max_imbalance});
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
  const double age = seconds(now_us_ - load_us_);
  guard_.filter().correct_gyro_bias(aligned.gyro_bias_B);
  begin(math::C_NB_from_euler(aligned.attitude) *
            math::exp_so3(age * (aligned.omega_B - aligned.gyro_bias_B)),
        aligned.sigma_B, now_us_);
  alignment_.restart();
  if (again) {
    ++attitude_.reset_count;
    attitude_.reset_delta_B = math::log_quaternion(before.conjugate() * filter().estimate().q_NB);
  }
}

void VelocitySahrs::finish_frame() {
  const strapdown::Estimate x = filter().estimate();
  attitude_.time_us = now_us_;
  attitude_.q_NB = x.q_NB;
  const math::Euler euler = math::euler_from_C_NB(x.C_NB);
  attitude_.roll = euler.roll;
  attitude_.pitch = euler.pitch;
  attitude_.heading = euler.heading;
  attitude_.P_B = filter().attitude_covariance_B();
  attitude_.omega_B = filter().corrected(omega_B_);
  attitude_.gyro_bias_B = x.gyro_bias_B;
  attitude_.field_bias_B = x.field_bias_B + x.field_drift_B;
  attitude_.used = filter().used();
  attitude_.rejected = guard_.rejected();
  const Eigen::Vector3d variance_N = filter().attitude_variance_N();
  const bool certain =
      std::max(variance_N.x(), variance_N.y()) <= square(parameters_.max_valid_tilt_sigma) &&
      variance_N.z() <= square(parameters_.max_valid_heading_sigma);
  guard_.finish_frame();
  attitude_.valid = state_ == State::kRunning && certain;
  attitude_.mode = mode(certain);
}

samples::AttitudeMode VelocitySahrs::mode(bool certain) const {
  using samples::AttitudeMode;
  if (state_ == State::kWaiting) return AttitudeMode::kWaiting;
  if (state_ == State::kRealigning) return AttitudeMode::kRealigning;
  if (now_us_ - guard_.last_used_us() > kCoasting_us) return AttitudeMode::kCoasting;
  return certain ? AttitudeMode::kRunning : AttitudeMode::kAligning;
}

}  // namespace lodestar::sahrs
