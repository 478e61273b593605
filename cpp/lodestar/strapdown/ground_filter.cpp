// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/wgs84.h"
#include "lodestar/strapdown/initial_covariance.h"
#include "lodestar/strapdown/velocity_filter.h"

// What only the filter with a ground does.

namespace lodestar::strapdown {
namespace {

constexpr std::int64_t kSilent_us = 1'000'000;  // of air data

}  // namespace

template <>
void GroundFilter::fly_over_ground(const Step& step, const ProcessNoise& noise) {
  x_.gps_error *= noise.gps_error_decay;
  x_.baro_bias *= noise.baro_bias_decay;
  x_.return_wind(noise.wind_return);
  travelled_ += move_over_ground(x_, best_velocity(step.air_velocity_N), step.dt);
  if (now_us_ - air_us_ > kSilent_us) follow_transport();  // else the air data do so
}

/// Position and wind go on as they were estimated, the position as well as it was known `before`.
template <>
void GroundFilter::restart_ground(const Estimate& best, const Matrix& before) {
  x_.lat = best.lat;
  x_.lon = best.lon;
  x_.wind_N = best.wind_N;
  x_.mean_wind_N = best.mean_wind_N;
  x_.baro_bias = best.baro_bias;
  start_ground(P_, ground_);
  constexpr int kP = kPosition.offset;
  P_.block<2, 2>(kP, kP) = before.block<2, 2>(kP, kP);
  // The slow error of GPS is part of it, and unknown again.
  const double slow = ground_.gps_error.sigma * ground_.gps_error.sigma;
  P_(kP, kP) += slow;
  P_(kP + 1, kP + 1) += slow;
}

template <>
void GroundFilter::set_ground_position(double lat, double lon, double sigma) {
  x_.lat = lat;
  x_.lon = lon;
  forget(P_, kPosition);
  auto diagonal = P_.diagonal();
  part<2>(diagonal, kPosition).setConstant(sigma * sigma);
}

template <>
void GroundFilter::start_over_ground(const Eigen::Vector3d& v_N, double height) {
  constexpr double kWide = 100.0;  // m/s, m
  Eigen::Vector3d air_velocity_N = v_N;
  air_velocity_N.head<2>() -= x_.wind_N;
  if (held_) air_velocity_N = turn_of(part<3>(offset_, kAttitude)).conjugate() * air_velocity_N;
  x_.air_velocity_N = air_velocity_N;
  x_.gust_B.setZero();
  x_.height = x_.baro_height = height - x_.baro_bias;
  for (const math::Block block : {kVelocity, kHeight, kBaroHeight, kGust}) forget(P_, block);
  auto diagonal = P_.diagonal();
  part<3>(diagonal, kVelocity).setConstant(kWide * kWide);
  part<3>(diagonal, kGust).setConstant(gust_level_.sigma() * gust_level_.sigma());
  diagonal(kHeight.offset) = diagonal(kBaroHeight.offset) = kWide * kWide;
  P_(kBaroHeight.offset, kHeight.offset) = kWide * kWide;  // one is the other
  follow_transport();
  has_velocity_ = true;
  forget_history();
}

template <>
std::optional<GroundPoint> GroundFilter::ground_at(std::int64_t time_us) const {
  Moment moment;
  if (!locate(time_us, moment)) return std::nullopt;
  GroundPoint point;
  const Eigen::Vector2d since = travelled_ - moment.travelled;
  point.position = earth::displaced({x_.lat, x_.lon, moment.height + x_.baro_bias},
                                    {-since.x(), -since.y(), 0.0});
  point.air_velocity_N = moment.air_velocity_N;
  point.v_N = best_velocity(moment.air_velocity_N).head<2>();
  point.delay = delay(moment);
  return point;
}

}  // namespace lodestar::strapdown
