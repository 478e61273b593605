// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/geomagnetic_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "lodestar/earth/igrf14_coefficients.h"
#include "lodestar/earth/wgs84.h"
#include "lodestar/earth/wmm2025_coefficients.h"

namespace lodestar::earth {
namespace {

constexpr double kReferenceRadius = 6371200.0;  // m, of both models

}  // namespace

GeomagneticModel::GeomagneticModel(GeomagneticKind kind)
    : year_(std::numeric_limits<double>::quiet_NaN()) {
  if (kind == GeomagneticKind::kIgrf14) {
    degree_ = igrf14::kDegree;
    epochs_ = static_cast<int>(std::size(igrf14::kYears));
    years_ = igrf14::kYears;
    coefficients_ = igrf14::kCoefficients[0];
    max_height_ = 600e3;
  } else {
    degree_ = wmm2025::kDegree;
    epochs_ = static_cast<int>(std::size(wmm2025::kYears));
    years_ = wmm2025::kYears;
    coefficients_ = wmm2025::kCoefficients[0];
    max_height_ = 850e3;
  }
  set_factors();
}

ModelValidity GeomagneticModel::validity(double decimal_year, double h) const {
  return {decimal_year >= first_year() && decimal_year <= last_year(),
          h >= min_height() && h <= max_height()};
}

Eigen::Vector3d GeomagneticModel::field_N(double lat, double lon, double h, double decimal_year) {
  const double year = std::clamp(decimal_year, first_year(), last_year());
  if (year != year_) set_year(year);

  const double sin_lat = std::sin(lat);
  const double cos_lat = std::cos(lat);
  const double radius = kSemiMajorAxis / std::sqrt(1.0 - kEccentricitySquared * sin_lat * sin_lat);
  const double from_axis = (radius + h) * cos_lat;
  const double above_equator = ((1.0 - kEccentricitySquared) * radius + h) * sin_lat;
  const double r = std::sqrt(from_axis * from_axis + above_equator * above_equator);
  const Place place{above_equator / r, from_axis / r, kReferenceRadius / r};
  const Eigen::Vector3d geocentric = field_geocentric(place, lon);

  // Down is along the normal of the ellipsoid, not towards the centre: turn about east by the
  // geocentric less the geodetic latitude.
  const double sin_turn = cos_lat * place.x - sin_lat * place.s;
  const double cos_turn = sin_lat * place.x + cos_lat * place.s;
  return {cos_turn * geocentric.x() - sin_turn * geocentric.z(), geocentric.y(),
          sin_turn * geocentric.x() + cos_turn * geocentric.z()};
}

void GeomagneticModel::set_factors() {
  for (int m = 0; m <= degree_; ++m) {
    diagonal_[m] = m > 1 ? std::sqrt((2.0 * m - 1.0) / (2.0 * m)) : 1.0;
    for (int n = m; n <= degree_; ++n) {
      const double next_root = std::sqrt((n + 1) * (n + 1) - m * m);
      Term& term = orders_[m][n];
      term.n = n;
      term.root = std::sqrt(n * n - m * m);
      term.forward = (2.0 * n + 1.0) / next_root;
      term.backward = term.root / next_root;
    }
  }
}

void GeomagneticModel::set_year(double year) {
  int epoch = 0;
  while (epoch < epochs_ - 2 && year >= years_[epoch + 1]) ++epoch;
  const double fraction = (year - years_[epoch]) / (years_[epoch + 1] - years_[epoch]);
  const int row = degree_ * (degree_ + 2);
  const double* before = coefficients_ + epoch * row;
  const double* after = before + row;
  const auto next = [&] {
    const double value = *before + fraction * (*after - *before);
    ++before;
    ++after;
    return value;
  };
  for (int n = 1; n <= degree_; ++n) {
    orders_[0][n].gh.x() = next();
    for (int m = 1; m <= n; ++m) {
      orders_[m][n].gh.x() = next();
      orders_[m][n].gh.y() = next();
    }
  }
  year_ = year;
}

// The order m = 0, whose slope P' = dP/dx obeys P'_{n+1} = (n + 1) P_n + x P'_n.
Eigen::Vector3d GeomagneticModel::zonal_field(const Place& place) const {
  const double ratio_squared = place.ratio * place.ratio;
  const double x = place.ratio * place.x;
  double previous = 0.0;
  double value = ratio_squared;  // (a/r)^(n+2) P_n
  double slope = 0.0;            // (a/r)^(n+2) P'_n
  double south = 0.0;
  double up = 0.0;
  for (int n = 0; n <= degree_; ++n) {
    const Term& term = orders_[0][n];
    south += term.gh.x() * slope;
    up += term.gh.x() * (term.n + 1.0) * value;
    slope = (term.n + 1.0) * place.ratio * value + x * slope;
    const double next = term.forward * x * value - term.backward * ratio_squared * previous;
    previous = value;
    value = next;
  }
  return {-place.s * south, 0.0, -up};
}

// Field (nT) north, east and down of the sphere through the place.
Eigen::Vector3d GeomagneticModel::field_geocentric(const Place& place, double lon) const {
  Eigen::Vector3d field = zonal_field(place);
  const double ratio_squared = place.ratio * place.ratio;
  const double x = place.ratio * place.x;
  const double cos_lon = std::cos(lon);
  const double sin_lon = std::sin(lon);
  Eigen::Vector2d cos_sin(1.0, 0.0);           // of m lon
  double first = ratio_squared * place.ratio;  // (a/r)^(m+2) P_m / s
  for (int m = 1; m <= degree_; ++m) {
    cos_sin = Eigen::Vector2d(cos_sin.x() * cos_lon - cos_sin.y() * sin_lon,
                              cos_sin.x() * sin_lon + cos_sin.y() * cos_lon);
    if (m > 1) first *= place.ratio * place.s * diagonal_[m];

    // Sums over n, for g and h, of the value R_n = (a/r)^(n+2) P_n / s, n R_n and root(n) R_{n-1}.
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Vector2d sum_by_degree = Eigen::Vector2d::Zero();
    Eigen::Vector2d sum_of_previous = Eigen::Vector2d::Zero();
    double previous = 0.0;
    double value = first;
    for (int n = m; n <= degree_; ++n) {
      const Term& term = orders_[m][n];
      sum += term.gh * value;
      sum_by_degree += term.gh * (term.n * value);
      sum_of_previous += term.gh * (term.root * previous);
      const double next = term.forward * x * value - term.backward * ratio_squared * previous;
      previous = value;
      value = next;
    }
    field.x() += cos_sin.dot(place.x * sum_by_degree - place.ratio * sum_of_previous);
    field.y() += m * (sum.x() * cos_sin.y() - sum.y() * cos_sin.x());
    field.z() -= place.s * cos_sin.dot(sum + sum_by_degree);
  }
  return field;
}

}  // namespace lodestar::earth
