// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/wgs84.h"

#include <cmath>

#include "lodestar/math/rotation.h"

namespace lodestar::earth {
namespace {

// Normal gravity of WGS84 (TR8350.2, tables 3.4 and 3.6).
constexpr double kEquatorialGravity = 9.7803253359;  // m/s^2
constexpr double kSomigliana = 1.931852652458e-3;    // -
constexpr double kGravityRatio = 3.449786506841e-3;  // -, centrifugal over gravity at the equator

// 1 - e^2 sin^2(lat), which both radii and gravity are made of.
double ellipticity_factor(double lat) {
  const double sin_lat = std::sin(lat);
  return 1.0 - kEccentricitySquared * sin_lat * sin_lat;
}

}  // namespace

double meridian_radius(double lat) {
  const double factor = ellipticity_factor(lat);
  return kSemiMajorAxis * (1.0 - kEccentricitySquared) / (factor * std::sqrt(factor));
}

double transverse_radius(double lat) { return kSemiMajorAxis / std::sqrt(ellipticity_factor(lat)); }

double gravity(double lat, double h) {
  const double sin_lat = std::sin(lat);
  const double sin_squared = sin_lat * sin_lat;
  const double on_ellipsoid = kEquatorialGravity * (1.0 + kSomigliana * sin_squared) /
                              std::sqrt(1.0 - kEccentricitySquared * sin_squared);
  const double ratio = h / kSemiMajorAxis;
  const double first_order = 1.0 + kFlattening + kGravityRatio - 2.0 * kFlattening * sin_squared;
  return on_ellipsoid * (1.0 - 2.0 * first_order * ratio + 3.0 * ratio * ratio);
}

Eigen::Vector3d earth_rate_N(double lat) {
  return {kEarthRate * std::cos(lat), 0.0, -kEarthRate * std::sin(lat)};
}

Eigen::Vector3d transport_rate_N(double lat, double h, const Eigen::Vector3d& v_N) {
  const double about_north = v_N.y() / (transverse_radius(lat) + h);
  return {about_north, -v_N.x() / (meridian_radius(lat) + h), -about_north * std::tan(lat)};
}

Eigen::Vector3d position_rates(double lat, double h, const Eigen::Vector3d& v_N) {
  return {v_N.x() / (meridian_radius(lat) + h),
          v_N.y() / ((transverse_radius(lat) + h) * std::cos(lat)), -v_N.z()};
}

Eigen::Matrix3d C_NE(double lat, double lon) {
  const double sin_lat = std::sin(lat);
  const double cos_lat = std::cos(lat);
  const double sin_lon = std::sin(lon);
  const double cos_lon = std::cos(lon);
  Eigen::Matrix3d C;
  C << -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
      -sin_lon, cos_lon, 0.0,                            //
      -cos_lat * cos_lon, -cos_lat * sin_lon, -sin_lat;
  return C;
}

Eigen::Vector3d geodetic_to_ecef(const Geodetic& position) {
  const double radius = transverse_radius(position.lat);
  const double from_axis = (radius + position.h) * std::cos(position.lat);
  return {from_axis * std::cos(position.lon), from_axis * std::sin(position.lon),
          ((1.0 - kEccentricitySquared) * radius + position.h) * std::sin(position.lat)};
}

Geodetic ecef_to_geodetic(const Eigen::Vector3d& p_E) {
  // Bowring's iteration on the reduced latitude, on (sine, cosine) pairs so that no tangent grows
  // at the poles. Once is right to 1e-9 rad at 1000 km, twice to rounding.
  constexpr double kSecondEccentricitySquared = kEccentricitySquared / (1.0 - kEccentricitySquared);
  const double p = std::hypot(p_E.x(), p_E.y());
  double sin_reduced = p_E.z() * kSemiMajorAxis;
  double cos_reduced = p * kSemiMinorAxis;
  double sin_lat = 0.0;
  double cos_lat = 1.0;
  for (int iteration = 0; iteration < 2; ++iteration) {
    const double norm = std::hypot(sin_reduced, cos_reduced);
    const double s = sin_reduced / norm;
    const double c = cos_reduced / norm;
    sin_lat = p_E.z() + kSecondEccentricitySquared * kSemiMinorAxis * s * s * s;
    cos_lat = p - kEccentricitySquared * kSemiMajorAxis * c * c * c;
    sin_reduced = (1.0 - kFlattening) * sin_lat;
    cos_reduced = cos_lat;
  }
  const double norm = std::hypot(sin_lat, cos_lat);
  sin_lat /= norm;
  cos_lat /= norm;
  const double h = p * cos_lat + p_E.z() * sin_lat -
                   kSemiMajorAxis * std::sqrt(1.0 - kEccentricitySquared * sin_lat * sin_lat);
  return {std::atan2(sin_lat, cos_lat), std::atan2(p_E.y(), p_E.x()), h};
}

Eigen::Vector3d displacement_N(const Geodetic& from, const Geodetic& to) {
  const double lat = 0.5 * (from.lat + to.lat);
  const double h = 0.5 * (from.h + to.h);
  return {(to.lat - from.lat) * (meridian_radius(lat) + h),
          math::wrap_pi(to.lon - from.lon) * (transverse_radius(lat) + h) * std::cos(lat),
          from.h - to.h};
}

Geodetic displaced(const Geodetic& from, const Eigen::Vector3d& offset_N) {
  Geodetic to{from.lat, from.lon, from.h - offset_N.z()};
  const double h = 0.5 * (from.h + to.h);
  // The radius halfway depends on where the way ends: a fixed point that two turns reach.
  for (int iteration = 0; iteration < 3; ++iteration) {
    to.lat = from.lat + offset_N.x() / (meridian_radius(0.5 * (from.lat + to.lat)) + h);
  }
  const double lat = 0.5 * (from.lat + to.lat);
  const double parallel_radius = (transverse_radius(lat) + h) * std::cos(lat);
  to.lon = math::wrap_pi(from.lon + offset_N.y() / parallel_radius);
  return to;
}

}  // namespace lodestar::earth
