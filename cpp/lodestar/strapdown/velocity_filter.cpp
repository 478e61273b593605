// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/velocity_filter.h"

#include <algorithm>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/scalar.h"
#include "lodestar/strapdown/initial_covariance.h"

// The start, the frame and what is remembered. Samples are taken in in measurement_updates.cpp.

namespace lodestar::strapdown {
namespace {

using math::seconds;
using math::square;

constexpr double kUnknownForce = 3.0;  // m/s^2/sqrt(Hz), where none is measured
constexpr double kLeastTurn = 1e-3;    // rad; a smaller turn of P is put off

/// The least level of the air: with GPS, which can tell, that of still air.
template <int N>
double least(double of_air, double of_still_air) {
  return kOverGround<N> ? std::min(of_air, of_still_air) : of_air;
}

}  // namespace

template <int N>
StrapdownFilter<N>::StrapdownFilter(const Parameters& parameters, const GroundParameters& ground)
    : parameters_(parameters),
      ground_(ground),
      gate_(parameters.gate_false_rejection),
      P_(initial_covariance<N>(parameters)),
      gust_level_(parameters.gust_sigma,
                  least<N>(parameters.gust_sigma_min, ground.still_gust_sigma),
                  parameters.gust_sigma_max, parameters.gust_adaptation),
      wind_level_(parameters.wind_walk, least<N>(parameters.wind_walk_min, ground.still_wind_walk),
                  parameters.wind_walk_max, parameters.wind_adaptation,
                  parameters.wind_base_adaptation),
      still_air_(ground, parameters.wind_walk_min) {
  place_.baro_lag = parameters.baro_lag;
  if constexpr (kOverGround<N>) start_ground(P_, ground_);
}

template <int N>
void StrapdownFilter<N>::set_place(double lat, double h, const Eigen::Vector3d& b_N) {
  h_ = h;
  b_N_ = b_N;
  place_.lat = lat;
  place_.gravity = earth::gravity(lat, h);
  place_.earth_rate_N = earth::earth_rate_N(lat);
}

template <int N>
void StrapdownFilter<N>::start(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B,
                               std::int64_t time_us) {
  x_.C_NB = C_NB;
  x_.q_NB = Eigen::Quaterniond(C_NB).normalized();
  restart_attitude(P_, C_NB * sigma_B.cwiseAbs2().asDiagonal() * C_NB.transpose());
  has_velocity_ = false;
  have_load_ = false;
  now_us_ = time_us;
  held_ = false;
  forget_history();
}

template <int N>
void StrapdownFilter<N>::hold_linearisation() {
  held_ = true;
  offset_.setZero();
}

template <int N>
void StrapdownFilter<N>::start_again(const Eigen::Vector3d& sigma_B) {
  const Estimate best = estimate();
  [[maybe_unused]] const Matrix before = P_;
  held_ = false;
  offset_.setZero();
  x_ = Estimate{};
  x_.q_NB = best.q_NB;
  x_.C_NB = best.C_NB;
  x_.air_velocity_N = best.air_velocity_N;
  x_.height = best.height;
  x_.baro_height = best.baro_height;
  P_ = initial_covariance<N>(parameters_);
  if constexpr (kOverGround<N>) restart_ground(best, before);
  restart_attitude(P_, x_.C_NB * sigma_B.cwiseAbs2().asDiagonal() * x_.C_NB.transpose());
  restart_velocity(P_, parameters_, gust_level_.sigma(), x_.air_velocity_N.norm());
  forget_history();
}

template <int N>
void StrapdownFilter<N>::settle() {
  Vector rest = offset_;
  part<3>(rest, kAttitude).setZero();
  part<3>(rest, kVelocity) = turn_of(part<3>(offset_, kAttitude)).conjugate() *
                             Eigen::Vector3d(part<3>(offset_, kVelocity));
  x_.correct(rest);
  corrections_.add(rest);
  offset_.template tail<N - kAttitude.size>().setZero();
}

template <int N>
void StrapdownFilter<N>::fold_in(const Vector& correction) {
  x_.correct(correction);
  corrections_.add(correction);
  unturned_N_ += part<3>(correction, kAttitude);
  if (unturned_N_.squaredNorm() > kLeastTurn * kLeastTurn) {
    turn_errors(P_, unturned_N_, x_.C_NB);
    unturned_N_.setZero();
  }
}

template <int N>
Estimate StrapdownFilter<N>::estimate() const {
  Estimate best = x_;
  if (held_) best.correct(offset_);
  return best;
}

template <int N>
void StrapdownFilter<N>::forget_history() {
  Corrections none;  // but for the sums, which others follow
  none.heading = corrections_.heading;
  none.position = corrections_.position;
  corrections_ = none;
  history_.clear();
  remember(force_B_, 0.0);
}

template <int N>
void StrapdownFilter<N>::propagate(const samples::BodyRates& sample, double extra_angle_variance) {
  used_ = 0;
  rejected_ = 0;
  const double dt = seconds(sample.time_us - now_us_);
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
  strapdown::propagate<N>(P_, step, place_, noise);
  if constexpr (kOverGround<N>) fly_over_ground(step, noise);
  if (held_) {
    propagate_error<N>(offset_, step, place_, noise);
    settle();
  }
  if (extra_angle_variance > 0.0) {
    P_.diagonal().template segment<3>(kAttitude.offset).array() += extra_angle_variance;
  }
  impulse_N_ += dt * (step.C_NB * force_B);
  remember(force_B, dt);
}

template <int N>
ProcessNoise StrapdownFilter<N>::process_noise(double dt) const {
  const Parameters& p = parameters_;
  ProcessNoise noise;
  noise.gyro = square(p.gyro_noise);
  noise.force = square(p.load_noise * samples::kStandardGravity);
  noise.wind = square(wind_level_.walk());
  noise.vertical_wind = square(p.vertical_wind_ratio) * noise.wind;
  noise.height = square(p.height_walk) + neglected_climb<N>(P_, x_.air_velocity_N);
  noise.gyro_bias = p.gyro_drift.spectral_density();
  noise.field_drift_decay = p.field_drift.decay(dt);
  noise.field_drift_variance = p.field_drift.added_variance(dt);
  const double airspeed = std::max(x_.air_velocity_N.norm(), p.min_airspeed);
  const math::GaussMarkov gust{gust_level_.sigma(), p.gust_length / airspeed};
  noise.gust_decay = gust.decay(dt);
  noise.gust_variance.setConstant(gust.added_variance(dt));
  if constexpr (kOverGround<N>) {
    noise.mean_wind =
        square(wind_level_.step()) + square(std::min(still_air_.least_walk(), p.wind_walk_min));
    noise.wind_return = 1.0 - std::exp(-dt / ground_.wind_tau);
    noise.gps_error_decay = ground_.gps_error.decay(dt);
    noise.gps_error_variance = ground_.gps_error.added_variance(dt);
    noise.baro_bias_decay = ground_.baro_bias.decay(dt);
    noise.baro_bias_variance = ground_.baro_bias.added_variance(dt);
  }
  return noise;
}

/// Without a fresh load factor the air velocity is taken to stay as it is in B.
template <int N>
Eigen::Vector3d StrapdownFilter<N>::force_to_use(double& density) const {
  if (have_load_ && now_us_ - load_heard_us_ <= kFresh_us) return force_B_;
  density = square(kUnknownForce);
  const Eigen::Vector3d weight_B = place_.gravity * x_.C_NB.row(2).transpose();
  return corrected(measured_omega_B_).cross(x_.C_NB.transpose() * x_.air_velocity_N) - weight_B +
         x_.force_bias_B;
}

template <int N>
void StrapdownFilter<N>::remember(const Eigen::Vector3d& force_B, double dt) {
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
  moment.omega_NB_B = corrected(measured_omega_B_) -
                      x_.C_NB.transpose() * (place_.earth_rate_N + place_.transport_rate_N);
  moment.force_N = x_.C_NB * force_B;
  moment.acceleration_N =
      moment.force_N - x_.C_NB * x_.force_bias_B + Eigen::Vector3d(0.0, 0.0, place_.gravity);
  moment.baro_rate = rate * baro_change;
  moment.corrections = corrections_;
  moment.travelled = travelled_;
  moment.v_N = best_velocity(x_.air_velocity_N).template head<2>();
}

/// The velocity over the ground (m/s, in N), if `air_velocity_N` is what x_ says of it.
template <int N>
Eigen::Vector3d StrapdownFilter<N>::best_velocity(const Eigen::Vector3d& air_velocity_N) const {
  Eigen::Vector3d v_N = air_velocity_N;
  if (held_) v_N = turn_of(part<3>(offset_, kAttitude)) * v_N;
  v_N.head<2>() += x_.wind_N;
  return v_N;
}

template <int N>
bool StrapdownFilter<N>::locate(std::int64_t time_us, Moment& moment) const {
  const Moment* found = history_.before(time_us);
  if (found == nullptr) return false;
  moment = *found;
  if (time_us != moment.time_us) moment.extrapolate(seconds(time_us - moment.time_us));
  moment.time_us = time_us;
  moment.bring_up(corrections_, seconds(now_us_ - time_us), place_.gravity);
  return true;
}

template <int N>
Eigen::Matrix3d StrapdownFilter<N>::attitude_covariance_B() const {
  const Eigen::Matrix3d lower = P_.template block<3, 3>(kAttitude.offset, kAttitude.offset);
  const Eigen::Matrix3d P_N = lower.selfadjointView<Eigen::Lower>();
  return x_.C_NB.transpose() * P_N * x_.C_NB;
}

template class StrapdownFilter<kStates>;
template class StrapdownFilter<kGroundStates>;

}  // namespace lodestar::strapdown
