// SPDX-License-Identifier: Apache-2.0
#include "lodestar/earth/cached_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"

namespace lodestar::earth {
namespace {

using math::kPi;

struct Flown {
  double worst = 0.0;   // nT, of held less exact field
  int evaluations = 0;  // times the held field changed
};

// A straight flight of 3000 frames of 1/60 s from `start`, at `v_N` (m/s).
Flown fly(CachedField& cached, const Geodetic& start, const Eigen::Vector3d& v_N, double year) {
  GeomagneticModel exact(GeomagneticKind::kIgrf14);
  Flown flown;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  Geodetic p = start;
  for (int frame = 0; frame < 3000; ++frame) {
    const Eigen::Vector3d held = cached.field_N(p.lat, p.lon, p.h, year);
    flown.worst = std::max(flown.worst, (held - exact.field_N(p.lat, p.lon, p.h, year)).norm());
    flown.evaluations += held != last ? 1 : 0;
    last = held;
    p = displaced(p, v_N / 60.0);
  }
  return flown;
}

TEST(CachedField, StaysWithinItsToleranceOnFlightsAllOverTheEarth) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  CachedField cached(GeomagneticKind::kIgrf14);
  for (int flight = 0; flight < 100; ++flight) {
    const Geodetic start{std::asin(uniform(generator)), kPi * uniform(generator),
                         15e3 + 15e3 * uniform(generator)};
    const Eigen::Vector3d v_N(400.0 * uniform(generator), 400.0 * uniform(generator),
                              100.0 * uniform(generator));
    const Flown flown = fly(cached, start, v_N, 1965.0 + 65.0 * uniform(generator));
    EXPECT_LE(flown.worst, 1.0);
  }
}

TEST(CachedField, IsEvaluatedAFewTimesASecondInCruise) {
  CachedField cached(GeomagneticKind::kIgrf14);
  const Flown flown = fly(cached, {1.0, 0.3, 9000.0}, {200.0, 150.0, 0.0}, 2026.0);  // 50 s
  EXPECT_LE(flown.worst, 1.0);
  EXPECT_GT(flown.evaluations, 50);
  EXPECT_LT(flown.evaluations, 500);
}

TEST(CachedField, TurnOfNorthNearThePoleCounts) {
  CachedField cached(GeomagneticKind::kIgrf14);
  const Flown flown = fly(cached, {-kPi / 2 + 1e-5, 0.3, 9000.0}, {0.0, 5.0, 0.0}, 2026.0);
  EXPECT_LE(flown.worst, 1.0);
  EXPECT_GT(flown.evaluations, 1000);
}

TEST(CachedField, IsHeldWhileStandingAndFollowsTheDate) {
  CachedField cached(GeomagneticKind::kIgrf14);
  GeomagneticModel exact(GeomagneticKind::kIgrf14);
  const Eigen::Vector3d first = cached.field_N(0.5, 0.5, 0.0, 2026.0);
  EXPECT_EQ(first, exact.field_N(0.5, 0.5, 0.0, 2026.0));
  EXPECT_EQ(first, cached.field_N(0.5, 0.5, 0.0, 2026.0 + 1e-4));
  EXPECT_EQ(exact.field_N(0.5, 0.5, 0.0, 2027.0), cached.field_N(0.5, 0.5, 0.0, 2027.0));
}

TEST(CachedField, RecoversFromAPositionThatIsNotANumber) {
  CachedField cached(GeomagneticKind::kWmm2025);
  const Eigen::Vector3d first = cached.field_N(0.5, 0.5, 0.0, 2026.0);
  EXPECT_TRUE(cached.field_N(std::nan(""), 0.5, 0.0, 2026.0).array().isNaN().any());
  EXPECT_EQ(cached.field_N(0.5, 0.5, 0.0, 2026.0), first);
}

}  // namespace
}  // namespace lodestar::earth
