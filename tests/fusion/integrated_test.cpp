// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/integrated.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "integrated_flight.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;
using samples::FusionMode;
using strapdown::SensorErrors;

IntegratedFlight fighter(std::uint32_t seed, double heading_sigma = 0.1 * kDegree) {
  std::mt19937 generator(seed);
  const SensorErrors errors = SensorErrors::fighter(generator);
  std::normal_distribution<double> normal(0.0, heading_sigma);
  return IntegratedFlight(errors, seed, normal(generator), heading_sigma);
}

TEST(Integrated, WaitsForAFixAndThenHasAPosition) {
  IntegratedFlight run(SensorErrors{}, 1);
  run.fly(0.4);
  EXPECT_EQ(run.nav().mode, FusionMode::kWaiting);
  EXPECT_FALSE(run.nav().valid);
  EXPECT_EQ(run.nav().horizontal_protection_level, -1.0);
  run.fly(0.2);
  EXPECT_EQ(run.nav().mode, FusionMode::kAiding);
  EXPECT_TRUE(run.nav().valid);
  EXPECT_LT(run.position_error().norm(), 3.0);  // by then the unknown wind has blown for 0.1 s
}

TEST(Integrated, PerfectSensorsGiveWindHeadingAndPosition) {
  IntegratedFlight run(SensorErrors{}, 1);
  run.fly(300.0);
  EXPECT_LT(run.wind_error().norm(), 0.1);
  EXPECT_LT(std::abs(run.heading_error()), 0.05 * kDegree);
  EXPECT_LT(run.position_error().norm(), 0.3);
  EXPECT_EQ(run.nav().reset_count, 0);
}

TEST(Integrated, TurnsTellTheHeadingThatTheStartDidNot) {
  IntegratedFlight run(SensorErrors{}, 2, 4.0 * kDegree, 3.0 * kDegree);
  run.fly(200.0);
  EXPECT_LT(std::abs(run.heading_error()), 0.5 * kDegree);
  EXPECT_LT(run.wind_error().norm(), 0.5);
}

TEST(Integrated, ALateFixDoesWhatAPromptOneDoes) {
  for (const std::size_t frames : {12u, 42u}) {
    IntegratedFlight prompt(SensorErrors{}, 3), late(SensorErrors{}, 3);
    late.latency_frames = frames;
    prompt.fly(120.0);
    late.fly(120.0);
    // The late one has one fix less.
    EXPECT_LT((late.position_error() - prompt.position_error()).norm(), 0.3) << frames;
    EXPECT_LT((late.wind_error() - prompt.wind_error()).norm(), 0.1) << frames;
  }
}

/// A flight whose sensors err as the filter is told, and in no other way.
IntegratedFlight matched(std::uint32_t seed) {
  strapdown::Parameters sensors;
  sensors.gyro_drift.sigma = sensors.gyro_scale_sigma = sensors.gyro_misalignment_sigma = 0.0;
  sensors.field_drift.sigma = sensors.field_matrix_sigma = 0.0;
  sensors.airspeed_scale_sigma = sensors.flow_scale_sigma = 0.0;
  sensors.wind_walk = sensors.wind_walk_min = sensors.wind_walk_max = 1e-3;
  sensors.gust_sigma = sensors.gust_sigma_min = sensors.gust_sigma_max = 1e-3;
  sensors.height_walk = 1e-3;
  IntegratedParameters parameters;
  parameters.ground.gps_error.sigma = 1e-3;
  std::mt19937 generator(seed);
  const SensorErrors errors = SensorErrors::fighter(generator);
  std::normal_distribution<double> normal(0.0, 0.1 * kDegree);
  return IntegratedFlight(errors, seed, normal(generator), 0.1 * kDegree, sensors, parameters);
}

TEST(Integrated, SigmaCoversTheErrorOverManyFlights) {
  constexpr std::uint32_t kFlights = 40;
  double heading = 0.0, wind = 0.0, position = 0.0;
  for (std::uint32_t seed = 1; seed <= kFlights; ++seed) {
    IntegratedFlight run = matched(seed);
    run.fly(150.0);
    const samples::Navigation& nav = run.nav();
    heading += std::pow(run.heading_error() / nav.sigma_attitude.z(), 2);
    wind += run.wind_error().cwiseQuotient(nav.sigma_wind).squaredNorm() / 2.0;
    position += run.position_error().cwiseQuotient(nav.sigma_position.head<2>()).squaredNorm() / 2;
    EXPECT_LT(run.position_error().norm(), nav.horizontal_protection_level);
  }
  // 99.8 % of such means lie within 0.46 to 1.84 (40 degrees of freedom), 0.60 to 1.56 (80).
  EXPECT_GT(heading / kFlights, 0.46);
  EXPECT_LT(heading / kFlights, 1.84);
  EXPECT_GT(wind / kFlights, 0.60);
  EXPECT_LT(wind / kFlights, 1.56);
  EXPECT_GT(position / kFlights, 0.60);
  EXPECT_LT(position / kFlights, 1.56);
}

TEST(Integrated, FliesOnWithoutGpsAndKnowsHowWell) {
  IntegratedFlight run = fighter(5);
  run.fly(240.0);
  run.with_gps = false;
  run.fly(120.0);
  EXPECT_EQ(run.nav().mode, FusionMode::kDeadReckoning);
  EXPECT_TRUE(run.nav().valid);
  EXPECT_NEAR(run.nav().gps_age, 120.0, 1.0);
  const double sigma = run.nav().sigma_position.head<2>().norm();
  EXPECT_LT(run.position_error().norm(), 3.0 * sigma);
  EXPECT_LT(sigma, 100.0);
  run.with_gps = true;
  run.fly(10.0);
  EXPECT_EQ(run.nav().mode, FusionMode::kAiding);
  EXPECT_EQ(run.nav().reset_count, 1);
  EXPECT_LT(run.position_error().norm(), 10.0);
}

TEST(Integrated, WithoutGpsTheWindIsTakenToBeAsLivelyAsItsGusts) {
  std::mt19937 generator(6);
  strapdown::Parameters sensors;
  IntegratedParameters parameters;
  // A filter that is sure of gusts, in air that has none.
  sensors.gust_sigma_min = parameters.ground.still_gust_sigma = 1.0;
  IntegratedFlight run(SensorErrors::fighter(generator), 6, 0.0, 0.1 * kDegree, sensors,
                       parameters);
  const strapdown::GroundFilter& filter = std::as_const(run.filter()).filter();
  const double least = strapdown::GroundParameters{}.lost_wind_walk;
  run.fly(240.0);
  EXPECT_LT(filter.wind_walk(), 0.5 * least);
  run.with_gps = false;
  run.fly(30.0);
  const double gusts =
      std::sqrt(std::pow(filter.gust_sigma(), 2) - std::pow(strapdown::StillAir::kCalm, 2));
  EXPECT_GE(filter.wind_walk(), least * gusts);
  run.with_gps = true;
  run.fly(200.0);
  EXPECT_LT(filter.wind_walk(), 0.5 * least);
}

TEST(Integrated, StillAirIsKnownForStill) {
  IntegratedFlight run = fighter(7);
  run.fly(900.0);
  EXPECT_LT(std::as_const(run.filter()).filter().wind_walk(), 0.001);
  EXPECT_LT(std::as_const(run.filter()).filter().gust_sigma(), 0.02);
  EXPECT_LT(run.wind_error().norm(), 3.0 * run.nav().sigma_wind.norm());
}

TEST(Integrated, AWindThatChangesTooSlowlyForTheAirDataIsSeenByTheFixes) {
  IntegratedFlight run = fighter(8);
  run.fly(600.0);
  ASSERT_LT(std::as_const(run.filter()).filter().wind_walk(), 0.001);
  run.change_wind({0.002, -0.001});
  run.fly(300.0);
  EXPECT_GT(std::as_const(run.filter()).filter().wind_walk(), 0.006);
  EXPECT_LT(run.wind_error().norm(), 3.0 * run.nav().sigma_wind.norm());
}

TEST(Integrated, TakesGoodAirspeedHoweverLongThereIsNoGps) {
  IntegratedFlight run = fighter(21);
  run.fly(200.0);
  run.with_gps = false;
  run.airspeed_refused = 0;
  run.fly(600.0);
  EXPECT_LE(run.airspeed_refused, 2);  // of 18 000; the gate refuses a good one in 100 000
  EXPECT_LT(run.position_error().norm(), 3.0 * run.nav().sigma_position.head<2>().norm());
}

TEST(Integrated, HeadingDoesNotJumpWhenGpsComesBackOrIsElsewhere) {
  IntegratedFlight run = fighter(22);
  run.fly(200.0);
  double before = run.heading_error(), largest = 0.0;
  const auto watch = [&](double seconds) {
    for (double flown = 0.0; flown < seconds; flown += 1.0 / 60.0) {
      run.fly(1.0 / 60.0);
      largest = std::max(largest, std::abs(math::wrap_pi(run.heading_error() - before)));
      before = run.heading_error();
      ASSERT_LT(std::abs(before), 4.0 * run.nav().sigma_attitude.z());
    }
  };
  run.with_gps = false;
  watch(120.0);
  run.with_gps = true;
  watch(20.0);
  run.spoil = [](samples::GpsFix& fix) { fix.lon += 5000.0 / 6.4e6; };
  watch(20.0);
  run.spoil = [](samples::GpsFix&) {};
  watch(20.0);
  EXPECT_EQ(run.nav().reset_count, 3);
  EXPECT_LT(largest, 0.1 * kDegree);
}

TEST(Integrated, AJumpThatLastsIsBelievedWithinTenSecondsAndTold) {
  IntegratedFlight run = fighter(6);
  run.fly(120.0);
  run.spoil = [](samples::GpsFix& fix) { fix.lat += 500.0 / 6.4e6; };
  run.fly(2.0);
  EXPECT_EQ(run.last_use, samples::Use::kGated);
  EXPECT_LT(run.position_error().norm(), 15.0);
  run.fly(8.0);
  EXPECT_EQ(run.nav().mode, FusionMode::kAiding);
  EXPECT_EQ(run.nav().reset_count, 1);
  EXPECT_NEAR(run.nav().reset_delta.x(), 500.0, 20.0);
}

TEST(Integrated, ASlowDragOffIsToldThoughNoFixIsBeyondTheGate) {
  IntegratedFlight run = fighter(17);
  run.fly(240.0);
  ASSERT_EQ(run.nav().reset_count, 0);
  double dragged = 0.0;
  run.spoil = [&](samples::GpsFix& fix) { fix.lat += (dragged += 2.0) / 6.4e6; };  // 2 m/s
  const int before = run.used;
  run.fly(30.0);
  EXPECT_EQ(run.nav().reset_count, 1);
  EXPECT_GT(run.nav().reset_delta.x(), 2.0);
  EXPECT_GT(run.used - before, 20);
  EXPECT_EQ(run.nav().mode, FusionMode::kAiding);
}

TEST(Integrated, FixesThatScatterAreNotBelieved) {
  IntegratedFlight run = fighter(7);
  run.fly(120.0);
  std::mt19937 generator(1);
  std::normal_distribution<double> wide(0.0, 300.0 / 6.4e6);
  run.spoil = [&](samples::GpsFix& fix) { fix.lat += wide(generator); };
  const int before = run.used;
  run.fly(60.0);
  EXPECT_LE(run.used - before, 2);  // one now and then lies where it should
  EXPECT_LT(run.position_error().norm(), 60.0);
}

TEST(Integrated, AFixThatStandsStillIsNotTaken) {
  IntegratedFlight run = fighter(8);
  run.fly(120.0);
  samples::GpsFix frozen;
  bool first = true;
  run.spoil = [&](samples::GpsFix& fix) {
    if (first) frozen = fix;
    first = false;
    fix.lat = frozen.lat;
    fix.lon = frozen.lon;
  };
  run.fly(60.0);
  EXPECT_EQ(run.last_use, samples::Use::kGated);
  EXPECT_LT(run.position_error().norm(), 60.0);
}

TEST(Integrated, TakesTheHeadingOfAReferenceThatIsLost) {
  IntegratedFlight run = fighter(9, 3.0 * kDegree);
  run.fly(20.0);
  const double before = run.nav().sigma_attitude.z();
  ASSERT_GT(before, 0.6 * kDegree);
  const double true_heading = run.nav().heading - run.heading_error();
  run.filter().know_heading_error(math::wrap_pi(true_heading - run.sahrs_heading()), 0.1 * kDegree,
                                  20 * 1'000'000 - 1'000'000 / 60);
  run.fly(0.2);
  EXPECT_LT(std::abs(run.heading_error()), 0.4 * kDegree);
  EXPECT_LT(run.nav().sigma_attitude.z(), 0.4 * before);
}

TEST(Integrated, AReferenceThatContradictsIsNotTaken) {
  IntegratedFlight run = fighter(10);
  run.fly(200.0);
  const double before = run.heading_error();
  run.filter().know_heading_error(math::wrap_pi(run.nav().heading - run.sahrs_heading() + 0.1),
                                  0.1 * kDegree, 199'000'000);
  run.fly(0.1);
  EXPECT_NEAR(run.heading_error(), before, 0.05 * kDegree);
}

TEST(Integrated, StartsAnewFromSahrsAfterALongGapInTheRates) {
  IntegratedFlight run = fighter(11);
  run.fly(120.0);
  run.silent = true;
  run.fly(2.0);
  run.silent = false;
  run.fly(10.0);
  EXPECT_GE(run.nav().reset_count, 1);
  EXPECT_TRUE(run.nav().valid);
  EXPECT_LT(run.position_error().norm(), 30.0);
}

TEST(Integrated, FliesOnWithoutAirDataAndWithoutTheField) {
  for (const bool air : {true, false}) {
    IntegratedFlight run = fighter(14);
    run.fly(200.0);
    (air ? run.with_air : run.with_field) = false;
    run.fly(120.0);
    EXPECT_TRUE(run.nav().valid);
    EXPECT_LT(run.position_error().norm(), 20.0) << (air ? "no air data" : "no field");
    EXPECT_LT(std::abs(run.heading_error()), 3.0 * run.nav().sigma_attitude.z());
    EXPECT_LT(std::abs(run.heading_error()), 2.0 * kDegree);
  }
}

TEST(Integrated, WithoutAnyAirDataItStartsFromTheFixes) {
  IntegratedFlight run = fighter(16);
  run.with_air = false;
  run.fly(9.0);
  EXPECT_FALSE(run.nav().valid);  // they may still come
  run.fly(6.0);
  EXPECT_TRUE(run.nav().valid);
  run.fly(285.0);
  EXPECT_LT(run.position_error().norm(), 20.0);
  EXPECT_LT(run.velocity_error().norm(), 1.5);
  EXPECT_LT(run.velocity_error().cwiseQuotient(run.nav().sigma_velocity.head<2>()).norm(), 3.5);
  EXPECT_LT(std::abs(run.heading_error()), 3.0 * run.nav().sigma_attitude.z());
  EXPECT_LT(run.nav().sigma_attitude.z(), 2.0 * kDegree);
  EXPECT_GT(run.nav().sigma_wind.minCoeff(), 5.0);  // nothing tells it
  EXPECT_EQ(run.nav().reset_count, 0);

  run.with_air = true;
  run.fly(120.0);
  EXPECT_LT(run.wind_error().norm(), 3.0);
  EXPECT_LT(run.position_error().norm(), 20.0);
  EXPECT_LT(std::abs(run.heading_error()), 1.0 * kDegree);
}

TEST(Integrated, LongStraightFlightSpoilsNeitherWindNorAirspeed) {
  constexpr std::uint32_t kFlights = 10;
  double wind = 0.0, scale = 0.0;
  for (std::uint32_t seed = 1; seed <= kFlights; ++seed) {
    std::mt19937 generator(seed);
    IntegratedFlight run(SensorErrors::fighter(generator), seed, 0.0, 0.1 * kDegree, {}, {}, 0.0);
    run.fly(400.0);
    const strapdown::GroundFilter& filter = std::as_const(run.filter()).filter();
    wind += run.wind_error().cwiseQuotient(run.nav().sigma_wind).squaredNorm() / 2.0;
    const int row = strapdown::kAirspeedScale.offset;
    scale += std::pow(filter.estimate().airspeed_scale, 2) / filter.covariance()(row, row);
  }
  EXPECT_LT(wind / kFlights, 1.7);   // of 20 degrees of freedom: 97 %
  EXPECT_LT(scale / kFlights, 1.0);  // there is none, and nothing tells it
}

TEST(Integrated, ABadStartMakesNoAbsurdWind) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    IntegratedFlight run = fighter(seed, 5.0 * kDegree);
    run.fly(3.0);
    for (int i = 0; i < 100; ++i) {
      run.fly(1.0);
      ASSERT_LT(run.nav().wind_N.norm(), 40.0) << "seed " << seed << ", " << i << " s";
    }
  }
}

TEST(Integrated, APitotThatIcesUpSpoilsNeitherPositionNorHeading) {
  IntegratedFlight run = fighter(15);
  run.fly(200.0);
  for (int i = 0; i < 60; ++i) {
    run.airspeed_error -= 0.5;
    run.fly(1.0);
  }
  EXPECT_LT(run.position_error().norm(), 20.0);
  EXPECT_LT(std::abs(run.heading_error()), 3.0 * kDegree);
  run.airspeed_error = 0.0;
  run.fly(120.0);
  EXPECT_LT(std::abs(run.heading_error()), 1.0 * kDegree);
  EXPECT_LT(run.wind_error().norm(), 3.0);
}

TEST(Integrated, OutputMovesOnThroughAFrameWithoutRates) {
  IntegratedFlight run(SensorErrors{}, 12);
  run.fly(60.0);
  const samples::Navigation before = run.nav();
  run.filter().coast(before.time_us + 1'000'000);
  const earth::Geodetic from{before.lat, before.lon, before.h};
  const earth::Geodetic to{run.nav().lat, run.nav().lon, run.nav().h};
  EXPECT_LT((earth::displacement_N(from, to) - before.v_N).norm(), 0.01);
}

TEST(Integrated, SameInputSameBits) {
  IntegratedFlight one = fighter(13), other = fighter(13);
  one.fly(30.0);
  other.fly(30.0);
  EXPECT_EQ(one.nav().lat, other.nav().lat);
  EXPECT_EQ(one.nav().sigma_wind, other.nav().sigma_wind);
}

}  // namespace
}  // namespace lodestar::fusion
