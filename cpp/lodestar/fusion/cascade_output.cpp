// SPDX-License-Identifier: Apache-2.0
// What a Cascade publishes.
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/fusion/cascade.h"
#include "lodestar/fusion/uncertainty.h"

namespace lodestar::fusion {

using samples::FusionMode;

void Cascade::refresh_status() {
  if (reacquisition_.stale(navigation_.time_us)) reacquisition_.cancel();
  navigation_.mode = mode();
  navigation_.gps_age = ever_aided_ ? seconds(navigation_.time_us - aided_us_) : -1.0;
  navigation_.valid = started();
}

void Cascade::refresh() {
  refresh_status();
  if (!started()) return;

  const TrackPoint& now = dead_reckoning_.point();
  const StateVector& x = steps_.back().estimate.x;
  math::Euler attitude = corrected_attitude(parameters_.attitude_error, now, x);
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(attitude);
  if (std::abs(attitude.pitch) > 0.5 * math::kPi) attitude = math::euler_from_C_NB(C_NB);
  navigation_.roll = math::wrap_pi(attitude.roll);
  navigation_.pitch = attitude.pitch;
  navigation_.heading = math::wrap_2pi(attitude.heading);

  const Eigen::Vector2d wind = x.segment<2>(kWind.offset);
  navigation_.wind_N << wind, 0.0;
  navigation_.gps_error = x.segment<2>(kGpsError.offset);
  navigation_.v_N.head<2>() = (C_NB * now.v_air_B).head<2>() + wind;
  navigation_.v_N.z() = now.v_air_N.z() - vertical_.climb_correction();

  const double since_step = seconds(now.time_us - steps_.back().point.time_us);
  const Eigen::Vector2d error =
      x.segment<2>(kPositionError.offset) + since_step * (navigation_.v_N - now.v_air_N).head<2>();
  const earth::Geodetic here = earth::displaced(now.position(), {error.x(), error.y(), 0.0});
  navigation_.lat = here.lat;
  navigation_.lon = math::wrap_pi(here.lon);
  navigation_.h = now.h + vertical_.bias();
}

/// Once per step: sigma hardly changes within one.
void Cascade::refresh_sigma() {
  const Step& last = steps_.back();
  state_sigma(parameters_, last.point, last.estimate, last.conditions, gust_meter_.variance(),
              navigation_);
  const double alpha_velocity = air_.true_airspeed * parameters_.alpha_noise;
  navigation_.sigma_velocity.z() = std::sqrt(
      vertical_.climb_variance() + alpha_velocity * alpha_velocity + gust_meter_.variance());
  navigation_.sigma_position.z() = vertical_.sigma_height();
}

FusionMode Cascade::mode() const {
  if (!started()) return FusionMode::kWaiting;
  if (fresh(navigation_.time_us)) return FusionMode::kAiding;
  return reacquisition_.running() ? FusionMode::kReacquiring : FusionMode::kDeadReckoning;
}

}  // namespace lodestar::fusion
