// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/paper_sahrs.h"

#include <algorithm>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/filter/joseph.h"
#include "lodestar/sahrs/alignment.h"
#include "lodestar/sahrs/field_measurement.h"
#include "lodestar/sahrs/pitch_measurement.h"
#include "lodestar/sahrs/roll_measurement.h"

namespace lodestar::sahrs {
namespace {

constexpr double kMicrosecond = 1e-6;             // s
constexpr double kLongestBridge = 0.5;            // s without body rates that are bridged
constexpr double kLongestFrame = 0.05;            // s; a longer frame has lost samples
constexpr std::int64_t kFresh_us = 200'000;       // a sample this old still speaks of now
constexpr std::int64_t kCoasting_us = 2'000'000;  // without any measurement: coasting
constexpr double kFlowBandwidth = 2.0;            // rad/s, of the rates of V, alpha and beta
constexpr double kReset = 1e-3;                   // rad; below, the reset term is rounding

double seconds(std::int64_t later_us, std::int64_t earlier_us) {
  return kMicrosecond * static_cast<double>(later_us - earlier_us);
}

double square(double x) { return x * x; }

}  // namespace

PaperSahrs::PaperSahrs(const Parameters& parameters, const FieldCalibration& calibration,
                       earth::GeomagneticKind field_model, double epoch_year)
    : parameters_(parameters),
      calibration_(calibration),
      epoch_year_(epoch_year),
      field_model_(field_model),
      gate_(parameters.false_rejection),
      error_model_(parameters),
      P_(error_model_.initial(Eigen::Vector3d::Constant(math::kPi))),
      climb_(parameters.climb_filter_bandwidth, parameters.baro_lag),
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
  set_attitude(attitude, sigma_B);
}

void PaperSahrs::propagate(const samples::BodyRates& sample) {
  attitude_.used = 0;
  attitude_.rejected = 0;
  const bool first = !have_rates_;
  const double dt = seconds(sample.time_us, now_us_);
  const Eigen::Vector3d mean_omega_B = first ? sample.omega_B : 0.5 * (omega_B_ + sample.omega_B);
  have_rates_ = true;
  now_us_ = sample.time_us;
  omega_B_ = sample.omega_B;
  if (state_ != State::kRunning || !(dt > 0.0)) return;
  if (dt > kLongestBridge) {
    state_ = State::kRealigning;
    return;
  }
  integrate(mean_omega_B, dt);
}

void PaperSahrs::integrate(const Eigen::Vector3d& mean_omega_B, double dt) {
  const Eigen::Vector3d omega_IB_B = mean_omega_B - gyro_bias_B_;
  const Eigen::Vector3d omega_IN_B = C_NB_.transpose() * (earth_rate_N_ + transport_rate_N_);
  Pose pose;
  pose.time_us = now_us_;
  pose.q_SB =
      (history_.newest().q_SB * math::exp_quaternion(dt * (omega_IB_B - omega_IN_B))).normalized();
  pose.omega_B = omega_B_;
  pose.climb_integral = history_.newest().climb_integral + dt * vertical_acceleration();
  history_.push(pose);
  C_NB_ = (q_NS_ * pose.q_SB).toRotationMatrix();
  error_model_.propagate(P_, omega_IB_B, b_B_, dt);
  if (dt > kLongestFrame) {
    // Between two known ends the rate did what it liked: the integral of a Brownian bridge.
    P_.diagonal().head<3>().array() += square(parameters_.gyro_gap_noise) * dt * dt * dt / 12.0;
  }
  frame_interval_ = dt;
}

double PaperSahrs::vertical_acceleration() const {
  if (!have_load_ || !fresh(load_.time_us, now_us_)) return 0.0;
  return samples::kStandardGravity * C_NB_.row(2).dot(load_.n_B) - gravity_;
}

bool PaperSahrs::fresh(std::int64_t sample_us, std::int64_t time_us) const {
  return time_us - sample_us <= kFresh_us;
}

bool PaperSahrs::moment_at(std::int64_t time_us, Moment& moment) const {
  if (state_ != State::kRunning || !history_.at(time_us, moment.pose)) return false;
  moment.C_NB = time_us == now_us_ ? C_NB_ : (q_NS_ * moment.pose.q_SB).toRotationMatrix();
  return true;
}

samples::Use PaperSahrs::update(const samples::MagneticField& sample) {
  b_B_ = calibration_.matrix * sample.b_B + calibration_.bias;
  field_us_ = sample.time_us;
  have_field_ = true;
  try_alignment();
  Moment moment;
  if (!moment_at(sample.time_us, moment)) return samples::Use::kHeld;
  const Parameters& p = parameters_;
  const SlowNoise drift =
      SlowNoise::of(p.field_drift.sigma, p.field_drift.tau, interval(kFieldNorth, sample.time_us));
  Measurement<3> m =
      field_measurement({b_B_, field_bias_B_, moment.C_NB, b_N_}, p.field_noise, drift);
  return correct(m, moment, kFieldNorth);
}

samples::Use PaperSahrs::update(const samples::AirData& sample) {
  track_air_data(sample);
  try_alignment();
  Moment moment;
  if (!moment_at(sample.time_us, moment)) return samples::Use::kHeld;
  if (std::cos(lat_) > 1e-3) {
    transport_rate_N_ = earth::transport_rate_N(lat_, h_, moment.C_NB * v_air_B_);
  }
  return update_pitch(moment);
}

samples::Use PaperSahrs::update(const samples::LoadFactor& sample) {
  load_ = sample;
  have_load_ = true;
  try_alignment();
  Moment moment;
  if (!moment_at(sample.time_us, moment)) return samples::Use::kHeld;
  return update_roll(moment, sample);
}

void PaperSahrs::track_air_data(const samples::AirData& sample) {
  const double dt = have_air_ ? seconds(sample.time_us, air_.time_us) : 0.0;
  Pose pose;
  const bool located = history_.at(sample.time_us, pose);
  if (have_air_ && dt > 0.0 && dt <= kLongestBridge) {
    climb_.update(sample.baro_altitude, dt,
                  located ? pose.climb_integral - air_climb_integral_ : 0.0);
    airspeed_.update(sample.true_airspeed, dt);
    alpha_.update(sample.alpha, dt);
    beta_.update(sample.beta, dt);
  } else {
    climb_.restart(sample.baro_altitude);
    airspeed_.restart(sample.true_airspeed);
    alpha_.restart(sample.alpha);
    beta_.restart(sample.beta);
  }
  air_ = sample;
  v_air_B_ = sample.true_airspeed * Eigen::Vector3d(std::cos(sample.alpha) * std::cos(sample.beta),
                                                    std::sin(sample.beta),
                                                    std::sin(sample.alpha) * std::cos(sample.beta));
  air_climb_integral_ = pose.climb_integral;
  have_air_ = true;
}

void PaperSahrs::try_alignment() {
  if (state_ == State::kRunning || !have_rates_ || !have_load_ || !have_air_ || !have_field_)
    return;
  if (!fresh(load_.time_us, now_us_) || !fresh(air_.time_us, now_us_) ||
      !fresh(field_us_, now_us_) || air_.true_airspeed < parameters_.min_airspeed) {
    return;
  }
  const Eigen::Vector3d sigma_B = math::kDegree * Eigen::Vector3d(5.0, 5.0, 15.0);
  const std::optional<math::Euler> aligned =
      align({omega_B_ - gyro_bias_B_, load_.n_B, v_air_B_, b_B_ - field_bias_B_, b_N_, gravity_},
            parameters_.max_imbalance);
  if (!aligned) return;
  const bool again = state_ == State::kRealigning;
  const Eigen::Matrix3d before = C_NB_;
  set_attitude(*aligned, sigma_B);
  if (again) {
    ++attitude_.reset_count;
    attitude_.reset_delta_B = math::log_quaternion(Eigen::Quaterniond(before.transpose() * C_NB_));
  }
}

void PaperSahrs::set_attitude(const math::Euler& attitude, const Eigen::Vector3d& sigma_B) {
  C_NB_ = math::C_NB_from_euler(attitude);
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
}

bool PaperSahrs::holds(bool assumption, Assumption which) {
  if (!assumption) ++assumption_rejects_[static_cast<std::size_t>(which)];
  return assumption;
}

samples::Use PaperSahrs::reject(Row row) {
  attitude_.rejected |= 1 << row;
  return samples::Use::kAssumption;
}

double PaperSahrs::interval(Row row, std::int64_t time_us) const {
  return std::max(1e-3, seconds(time_us, used_us_[static_cast<std::size_t>(row)]));
}

samples::Use PaperSahrs::update_pitch(const Moment& moment) {
  const Parameters& p = parameters_;
  const PitchInput in{air_.true_airspeed, air_.alpha, air_.beta, climb_.rate(), Tilt(moment.C_NB)};
  const double fastest_climb = 0.9 * in.true_airspeed * std::cos(in.beta);
  const bool valid =
      holds(in.true_airspeed >= p.min_airspeed, Assumption::kAirspeed) &&
      holds(climb_.settled() && std::abs(in.climb_rate) < fastest_climb, Assumption::kClimbRate) &&
      holds(std::abs(in.beta) <= p.max_sideslip, Assumption::kSideslip) &&
      holds(in.tilt.cos_pitch >= std::cos(p.max_pitch), Assumption::kPitchAngle);
  if (!valid) return reject(kPitch);
  const double dt = interval(kPitch, moment.pose.time_us);
  const SlowNoise climb_rate =
      SlowNoise::of(p.climb_rate_sigma, 1.0 / p.climb_filter_bandwidth, dt) +
      SlowNoise::of(p.vertical_wind_sigma, p.vertical_wind_length / in.true_airspeed, dt);
  Measurement<1> m = pitch_measurement(in, p.alpha_noise, climb_rate);
  return correct(m, moment, kPitch);
}

samples::Use PaperSahrs::update_roll(const Moment& moment, const samples::LoadFactor& sample) {
  const Parameters& p = parameters_;
  const double g = gravity_;
  const RollInput in{moment.pose.omega_B - gyro_bias_B_, samples::kStandardGravity * sample.n_B.z(),
                     v_air_B_, Tilt(moment.C_NB)};
  const double V = air_.true_airspeed;
  const double unsteady = V * std::max(std::abs(alpha_.rate()), std::abs(beta_.rate()));
  const double imbalance = balance(in).size() / g - in.tilt.cos_pitch;
  const bool valid =
      holds(have_air_ && fresh(air_.time_us, sample.time_us) && V >= p.min_airspeed,
            Assumption::kAirspeed) &&
      holds(std::abs(airspeed_.rate()) <= p.max_speed_rate && unsteady <= p.max_flow_rate,
            Assumption::kSteadyVelocity) &&
      holds(std::abs(air_.beta) <= p.max_sideslip, Assumption::kSideslip) &&
      holds(std::abs(sample.n_B.y()) <= p.max_lateral_load, Assumption::kLateralLoad) &&
      holds(in.omega_B.norm() <= p.max_body_rate, Assumption::kBodyRate) &&
      holds(in.tilt.cos_pitch >= std::cos(p.max_pitch), Assumption::kPitchAngle) &&
      holds(std::abs(imbalance) <= p.max_imbalance, Assumption::kBalance);
  if (!valid) return reject(kRoll);
  const SlowNoise neglected = SlowNoise::of(p.neglected_force.sigma, p.neglected_force.tau,
                                            interval(kRoll, sample.time_us));
  const double rate_noise = p.gyro_noise / std::sqrt(std::max(1e-3, frame_interval_));
  Measurement<1> m = roll_measurement(in, {rate_noise, p.load_noise}, neglected);
  return correct(m, moment, kRoll);
}

template <int M>
samples::Use PaperSahrs::correct(Measurement<M>& m, const Moment& moment, Row first) {
  if (moment.pose.time_us != now_us_) {
    // phi(then) = C_then' C_now phi(now) + (mean of C over the time between) b_g dt.
    const Eigen::Matrix3d turn = moment.C_NB.transpose() * C_NB_;
    const double dt = seconds(now_us_, moment.pose.time_us);
    const Eigen::Matrix<double, M, 3> then = m.H.template middleCols<3>(kAttitude.offset);
    m.H.template middleCols<3>(kAttitude.offset) = then * turn;
    m.H.template middleCols<3>(kGyroBias.offset) +=
        (0.5 * dt) * (then * (Eigen::Matrix3d::Identity() + turn));
  }
  const Eigen::Matrix<double, M, M> excess = m.excess * Eigen::Matrix<double, M, M>::Identity();
  const filter::JosephUpdate<kStates, M> update(P_, m.H, m.R + excess);
  const Eigen::Matrix<double, M, M> S = update.S() - excess;  // of this sample by itself
  const int bits = ((1 << M) - 1) << first;
  for (int i = 0; i < M; ++i) {
    const std::size_t row = static_cast<std::size_t>(first + i);
    innovation_[row] = m.innovation(i);
    innovation_sigma_[row] = std::sqrt(S(i, i));
  }
  if (!gate_.passes(m.innovation.dot(S.inverse() * m.innovation), M)) {
    attitude_.rejected |= bits;
    return samples::Use::kGated;
  }
  fold_in(update.template apply<kEstimated>(P_, m.innovation));
  attitude_.used |= bits;
  used_us_[static_cast<std::size_t>(first)] = moment.pose.time_us;
  last_used_us_ = std::max(last_used_us_, moment.pose.time_us);
  return samples::Use::kUsed;
}

void PaperSahrs::fold_in(const Eigen::Matrix<double, kEstimated, 1>& correction) {
  const Eigen::Vector3d turn_B = correction.segment<kAttitude.size>(kAttitude.offset);
  const Eigen::Vector3d turn_N = C_NB_ * turn_B;
  q_NS_ = (math::exp_quaternion(turn_N) * q_NS_).normalized();
  C_NB_ = (q_NS_ * history_.newest().q_SB).toRotationMatrix();
  gyro_bias_B_ += correction.segment<kGyroBias.size>(kGyroBias.offset);
  field_bias_B_ += correction.segment<kFieldBias.size>(kFieldBias.offset);
  if (turn_B.squaredNorm() > kReset * kReset) {
    // The error is now counted from the new attitude: exp(-turn) exp(turn + e) = exp(G e).
    const Eigen::Matrix3d G = Eigen::Matrix3d::Identity() - 0.5 * math::skew(turn_B);
    P_.topRows<3>() = (G * P_.topRows<3>()).eval();
    P_.leftCols<3>() = (P_.leftCols<3>() * G.transpose()).eval();
  }
}

void PaperSahrs::finish_frame() {
  attitude_.time_us = now_us_;
  attitude_.q_NB = q_NS_ * history_.newest().q_SB;
  const math::Euler euler = math::euler_from_C_NB(C_NB_);
  attitude_.roll = euler.roll;
  attitude_.pitch = euler.pitch;
  attitude_.heading = euler.heading;
  attitude_.P_B = P_.topLeftCorner<3, 3>();
  attitude_.omega_B = omega_B_ - gyro_bias_B_;
  attitude_.gyro_bias_B = gyro_bias_B_;
  attitude_.field_bias_B = field_bias_B_;
  const Eigen::Vector3d variance_N = (C_NB_ * attitude_.P_B * C_NB_.transpose()).diagonal();
  const bool certain =
      std::max(variance_N.x(), variance_N.y()) <= square(parameters_.max_valid_tilt_sigma) &&
      variance_N.z() <= square(parameters_.max_valid_heading_sigma);
  attitude_.valid = state_ == State::kRunning && certain;
  if (state_ == State::kWaiting) {
    attitude_.mode = samples::AttitudeMode::kWaiting;
  } else if (state_ == State::kRealigning) {
    attitude_.mode = samples::AttitudeMode::kRealigning;
  } else if (now_us_ - last_used_us_ > kCoasting_us) {
    attitude_.mode = samples::AttitudeMode::kCoasting;
  } else {
    attitude_.mode = certain ? samples::AttitudeMode::kRunning : samples::AttitudeMode::kAligning;
  }
}

}  // namespace lodestar::sahrs
