// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/velocity_sahrs.h"

#include <algorithm>
#include <optional>

#include "lodestar/earth/wgs84.h"
#include "lodestar/strapdown/air_data_aid.h"

namespace lodestar::sahrs {
namespace {

constexpr double kLongestBridge = 0.5;            // s without body rates that are bridged
constexpr double kLongestFrame = 0.05;            // s; a longer frame has lost samples
constexpr std::int64_t kFresh_us = 200'000;       // a sample this old still speaks of now
constexpr std::int64_t kCoasting_us = 2'000'000;  // without any measurement: coasting

// What the alignments are good for, before the hard iron: an instant one is off by the gyro bias
// times the airspeed (0.2 deg/s and 190 m/s make 4 deg), and in heading by that times the tangent
// of the field's dip.
const Eigen::Vector3d kSteadySigma_B = math::kDegree * Eigen::Vector3d(1.2, 1.2, 5.0);
const Eigen::Vector3d kInstantSigma_B = math::kDegree * Eigen::Vector3d(6.0, 6.0, 20.0);
constexpr std::int64_t kLongestWait_us = 15'000'000;  // for steady flight
constexpr double kCoarse = 2.0 * math::kDegree;       // heading worse than this is refined
constexpr std::int64_t kLongestHold_us = 60'000'000;
constexpr double kFine = 1.0 * math::kDegree;  // until it is as good as that

double seconds(std::int64_t later_us, std::int64_t earlier_us) {
  return 1e-6 * static_cast<double>(later_us - earlier_us);
}

double square(double x) { return x * x; }

}  // namespace

VelocitySahrs::VelocitySahrs(const Parameters& parameters,
                             const strapdown::Parameters& filter_parameters,
                             const FieldCalibration& calibration,
                             earth::GeomagneticKind field_model, double epoch_year)
    : parameters_(parameters),
      calibration_(calibration),
      epoch_year_(epoch_year),
      field_model_(field_model),
      filter_(filter_parameters) {}

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
  state_ = State::kRunning;
}

void VelocitySahrs::propagate(const samples::BodyRates& sample) {
  const double dt = have_rates_ ? seconds(sample.time_us, now_us_) : 0.0;
  have_rates_ = true;
  now_us_ = sample.time_us;
  omega_B_ = sample.omega_B;
  if (state_ != State::kRunning) return;
  if (dt > kLongestBridge) {
    state_ = State::kRealigning;
    return;
  }
  // Between two known ends the rate did what it liked: the integral of a Brownian bridge.
  const double hidden =
      dt > kLongestFrame ? square(parameters_.gyro_gap_noise) * dt * dt * dt / 12.0 : 0.0;
  filter_.propagate(sample, hidden);
  if (coarse_) refine_alignment();
}

void VelocitySahrs::refine_alignment() {
  if (now_us_ - started_us_ > kLongestHold_us ||
      filter_.attitude_variance_N().z() < square(kFine)) {
    coarse_ = false;
    filter_.release_linearisation();
  }
}

samples::Use VelocitySahrs::update(const samples::LoadFactor& sample) {
  load_ = sample;
  have_load_ = true;
  if (state_ != State::kRunning) return samples::Use::kHeld;
  return filter_.update(sample);
}

samples::Use VelocitySahrs::update(const samples::MagneticField& sample) {
  field_ = sample;
  field_.b_B = calibration_.matrix * sample.b_B + calibration_.bias;
  have_field_ = true;
  try_alignment();
  if (state_ != State::kRunning) return samples::Use::kHeld;
  const samples::Use use = filter_.update(field_);
  note(use, sample.time_us);
  return use;
}

samples::Use VelocitySahrs::update(const samples::AirData& sample) {
  air_ = sample;
  have_air_ = true;
  if (state_ != State::kRunning) return samples::Use::kHeld;
  const samples::Use use = filter_.update(sample);
  note(use, sample.time_us);
  return use;
}

void VelocitySahrs::note(samples::Use use, std::int64_t time_us) {
  if (use == samples::Use::kUsed) last_used_us_ = std::max(last_used_us_, time_us);
  if (use == samples::Use::kAssumption) {
    ++assumption_rejects_[static_cast<std::size_t>(Assumption::kAirspeed)];
  }
}

void VelocitySahrs::try_alignment() {
  if (state_ == State::kRunning || !have_rates_ || !have_load_ || !have_field_ || !have_air_)
    return;
  const auto fresh = [this](std::int64_t time_us) { return now_us_ - time_us <= kFresh_us; };
  if (!fresh(load_.time_us) || !fresh(field_.time_us) || !fresh(air_.time_us)) return;
  if (air_.true_airspeed < filter_.parameters().min_airspeed) return;
  if (!waiting_for_steady_) {
    waiting_for_steady_ = true;
    waiting_us_ = now_us_;
    steady_.restart();
  }
  const MomentVectors in{omega_B_,   load_.n_B, strapdown::air_velocity_B(air_),
                         field_.b_B, b_N_,      gravity_};
  const std::optional<Eigen::Matrix3d> steady = steady_.add(now_us_, in, parameters_.max_imbalance);
  if (steady) {
    align_to(*steady, kSteadySigma_B);
  } else if (now_us_ - waiting_us_ > kLongestWait_us) {
    const std::optional<Eigen::Matrix3d> instant = attitude_of(in, parameters_.max_imbalance);
    if (instant) {
      align_to(*instant, kInstantSigma_B);
    } else {
      ++assumption_rejects_[static_cast<std::size_t>(Assumption::kBalance)];
    }
  }
}

void VelocitySahrs::align_to(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B) {
  const bool again = state_ == State::kRealigning;
  waiting_for_steady_ = false;
  begin(C_NB, sigma_B, now_us_);
  if (again) {
    ++attitude_.reset_count;
    attitude_.reset_delta_B =
        math::log_quaternion(attitude_.q_NB.conjugate() * filter_.estimate().q_NB);
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
  attitude_.rejected = filter_.rejected();
  const Eigen::Vector3d variance_N = filter_.attitude_variance_N();
  const bool certain =
      std::max(variance_N.x(), variance_N.y()) <= square(parameters_.max_valid_tilt_sigma) &&
      variance_N.z() <= square(parameters_.max_valid_heading_sigma);
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
