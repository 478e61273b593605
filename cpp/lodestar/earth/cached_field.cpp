// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/cached_field.h"

#include <cmath>
#include <limits>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"

namespace lodestar::earth {
namespace {

constexpr double kHorizontalGradient = 0.018;  // nT/m
constexpr double kVerticalGradient = 0.038;    // nT/m
constexpr double kSecularVariation = 320.0;    // nT/year
constexpr double kNotYet = std::numeric_limits<double>::quiet_NaN();

}  // namespace

CachedField::CachedField(GeomagneticKind kind, double tolerance)
    : model_(kind),
      tolerance_(tolerance),
      lat_(kNotYet),
      lon_(kNotYet),
      h_(kNotYet),
      decimal_year_(kNotYet),
      sin_lat_(kNotYet),
      cos_lat_(kNotYet),
      horizontal_field_(kNotYet),
      field_N_(Eigen::Vector3d::Constant(kNotYet)) {}

const Eigen::Vector3d& CachedField::field_N(double lat, double lon, double h, double decimal_year) {
  // Written so that a bound which is not a number evaluates.
  if (change_bound(lat, lon, h, decimal_year) <= tolerance_) return field_N_;
  lat_ = lat;
  lon_ = lon;
  h_ = h;
  decimal_year_ = decimal_year;
  sin_lat_ = std::sin(lat);
  cos_lat_ = std::cos(lat);
  field_N_ = model_.field_N(lat, lon, h, decimal_year);
  horizontal_field_ = std::hypot(field_N_.x(), field_N_.y());
  return field_N_;
}

double CachedField::change_bound(double lat, double lon, double h, double decimal_year) const {
  const double longitude = math::wrap_pi(lon - lon_);
  const double north = (lat - lat_) * kSemiMajorAxis;
  const double east = longitude * cos_lat_ * kSemiMajorAxis;
  return kHorizontalGradient * std::sqrt(north * north + east * east) +
         kVerticalGradient * std::abs(h - h_) + horizontal_field_ * std::abs(longitude * sin_lat_) +
         kSecularVariation * std::abs(decimal_year - decimal_year_);
}

}  // namespace lodestar::earth
