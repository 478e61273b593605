// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/guarded_filter.h"

#include <algorithm>
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/scalar.h"

namespace lodestar::strapdown {
namespace {

using math::seconds;
using math::square;

constexpr double kLongestBridge = 0.5;             // s without body rates that are bridged
constexpr double kLongestFrame = 0.05;             // s; a longer frame has lost samples
constexpr std::int64_t kPatience_us = 10'000'000;  // with a field that is not believed
constexpr double kDoubt = 0.5 * math::kDegree;     // rad/s that sigma then grows by
constexpr double kLost = 30.0 * math::kDegree;     // sigma beyond which linear filtering ends
constexpr double kCoarse = 2.0 * math::kDegree;    // heading worse than this is refined
constexpr double kFine = 1.0 * math::kDegree;      // until it is as good as that
constexpr std::int64_t kLongestHold_us = 150'000'000;
constexpr double kAgain = 1.5;  // of sigma, to start again with

Parameters with_airspeed(Parameters parameters, double min_airspeed) {
  parameters.min_airspeed = min_airspeed;
  return parameters;
}

}  // namespace

template <int N>
GuardedFilter<N>::GuardedFilter(const Parameters& parameters, const GuardLimits& limits,
                                earth::GeomagneticKind field_model, double epoch_year,
                                const GroundParameters& ground)
    : limits_(limits),
      epoch_year_(epoch_year),
      field_model_(field_model),
      filter_(with_airspeed(parameters, limits.min_airspeed), ground) {}

template <int N>
void GuardedFilter<N>::set_position(double lat, double lon, double h) {
  b_N_ = field_model_.field_N(lat, lon, h, epoch_year_);
  gravity_ = earth::gravity(lat, h);
  filter_.set_place(lat, h, b_N_);
}

template <int N>
void GuardedFilter<N>::begin(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B,
                             std::int64_t time_us) {
  filter_.start(C_NB, sigma_B, time_us);
  coarse_ = sigma_B.maxCoeff() > kCoarse;
  if (coarse_) filter_.hold_linearisation();
  now_us_ = begun_us_ = last_used_us_ = field_used_us_ = time_us;
  running_ = true;
  lost_ = lost_tilt_ = false;
}

template <int N>
bool GuardedFilter<N>::propagate(const samples::BodyRates& sample) {
  const double dt = have_rates_ ? seconds(sample.time_us - now_us_) : 0.0;
  have_rates_ = true;
  now_us_ = sample.time_us;
  field_refused_ = false;
  if (running_ && dt > kLongestBridge) {
    running_ = false;
    return false;
  }
  if (!running_) return true;
  // Between two known ends the rate did what it liked: the integral of a Brownian bridge.
  const double bridged =
      dt > kLongestFrame ? square(limits_.gyro_gap_noise) * dt * dt * dt / 12.0 : 0.0;
  filter_.propagate(sample, bridged + saturated_rates_.see(sample.omega_B, dt));
  if (coarse_) refine_start();
  return true;
}

// What the sensors seemed to err by while the attitude was off by degrees is not to be trusted, and
// less so its sigma: only the attitude is kept.
template <int N>
void GuardedFilter<N>::refine_start() {
  const bool fine = filter_.attitude_variance_N().z() < square(kFine);
  if (!fine && now_us_ - begun_us_ <= kLongestHold_us) return;
  const Eigen::Vector3d variance_B = filter_.attitude_covariance_B().diagonal();
  filter_.start_again(kAgain * variance_B.cwiseSqrt());
  begun_us_ = now_us_;
  coarse_ = !fine;
  if (coarse_) filter_.hold_linearisation();
}

template <int N>
samples::Use GuardedFilter<N>::update(const samples::LoadFactor& sample) {
  return running_ ? filter_.update(sample) : samples::Use::kHeld;
}

// A field of another strength is that of something near the detector. It neither turns the attitude
// nor speaks against it, and for a while no more does one of the right strength that the gate keeps
// out: what is fixed to the aircraft adds to the field at one heading and takes from it at another.
template <int N>
bool GuardedFilter<N>::vet(const samples::MagneticField& sample) {
  const Estimate x = filter_.estimate();
  const double strength = (sample.b_B - x.field_bias_B - x.field_drift_B).norm();
  const bool strong = std::abs(strength / b_N_.norm() - 1.0) <= limits_.max_field_strength_error;
  suspicion_.see(strong, sample.time_us);
  if (!strong) field_refused_ = true;
  return strong;
}

template <int N>
samples::Use GuardedFilter<N>::update(const samples::MagneticField& sample) {
  const std::int64_t before_us = field_us_;
  field_us_ = sample.time_us;
  if (!running_ || lost_) return samples::Use::kHeld;
  const samples::Use use = filter_.update(sample);
  note(use, sample.time_us);
  if (use == samples::Use::kUsed) field_used_us_ = sample.time_us;
  if (use == samples::Use::kGated) doubt_heading(before_us);
  return use;
}

// A field that contradicts the heading for a moment is a disturbance. If it goes on, either may be
// wrong, and in the long run there is no other reference: sigma grows until the field is believed.
template <int N>
void GuardedFilter<N>::doubt_heading(std::int64_t before_us) {
  if (field_us_ - field_used_us_ < kPatience_us) return;
  if (suspicion_.lasts(field_us_)) return;
  const double sigma = std::sqrt(filter_.attitude_variance_N().z());
  filter_.doubt_heading(2.0 * sigma * kDoubt * std::min(seconds(field_us_ - before_us), 1.0));
}

template <int N>
samples::Use GuardedFilter<N>::update(const samples::AirData& sample) {
  if (!running_ || lost_tilt_) return samples::Use::kHeld;
  const samples::Use use = filter_.update(sample);
  note(use, sample.time_us);
  return use;
}

template <int N>
void GuardedFilter<N>::note(samples::Use use, std::int64_t time_us) {
  if (use == samples::Use::kUsed) last_used_us_ = std::max(last_used_us_, time_us);
}

template <int N>
void GuardedFilter<N>::finish_frame() {
  const Eigen::Vector3d variance_N = filter_.attitude_variance_N();
  lost_tilt_ = std::max(variance_N.x(), variance_N.y()) > square(kLost);
  lost_ = lost_tilt_ || variance_N.z() > square(kLost);
}

template <int N>
int GuardedFilter<N>::rejected() const {
  constexpr int kField = 7 << StrapdownFilter<N>::kFieldX;
  return filter_.rejected() | (field_refused_ ? kField : 0);
}

template class GuardedFilter<kStates>;
template class GuardedFilter<kGroundStates>;

}  // namespace lodestar::strapdown
