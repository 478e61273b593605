// SPDX-License-Identifier: Apache-2.0
// GPS that lies: wrong time, frozen, moved at once, moved slowly.
#include <gtest/gtest.h>

#include "cascade_flight.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;
using samples::FusionMode;
using samples::Use;

bool within(double t, double from, double to) { return t >= from && t < to; }

/// Fixes used from now to `until` (s).
int used_until(CascadeFlight& flight, double until) {
  int used = 0;
  while (flight.time() < until) used += flight.step() == Use::kUsed ? 1 : 0;
  return used;
}

TEST(CascadeSpoofing, FixesStampedSecondsOffAreNotUsed) {
  for (const double off : {-5.0, -2.0, 2.0, 5.0}) {
    FlightOptions options;
    options.gps_stamp_error = [off](double t) { return within(t, 300.0, 330.0) ? off : 0.0; };
    CascadeFlight flight(options);
    flight.fly_until(300.1);
    EXPECT_EQ(used_until(flight, 330.0), 0) << off;
    EXPECT_NE(flight.navigation().mode, FusionMode::kAiding) << off;
    EXPECT_LT(flight.position_error().head<2>().norm(), 100.0) << "dead reckoning of 30 s";
    flight.fly_until(340.0);
    EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
    EXPECT_EQ(flight.navigation().reset_count, 1);
    EXPECT_LT(flight.position_error().head<2>().norm(), 25.0);
  }
}

TEST(CascadeSpoofing, AStampHalfASecondOffIsRefusedUntilItLastsAndThenCountedAsAReset) {
  // 100 m along the track. Fixes that all agree on it look like a receiver that is right.
  FlightOptions options;
  options.leg = 1000.0;
  options.gps_stamp_error = [](double t) { return t < 300.0 ? 0.0 : -0.5; };
  CascadeFlight flight(options);
  flight.fly_until(299.9);
  EXPECT_EQ(used_until(flight, 303.0), 0);
  EXPECT_LT(flight.position_error().head<2>().norm(), 30.0);
  flight.fly_until(310.0);
  EXPECT_EQ(flight.navigation().reset_count, 1);
  EXPECT_NEAR(flight.navigation().reset_delta.norm(), 104.0, 30.0);  // 0.5 s at ground speed
  EXPECT_LT(flight.position_error().head<2>().norm(), 130.0);
}

/// Holds the fixes at one place, with `noise` (m), from 300 to 330 s.
void freeze(FlightOptions& options, double noise) {
  options.gps_freeze = [](double t) { return within(t, 300.0, 330.0); };
  options.gps_freeze_noise = noise;
}

TEST(CascadeSpoofing, AFixThatRepeatsIsNotUsedAtAnyRateOrSpeed) {
  for (const double interval : {1.0, 0.1}) {
    for (const double speed : {200.0, 25.0}) {
      FlightOptions options;
      options.speed = speed;
      options.gps_interval = interval;
      options.leg = 1000.0;
      freeze(options, 0.0);
      CascadeFlight flight(options);
      flight.fly_until(300.19);  // fixes until then are good ones, 0.2 s under way
      EXPECT_EQ(used_until(flight, 330.0), 0) << interval << " " << speed;
      EXPECT_EQ(flight.navigation().mode, FusionMode::kDeadReckoning);
      EXPECT_EQ(flight.navigation().reset_count, 0);
      EXPECT_LT(flight.position_error().head<2>().norm(), 100.0);
      flight.fly_until(340.2);
      EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
      EXPECT_LT(flight.position_error().head<2>().norm(), 25.0);
    }
  }
}

TEST(CascadeSpoofing, AFixedPlaceWithNoiseIsNotBelievedInFastFlight) {
  FlightOptions options;
  freeze(options, 3.0);
  CascadeFlight flight(options);
  flight.fly_until(300.3);
  EXPECT_EQ(used_until(flight, 330.0), 0);
  EXPECT_EQ(flight.navigation().reset_count, 0);
  EXPECT_LT(flight.position_error().head<2>().norm(), 100.0) << "6 km if it were";
  EXPECT_LT(flight.wind_error().norm(), 8.0) << "200 m/s if it were";
  flight.fly_until(340.2);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  EXPECT_LT(flight.position_error().head<2>().norm(), 25.0);
}

TEST(CascadeSpoofing, AJumpOfTwoHundredMetresIsRefusedWhileItIsShort) {
  FlightOptions options;
  options.gps_jump = [](double t) {
    return within(t, 299.9, 302.1) ? Eigen::Vector2d(-120.0, 160.0) : Eigen::Vector2d(0.0, 0.0);
  };
  CascadeFlight flight(options);
  flight.fly_until(299.9);
  int gated = 0;
  while (flight.time() < 310.0) {
    gated += flight.step() == Use::kGated ? 1 : 0;
    ASSERT_LT(flight.position_error().head<2>().norm(), 30.0) << flight.time();
  }
  EXPECT_EQ(gated, 3);
  EXPECT_EQ(flight.navigation().reset_count, 0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
}

TEST(CascadeSpoofing, AJumpOfTwoHundredMetresThatStaysIsSaidWithinTenSeconds) {
  FlightOptions options;
  options.gps_jump = [](double t) {
    return t < 299.9 ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(-120.0, 160.0);
  };
  CascadeFlight flight(options);
  flight.fly_until(302.9);
  EXPECT_EQ(flight.navigation().reset_count, 0);
  flight.fly_until(310.0);
  EXPECT_EQ(flight.navigation().reset_count, 1);
  EXPECT_LT((flight.navigation().reset_delta - Eigen::Vector2d(-120.0, 160.0)).norm(), 30.0);
}

TEST(CascadeSpoofing, ADragOffOfOneMetrePerSecondIsTakenForWindAndNotForHeading) {
  // Nothing here can tell the two apart. What can be said: the position leaves by no more than the
  // fixes do, the wind by 1 m/s, and the heading, which turns tell from wind, stays.
  const auto drag = [](double t) {
    return Eigen::Vector2d(0.0, std::clamp(t - 500.0, 0.0, 300.0));
  };
  FlightOptions options;
  options.rate = 30.0;
  CascadeFlight honest(options);
  options.gps_jump = drag;
  CascadeFlight spoofed(options);
  for (CascadeFlight* flight : {&honest, &spoofed}) flight->fly_until(800.0);
  const Eigen::Vector2d led_away =
      honest.position_error().head<2>() - spoofed.position_error().head<2>();
  EXPECT_LT((led_away - drag(800.0)).norm(), 10.0);
  const samples::Navigation& a = honest.navigation();
  const samples::Navigation& b = spoofed.navigation();
  EXPECT_EQ(b.reset_count, a.reset_count);
  EXPECT_LT((b.wind_N - a.wind_N - Eigen::Vector3d(0.0, 1.0, 0.0)).norm(), 0.4);
  EXPECT_LT(std::abs(math::wrap_pi(b.heading - a.heading)), 0.2 * kDegree);
}

}  // namespace
}  // namespace lodestar::fusion
