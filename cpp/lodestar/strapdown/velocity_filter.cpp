// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/velocity_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/strapdown/air_data_aid.h"
#include "lodestar/strapdown/initial_covariance.h"
#include "lodestar/strapdown/magnetic_aid.h"
#include "lodestar/strapdown/sparse_update.h"

namespace lodestar::strapdown {
namespace {

constexpr double kMicrosecond = 1e-6;        // s
constexpr std::int64_t kFresh_us = 200'000;  // silence after which no load factor holds
constexpr std::int64_t kBaroPatience_us = 2'000'000;
constexpr double kUnknownForce = 3.0;  // m/s^2/sqrt(Hz), where none is measured
constexpr double kNearestPole = 1e-3;  // cos(latitude), for the transport rate

constexpr double kLeastTurn = 1e-3;  // rad; a smaller turn of P is put off

double seconds(std::int64_t later_us, std::int64_t earlier_us) {
  return kMicrosecond * static_cast<double>(later_us - earlier_us);
}

double square(double x) { return x * x; }

}  // namespace

template <int N>
StrapdownFilter<N>::StrapdownFilter(const Parameters& parameters, const GroundParameters& ground)
    : parameters_(parameters),
      ground_(ground),
      gate_(parameters.gate_false_rejection),
      P_(initial_covariance<N>(parameters)),
      gust_level_(parameters.gust_sigma, parameters.gust_sigma_min, parameters.gust_sigma_max,
                  parameters.gust_adaptation),
      wind_level_(parameters.wind_walk, parameters.wind_walk_min, parameters.wind_walk_max,
                  parameters.wind_adaptation, parameters.wind_base_adaptation) {
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
    noise.mean_wind = square(wind_level_.step()) + square(p.wind_walk_min);
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
  if (time_us != moment.time_us) moment.extrapolate(seconds(time_us, moment.time_us));
  moment.time_us = time_us;
  moment.bring_up(corrections_, seconds(now_us_, time_us), place_.gravity);
  return true;
}

template <int N>
samples::Use StrapdownFilter<N>::update(const samples::LoadFactor& sample) {
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
  load_heard_us_ = now_us_;
  load_us_ = sample.time_us;
  force_B_ = force_B;
  force_N_ = force_N;
  impulse_at_load_N_ = impulse_N;
  return samples::Use::kUsed;
}

template <int N>
samples::Use StrapdownFilter<N>::update(const samples::MagneticField& sample) {
  if (sample.time_us == now_us_) {
    return correct(measure_field(sample.b_B, x_, b_N_, parameters_.field_noise), kFieldX, true);
  }
  Moment moment;
  if (!locate(sample.time_us, moment)) return samples::Use::kHeld;
  const MagneticMeasurement then =
      measure_field(sample.b_B, as_of(moment, x_), b_N_, parameters_.field_noise);
  return correct(Delayed<MagneticMeasurement>(then, delay(moment)), kFieldX, true);
}

template <int N>
samples::Use StrapdownFilter<N>::update(const samples::AirData& sample) {
  if (!(sample.true_airspeed >= parameters_.min_airspeed)) return samples::Use::kAssumption;
  frozen_ = frozen_flow_.see(sample);
  if (!has_velocity_) {
    start_velocity(sample);
    return samples::Use::kUsed;
  }
  const AirDataNoise noise{parameters_.airspeed_noise, parameters_.flow_noise,
                           parameters_.baro_noise};
  samples::Use use = samples::Use::kHeld;
  if (sample.time_us == now_us_) {
    const Eigen::Vector3d& scaled = scaled_flow_.follow(flow_without_gust(x_));
    use = correct(measure_air(sample, x_, scaled, noise), kAirspeed, false, frozen_);
  } else {
    Moment moment;
    if (!locate(sample.time_us, moment)) return use;
    const Estimate x = as_of(moment, x_);
    const Eigen::Vector3d& scaled = scaled_flow_.follow(flow_without_gust(x));
    const AirDataMeasurement then = measure_air(sample, x, scaled, noise);
    use = correct(Delayed<AirDataMeasurement>(then, delay(moment)), kAirspeed, false, frozen_);
  }
  learn_air(seconds(sample.time_us, air_us_));
  air_us_ = sample.time_us;
  follow_baro(sample);
  follow_transport();
  return use;
}

template <int N>
void StrapdownFilter<N>::follow_transport() {
  if (std::cos(place_.lat) <= kNearestPole) return;
  place_.transport_rate_N = earth::transport_rate_N(place_.lat, h_, x_.v_N());
}

/// A baro altitude that stays off is one on another scale, or the climb was wrong; either way how
/// it goes on tells the climb from here on.
template <int N>
void StrapdownFilter<N>::follow_baro(const samples::AirData& sample) {
  if ((used_ >> kBaro & 1) != 0) baro_used_us_ = sample.time_us;
  if (sample.time_us - baro_used_us_ <= kBaroPatience_us) return;
  Vector step = Vector::Zero();
  step(kHeight.offset) = innovation_[kBaro];
  step(kBaroHeight.offset) = innovation_[kBaro];
  fold_in(step);
  restart_heights(P_, parameters_, x_.air_velocity_N.norm());
  baro_used_us_ = sample.time_us;
}

/// One sensor alone that is far off is taken for a fault of that sensor, several for a gust.
template <int N>
void StrapdownFilter<N>::learn_air(double since_last) {
  constexpr double kLongest = 0.1;  // s
  constexpr std::array<Row, 3> kFlow = {kAirspeed, kAlpha, kBeta};
  int gated = 0;
  for (const Row row : kFlow) gated += rejected_ >> row & 1;
  std::array<double, kFlow.size()> normalised{};
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < kFlow.size(); ++i) {
    const Row row = kFlow[i];
    if (gated == 1 && (rejected_ >> row & 1) != 0) continue;
    normalised[i] = innovation_[row] / innovation_sigma_[row];
    sum += square(normalised[i]);
    ++count;
  }
  const double dt = std::clamp(since_last, 0.0, kLongest);
  gust_level_.learn(sum / count, dt);
  wind_level_.learn(normalised, dt);
}

template <int N>
void StrapdownFilter<N>::start_velocity(const samples::AirData& sample) {
  x_.air_velocity_N = x_.C_NB * air_velocity_B(sample);
  x_.gust_B.setZero();
  x_.height = sample.baro_altitude;
  x_.baro_height = sample.baro_altitude;
  restart_velocity(P_, parameters_, gust_level_.sigma(), sample.true_airspeed);
  air_us_ = sample.time_us;
  baro_used_us_ = sample.time_us;
  has_velocity_ = true;
  forget_history();
}

template <int N>
template <class Measurement>
samples::Use StrapdownFilter<N>::correct(const Measurement& m, Row first, bool together,
                                         int left_out) {
  constexpr int kM = Measurement::kRows;
  SparseUpdate<N, Measurement> update(P_, m);
  if (held_) update.expect(m, offset_);
  int passed = 0;
  for (int i = 0; i < kM; ++i) {
    const std::size_t row = static_cast<std::size_t>(first + i);
    innovation_[row] = update.innovation()(i);
    innovation_sigma_[row] = update.sigma(i);
    if (together || gate_.passes(update.normalised_square(i), 1)) passed |= 1 << i;
  }
  if (together && !gate_.passes(update.normalised_square(), kM)) passed = 0;
  passed &= ~left_out;
  const int all = (1 << kM) - 1;
  used_ |= passed << first;
  rejected_ |= (all & ~passed) << first;
  if (passed == 0) return samples::Use::kGated;
  for (int i = 0; i < kM; ++i) {
    if ((passed >> i & 1) == 0) update.exclude(i);
  }
  take(update.apply(P_));
  return samples::Use::kUsed;
}

template <int N>
void StrapdownFilter<N>::take(const Vector& correction) {
  if (held_) {
    offset_ += correction;
    settle();
  } else {
    fold_in(correction);
  }
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
