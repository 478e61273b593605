// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/filter/joseph.h"
#include "lodestar/math/scalar.h"
#include "lodestar/sahrs/field_measurement.h"
#include "lodestar/sahrs/paper_sahrs.h"
#include "lodestar/sahrs/pitch_measurement.h"
#include "lodestar/sahrs/roll_measurement.h"

// What PaperSahrs makes of each sample that is not a body rate.

namespace lodestar::sahrs {
namespace {

using math::seconds;

constexpr double kShortestInterval = 1e-3;  // s, between samples or frames
constexpr double kNorthernmost = 89.9 * math::kDegree;
constexpr double kPatience = 10.0;              // s of a field that contradicts the heading
constexpr double kDoubt = 0.5 * math::kDegree;  // rad/s, by which its sigma grows after that
constexpr double kJump = 5.0 * math::kDegree;   // rad, a correction that users are told of

}  // namespace

samples::Use PaperSahrs::update(const samples::MagneticField& sample) {
  const Eigen::Vector3d b_B = calibration_.apply(sample.b_B);
  const double strength = (b_B - field_bias_B_).norm() / b_N_.norm();
  const bool strong_enough = holds(std::abs(strength - 1.0) <= parameters_.max_field_strength_error,
                                   Assumption::kFieldStrength);
  suspicion_.see(strong_enough, sample.time_us);
  if (!strong_enough) {
    attitude_.rejected |= 7 << kFieldNorth;
    return samples::Use::kAssumption;
  }
  const double dt = have_field_ ? seconds(sample.time_us - field_us_) : 0.0;
  b_B_ = b_B;
  field_us_ = sample.time_us;
  have_field_ = true;
  if (needs_alignment()) alignment_.observe_field(b_B_ - field_bias_B_, sample.time_us);
  try_alignment();
  Moment moment;
  if (!moment_at(sample.time_us, moment)) return samples::Use::kHeld;
  const Parameters& p = parameters_;
  const SlowNoise drift =
      SlowNoise::of(p.field_drift.sigma, p.field_drift.tau, interval(kFieldNorth, sample.time_us));
  Measurement<3> m =
      field_measurement({b_B_, field_bias_B_, moment.C_NB, b_N_}, p.field_noise, drift);
  const samples::Use use = correct(m, moment, kFieldNorth);
  if (use == samples::Use::kGated) doubt_heading(dt);
  return use;
}

// A field that contradicts the heading for a moment is a disturbance. If it goes on, either may be
// wrong, and in the long run there is no other reference: sigma grows until the field is believed.
void PaperSahrs::doubt_heading(double dt) {
  if (interval(kFieldNorth, field_us_) < kPatience) return;
  if (suspicion_.lasts(field_us_)) return;
  const Eigen::Vector3d down_B = C_NB_.row(2).transpose();
  const double sigma = std::sqrt(down_B.dot(P_.topLeftCorner<3, 3>() * down_B));
  P_.topLeftCorner<3, 3>() += (2.0 * sigma * kDoubt * dt) * (down_B * down_B.transpose());
}

samples::Use PaperSahrs::update(const samples::AirData& sample) {
  track_air_data(sample);
  try_alignment();
  Moment moment;
  if (!moment_at(sample.time_us, moment)) return samples::Use::kHeld;
  if (std::abs(lat_) < kNorthernmost) {  // at the poles north turns as fast as one likes
    transport_rate_N_ = earth::transport_rate_N(lat_, h_, moment.C_NB * v_air_B_);
  }
  return update_pitch(moment);
}

samples::Use PaperSahrs::update(const samples::LoadFactor& sample) {
  load_us_ = sample.time_us;
  have_load_ = true;
  if (needs_alignment() && have_air_ && sample.time_us - air_.time_us <= kFresh_us) {
    alignment_.observe_load(sample.n_B, v_air_B_, sample.time_us);
  }
  try_alignment();
  Moment moment;
  if (!moment_at(sample.time_us, moment)) return samples::Use::kHeld;
  climb_acceleration_ = samples::kStandardGravity * moment.C_NB.row(2).dot(sample.n_B) - gravity_;
  return update_roll(moment, sample);
}

void PaperSahrs::track_air_data(const samples::AirData& sample) {
  const double dt = have_air_ ? seconds(sample.time_us - air_.time_us) : 0.0;
  Pose pose;  // stays at the start of the integral if the history does not reach back
  const bool located = history_.at(sample.time_us, pose);
  if (dt > 0.0 && dt <= kLongestBridge) {
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
  const double cos_beta = std::cos(sample.beta);
  v_air_B_ = sample.true_airspeed * Eigen::Vector3d(std::cos(sample.alpha) * cos_beta,
                                                    std::sin(sample.beta),
                                                    std::sin(sample.alpha) * cos_beta);
  air_ = sample;
  have_air_ = true;
  live_flow_ = frozen_flow_.see(sample) == 0;
  if (located) air_climb_integral_ = pose.climb_integral;
}

samples::Use PaperSahrs::update_pitch(const Moment& moment) {
  const Parameters& p = parameters_;
  const PitchInput in{v_air_B_, climb_.rate(), Tilt(moment.C_NB)};
  const double V = air_.true_airspeed;
  const double fastest_climb = 0.9 * pitch_plane_airspeed(in);
  const bool valid =
      holds(V >= p.min_airspeed, Assumption::kAirspeed) &&
      holds(live_flow_, Assumption::kLiveFlow) &&
      holds(climb_.settled() && std::abs(in.climb_rate) < fastest_climb, Assumption::kClimbRate) &&
      holds(std::abs(air_.beta) <= p.max_sideslip, Assumption::kSideslip) &&
      holds(in.tilt.cos_pitch >= min_cos_pitch_, Assumption::kPitchAngle);
  if (!valid) return reject(kPitch);
  const double dt = interval(kPitch, moment.pose.time_us);
  const SlowNoise climb_rate =
      SlowNoise::of(p.climb_rate_sigma, 1.0 / p.climb_filter_bandwidth, dt) +
      SlowNoise::of(p.vertical_wind_sigma, p.vertical_wind_length / V, dt);
  Measurement<1> m = pitch_measurement(in, p.alpha_noise, climb_rate);
  return correct(m, moment, kPitch);
}

samples::Use PaperSahrs::update_roll(const Moment& moment, const samples::LoadFactor& sample) {
  const Parameters& p = parameters_;
  const RollInput in{moment.pose.omega_B - gyro_bias_B_, samples::kStandardGravity * sample.n_B.z(),
                     v_air_B_, Tilt(moment.C_NB)};
  const double V = air_.true_airspeed;
  const double flow_rate = V * std::max(std::abs(alpha_.rate()), std::abs(beta_.rate()));
  const double size = balance(in).size() / (gravity_ * in.tilt.cos_pitch);
  const bool valid =
      holds(have_air_ && sample.time_us - air_.time_us <= kFresh_us && V >= p.min_airspeed,
            Assumption::kAirspeed) &&
      holds(live_flow_, Assumption::kLiveFlow) &&
      holds(std::abs(airspeed_.rate()) <= p.max_speed_rate && flow_rate <= p.max_flow_rate,
            Assumption::kSteadyVelocity) &&
      holds(std::abs(air_.beta) <= p.max_sideslip, Assumption::kSideslip) &&
      holds(std::abs(sample.n_B.y()) <= p.max_lateral_load, Assumption::kLateralLoad) &&
      holds(in.omega_B.norm() <= p.max_body_rate, Assumption::kBodyRate) &&
      holds(in.tilt.cos_pitch >= min_cos_pitch_, Assumption::kPitchAngle) &&
      holds(std::abs(size - 1.0) <= p.max_imbalance, Assumption::kBalance);
  if (!valid) return reject(kRoll);
  const SlowNoise neglected = SlowNoise::of(p.neglected_force.sigma, p.neglected_force.tau,
                                            interval(kRoll, sample.time_us));
  const double rate_noise = p.gyro_noise / std::sqrt(std::max(kShortestInterval, frame_interval_));
  Measurement<1> m = roll_measurement(in, {rate_noise, p.load_noise}, neglected);
  return correct(m, moment, kRoll);
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
  return std::max(kShortestInterval, seconds(time_us - used_us_[static_cast<std::size_t>(row)]));
}

bool PaperSahrs::moment_at(std::int64_t time_us, Moment& moment) const {
  if (state_ != State::kRunning || !history_.at(time_us, moment.pose)) return false;
  moment.C_NB = time_us == now_us_ ? C_NB_ : (q_NS_ * moment.pose.q_SB).toRotationMatrix();
  return true;
}

template <int M>
samples::Use PaperSahrs::correct(Measurement<M>& m, const Moment& moment, Row first) {
  if (moment.pose.time_us != now_us_) {
    // phi(then) = C_then' C_now phi(now) + (mean of C_then' C over the time between) b_g dt.
    const Eigen::Matrix3d turn = moment.C_NB.transpose() * C_NB_;
    const double dt = seconds(now_us_ - moment.pose.time_us);
    const Eigen::Matrix<double, M, 3> then = m.H.template middleCols<3>(kAttitude.offset);
    m.H.template middleCols<3>(kAttitude.offset) = then * turn;
    m.H.template middleCols<3>(kGyroBias.offset) +=
        (0.5 * dt) * (then * (Eigen::Matrix3d::Identity() + turn));
  }
  const Eigen::Matrix<double, M, M> excess = m.excess * Eigen::Matrix<double, M, M>::Identity();
  const filter::JosephUpdate<kStates, M> update(P_, m.H, m.R + excess);
  const Eigen::Matrix<double, M, M> S = update.S() - excess;  // of this sample by itself
  for (int i = 0; i < M; ++i) {
    const std::size_t row = static_cast<std::size_t>(first + i);
    innovation_[row] = m.innovation(i);
    innovation_sigma_[row] = std::sqrt(S(i, i));
  }
  const int bits = ((1 << M) - 1) << first;
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
  ErrorModel::fold_in(P_, turn_B);
  if (turn_B.norm() > kJump) count_reset(turn_B);
}

}  // namespace lodestar::sahrs
