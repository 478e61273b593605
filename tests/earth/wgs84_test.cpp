// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/wgs84.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lodestar/math/rotation.h"

namespace lodestar::earth {
namespace {

using math::kDegree;
using math::kPi;

constexpr double kLatitudes[] = {-1.5, -0.7, -1e-3, 0.0, 0.4, 1.0, 1.5};  // rad, no pole

TEST(Wgs84, RadiiAtEquatorAndPoleAreThoseOfTheEllipse) {
  const double a = kSemiMajorAxis;
  const double b = kSemiMinorAxis;
  EXPECT_NEAR(b, 6356752.3142, 1e-4);  // TR8350.2, table 3.3
  EXPECT_NEAR(meridian_radius(0.0), b * b / a, 1e-8);
  EXPECT_NEAR(meridian_radius(kPi / 2), a * a / b, 1e-8);
  EXPECT_NEAR(transverse_radius(0.0), a, 1e-8);
  EXPECT_NEAR(transverse_radius(-kPi / 2), a * a / b, 1e-8);
}

TEST(Wgs84, GravityIsThatOfTheTables) {
  EXPECT_NEAR(gravity(0.0, 0.0), 9.7803253359, 1e-10);
  EXPECT_NEAR(gravity(kPi / 2, 0.0), 9.8321849378, 1e-10);
  EXPECT_EQ(gravity(-0.6, 500.0), gravity(0.6, 500.0));
}

TEST(Wgs84, GravityFallsWithHeightByTheFreeAirGradient) {
  const double gradient = (gravity(kPi / 4, 100.0) - gravity(kPi / 4, -100.0)) / 200.0;
  EXPECT_NEAR(gradient, -3.086e-6, 1e-9);  // 1/s^2, the textbook value has four digits
}

TEST(Wgs84, EarthRatePointsNorthAtTheEquatorAndUpAtThePole) {
  EXPECT_TRUE(earth_rate_N(0.0).isApprox(Eigen::Vector3d(kEarthRate, 0.0, 0.0), 1e-15));
  EXPECT_TRUE(earth_rate_N(kPi / 2).isApprox(Eigen::Vector3d(0.0, 0.0, -kEarthRate), 1e-15));
  for (const double lat : kLatitudes) {
    const Eigen::Vector3d in_E = C_NE(lat, 2.0).transpose() * earth_rate_N(lat);
    EXPECT_TRUE(in_E.isApprox(Eigen::Vector3d(0.0, 0.0, kEarthRate), 1e-14));
  }
}

TEST(Wgs84, FrameAtLatitudeZeroLongitudeZeroHasItsAxesAlongE) {
  Eigen::Matrix3d expected;
  expected << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  EXPECT_TRUE(C_NE(0.0, 0.0).isApprox(expected));
}

TEST(Wgs84, FrameIsARotation) {
  for (const double lat : kLatitudes) {
    const Eigen::Matrix3d C = C_NE(lat, -2.5);
    EXPECT_TRUE((C * C.transpose()).isIdentity(1e-15));
    EXPECT_NEAR(C.determinant(), 1.0, 1e-15);
  }
}

TEST(Wgs84, TransportRateIsTheRateOfTurnOfTheFrame) {
  const Eigen::Vector3d v_N(180.0, -240.0, 12.0);
  const double h = 9000.0;
  const double lon = 0.3;
  const double dt = 1.0;
  for (const double lat : kLatitudes) {
    const Eigen::Vector3d step = 0.5 * dt * position_rates(lat, h, v_N);
    const Eigen::Matrix3d derivative =
        (C_NE(lat + step.x(), lon + step.y()) - C_NE(lat - step.x(), lon - step.y())) / dt;
    const Eigen::Matrix3d expected = -math::skew(transport_rate_N(lat, h, v_N)) * C_NE(lat, lon);
    EXPECT_TRUE(derivative.isApprox(expected, 1e-6)) << lat;
  }
}

TEST(Wgs84, PositionRatesMoveThePointWithTheVelocity) {
  const Eigen::Vector3d v_N(-100.0, 250.0, -30.0);
  const double dt = 0.1;
  for (const double lat : kLatitudes) {
    const Eigen::Vector3d step = 0.5 * dt * position_rates(lat, 3000.0, v_N);
    const Eigen::Vector3d moved =
        geodetic_to_ecef({lat + step.x(), 1.0 + step.y(), 3000.0 + step.z()}) -
        geodetic_to_ecef({lat - step.x(), 1.0 - step.y(), 3000.0 - step.z()});
    // 1e-5 m/s: positions of 6.4e6 m are rounded to 1e-9 m, and the step is not infinitesimal.
    EXPECT_LT((moved / dt - C_NE(lat, 1.0).transpose() * v_N).norm(), 1e-5) << lat;
  }
}

TEST(Ecef, KnownPoints) {
  EXPECT_TRUE(geodetic_to_ecef({0.0, 0.0, 0.0}).isApprox(Eigen::Vector3d(kSemiMajorAxis, 0, 0)));
  EXPECT_TRUE(geodetic_to_ecef({0.0, kPi / 2, 100.0})
                  .isApprox(Eigen::Vector3d(0, kSemiMajorAxis + 100.0, 0)));
  EXPECT_TRUE(geodetic_to_ecef({-kPi / 2, 0.0, 100.0})
                  .isApprox(Eigen::Vector3d(0, 0, -kSemiMinorAxis - 100.0)));
}

TEST(Ecef, PolesAreReachedExactly) {
  for (const double sign : {-1.0, 1.0}) {
    const Geodetic pole = ecef_to_geodetic({0.0, 0.0, sign * (kSemiMinorAxis + 5000.0)});
    EXPECT_EQ(pole.lat, sign * kPi / 2);
    EXPECT_EQ(pole.lon, 0.0);
    EXPECT_NEAR(pole.h, 5000.0, 2e-9);
  }
}

TEST(Ecef, RoundTripFromBelowGroundToSpaceAndPoleToPole) {
  for (const double h : {-10e3, 0.0, 1.0, 12e3, 100e3, 1000e3}) {
    for (int i = -900; i <= 900; ++i) {
      const Geodetic p{0.1 * i * kDegree, 0.19 * i * kDegree, h};
      const Geodetic back = ecef_to_geodetic(geodetic_to_ecef(p));
      EXPECT_NEAR(back.lat, p.lat, 2e-15);
      EXPECT_NEAR(back.h, p.h, 4e-9);
      if (std::abs(i) < 900) {
        EXPECT_NEAR(back.lon, p.lon, 2e-15);
      }
    }
  }
}

TEST(LocalMetric, DisplacementIsTheDifferenceInE) {
  // The chord differs from the way along the parallel by a third-order term: 1 cm over 10 km at 60
  // degrees; down differs by the drop of the horizon and is not compared.
  const Geodetic from{60.0 * kDegree, 18.0 * kDegree, 1000.0};
  const Geodetic to = displaced(from, {6000.0, -8000.0, 250.0});
  const double middle_lat = 0.5 * (from.lat + to.lat);
  const double middle_lon = 0.5 * (from.lon + to.lon);
  const Eigen::Vector3d chord_N =
      C_NE(middle_lat, middle_lon) * (geodetic_to_ecef(to) - geodetic_to_ecef(from));
  EXPECT_NEAR(chord_N.x(), 6000.0, 0.01);
  EXPECT_NEAR(chord_N.y(), -8000.0, 0.01);
  EXPECT_DOUBLE_EQ(to.h, 750.0);
}

TEST(LocalMetric, CrossesTheDateLine) {
  const Geodetic from{0.2, kPi - 1e-4, 0.0};
  const Geodetic to{0.2, -kPi + 1e-4, 0.0};
  const double expected = 2e-4 * transverse_radius(0.2) * std::cos(0.2);
  EXPECT_NEAR(displacement_N(from, to).y(), expected, 1e-6);
  EXPECT_NEAR(displaced(from, {0.0, expected, 0.0}).lon, to.lon, 1e-14);
}

TEST(LocalMetric, DisplacedUndoesDisplacement) {
  const Eigen::Vector3d offset_N(12e3, -34e3, 560.0);
  for (const double lat : kLatitudes) {
    const Geodetic from{lat, 3.1, 2000.0};
    const Eigen::Vector3d back = displacement_N(from, displaced(from, offset_N));
    EXPECT_LT((back - offset_N).norm(), 1e-6) << lat;
  }
}

}  // namespace
}  // namespace lodestar::earth
