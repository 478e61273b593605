// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/scalar.h"
#include "lodestar/strapdown/air_data_aid.h"
#include "lodestar/strapdown/initial_covariance.h"
#include "lodestar/strapdown/magnetic_aid.h"
#include "lodestar/strapdown/sparse_update.h"
#include "lodestar/strapdown/velocity_filter.h"

// What the filter makes of each sample that is not a body rate.

namespace lodestar::strapdown {
namespace {

using math::seconds;
using math::square;

constexpr std::int64_t kBaroPatience_us = 2'000'000;
constexpr double kNearestPole = 1e-3;  // cos(latitude), for the transport rate

}  // namespace

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
  const double dt = seconds(sample.time_us - load_us_);
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
  learn_air(seconds(sample.time_us - air_us_));
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
  const bool still = kOverGround<N> && still_air_.still();
  gust_level_.learn(sum / count, dt, still);
  wind_level_.learn(normalised, dt, still);
  if constexpr (kOverGround<N>) {
    still_air_.see_air(gust_level_.sigma(), wind_level_.step(), gps_lost_, dt);
    wind_level_.raise(still_air_.least_walk());
  }
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

template class StrapdownFilter<kStates>;
template class StrapdownFilter<kGroundStates>;

}  // namespace lodestar::strapdown
