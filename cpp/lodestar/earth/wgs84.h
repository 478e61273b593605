// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace lodestar::earth {

// WGS84 (NIMA TR8350.2, tables 3.1 and 3.3).
inline constexpr double kSemiMajorAxis = 6378137.0;                                // m
inline constexpr double kFlattening = 1.0 / 298.257223563;                         // -
inline constexpr double kSemiMinorAxis = kSemiMajorAxis * (1.0 - kFlattening);     // m
inline constexpr double kEccentricitySquared = kFlattening * (2.0 - kFlattening);  // -
inline constexpr double kEarthRate = 7.292115e-5;                                  // rad/s

/// A point: geodetic latitude and east longitude (rad), height above the ellipsoid (m).
struct Geodetic {
  double lat = 0.0;
  double lon = 0.0;
  double h = 0.0;
};

/// Radius of curvature of the meridian (m) at `lat` (rad).
double meridian_radius(double lat);

/// Radius of curvature in the prime vertical (m) at `lat` (rad).
/// Linköping thesis eq. 2.10, without its stray factor (1 - e^2).
double transverse_radius(double lat);

/// Normal gravity (m/s^2, along down) at `lat` (rad) and `h` (m): Somigliana's formula with the
/// height correction to second order, TR8350.2 eq. 4-1 and 4-3. Right to 1e-5 m/s^2 up to 30 km.
double gravity(double lat, double h);

/// omega_IE in N (rad/s): rotation of the Earth at `lat` (rad).
Eigen::Vector3d earth_rate_N(double lat);

/// omega_EN in N (rad/s): rotation of N over the Earth at ground velocity `v_N` (m/s).
/// North is undefined at the poles, where its third component is not finite or very large.
Eigen::Vector3d transport_rate_N(double lat, double h, const Eigen::Vector3d& v_N);

/// Time derivatives of (lat, lon, h) in (rad/s, rad/s, m/s) at ground velocity `v_N` (m/s).
/// Longitude is undefined at the poles, where its rate is not finite or very large.
Eigen::Vector3d position_rates(double lat, double h, const Eigen::Vector3d& v_N);

/// C_NE: takes a vector from E to N (north, east, down) at `lat`, `lon` (rad).
Eigen::Matrix3d C_NE(double lat, double lon);

/// Position in E (m).
Eigen::Vector3d geodetic_to_ecef(const Geodetic& position);

/// Geodetic position of `p_E` (m), right to rounding (4e-9 m, 1e-15 rad) from 10 km below the
/// ellipsoid to 1000 km above it, poles included; longitude 0 on the axis. Meaningless within 50 km
/// of the centre.
Geodetic ecef_to_geodetic(const Eigen::Vector3d& p_E);

/// Metres north, east and down from `from` to `to`, along the local radii halfway between them:
/// for short ways (right to 1 cm over 10 km at 60 degrees of latitude), either side of the date
/// line.
Eigen::Vector3d displacement_N(const Geodetic& from, const Geodetic& to);

/// The point `offset_N` (m north, east, down) away from `from`; undoes displacement_N.
Geodetic displaced(const Geodetic& from, const Eigen::Vector3d& offset_N);

}  // namespace lodestar::earth
