// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/cascade.h"

#include <gtest/gtest.h>

#include "cascade_flight.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;
using samples::FusionMode;
using samples::Use;

TEST(Cascade, WaitsForItsFirstFix) {
  FlightOptions options = FlightOptions::perfect();
  options.gps_on = [](double t) { return t >= 10.0; };
  CascadeFlight flight(options);
  flight.fly_until(10.0);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kWaiting);
  EXPECT_FALSE(flight.navigation().valid);
  EXPECT_EQ(flight.navigation().gps_age, -1.0);
  flight.fly_until(10.3);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kAiding);
  EXPECT_TRUE(flight.navigation().valid);
  EXPECT_EQ(flight.navigation().reset_count, 0);
}

TEST(Cascade, BringsItsFirstFixForward) {
  FlightOptions options = FlightOptions::perfect();
  options.wind = [](double) { return Eigen::Vector2d(0.0, 0.0); };
  options.gps_latency = 0.8;  // 160 m of flight
  CascadeFlight flight(options);
  flight.fly_until(0.9);
  ASSERT_TRUE(flight.navigation().valid);
  EXPECT_LT(flight.position_error().head<2>().norm(), 1e-3);
}

TEST(Cascade, WaitsForAirDataAndForAValidAttitude) {
  const auto cascade = std::make_unique<Cascade>(CascadeParameters{});
  FlightSimulator simulator(FlightOptions::perfect());
  for (int i = 0; i < 60; ++i) {
    const SimulatedFrame frame = simulator.next();
    cascade->propagate(frame.sahrs);
    if (frame.fix) {
      EXPECT_EQ(cascade->update(*frame.fix), Use::kHeld);
    }
  }
  EXPECT_EQ(cascade->navigation().mode, FusionMode::kWaiting);
  for (int i = 0; i < 60; ++i) {
    SimulatedFrame frame = simulator.next();
    frame.sahrs.valid = false;
    if (frame.air) cascade->update(*frame.air);
    cascade->propagate(frame.sahrs);
    if (frame.fix) {
      EXPECT_EQ(cascade->update(*frame.fix), Use::kHeld);
    }
    EXPECT_FALSE(cascade->navigation().valid);
  }
}

TEST(Cascade, StartsWhereConfigured) {
  CascadeParameters parameters;
  parameters.initial_lat = 57.5 * kDegree;
  parameters.initial_lon = 16.0 * kDegree;
  parameters.initial_position_sigma = 30.0;
  FlightOptions options = FlightOptions::perfect();
  options.gps_on = [](double) { return false; };
  CascadeFlight flight(options, parameters);
  flight.step();
  EXPECT_TRUE(flight.navigation().valid);
  EXPECT_EQ(flight.navigation().mode, FusionMode::kDeadReckoning);
  EXPECT_LT(flight.position_error().head<2>().norm(), 1e-3);
  EXPECT_NEAR(flight.navigation().sigma_position.x(), 30.0, 1e-9);
  flight.fly_until(100.0);
  // Nothing wrong but the wind, which it does not know: 922 m, and sigma says so.
  EXPECT_NEAR(flight.position_error().head<2>().norm(), 100.0 * std::hypot(6.0, 7.0), 5.0);
  EXPECT_GT(flight.navigation().sigma_position.x(), 600.0);
}

TEST(Cascade, WithPerfectSensorsFindsWindAndPosition) {
  CascadeFlight flight(FlightOptions::perfect());
  flight.fly_until(600.0);
  // What is left is the doubt between wind and heading error that the racetrack leaves.
  EXPECT_LT(flight.wind_error().norm(), 0.1);
  EXPECT_LT(std::abs(flight.heading_error()), 0.03 * kDegree);
  EXPECT_LT(flight.position_error().head<2>().norm(), 0.1);
  EXPECT_LT(flight.velocity_error().norm(), 0.1);
  EXPECT_EQ(flight.navigation().reset_count, 0);
}

TEST(Cascade, SeparatesHeadingErrorFromWindInTurns) {
  FlightOptions options = FlightOptions::perfect();
  options.heading_offset = 3.0 * kDegree;
  options.heading_error.sigma = 2.0 * kDegree;  // as stated; seed 1 starts at +0.2
  options.heading_error.tau = 1e5;
  CascadeFlight flight(options);
  flight.fly_until(100.0);  // one straight leg
  EXPECT_GT(std::abs(flight.heading_error()), 0.5 * kDegree);
  flight.fly_until(700.0);
  EXPECT_LT(std::abs(flight.heading_error()), 0.4 * kDegree);
  EXPECT_LT(flight.wind_error().norm(), 1.5);
}

TEST(Cascade, AGivenHeadingStartsTheHeadingError) {
  FlightOptions options = FlightOptions::perfect();
  options.heading_offset = 8.0 * kDegree;
  CascadeParameters parameters;
  parameters.initial_heading = 0.5;  // the simulator's
  parameters.initial_heading_sigma = 0.1 * kDegree;
  CascadeFlight flight(options, parameters);
  flight.fly_until(3.0);
  EXPECT_LT(std::abs(flight.heading_error()), 0.3 * kDegree);
  EXPECT_LT(flight.navigation().sigma_attitude.z(), 0.4 * kDegree);
  EXPECT_LT(flight.velocity_error().head<2>().norm(), 12.0) << "28 m/s without it";
}

TEST(Cascade, AHeadingKnownInFlightIsTakenInAtOnce) {
  for (const auto form : {CovarianceForm::kJoseph, CovarianceForm::kUd}) {
    FlightOptions options;
    options.heading_offset = 6.0 * kDegree;
    options.leg = 1000.0;  // no turn that would tell heading from wind
    CascadeParameters parameters;
    parameters.covariance = form;
    CascadeFlight flight(options, parameters);
    flight.fly_until(60.0);
    ASSERT_GT(std::abs(flight.heading_error()), 2.0 * kDegree);
    const double error = math::wrap_pi(flight.truth().attitude.heading - flight.sahrs().heading);
    flight.cascade().know_heading_error(error, 0.2 * kDegree, flight.sahrs().time_us);
    flight.fly_until(60.2);
    EXPECT_LT(std::abs(flight.heading_error()), 0.3 * kDegree);
    EXPECT_LT(flight.navigation().sigma_attitude.z(), 0.5 * kDegree);
    flight.fly_until(65.0);  // late fixes do the steps again, that one too
    EXPECT_LT(std::abs(flight.heading_error()), 0.6 * kDegree);
  }
}

TEST(Cascade, AHeadingKnownBeforeTheFirstFixStartsTheHeadingError) {
  FlightOptions options;
  options.heading_offset = 8.0 * kDegree;
  options.gps_on = [](double t) { return t > 10.0; };
  CascadeFlight flight(options);
  flight.fly_until(5.0);
  const double error = math::wrap_pi(flight.truth().attitude.heading - flight.sahrs().heading);
  flight.cascade().know_heading_error(error, 0.1 * kDegree, flight.sahrs().time_us);
  flight.fly_until(13.0);
  // SAHRS's own error has wandered for 8 s since.
  EXPECT_LT(std::abs(flight.heading_error()), 1.5 * kDegree);
}

TEST(Cascade, AnOldHeadingCountsAsFarAsItStillHolds) {
  FlightOptions options;
  options.leg = 1000.0;
  CascadeFlight fresh(options);
  CascadeFlight stale(options);
  for (CascadeFlight* flight : {&fresh, &stale}) flight->fly_until(60.0);
  fresh.cascade().know_heading_error(0.0, 0.1 * kDegree, 60'000'000);
  stale.cascade().know_heading_error(0.0, 0.1 * kDegree, 30'000'000);
  for (CascadeFlight* flight : {&fresh, &stale}) flight->fly_until(60.2);
  EXPECT_GT(stale.navigation().sigma_attitude.z(), 2.0 * fresh.navigation().sigma_attitude.z());
}

TEST(Cascade, PublishesWhatItEstimates) {
  CascadeFlight flight(FlightOptions{});
  flight.fly_until(300.0);
  const samples::Navigation& n = flight.navigation();
  EXPECT_EQ(n.time_us, flight.sahrs().time_us);
  EXPECT_GE(n.heading, 0.0);
  EXPECT_LT(n.heading, 2.0 * math::kPi);
  EXPECT_GT(n.sigma_position.minCoeff(), 0.0);
  EXPECT_GT(n.sigma_velocity.minCoeff(), 0.0);
  EXPECT_GT(n.sigma_attitude.minCoeff(), 0.0);
  EXPECT_GT(n.sigma_wind.minCoeff(), 0.0);
  EXPECT_EQ(n.wind_N.z(), 0.0);
  EXPECT_GT(n.gps_error.norm(), 0.0);
  EXPECT_GE(n.gps_age, 0.2);
  EXPECT_LE(n.gps_age, 1.2 + 0.02);
  EXPECT_EQ(n.horizontal_protection_level, -1.0);
  EXPECT_GT(flight.cascade().innovation_sigma().minCoeff(), 0.5);
  EXPECT_LT(flight.cascade().innovation().norm(), 10.0);
}

/// What two cascades on the same flight end with, fixes at `interval`, late by `latency` or not at
/// all late; after the last fix has come to both.
std::array<samples::Navigation, 2> prompt_and_late(double rate, double interval, double latency) {
  FlightOptions options = FlightOptions::perfect();
  options.rate = rate;
  options.gps_interval = interval;
  options.gps_error.sigma = 5.0;
  options.gps_noise = 1.0;
  options.heading_offset = 2.0 * kDegree;
  options.leg = 30.0;
  options.gps_on = [](double t) { return t < 88.05; };  // in a turn
  CascadeParameters parameters;                         // the same start for both
  parameters.initial_lat = 57.5 * kDegree;
  parameters.initial_lon = 16.0 * kDegree;
  options.gps_latency = 0.0;
  CascadeFlight prompt(options, parameters);
  options.gps_latency = latency;
  CascadeFlight late(options, parameters);
  prompt.fly_until(89.1);
  late.fly_until(89.1);
  return {prompt.navigation(), late.navigation()};
}

TEST(Cascade, ALateFixDoesWhatAPromptOneWouldHaveDone) {
  for (const double rate : {60.0, 200.0, 1000.0}) {
    for (const double latency : {0.2, 0.7, 1.0}) {
      const auto [prompt, late] = prompt_and_late(rate, 1.0, latency);
      SCOPED_TRACE(testing::Message() << rate << " Hz, " << latency << " s");
      const Eigen::Vector3d apart =
          earth::displacement_N({prompt.lat, prompt.lon, 0.0}, {late.lat, late.lon, 0.0});
      // The steps of the two fall differently, and with them what trapezoids make of a turn: 1 cm,
      // where a fix that is taken for a prompt one would be 40 to 200 m wrong.
      EXPECT_LT(apart.norm(), 0.02);
      EXPECT_LT((prompt.wind_N - late.wind_N).norm(), 0.01);
      EXPECT_LT(std::abs(prompt.heading - late.heading), 1e-4);
      // Sigma is of the last step's end, up to 0.1 s apart.
      EXPECT_LT((prompt.sigma_position - late.sigma_position).norm(),
                0.03 * prompt.sigma_position.norm());
    }
  }
}

TEST(Cascade, ManyFixesUnderWayAtOnceAreAllTakenIn) {
  const auto [prompt, late] = prompt_and_late(60.0, 0.1, 0.95);
  const Eigen::Vector3d apart =
      earth::displacement_N({prompt.lat, prompt.lon, 0.0}, {late.lat, late.lon, 0.0});
  EXPECT_LT(apart.norm(), 0.02);  // ten fixes a second, each with its own steps
}

TEST(Cascade, RefusesAFixThatIsOlderThanItsMemory) {
  CascadeFlight flight(FlightOptions::perfect());
  flight.fly_until(60.0);
  samples::GpsFix fix;
  fix.time_us = 10'000'000;
  EXPECT_EQ(flight.cascade().update(fix), Use::kHeld);
  fix.time_us = 61'000'000;  // not flown yet
  EXPECT_EQ(flight.cascade().update(fix), Use::kHeld);
  EXPECT_LT(flight.position_error().head<2>().norm(), 1.0);
}

TEST(Cascade, BothCovarianceFormsGiveTheSameFlight) {
  FlightOptions options;
  options.gps_on = [](double t) { return t < 200.0 || t > 260.0; };
  CascadeParameters parameters;
  CascadeFlight joseph(options, parameters);
  parameters.covariance = CovarianceForm::kUd;
  CascadeFlight ud(options, parameters);
  for (int minute = 1; minute <= 8; ++minute) {
    joseph.fly_until(60.0 * minute);
    ud.fly_until(60.0 * minute);
    const samples::Navigation& a = joseph.navigation();
    const samples::Navigation& b = ud.navigation();
    EXPECT_NEAR(a.lat, b.lat, 1e-9 * a.lat);
    EXPECT_NEAR(a.heading, b.heading, 1e-9);
    EXPECT_LT((a.wind_N - b.wind_N).norm(), 1e-9 * a.wind_N.norm());
    EXPECT_LT((a.sigma_position - b.sigma_position).norm(), 1e-9 * a.sigma_position.norm());
    EXPECT_LT((a.sigma_wind - b.sigma_wind).norm(), 1e-9 * a.sigma_wind.norm());
    EXPECT_LT((a.sigma_attitude - b.sigma_attitude).norm(), 1e-9 * a.sigma_attitude.norm());
  }
}

TEST(Cascade, LinearisedFormHoldsPositionToo) {
  CascadeParameters parameters;
  parameters.linearisation = Linearisation::kLinearised;
  CascadeFlight flight(FlightOptions{}, parameters);
  flight.fly_until(600.0);
  EXPECT_LT(flight.position_error().head<2>().norm(), 20.0);
  EXPECT_LT(std::abs(flight.heading_error()), 2.0 * kDegree);
}

TEST(Cascade, HoldsPositionAcrossTheDateLineAndAtHighLatitude) {
  FlightOptions options;
  options.start = {84.0 * kDegree, 179.99 * kDegree, 3000.0};
  CascadeFlight flight(options);
  while (flight.time() < 400.0) {
    flight.step();
    if (flight.time() < 10.0) continue;
    ASSERT_LT(flight.position_error().head<2>().norm(), 30.0) << flight.time();
    ASSERT_LE(std::abs(flight.navigation().lon), math::kPi);
  }
}

TEST(Cascade, SaysSoWhenSahrsIsNotValidAndGoesOnAfterwards) {
  FlightSimulator simulator{FlightOptions{}};
  const auto cascade = std::make_unique<Cascade>(CascadeParameters{});
  Truth truth;
  while (simulator.time() < 200.0) {
    SimulatedFrame frame = simulator.next();
    frame.sahrs.valid = frame.sahrs.time_us < 100'000'000 || frame.sahrs.time_us >= 103'000'000;
    if (frame.air) cascade->update(*frame.air);
    cascade->propagate(frame.sahrs);
    if (frame.fix) cascade->update(*frame.fix);
    EXPECT_EQ(cascade->navigation().time_us, frame.sahrs.time_us);
    if (!frame.sahrs.valid) {
      EXPECT_FALSE(cascade->navigation().valid);
    }
    truth = frame.truth;
  }
  const samples::Navigation& n = cascade->navigation();
  EXPECT_TRUE(n.valid);
  EXPECT_LT(earth::displacement_N({n.lat, n.lon, n.h}, truth.position()).norm(), 40.0);
}

TEST(Cascade, ARestartOfSahrsDoesNotUpsetThePosition) {
  FlightSimulator simulator{FlightOptions{}};
  const auto cascade = std::make_unique<Cascade>(CascadeParameters{});
  while (simulator.time() < 300.0) {
    SimulatedFrame frame = simulator.next();
    if (frame.sahrs.time_us >= 150'000'000) {  // starts anew, 6 degrees from where it was
      frame.sahrs.reset_count = 1;
      frame.sahrs.heading = math::wrap_2pi(frame.sahrs.heading + 6.0 * kDegree);
      frame.sahrs.q_NB = Eigen::Quaterniond(
          math::C_NB_from_euler({frame.sahrs.roll, frame.sahrs.pitch, frame.sahrs.heading}));
      frame.sahrs.P_B.diagonal().array() += std::pow(6.0 * kDegree, 2);
    }
    if (frame.air) cascade->update(*frame.air);
    cascade->propagate(frame.sahrs);
    if (frame.fix) cascade->update(*frame.fix);
    const samples::Navigation& n = cascade->navigation();
    if (simulator.time() < 10.0) continue;
    const Eigen::Vector3d error =
        earth::displacement_N({n.lat, n.lon, n.h}, frame.truth.position());
    ASSERT_LT(error.head<2>().norm(), 60.0) << simulator.time();
  }
  EXPECT_EQ(cascade->navigation().reset_count, 0);
}

}  // namespace
}  // namespace lodestar::fusion
