// SPDX-License-Identifier: Apache-2.0
// GPS lost, jammed, jumped, wrong from the start; wind that changes; air data that stop.
#include <gtest/gtest.h>

#include "cascade_flight.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;
using samples::FusionMode;
using samples::Use;

bool within(double t, double from, double to) { return t >= from && t < to; }

TEST(CascadeOutage, ModeFollowsTheOutage) {
  FlightOptions options;
  options.gps_on = [](double t) { return !within(t, 300.0, 420.0); };
  CascadeFlight flight(options);
  flight.fly_until(299.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  flight.fly_until(310.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kDeadReckoning);
  EXPECT_TRUE(flight.navigation().valid);
  flight.fly_until(419.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kDeadReckoning);
  EXPECT_NEAR(flight.navigation().gps_age, 120.0, 0.1);
  flight.fly_until(421.5);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kReacquiring);
  flight.fly_until(426.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  EXPECT_EQ(flight.navigation().reset_count, 1);
}

TEST(CascadeOutage, SigmaGrowsAndHoldsTheError) {
  int outside = 0;
  constexpr int kFlights = 12;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    FlightOptions options;
    options.seed = seed;
    options.gps_on = [](double t) { return t < 300.0; };
    CascadeFlight flight(options);
    flight.fly_until(300.0);
    const double sigma_before = flight.navigation().sigma_position.head<2>().norm();
    flight.fly_until(480.0);
    const samples::Navigation& n = flight.navigation();
    EXPECT_GT(n.sigma_position.head<2>().norm(), 20.0 * sigma_before);
    EXPECT_LT(flight.position_error().head<2>().norm(), 2000.0);
    for (int axis = 0; axis < 2; ++axis) {
      outside += std::abs(flight.position_error()(axis)) > 2.0 * n.sigma_position(axis) ? 1 : 0;
    }
  }
  EXPECT_LE(outside, 4);  // 24 draws at 5 %: more than 4 once in 160 times
}

TEST(CascadeOutage, ResetSaysHowFarThePositionWasMoved) {
  FlightOptions options;
  options.gps_on = [](double t) { return !within(t, 200.0, 500.0); };
  CascadeFlight flight(options);
  flight.fly_until(501.0);
  Eigen::Vector2d error_before = flight.position_error().head<2>();
  flight.fly_until(510.0, [&] {
    if (flight.navigation().reset_count > 0) return true;
    error_before = flight.position_error().head<2>();
    return false;
  });
  ASSERT_EQ(flight.navigation().reset_count, 1);
  const Eigen::Vector2d moved = error_before - flight.position_error().head<2>();
  EXPECT_LT((flight.navigation().reset_delta - moved).norm(), 0.5);  // and a frame of flight
  EXPECT_LT(flight.position_error().head<2>().norm(), 25.0);
}

TEST(CascadeOutage, AWindThatChangedMeanwhileDoesNotLockGpsOut) {
  FlightOptions options;
  options.gps_on = [](double t) { return !within(t, 300.0, 600.0); };
  options.wind = [](double t) {
    const double change = 20.0 * std::clamp((t - 350.0) / 10.0, 0.0, 1.0);
    return Eigen::Vector2d(3.0 + change, 3.0 - change);  // 7 km in 250 s
  };
  CascadeFlight flight(options);
  flight.fly_until(600.0);
  EXPECT_GT(flight.position_error().head<2>().norm(), 3000.0);
  flight.fly_until(610.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  EXPECT_LT(flight.position_error().head<2>().norm(), 30.0);
  flight.fly_until(900.0);
  EXPECT_LT(flight.wind_error().norm(), 6.0);
}

TEST(CascadeOutage, GpsThatJumpedForGoodIsBelievedWithinTenSeconds) {
  for (const double jump : {60.0, 500.0, 5e3, 300e3}) {
    FlightOptions options;
    options.gps_jump = [jump](double t) {
      return t < 300.0 ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(jump, -0.5 * jump);
    };
    CascadeFlight flight(options);
    flight.fly_until(299.5);
    const double resets_before = flight.navigation().reset_count;
    flight.fly_until(310.2);
    const samples::Navigation& n = flight.navigation();
    EXPECT_EQ(n.mode, FusionMode::kAiding);
    EXPECT_EQ(n.reset_count, resets_before + 1);
    // 300 km are more than a displacement by mean radii can tell to the metre.
    const Eigen::Vector2d off =
        flight.position_error().head<2>() + Eigen::Vector2d(jump, -0.5 * jump);
    EXPECT_LT(off.norm(), 30.0 + 0.02 * jump) << jump;
    EXPECT_NEAR(n.reset_delta.x(), jump, 30.0 + 0.02 * jump);
  }
}

TEST(CascadeOutage, ASingleWildFixIsRefusedAndForgotten) {
  FlightOptions options;
  options.gps_jump = [](double t) {
    return within(t, 299.9, 300.1) ? Eigen::Vector2d(80.0, 0.0) : Eigen::Vector2d(0.0, 0.0);
  };
  CascadeFlight flight(options);
  flight.fly_until(300.1);
  int gated = 0;
  while (flight.time() < 305.0) {
    const std::optional<Use> use = flight.step();
    gated += use == Use::kGated ? 1 : 0;
    EXPECT_LT(flight.position_error().head<2>().norm(), 25.0);
    EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  }
  EXPECT_EQ(gated, 1);
  EXPECT_EQ(flight.navigation().reset_count, 0);
}

TEST(CascadeOutage, JammedFixesThatScatterAreNotBelieved) {
  auto generator = std::make_shared<std::mt19937_64>(5);
  FlightOptions options;
  options.gps_jump = [generator](double t) -> Eigen::Vector2d {
    std::normal_distribution<double> normal(0.0, 300.0);
    if (!within(t, 300.0, 360.0)) return Eigen::Vector2d::Zero();
    const double north = normal(*generator);
    return {north, normal(*generator)};
  };
  CascadeFlight flight(options);
  flight.fly_until(300.3);
  double worst = 0.0;
  while (flight.time() < 360.0) {
    flight.step();
    worst = std::max(worst, flight.position_error().head<2>().norm());
  }
  EXPECT_LT(worst, 250.0);  // dead reckoning's drift in a minute
  EXPECT_EQ(flight.navigation().reset_count, 0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kReacquiring);
  flight.fly_until(370.2);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  EXPECT_LT(flight.position_error().head<2>().norm(), 25.0);
}

TEST(CascadeOutage, AHeadingFarBeyondItsSigmaDoesNotLockGpsOut) {
  FlightOptions options;
  options.heading_offset = 20.0 * kDegree;  // 13 sigma; the position runs away at 70 m/s
  CascadeFlight flight(options);
  flight.fly_until(11.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  for (int i = 0; i < 60 * 120; ++i) {
    flight.step();
    ASSERT_LT(flight.position_error().head<2>().norm(), 60.0) << flight.time();
  }
}

TEST(CascadeOutage, FixesWithWhiteErrorsAsLargeAsStatedAreUsed) {
  FlightOptions options;
  options.gps_error.sigma = 0.0;
  options.gps_noise = 5.0;
  CascadeFlight flight(options);
  int refused = 0;
  while (flight.time() < 600.0) {
    const std::optional<Use> use = flight.step();
    refused += use && *use != Use::kUsed ? 1 : 0;
  }
  EXPECT_LE(refused, 2);
  EXPECT_EQ(flight.navigation().reset_count, 0);
  EXPECT_LT(flight.position_error().head<2>().norm(), 15.0);
}

TEST(CascadeOutage, AChangeOfWindIsFollowedWithoutLosingTheHeading) {
  double worst_heading = 0.0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    FlightOptions options;
    options.seed = seed;
    options.wind = [](double t) {
      const double change = 12.0 * std::clamp((t - 500.0) / 10.0, 0.0, 1.0);
      return Eigen::Vector2d(3.0 + change, 3.0 + change);
    };
    CascadeFlight flight(options);
    flight.fly_until(500.0);
    while (flight.time() < 900.0) {
      flight.step();
      // GPS's own 5 m per axis, and what the wind does until it is noticed.
      ASSERT_LT(flight.position_error().head<2>().norm(), 50.0) << flight.time();
    }
    worst_heading = std::max(worst_heading, std::abs(flight.heading_error()));
    EXPECT_LT(flight.wind_error().norm(), 5.0);
  }
  EXPECT_LT(worst_heading, 2.5 * kDegree);  // 12 m/s taken for heading error would be 3.4
}

TEST(CascadeOutage, WithoutAirDataGpsStillCarriesIt) {
  FlightSimulator simulator{FlightOptions{}};
  const auto cascade = std::make_unique<Cascade>(CascadeParameters{});
  double sigma_before = 0.0;
  while (simulator.time() < 400.0) {
    const SimulatedFrame frame = simulator.next();
    if (frame.air && simulator.time() < 300.0) cascade->update(*frame.air);
    cascade->propagate(frame.sahrs);
    if (frame.fix) cascade->update(*frame.fix);
    if (simulator.time() < 300.0) sigma_before = cascade->navigation().sigma_wind.norm();
    const samples::Navigation& n = cascade->navigation();
    if (simulator.time() < 10.0) continue;
    ASSERT_LT(earth::displacement_N({n.lat, n.lon, n.h}, frame.truth.position()).norm(), 50.0);
  }
  EXPECT_GT(cascade->navigation().sigma_wind.norm(), 1.2 * sigma_before);
}

TEST(CascadeOutage, NothingThatPassesTheChecksMakesItUnfit) {
  std::mt19937_64 generator(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto draw = [&](double limit) { return limit * uniform(generator); };
  CascadeParameters plain, factors, small_angle;
  factors.covariance = CovarianceForm::kUd;
  small_angle.attitude_error = AttitudeError::kSmallAngle;
  small_angle.heading_deviation.sigma = 1.0 * kDegree;
  small_angle.wind_turn_gain = small_angle.heading_turn_gain = 5.0;
  for (const CascadeParameters& parameters : {plain, factors, small_angle}) {
    const auto cascade = std::make_unique<Cascade>(parameters);
    std::int64_t time_us = 0;
    const auto frame = [&](const SimulatedFrame& good, bool wild) {
      samples::AirData air = good.air.value_or(samples::AirData{});
      samples::Attitude sahrs = good.sahrs;
      samples::GpsFix fix = good.fix.value_or(samples::GpsFix{});
      if (wild) {
        air = {time_us,
               750.0 + draw(750.0),
               draw(math::kPi),
               draw(0.5 * math::kPi),
               20e3 + draw(20e3),
               288.0,
               true};
        const math::Euler e{draw(math::kPi), draw(0.5 * math::kPi), math::kPi + draw(math::kPi)};
        sahrs.q_NB = Eigen::Quaterniond(math::C_NB_from_euler(e));
        sahrs.roll = e.roll;
        sahrs.pitch = e.pitch;
        sahrs.heading = e.heading;
        sahrs.P_B = std::pow(10.0, draw(6.0)) * Eigen::Matrix3d::Identity();
        sahrs.omega_B << draw(10.0), draw(10.0), draw(10.0);
        sahrs.reset_count = static_cast<std::int16_t>(draw(3.0));
        fix.lat = draw(0.5 * math::kPi);
        fix.lon = draw(math::kPi);
        fix.h = 50e3 + draw(50e3);
        fix.sigma_horizontal = std::pow(10.0, draw(4.5));
        fix.sigma_vertical = std::pow(10.0, draw(4.5));
      }
      air.time_us = sahrs.time_us = fix.time_us = time_us;
      if (wild || good.air) cascade->update(air);
      cascade->propagate(sahrs);
      fix.time_us -= wild ? static_cast<std::int64_t>(500e3 + draw(500e3)) : 0;
      if (wild || good.fix) cascade->update(fix);
    };
    for (int i = 0; i < 20000; ++i) {
      time_us += 1 + static_cast<std::int64_t>(50e3 + draw(50e3));
      frame({}, true);
    }
    FlightOptions options;
    options.gps_latency = 0.0;
    FlightSimulator simulator(options);
    Truth truth;
    while (simulator.time() < 60.0) {
      const SimulatedFrame good = simulator.next();
      time_us += 16'667;
      frame(good, false);
      truth = good.truth;
    }
    const samples::Navigation& n = cascade->navigation();
    EXPECT_TRUE(n.valid);
    const Eigen::Vector3d error = earth::displacement_N({n.lat, n.lon, n.h}, truth.position());
    EXPECT_LT(error.norm(), 60.0) << "a minute of good data after 1000 s of nonsense";
    EXPECT_TRUE(n.v_N.allFinite() && n.sigma_position.allFinite() && n.sigma_wind.allFinite());
  }
}

TEST(CascadeOutage, AnHourWithoutGpsStaysFinite) {
  FlightOptions options;
  options.rate = 30.0;
  options.gps_on = [](double t) { return t < 60.0; };
  CascadeFlight flight(options);
  flight.fly_until(3660.0);
  const samples::Navigation& n = flight.navigation();
  EXPECT_TRUE(n.valid);
  EXPECT_LT(flight.position_error().head<2>().norm(), 3.5 * n.sigma_position.head<2>().norm());
  EXPECT_LT(n.sigma_position.head<2>().norm(), 60e3);
}

}  // namespace
}  // namespace lodestar::fusion
