// SPDX-License-Identifier: Apache-2.0
// How the filter of a Cascade starts, and what is known of the heading before it does.
#include <cmath>

#include "lodestar/earth/wgs84.h"
#include "lodestar/fusion/cascade.h"
#include "lodestar/fusion/uncertainty.h"

namespace lodestar::fusion {

void Cascade::start_at_fix(const samples::GpsFix& fix, const TrackPoint& at) {
  const TrackPoint& now = dead_reckoning_.point();
  const Eigen::Vector3d flown_N = earth::displacement_N(at.position(), now.position());
  const earth::Geodetic here = earth::displaced({fix.lat, fix.lon, at.h}, flown_N);
  const double age = seconds(now.time_us - at.time_us);
  // The fix's slow error is now the position's, with the opposite sign.
  const double slow = parameters_.gps_error.sigma * parameters_.gps_error.sigma;
  const double noise = fix_noise_.variance(fix.sigma_horizontal);
  const double drift = parameters_.wind.sigma * age;
  ErrorEstimate estimate = initial_estimate(slow + noise + drift * drift, -slow);
  note_aided(fix, at);
  start(here.lat, here.lon, estimate);
}

void Cascade::start_where_configured() {
  if (!parameters_.initial_lat || !parameters_.initial_lon) return;
  const double sigma = parameters_.initial_position_sigma;
  start(*parameters_.initial_lat, *parameters_.initial_lon, initial_estimate(sigma * sigma, 0.0));
}

void Cascade::start(double lat, double lon, const ErrorEstimate& estimate) {
  dead_reckoning_.set_position(lat, lon);
  steps_.clear();
  track_.clear();
  track_.push(dead_reckoning_.point());
  steps_.push({dead_reckoning_.point(), conditions(), estimate});
  refresh_sigma();
  refresh();
}

/// Remembers by how much SAHRS differs from the configured heading; the filter starts later.
void Cascade::note_initial_heading() {
  if (!parameters_.use_initial_heading || !parameters_.initial_heading) return;
  if (heading_reference_) return;
  heading_reference_ =
      HeadingReference{sahrs_.time_us, math::wrap_pi(*parameters_.initial_heading - sahrs_.heading),
                       parameters_.initial_heading_sigma};
}

void Cascade::know_heading_error(double error, double sigma, std::int64_t time_us) {
  heading_reference_ = HeadingReference{time_us, error, sigma};
  heading_news_ = started();
}

/// The heading error that was known, as far as it still is.
KnownAngle Cascade::heading_error_now() const {
  const double level = std::hypot(std::sqrt(angle_variance(parameters_, sahrs_)(0)),
                                  parameters_.heading_deviation.sigma);
  const math::GaussMarkov model{level, parameters_.heading_error.tau};
  const double dt = seconds(sahrs_.time_us - heading_reference_->time_us);
  const double sigma = heading_reference_->sigma * model.decay(dt);
  return {heading_reference_->error * model.decay(dt), sigma * sigma + model.added_variance(dt)};
}

ErrorEstimate Cascade::initial_estimate(double position_variance, double gps_covariance) const {
  StateVector x = StateVector::Zero();
  StateMatrix P = StateMatrix::Zero();
  const double gps_variance = parameters_.gps_error.sigma * parameters_.gps_error.sigma;
  const double wind_variance = parameters_.wind.sigma * parameters_.wind.sigma;
  P.diagonal().segment<2>(kPositionError.offset).setConstant(position_variance);
  P.diagonal().segment<2>(kGpsError.offset).setConstant(gps_variance);
  P.diagonal().segment<2>(kWind.offset).setConstant(wind_variance);
  P.block<3, 3>(kHeadingError.offset, kHeadingError.offset) = angle_covariance(
      parameters_.attitude_error, sahrs_.heading, angle_variance(parameters_, sahrs_));
  const double deviation_variance = std::pow(parameters_.heading_deviation.sigma, 2);
  P.diagonal().segment<2>(kDeviation.offset).setConstant(deviation_variance);
  for (int axis = 0; axis < 2; ++axis) {
    const int position = kPositionError.offset + axis;
    const int gps = kGpsError.offset + axis;
    P(position, gps) = P(gps, position) = gps_covariance;
  }
  if (heading_reference_) {
    const KnownAngle known = heading_error_now();
    x(kHeadingError.offset) = known.error;
    // The sum of heading error and deviation is known; each is as unknown as the deviation.
    P(kHeadingError.offset, kHeadingError.offset) = known.variance + deviation_variance;
    const Eigen::RowVector2d shared = -deviation_variance * deviation(sahrs_.heading);
    P.block<1, 2>(kHeadingError.offset, kDeviation.offset) = shared;
    P.block<2, 1>(kDeviation.offset, kHeadingError.offset) = shared.transpose();
  }
  return {x, ErrorCovariance(parameters_.covariance, P)};
}

}  // namespace lodestar::fusion
