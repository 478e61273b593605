// SPDX-License-Identifier: Apache-2.0
// What each option of the model does in flight, and that it does nothing when it is off.
#include <gtest/gtest.h>

#include "cascade_flight.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;

/// SAHRS wrong as a compass is, and hardly otherwise.
FlightOptions compass_flight(unsigned seed) {
  FlightOptions options;
  options.seed = seed;
  options.rate = 30.0;
  options.leg = 60.0;
  options.heading_error.sigma = 0.2 * kDegree;
  options.compass_error << 2.0 * kDegree, -1.5 * kDegree;
  return options;
}

CascadeParameters with_deviation() {
  CascadeParameters parameters;
  parameters.heading_error.sigma = 0.3 * kDegree;
  parameters.heading_deviation.sigma = 2.0 * kDegree;
  return parameters;
}

/// Rms of the heading error from `from` to `to` (s), over four flights.
double heading_rms(const CascadeParameters& parameters, double from, double to) {
  double sum = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    CascadeFlight flight(compass_flight(seed), parameters);
    flight.fly_until(from);
    while (flight.time() < to) {
      flight.step();
      sum += std::pow(flight.heading_error(), 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(CascadeOptions, ACompassErrorIsLearntOnceAndHoldsOnEveryHeading) {
  // Without it each turn makes another heading error, which has to be found anew.
  const double without = heading_rms({}, 400.0, 800.0);
  const double with = heading_rms(with_deviation(), 400.0, 800.0);
  EXPECT_GT(without, 0.5 * kDegree);
  EXPECT_LT(with, 0.5 * without);
}

TEST(CascadeOptions, AKnownHeadingIsOfErrorAndDeviationTogether) {
  for (const bool small_angle : {false, true}) {
    CascadeParameters parameters = with_deviation();
    if (small_angle) parameters.attitude_error = AttitudeError::kSmallAngle;
    parameters.initial_heading = 0.5;  // the simulator's
    FlightOptions options = compass_flight(1);
    options.leg = 1000.0;
    CascadeFlight flight(options, parameters);
    flight.fly_until(3.0);
    EXPECT_LT(std::abs(flight.heading_error()), 0.3 * kDegree);
    EXPECT_LT(flight.navigation().sigma_attitude.z(), 0.4 * kDegree);
    flight.fly_until(60.0);
    const double error = math::wrap_pi(flight.truth().attitude.heading - flight.sahrs().heading);
    flight.cascade().know_heading_error(error, 0.1 * kDegree, flight.sahrs().time_us);
    flight.fly_until(60.2);
    EXPECT_LT(std::abs(flight.heading_error()), 0.3 * kDegree);
    EXPECT_LT(flight.navigation().sigma_attitude.z(), 0.4 * kDegree);
  }
}

TEST(CascadeOptions, AnInitialHeadingCanBeLeftUnused) {
  CascadeParameters parameters;
  parameters.initial_heading = 0.5;
  parameters.use_initial_heading = false;
  FlightOptions options = FlightOptions::perfect();
  options.heading_offset = 8.0 * kDegree;
  CascadeFlight flight(options, parameters);
  flight.fly_until(0.5);
  EXPECT_GT(std::abs(flight.heading_error()), 7.0 * kDegree);
}

TEST(CascadeOptions, SmallAnglesHoldTheSameFlightAsEulerErrors) {
  FlightOptions options;
  CascadeFlight euler(options);
  CascadeParameters parameters;
  parameters.attitude_error = AttitudeError::kSmallAngle;
  CascadeFlight small_angle(options, parameters);
  while (euler.time() < 600.0) {
    euler.step();
    small_angle.step();
    if (euler.time() < 60.0) continue;
    // The two models of tilt differ in turns only, and tilt hardly moves the track.
    ASSERT_LT((euler.position_error() - small_angle.position_error()).norm(), 2.0);
    ASSERT_LT(std::abs(euler.heading_error() - small_angle.heading_error()), 0.4 * kDegree);
    const Eigen::Vector3d a = euler.navigation().sigma_attitude;
    const Eigen::Vector3d b = small_angle.navigation().sigma_attitude;
    ASSERT_LT((a - b).norm(), 0.2 * a.norm());
  }
}

TEST(CascadeOptions, SmallAnglesGoStraightUpWithoutLosingSigma) {
  CascadeParameters parameters;
  parameters.attitude_error = AttitudeError::kSmallAngle;
  FlightOptions options;
  options.climb = 89.0 * kDegree;  // a leg up, a turn, a leg down
  options.leg = 20.0;
  CascadeFlight flight(options, parameters);
  while (flight.time() < 120.0) {
    flight.step();
    if (flight.time() < 5.0) continue;
    const samples::Navigation& n = flight.navigation();
    ASSERT_TRUE(n.sigma_attitude.allFinite() && n.v_N.allFinite());
    ASSERT_LT(flight.position_error().head<2>().norm(), 60.0) << flight.time();
  }
}

TEST(CascadeOptions, TheWindIsLessKnownAfterATurnWithItsTurnGain) {
  CascadeParameters parameters;
  FlightOptions options;
  options.rate = 30.0;
  CascadeFlight plain(options, parameters);
  parameters.wind_turn_gain = 30.0;
  CascadeFlight raised(options, parameters);
  plain.fly_until(115.0);  // straight so far
  raised.fly_until(115.0);
  EXPECT_EQ(raised.navigation().lat, plain.navigation().lat);
  EXPECT_EQ(raised.navigation().sigma_wind, plain.navigation().sigma_wind);
  plain.fly_until(180.0);  // half a turn
  raised.fly_until(180.0);
  EXPECT_GT(raised.navigation().sigma_wind.norm(), 1.2 * plain.navigation().sigma_wind.norm());
}

/// Whether two parameter sets make the same outputs, bit for bit.
void expect_same_bits(const CascadeParameters& one, const CascadeParameters& other) {
  FlightOptions options;
  options.rate = 30.0;
  options.leg = 60.0;
  options.gps_on = [](double t) { return t < 100.0 || t > 130.0; };
  CascadeFlight a(options, one);
  CascadeFlight b(options, other);
  while (a.time() < 200.0) {
    a.step();
    b.step();
    const samples::Navigation& m = a.navigation();
    const samples::Navigation& n = b.navigation();
    ASSERT_TRUE(m.lat == n.lat && m.lon == n.lon && m.v_N == n.v_N && m.roll == n.roll &&
                m.pitch == n.pitch && m.heading == n.heading && m.wind_N == n.wind_N &&
                m.sigma_position == n.sigma_position && m.sigma_wind == n.sigma_wind &&
                m.sigma_attitude == n.sigma_attitude)
        << a.time();
  }
}

TEST(CascadeOptions, ADeviationOfZeroIsNone) {
  CascadeParameters other;
  other.heading_deviation.tau = 20.0;
  expect_same_bits({}, other);
}

TEST(CascadeOptions, BothCovarianceFormsGiveTheSameFlightWithEachOption) {
  CascadeParameters small_angle;
  small_angle.attitude_error = AttitudeError::kSmallAngle;
  CascadeParameters turning;
  turning.wind_turn_gain = turning.heading_turn_gain = 5.0;
  CascadeParameters linearised;
  linearised.linearisation = Linearisation::kLinearised;
  for (CascadeParameters parameters : {small_angle, turning, linearised, with_deviation()}) {
    const FlightOptions options = compass_flight(3);
    CascadeFlight joseph(options, parameters);
    parameters.covariance = CovarianceForm::kUd;
    CascadeFlight ud(options, parameters);
    joseph.fly_until(300.0);
    ud.fly_until(300.0);
    const samples::Navigation& a = joseph.navigation();
    const samples::Navigation& b = ud.navigation();
    EXPECT_NEAR(a.lat, b.lat, 1e-9 * a.lat);
    EXPECT_NEAR(a.heading, b.heading, 1e-9);
    EXPECT_LT((a.wind_N - b.wind_N).norm(), 1e-9 * a.wind_N.norm());
    EXPECT_LT((a.sigma_position - b.sigma_position).norm(), 1e-9 * a.sigma_position.norm());
    EXPECT_LT((a.sigma_attitude - b.sigma_attitude).norm(), 1e-9 * a.sigma_attitude.norm());
  }
}

}  // namespace
}  // namespace lodestar::fusion
