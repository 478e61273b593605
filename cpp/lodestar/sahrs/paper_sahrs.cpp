// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/paper_sahrs.h"

#include <algorithm>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/scalar.h"

// The frame: rates, pose, alignment, output. The measurements are in paper_measurements.cpp.

namespace lodestar::sahrs {
namespace {

using math::seconds;
using math::square;

constexpr double kLongestFrame = 0.05;            // s; a longer frame has lost samples
constexpr std::int64_t kCoasting_us = 2'000'000;  // without any measurement: coasting
constexpr double kLost = 30.0 * math::kDegree;    // rad, sigma of an attitude that is none
constexpr double kFlowBandwidth = 2.0;            // rad/s, of the rates of V, alpha and beta
constexpr double kAltitudeOutlier = 20.0;         // m, off the altitude filter

}  // namespace

PaperSahrs::PaperSahrs(const Parameters& parameters, const FieldCalibration& calibration,
                       earth::GeomagneticKind field_model, double epoch_year)
    : parameters_(parameters),
      calibration_(calibration),
      epoch_year_(epoch_year),
      field_model_(field_model),
      min_cos_pitch_(std::cos(parameters.max_pitch)),
      gate_(parameters.false_rejection),
      error_model_(parameters),
      P_(error_model_.initial(Eigen::Vector3d::Constant(math::kPi))),
      climb_(parameters.climb_filter_bandwidth, parameters.baro_lag, kAltitudeOutlier),
      airspeed_(kFlowBandwidth),
      alpha_(kFlowBandwidth),
      beta_(kFlowBandwidth) {}

void PaperSahrs::set_position(double lat, double lon, double h) {
  lat_ = lat;
  h_ = h;
  b_N_ = field_model_.field_N(lat, lon, h, epoch_year_);
  gravity_ = earth::gravity(lat, h);
  earth_rate_N_ = earth::earth_rate_N(lat);
}

void PaperSahrs::start(const math::Euler& attitude, const Eigen::Vector3d& sigma_B,
                       std::int64_t time_us) {
  now_us_ = time_us;
  set_attitude(math::C_NB_from_euler(attitude), sigma_B);
}

void PaperSahrs::propagate(const samples::BodyRates& sample) {
  attitude_.used = 0;
  attitude_.rejected = 0;
  const double dt = seconds(sample.time_us - now_us_);
  const Eigen::Vector3d before_B = have_rates_ ? omega_B_ : sample.omega_B;
  have_rates_ = true;
  now_us_ = sample.time_us;
  omega_B_ = sample.omega_B;
  if (state_ == State::kRunning && dt > kLongestBridge) {
    state_ = State::kRealigning;
    alignment_.restart();
  }
  if (needs_alignment()) alignment_.observe_rates(omega_B_ - gyro_bias_B_, now_us_);
  if (state_ == State::kRunning && dt > 0.0) integrate(before_B, dt);
}

void PaperSahrs::integrate(const Eigen::Vector3d& before_B, double dt) {
  const Eigen::Vector3d turn_IB_B =
      math::rotation_vector(before_B - gyro_bias_B_, omega_B_ - gyro_bias_B_, dt);
  const Eigen::Vector3d omega_IN_B = C_NB_.transpose() * (earth_rate_N_ + transport_rate_N_);
  Pose pose;
  pose.time_us = now_us_;
  pose.q_SB =
      (history_.newest().q_SB * math::exp_quaternion(turn_IB_B - dt * omega_IN_B)).normalized();
  pose.omega_B = omega_B_;
  pose.climb_integral = history_.newest().climb_integral;
  if (have_load_ && now_us_ - load_us_ <= kOldest_us) {
    pose.climb_integral += dt * climb_acceleration_;
  }
  history_.push(pose);
  C_NB_ = (q_NS_ * pose.q_SB).toRotationMatrix();
  error_model_.propagate(P_, turn_IB_B / dt, b_B_, dt);
  if (dt > kLongestFrame) {
    // Between two known ends the rate did what it liked: the integral of a Brownian bridge.
    P_.diagonal().head<3>().array() += square(parameters_.gyro_gap_noise) * dt * dt * dt / 12.0;
  }
  P_.diagonal().head<3>().array() += saturated_rates_.see(omega_B_, dt);
  frame_interval_ = dt;
}

void PaperSahrs::try_alignment() {
  if (!needs_alignment() || !have_load_ || !have_air_ || !have_field_) return;
  if (suspicion_.lasts(now_us_)) return;
  const std::int64_t oldest_us = std::min({load_us_, air_.time_us, field_us_});
  if (now_us_ - oldest_us > kOldest_us || air_.true_airspeed < parameters_.min_airspeed ||
      std::abs(air_.beta) > parameters_.max_sideslip || !climb_.settled()) {
    return;
  }
  const double bias_sigma = std::sqrt(P_.diagonal().segment<3>(kGyroBias.offset).mean());
  const std::optional<Aligned> aligned = alignment_.solve(
      {climb_.rate(), b_N_, gravity_, 3.0 * bias_sigma, parameters_.max_imbalance});
  if (!aligned) return;
  const double age = seconds(now_us_ - load_us_);
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(aligned->attitude) *
                               math::exp_so3(age * (aligned->omega_B - aligned->gyro_bias_B));
  if (state_ != State::kWaiting) {
    const Eigen::Matrix3d turn_B = C_NB_.transpose() * C_NB;
    count_reset(math::log_quaternion(Eigen::Quaterniond(turn_B)));
  }
  gyro_bias_B_ += aligned->gyro_bias_B;
  set_attitude(C_NB, aligned->sigma_B);
}

void PaperSahrs::set_attitude(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B) {
  C_NB_ = C_NB;
  q_NS_ = Eigen::Quaterniond(C_NB_);
  Pose pose;
  pose.time_us = now_us_;
  pose.omega_B = omega_B_;
  pose.climb_integral = air_climb_integral_;
  history_.clear();
  history_.push(pose);
  ErrorModel::restart_attitude(P_, sigma_B);
  used_us_.fill(now_us_);
  last_used_us_ = now_us_;
  state_ = State::kRunning;
  lost_ = false;
  alignment_.restart();
}

void PaperSahrs::count_reset(const Eigen::Vector3d& turn_B) {
  attitude_.reset_delta_B = turn_B;
  ++attitude_.reset_count;
}

void PaperSahrs::finish_frame() {
  const math::Euler euler = math::euler_from_C_NB(C_NB_);
  attitude_.time_us = now_us_;
  attitude_.q_NB = q_NS_ * history_.newest().q_SB;
  attitude_.roll = euler.roll;
  attitude_.pitch = euler.pitch;
  attitude_.heading = euler.heading;
  attitude_.P_B = P_.topLeftCorner<3, 3>();
  attitude_.omega_B = omega_B_ - gyro_bias_B_;
  attitude_.gyro_bias_B = gyro_bias_B_;
  attitude_.field_bias_B = field_bias_B_;

  const Eigen::Vector3d variance_N =
      (C_NB_ * attitude_.P_B * C_NB_.transpose()).diagonal();  // heading is about z
  const double tilt_variance = std::max(variance_N.x(), variance_N.y());
  const bool certain = tilt_variance <= square(parameters_.max_valid_tilt_sigma) &&
                       variance_N.z() <= square(parameters_.max_valid_heading_sigma);
  lost_ = std::max(tilt_variance, variance_N.z()) > square(kLost);
  attitude_.valid = state_ == State::kRunning && certain;
  attitude_.mode = mode(certain);
}

samples::AttitudeMode PaperSahrs::mode(bool certain) const {
  if (state_ == State::kWaiting) return samples::AttitudeMode::kWaiting;
  if (state_ == State::kRealigning) return samples::AttitudeMode::kRealigning;
  if (now_us_ - last_used_us_ > kCoasting_us) return samples::AttitudeMode::kCoasting;
  return certain ? samples::AttitudeMode::kRunning : samples::AttitudeMode::kAligning;
}

}  // namespace lodestar::sahrs
