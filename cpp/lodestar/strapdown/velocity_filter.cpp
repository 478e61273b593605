// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/velocity_filter.h"

#include <algorithm>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/strapdown/air_data_aid.h"
#include "lodestar/strapdown/baro_aid.h"
#include "lodestar/strapdown/initial_covariance.h"
#include "lodestar/strapdown/magnetic_aid.h"
#include "lodestar/strapdown/sparse_update.h"

namespace lodestar::strapdown {
namespace {

constexpr double kMicrosecond = 1e-6;               // s
constexpr std::int64_t kFresh_us = 200'000;         // a load factor this old still holds
constexpr double kUnknownForce = 3.0;               // m/s^2/sqrt(Hz), where none is measured
constexpr double kNearestPole = 1e-3;               // cos(latitude), for the transport rate

double seconds(std::int64_t later_us, std::int64_t earlier_us) {
  return kMicrosecond * static_cast<double>(later_us - earlier_us);
}

double square(double x) { return x * x; }

}  // namespace

VelocityFilter::VelocityFilter(const Parameters& parameters)
    : parameters_(parameters),
      gate_(parameters.gate_false_rejection),
      P_(initial_covariance(parameters)),
      gust_level_(parameters.gust_sigma, parameters.gust_sigma_min, parameters.gust_sigma_max,
                  parameters.gust_adaptation) {
  place_.baro_lag = parameters.baro_lag;
}

void VelocityFilter::set_place(double lat, double h, const Eigen::Vector3d& b_N) {
  lat_ = lat;
  h_ = h;
  b_N_ = b_N;
  place_.gravity = earth::gravity(lat, h);
  place_.earth_rate_N = earth::earth_rate_N(lat);
}

void VelocityFilter::start(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B,
                           std::int64_t time_us) {
  x_.C_NB = C_NB;
  x_.q_NB = Eigen::Quaterniond(C_NB).normalized();
  restart_attitude(P_, C_NB * sigma_B.cwiseAbs2().asDiagonal() * C_NB.transpose());
  has_velocity_ = false;
  have_load_ = false;
  now_us_ = time_us;
  corrections_ = Corrections{};
  history_.clear();
  remember(Eigen::Vector3d::Zero(), 0.0);
}

void VelocityFilter::propagate(const samples::BodyRates& sample, double extra_angle_variance) {
  used_ = 0;
  rejected_ = 0;
  const double dt = seconds(sample.time_us, now_us_);
  const Eigen::Vector3d mean_omega_B =
      have_rates_ ? 0.5 * (measured_omega_B_ + sample.omega_B) : sample.omega_B;
  have_rates_ = true;
  measured_omega_B_ = sample.omega_B;
  now_us_ = sample.time_us;
  if (!(dt > 0.0)) return;

  ProcessNoise noise = process_noise(dt);
  const Eigen::Vector3d force_B = force_to_use(noise.force);
  const Step step = move(x_, mean_omega_B, force_B, place_, dt);
  x_.field_drift_B *= noise.field_drift_decay;
  x_.gust_B *= noise.gust_decay;
  strapdown::propagate(P_, step, place_, noise);
  if (extra_angle_variance > 0.0) {
    P_.diagonal().segment<3>(kAttitude.offset).array() += extra_angle_variance;
  }
  impulse_N_ += dt * (step.C_NB * force_B);
  remember(force_B, dt);
}

ProcessNoise VelocityFilter::process_noise(double dt) const {
  const Parameters& p = parameters_;
  ProcessNoise noise;
  noise.gyro = square(p.gyro_noise);
  noise.force = square(p.load_noise * samples::kStandardGravity);
  noise.wind = square(p.wind_walk);
  noise.vertical_wind = square(p.vertical_wind_walk);
  noise.height = square(p.height_walk);
  noise.gyro_bias = p.gyro_drift.spectral_density();
  noise.field_drift_decay = p.field_drift.decay(dt);
  noise.field_drift_variance = p.field_drift.added_variance(dt);
  const double airspeed = std::max(x_.air_velocity_N.norm(), p.min_airspeed);
  const math::GaussMarkov gust{gust_level_.sigma(), p.gust_length / airspeed};
  noise.gust_decay = gust.decay(dt);
  noise.gust_variance.setConstant(gust.added_variance(dt));
  return noise;
}

/// Without a fresh load factor the air velocity is taken to stay as it is in B.
Eigen::Vector3d VelocityFilter::force_to_use(double& density) const {
  if (have_load_ && now_us_ - load_us_ <= kFresh_us) return force_B_;
  density = square(kUnknownForce);
  const Eigen::Vector3d weight_B = place_.gravity * x_.C_NB.row(2).transpose();
  return omega_B().cross(x_.C_NB.transpose() * x_.air_velocity_N) - weight_B + x_.force_bias_B;
}

void VelocityFilter::remember(const Eigen::Vector3d& force_B, double dt) {
  const Moment* last = history_.before(now_us_);
  const double rate = dt > 0.0 ? 1.0 / dt : 0.0;
  const double baro_change = last != nullptr ? x_.baro_height - last->baro_height : 0.0;
  Moment& moment = history_.push();
  moment.time_us = now_us_;
  moment.q_NB = x_.q_NB;
  moment.air_velocity_N = x_.air_velocity_N;
  moment.height = x_.height;
  moment.baro_height = x_.baro_height;
  moment.impulse_N = impulse_N_;
  moment.omega_NB_B =
      omega_B() - x_.C_NB.transpose() * (place_.earth_rate_N + place_.transport_rate_N);
  moment.force_N = x_.C_NB * force_B;
  moment.acceleration_N = moment.force_N - x_.C_NB * x_.force_bias_B +
                          Eigen::Vector3d(0.0, 0.0, place_.gravity);
  moment.baro_rate = rate * baro_change;
  moment.corrections = corrections_;
}

bool VelocityFilter::locate(std::int64_t time_us, Moment& moment) const {
  const Moment* found = history_.before(time_us);
  if (found == nullptr) return false;
  moment = *found;
  if (time_us != moment.time_us) moment.extrapolate(seconds(time_us, moment.time_us));
  moment.time_us = time_us;
  moment.bring_up(corrections_, seconds(now_us_, time_us), place_.gravity);
  return true;
}

Estimate VelocityFilter::estimate_at(const Moment& moment) const {
  Estimate then = x_;
  then.q_NB = moment.q_NB;
  then.C_NB = moment.q_NB.toRotationMatrix();
  then.air_velocity_N = moment.air_velocity_N;
  then.height = moment.height;
  then.baro_height = moment.baro_height;
  return then;
}

Delay VelocityFilter::delay_of(const Moment& moment) const {
  Delay delay;
  delay.age = seconds(now_us_, moment.time_us);
  delay.gravity = place_.gravity;
  const Eigen::Matrix3d C_then = moment.q_NB.toRotationMatrix();
  delay.C_NB = 0.5 * (C_then + x_.C_NB);
  delay.omega_B =
      math::log_quaternion(moment.q_NB.conjugate() * x_.q_NB) / std::max(delay.age, 1e-3);
  delay.air_velocity_N = moment.air_velocity_N;
  return delay;
}

samples::Use VelocityFilter::update(const samples::LoadFactor& sample) {
  const Eigen::Vector3d force_B = -samples::kStandardGravity * sample.n_B;
  Eigen::Vector3d force_N = x_.C_NB * force_B;
  Eigen::Vector3d impulse_N = impulse_N_;
  if (sample.time_us != now_us_) {
    Moment moment;
    if (!locate(sample.time_us, moment)) return samples::Use::kHeld;
    force_N = moment.q_NB * force_B;
    impulse_N = moment.impulse_N;
  }
  const double dt = seconds(sample.time_us, load_us_);
  if (have_load_ && dt > 0.0 && sample.time_us - load_us_ <= kFresh_us) {
    // The trapezoid since the last sample, in place of what was held over that time.
    const Eigen::Vector3d missed_N =
        (0.5 * dt) * (force_N_ + force_N) - (impulse_N - impulse_at_load_N_);
    x_.air_velocity_N += missed_N;
    const double down = missed_N.z() * 0.5 * dt;
    x_.height -= down;
  }
  have_load_ = true;
  load_us_ = sample.time_us;
  force_B_ = force_B;
  force_N_ = force_N;
  impulse_at_load_N_ = impulse_N;
  return samples::Use::kUsed;
}

samples::Use VelocityFilter::update(const samples::MagneticField& sample) {
  Moment moment;
  moment.time_us = now_us_;
  if (sample.time_us != now_us_ && !locate(sample.time_us, moment)) return samples::Use::kHeld;
  const bool late = sample.time_us != now_us_;
  return correct(measure_field(sample.b_B, late ? estimate_at(moment) : x_, b_N_,
                               parameters_.field_noise),
                 moment, kFieldX, true);
}

samples::Use VelocityFilter::update(const samples::AirData& sample) {
  if (sample.true_airspeed < parameters_.min_airspeed) return samples::Use::kAssumption;
  if (!has_velocity_) {
    start_velocity(sample);
    return samples::Use::kUsed;
  }
  Moment moment;
  moment.time_us = now_us_;
  const bool late = sample.time_us != now_us_;
  if (late && !locate(sample.time_us, moment)) return samples::Use::kHeld;
  const Estimate& then = late ? estimate_at(moment) : x_;
  const AirDataMeasurement air =
      measure_air(sample, then, {parameters_.airspeed_noise, parameters_.flow_noise});
  const BaroMeasurement baro =
      measure_baro(sample.baro_altitude, then, parameters_.baro_noise);
  const double dt = std::clamp(seconds(sample.time_us, air_us_), 0.0, 0.1);
  air_us_ = sample.time_us;
  const samples::Use use = correct(air, moment, kAirspeed, false);
  double surprise = 0.0;
  for (const Row row : {kAirspeed, kAlpha, kBeta}) {
    surprise += square(innovation_[row] / innovation_sigma_[row]) / 3.0;
  }
  gust_level_.learn(surprise, dt);
  correct(baro, moment, kBaro, false);
  if (std::cos(lat_) > kNearestPole) {
    place_.transport_rate_N = earth::transport_rate_N(lat_, h_, x_.air_velocity_N);
  }
  return use;
}

void VelocityFilter::start_velocity(const samples::AirData& sample) {
  const double V = sample.true_airspeed;
  const Eigen::Vector3d v_air_B =
      V * Eigen::Vector3d(std::cos(sample.alpha) * std::cos(sample.beta), std::sin(sample.beta),
                          std::sin(sample.alpha) * std::cos(sample.beta));
  x_.air_velocity_N = x_.C_NB * v_air_B;
  x_.gust_B.setZero();
  x_.height = sample.baro_altitude;
  x_.baro_height = sample.baro_altitude;
  restart_velocity(P_, parameters_, gust_level_.sigma(), V);
  air_us_ = sample.time_us;
  has_velocity_ = true;
  corrections_ = Corrections{};
  history_.clear();
  remember(force_B_, 0.0);
}

template <class Measurement>
samples::Use VelocityFilter::correct(const Measurement& m, const Moment& moment, Row first,
                                     bool together) {
  if (moment.time_us == now_us_) return correct_now(m, first, together);
  return correct_now(Delayed<Measurement>(m, delay_of(moment)), first, together);
}

template <class Measurement>
samples::Use VelocityFilter::correct_now(const Measurement& m, Row first, bool together) {
  constexpr int kM = Measurement::kRows;
  SparseUpdate<kStates, Measurement> update(P_, m);
  int passed = 0;
  for (int i = 0; i < kM; ++i) {
    const std::size_t row = static_cast<std::size_t>(first + i);
    innovation_[row] = m.innovation(i);
    innovation_sigma_[row] = update.sigma(i);
    if (together || gate_.passes(update.normalised_square(i), 1)) passed |= 1 << i;
  }
  if (together && !gate_.passes(update.normalised_square(), kM)) passed = 0;
  const int all = (1 << kM) - 1;
  used_ |= passed << first;
  rejected_ |= (all & ~passed) << first;
  if (passed == 0) return samples::Use::kGated;
  for (int i = 0; i < kM; ++i) {
    if ((passed >> i & 1) == 0) update.exclude(i);
  }
  const StateVector correction = update.apply(P_);
  x_.correct(correction);
  corrections_.add(correction);
  return samples::Use::kUsed;
}

Eigen::Matrix3d VelocityFilter::attitude_covariance_B() const {
  const Eigen::Matrix3d lower = P_.block<3, 3>(kAttitude.offset, kAttitude.offset);
  const Eigen::Matrix3d P_N = lower.selfadjointView<Eigen::Lower>();
  return x_.C_NB.transpose() * P_N * x_.C_NB;
}

Eigen::Vector3d VelocityFilter::omega_B() const {
  return measured_omega_B_ - x_.gyro_matrix * measured_omega_B_ - x_.gyro_bias_B;
}

}  // namespace lodestar::strapdown
