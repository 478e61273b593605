// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/dead_reckoning.h"

#include <gtest/gtest.h>

#include "lodestar/fusion/track_history.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;

samples::Attitude attitude_at(double time, const math::Euler& angles) {
  samples::Attitude sahrs;
  sahrs.time_us = static_cast<std::int64_t>(std::llround(1e6 * time));
  sahrs.q_NB = Eigen::Quaterniond(math::C_NB_from_euler(angles));
  sahrs.roll = angles.roll;
  sahrs.pitch = angles.pitch;
  sahrs.heading = angles.heading;
  sahrs.valid = true;
  return sahrs;
}

samples::AirData air_data(double speed, double alpha, double beta) {
  samples::AirData air;
  air.true_airspeed = speed;
  air.alpha = alpha;
  air.beta = beta;
  return air;
}

/// Length of the meridian between two latitudes (m), by Simpson's rule on its radius.
double meridian_arc(double from, double to) {
  constexpr int kIntervals = 1000;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = i == 0 || i == kIntervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * earth::meridian_radius(from + (to - from) * i / kIntervals);
  }
  return sum * (to - from) / (3.0 * kIntervals);
}

TEST(AirVelocity, FollowsTheStandardConvention) {
  const Eigen::Vector3d v = air_velocity_B(air_data(100.0, 0.1, 0.05));
  EXPECT_NEAR(v.norm(), 100.0, 1e-12);
  EXPECT_NEAR(std::atan2(v.z(), v.x()), 0.1, 1e-15);
  EXPECT_NEAR(std::asin(v.y() / v.norm()), 0.05, 1e-15);
}

TEST(DeadReckoning, FlightAlongTheMeridianCoversItsArc) {
  DeadReckoning reckoning;
  reckoning.set_position(40.0 * kDegree, 0.3);
  reckoning.set_air_velocity(air_velocity_B(air_data(250.0, 0.0, 0.0)));
  for (int i = 0; i <= 60 * 600; ++i) reckoning.advance(attitude_at(i / 60.0, {0.0, 0.0, 0.0}));
  const double flown = meridian_arc(40.0 * kDegree, reckoning.point().lat);
  // The rounding of frame times to 1 us makes up to 0.5 us of flight.
  EXPECT_NEAR(flown, 250.0 * 600.0, 2e-4);
  EXPECT_NEAR(reckoning.point().lon, 0.3, 1e-12);
}

TEST(DeadReckoning, FlightAlongAParallelKeepsItsLatitude) {
  DeadReckoning reckoning;
  const double lat = 60.0 * kDegree;
  reckoning.set_position(lat, 179.9 * kDegree);
  reckoning.set_height(5000.0);
  reckoning.set_air_velocity(air_velocity_B(air_data(200.0, 0.0, 0.0)));
  for (int i = 0; i <= 50 * 1000; ++i) {
    reckoning.advance(attitude_at(i / 50.0, {0.0, 0.0, 90.0 * kDegree}));
  }
  const double radius = (earth::transverse_radius(lat) + 5000.0) * std::cos(lat);
  EXPECT_NEAR(reckoning.point().lat, lat, 1e-12);
  EXPECT_NEAR(reckoning.point().lon, 179.9 * kDegree + 200e3 / radius, 1e-11);
}

TEST(DeadReckoning, AirAnglesAndAttitudeCancelInLevelFlight) {
  DeadReckoning reckoning;
  reckoning.set_air_velocity(air_velocity_B(air_data(200.0, 0.1, 0.0)));
  reckoning.advance(attitude_at(0.0, {0.0, 0.1, 0.7}));
  const Eigen::Vector3d expected(200.0 * std::cos(0.7), 200.0 * std::sin(0.7), 0.0);
  EXPECT_LT((reckoning.point().v_air_N - expected).norm(), 1e-12);
}

TEST(DeadReckoning, AFullTurnInStillAirReturnsToItsStart) {
  DeadReckoning reckoning;
  // At the equator, where meridians are parallel: elsewhere north itself turns on the way round.
  reckoning.set_position(0.0, 0.0);
  reckoning.set_air_velocity(air_velocity_B(air_data(200.0, 0.0, 0.0)));
  constexpr double kTurnRate = 0.1;  // rad/s
  const int frames = static_cast<int>(std::lround(60.0 * 2.0 * math::kPi / kTurnRate));
  for (int i = 0; i <= frames; ++i) {
    const double heading = 2.0 * math::kPi * i / frames;
    reckoning.advance(attitude_at(i / 60.0, {0.0, 0.0, math::wrap_2pi(heading)}));
  }
  const Eigen::Vector3d miss = earth::displacement_N({0.0, 0.0, 0.0}, reckoning.point().position());
  // 5 mm of 12.6 km: frame times are rounded to 1 us, 0.1 mm of flight each.
  EXPECT_LT(miss.norm(), 5e-3);
}

TEST(DeadReckoning, HoldsAirDataBetweenSamples) {
  DeadReckoning reckoning;
  reckoning.set_air_velocity({100.0, 0.0, 0.0});
  reckoning.advance(attitude_at(0.0, {}));
  reckoning.advance(attitude_at(1.0, {}));
  EXPECT_EQ(reckoning.point().v_air_N.x(), 100.0);
  reckoning.set_air_velocity({120.0, 0.0, 0.0});
  const TrackPoint before = reckoning.point();
  reckoning.advance(attitude_at(2.0, {}));
  const double flown = meridian_arc(before.lat, reckoning.point().lat);
  EXPECT_NEAR(flown, 110.0, 1e-6);  // trapezoid of the two
}

TrackPoint point_at(double time, double lat) {
  TrackPoint point;
  point.time_us = static_cast<std::int64_t>(std::llround(1e6 * time));
  point.lat = lat;
  return point;
}

TEST(TrackHistory, GivesBackAPointAtItsOwnTime) {
  TrackHistory history;
  for (int i = 0; i < 60; ++i) history.push(point_at(0.1 * i, i));
  ASSERT_TRUE(history.at(1'200'000));
  EXPECT_EQ(history.at(1'200'000)->lat, 12.0);
}

TEST(TrackHistory, InterpolatesAnAcceleratedTrackExactly) {
  TrackHistory history;
  const auto accelerated = [](double t) {
    TrackPoint point = point_at(t, 0.2 + 0.3 * t + 0.4 * t * t);
    point.lon = -0.5 * t * t * t;
    point.rates = {0.3 + 0.8 * t, -1.5 * t * t};
    point.h = 100.0 * t;
    point.attitude.heading = math::wrap_2pi(-0.1 + 0.2 * t);  // through north
    return point;
  };
  history.push(accelerated(0.0));
  history.push(accelerated(1.0));
  for (const double t : {0.1, 0.5, 0.9}) {
    const auto point = history.at(static_cast<std::int64_t>(1e6 * t));
    ASSERT_TRUE(point);
    EXPECT_NEAR(point->lat, accelerated(t).lat, 1e-15);
    EXPECT_NEAR(point->lon, accelerated(t).lon, 1e-15);
    EXPECT_NEAR(point->h, 100.0 * t, 1e-12);
    EXPECT_NEAR(math::wrap_pi(point->attitude.heading - (-0.1 + 0.2 * t)), 0.0, 1e-12);
  }
}

TEST(TrackHistory, HoldsOneSecondAt1000Hz) {
  TrackHistory history;
  for (int i = 0; i <= 5000; ++i) history.push(point_at(1e-3 * i, i));
  EXPECT_TRUE(history.at(4'000'000));
  EXPECT_EQ(history.at(4'000'500)->lat, 4000.5);
  EXPECT_FALSE(history.at(5'000'001)) << "newer than the newest";
  EXPECT_FALSE(history.at(3'000'000)) << "older than the oldest";
}

TEST(TrackHistory, ShiftsWholeAndForgetsWhole) {
  TrackHistory history;
  for (int i = 0; i < 10; ++i) history.push(point_at(i, i));
  history.shift(0.5, -0.25);
  EXPECT_EQ(history.at(3'000'000)->lat, 3.5);
  EXPECT_EQ(history.at(9'000'000)->lon, -0.25);
  history.clear();
  EXPECT_FALSE(history.at(9'000'000));
}

}  // namespace
}  // namespace lodestar::fusion
