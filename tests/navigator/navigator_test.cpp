// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/navigator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace lodestar::navigator {
namespace {

using samples::Channel;
using samples::Reason;

constexpr std::int64_t kFrame = 20'000;  // us

/// Straight and level flight to the north at 150 m/s with a little noise on every sensor.
class LevelFlight {
 public:
  explicit LevelFlight(const Config& config = {}) : navigator(config) {}

  double noise(double sigma) { return sigma * normal_(random_); }

  samples::BodyRates rates(std::int64_t time_us) {
    samples::BodyRates s;
    s.time_us = time_us;
    s.omega_B = {noise(1e-3), noise(1e-3), noise(1e-3)};
    return s;
  }
  samples::LoadFactor load(std::int64_t time_us) {
    samples::LoadFactor s;
    s.time_us = time_us;
    s.n_B = {noise(0.01), noise(0.01), 1.0 + noise(0.01)};
    return s;
  }
  samples::MagneticField field(std::int64_t time_us) {
    samples::MagneticField s;
    s.time_us = time_us;
    s.b_B = {15'900.0 + noise(50.0), 1'800.0 + noise(50.0), 48'600.0 + noise(50.0)};
    return s;
  }
  samples::AirData air(std::int64_t time_us) {
    samples::AirData s;
    s.time_us = time_us;
    s.true_airspeed = 150.0 + noise(0.3);
    s.alpha = noise(1e-3);
    s.beta = noise(1e-3);
    s.baro_altitude = 3000.0 + noise(0.3);
    return s;
  }
  samples::InsSolution ins(std::int64_t time_us) {
    samples::InsSolution s;
    s.time_us = time_us;
    s.roll = noise(1e-4);
    s.pitch = noise(1e-4);
    s.heading = math::wrap_2pi(ins_heading + noise(1e-4));
    s.valid = ins_valid;
    return s;
  }
  samples::GpsFix fix(std::int64_t time_us) {
    samples::GpsFix s;
    s.time_us = time_us;
    s.lat = 57.5 * math::kDegree + 150e-6 * static_cast<double>(time_us) / 6.37e6 + noise(1e-7);
    s.lon = 16.0 * math::kDegree + noise(1e-7);
    s.h = 3000.0 + noise(1.0);
    return s;
  }

  /// Frames from the last one to `until_us`, all sensors with them; GPS at 1 Hz.
  void fly(std::int64_t until_us) {
    for (; next_us <= until_us; next_us += kFrame) {
      navigator.offer(load(next_us));
      navigator.offer(field(next_us));
      navigator.offer(air(next_us));
      if (with_gps && next_us % 1'000'000 == 0) navigator.offer(fix(next_us));
      if (with_ins) navigator.offer(ins(next_us));
      outputs.push_back(*navigator.step(rates(next_us)));
    }
  }

  std::int64_t rejected(Channel channel, Reason reason) const {
    return of(navigator.health().counters, channel).rejected[static_cast<std::size_t>(reason)];
  }
  std::int64_t used(Channel channel) const { return of(navigator.health().counters, channel).used; }

  Navigator navigator;
  std::vector<Outputs> outputs;
  std::int64_t next_us = 0;
  bool with_gps = true;
  bool with_ins = false;
  bool ins_valid = true;
  double ins_heading = 0.0;  // rad

 private:
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
};

TEST(Navigator, AnswersEveryFrameAtItsTime) {
  LevelFlight flight;
  flight.fly(10'000'000);
  ASSERT_EQ(flight.outputs.size(), 501u);
  for (std::size_t i = 0; i < flight.outputs.size(); ++i) {
    EXPECT_EQ(flight.outputs[i].sahrs.time_us, static_cast<std::int64_t>(i) * kFrame);
    EXPECT_EQ(flight.outputs[i].nav.time_us, static_cast<std::int64_t>(i) * kFrame);
  }
}

TEST(Navigator, FindsLevelFlightToTheNorth) {
  LevelFlight flight;
  flight.fly(60'000'000);
  const Outputs& last = flight.outputs.back();
  EXPECT_TRUE(last.sahrs.valid);
  EXPECT_TRUE(last.nav.valid);
  EXPECT_NEAR(last.sahrs.roll, 0.0, 1.0 * math::kDegree);  // sensors' noise and its filtering
  EXPECT_NEAR(last.sahrs.pitch, 0.0, 1.0 * math::kDegree);
  EXPECT_NEAR(math::wrap_pi(last.sahrs.heading), 0.0, 3.0 * math::kDegree);
  EXPECT_NEAR(last.nav.lat, flight.fix(60'000'000).lat, 20.0 / 6.37e6);
}

TEST(Navigator, NavigatesFromAConfiguredPositionWithoutAnyFix) {
  Config config;
  config.initial.position_sigma = 20.0;
  LevelFlight flight(config);
  LevelFlight waiting;
  for (LevelFlight* each : {&flight, &waiting}) {
    each->with_gps = false;
    each->fly(30'000'000);
  }
  EXPECT_TRUE(flight.outputs.back().nav.valid);
  // It starts there as soon as the attitude is valid, which takes the first seconds of the 4.5 km.
  EXPECT_NEAR(flight.outputs.back().nav.lat, flight.fix(30'000'000).lat, 2000.0 / 6.37e6);
  EXPECT_FALSE(waiting.outputs.back().nav.valid);
}

TEST(Navigator, HealthIsDueOnTheFirstFrameAndThenOnceASecond) {
  LevelFlight flight;
  flight.next_us = 300'000;
  flight.fly(5'000'000);
  std::vector<std::int64_t> due;
  for (const Outputs& outputs : flight.outputs) {
    if (outputs.health_due) due.push_back(outputs.sahrs.time_us);
  }
  EXPECT_EQ(due, (std::vector<std::int64_t>{300'000, 1'000'000, 2'000'000, 3'000'000, 4'000'000,
                                            5'000'000}));
}

TEST(Navigator, TheSameSamplesGiveTheSameBits) {
  LevelFlight one;
  LevelFlight two;
  one.fly(20'000'000);
  two.fly(20'000'000);
  for (std::size_t i = 0; i < one.outputs.size(); ++i) {
    ASSERT_EQ(one.outputs[i].sahrs.q_NB.coeffs(), two.outputs[i].sahrs.q_NB.coeffs()) << i;
    ASSERT_EQ(one.outputs[i].nav.lat, two.outputs[i].nav.lat) << i;
    ASSERT_EQ(one.outputs[i].nav.wind_N, two.outputs[i].nav.wind_N) << i;
  }
}

TEST(Navigator, AMeasurementWaitsForTheFrameOfItsTime) {
  LevelFlight flight;
  flight.fly(2'000'000);
  const std::int64_t before = flight.used(Channel::kMagneticField);
  flight.navigator.offer(flight.field(2'030'000));
  flight.navigator.step(flight.rates(2'020'000));
  EXPECT_EQ(flight.used(Channel::kMagneticField), before);
  flight.navigator.step(flight.rates(2'040'000));
  EXPECT_EQ(flight.used(Channel::kMagneticField), before + 1);
}

TEST(Navigator, AnInsSolutionWaitsForItsFrameAndNeverMovesSahrs) {
  LevelFlight flight;
  LevelFlight alone;
  flight.fly(2'000'000);
  alone.fly(2'000'000);
  samples::InsSolution ins = flight.ins(2'030'000);
  ins.roll = 0.5;
  alone.ins(2'030'000);  // draws the same noise
  flight.navigator.offer(ins);
  flight.fly(2'020'000);
  EXPECT_EQ(flight.used(Channel::kIns), 0);
  flight.fly(5'000'000);
  alone.fly(5'000'000);
  EXPECT_EQ(flight.used(Channel::kIns), 1);
  EXPECT_EQ(flight.outputs.back().sahrs.q_NB.coeffs(), alone.outputs.back().sahrs.q_NB.coeffs());
  samples::InsSolution late = flight.ins(3'900'000);
  flight.navigator.offer(late);
  flight.fly(5'020'000);
  EXPECT_EQ(flight.rejected(Channel::kIns, Reason::kLate), 1);
}

TEST(Navigator, WatchesTheInsTenTimesASecond) {
  LevelFlight flight;
  flight.with_ins = true;
  flight.fly(30'000'000);
  int due = 0;
  for (const Outputs& outputs : flight.outputs) due += outputs.ins_monitor_due;
  EXPECT_GE(due, 301);
  EXPECT_LE(due, 301 + 2);  // and when there is something to compare with
  EXPECT_EQ(flight.outputs.back().ins_monitor.state, samples::InsState::kAgree);
  EXPECT_EQ(flight.outputs.back().ins_monitor.time_us, 30'000'000);
}

TEST(Navigator, AnInsThatCallsItselfInvalidHandsItsHeadingToTheFusion) {
  LevelFlight flight;
  flight.with_ins = true;
  flight.ins_heading = 3.0 * math::kDegree;
  flight.fly(60'000'000);
  const double before = math::wrap_pi(flight.outputs.back().nav.heading);
  flight.ins_valid = false;
  flight.fly(62'000'000);
  EXPECT_EQ(flight.outputs.back().ins_monitor.state, samples::InsState::kNone);
  const double after = math::wrap_pi(flight.outputs.back().nav.heading);
  EXPECT_LT(std::abs(before), 2.0 * math::kDegree);
  EXPECT_NEAR(after, 3.0 * math::kDegree, 0.5 * math::kDegree);  // SAHRS wanders, GPS says north
  EXPECT_LT(std::abs(math::wrap_pi(flight.outputs.back().sahrs.heading)), 2.0 * math::kDegree);
}

TEST(Navigator, OutsideTheGeomagneticModelHealthWarns) {
  const auto warning = [](double epoch_year, double h) {
    Config config;
    config.earth.epoch_year = epoch_year;
    config.initial.h = h;
    LevelFlight flight(config);
    flight.with_gps = false;
    flight.fly(1'000'000);
    return flight.navigator.health().warning;
  };
  EXPECT_EQ(warning(2026.5, 0.0), 0);
  EXPECT_EQ(warning(2030.0, -1000.0), 0);
  EXPECT_EQ(warning(2030.1, 0.0), samples::kWarningFieldModel);
  EXPECT_EQ(warning(2026.5, -1001.0), samples::kWarningFieldModel);
}

TEST(Navigator, ADateAfterTheGeomagneticModelIsItsLast) {
  const auto heading = [](double epoch_year) {
    Config config;
    config.earth.epoch_year = epoch_year;
    LevelFlight flight(config);
    flight.fly(30'000'000);
    return flight.outputs.back().sahrs.heading;
  };
  EXPECT_EQ(heading(2035.0), heading(2030.0));
  EXPECT_NE(heading(2030.0), heading(2028.0));
}

TEST(Navigator, AMeasurementMayBeOneSecondOldAndNoOlder) {
  LevelFlight flight;
  for (; flight.next_us <= 3'000'000; flight.next_us += kFrame) {
    flight.navigator.step(flight.rates(flight.next_us));
  }
  flight.navigator.offer(flight.air(2'000'001));
  flight.navigator.step(flight.rates(3'001'002));
  EXPECT_EQ(flight.rejected(Channel::kAirData, Reason::kLate), 1);
  flight.navigator.offer(flight.air(2'010'000));
  flight.navigator.step(flight.rates(3'010'000));
  EXPECT_EQ(flight.rejected(Channel::kAirData, Reason::kLate), 1);
}

TEST(Navigator, AMeasurementFromTheFutureIsDroppedAndBlocksNothing) {
  LevelFlight flight;
  flight.fly(30'000'000);
  flight.navigator.offer(flight.air(39'000'000));
  flight.fly(31'000'000);
  EXPECT_EQ(flight.rejected(Channel::kAirData, Reason::kFuture), 1);
  EXPECT_LE(flight.rejected(Channel::kAirData, Reason::kTimeBackwards), 1);
  EXPECT_EQ(flight.navigator.health().sensor_state[3], samples::SensorState::kGood);
  const std::int64_t used = flight.used(Channel::kAirData);
  flight.fly(32'000'000);
  EXPECT_EQ(flight.used(Channel::kAirData), used + 50);
}

TEST(Navigator, BadValuesNeverTouchAState) {
  const double bad_values[] = {std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity(), 1e300, -1e300};
  LevelFlight clean;
  LevelFlight dirty;
  for (int i = 0; i < 100; ++i) {
    clean.fly(clean.next_us);
    for (const double bad : bad_values) {
      samples::AirData air;
      air.time_us = dirty.next_us;
      air.true_airspeed = bad;
      dirty.navigator.offer(air);
      samples::MagneticField field;
      field.time_us = dirty.next_us;
      field.b_B.y() = bad;
      dirty.navigator.offer(field);
      samples::GpsFix fix;
      fix.time_us = dirty.next_us;
      fix.lat = bad;
      dirty.navigator.offer(fix);
    }
    dirty.fly(dirty.next_us);
    ASSERT_EQ(clean.outputs.back().sahrs.q_NB.coeffs(), dirty.outputs.back().sahrs.q_NB.coeffs());
    ASSERT_EQ(clean.outputs.back().nav.lat, dirty.outputs.back().nav.lat);
  }
  EXPECT_EQ(dirty.rejected(Channel::kAirData, Reason::kNotFinite), 200);
  EXPECT_EQ(dirty.rejected(Channel::kGps, Reason::kOutOfRange), 200);
}

TEST(Navigator, BadRatesMakeAFrameThatCoastsAndALongGapIsNotValid) {
  LevelFlight flight;
  flight.fly(60'000'000);
  samples::BodyRates bad = flight.rates(60'020'000);
  bad.omega_B.x() = std::numeric_limits<double>::quiet_NaN();
  for (; bad.time_us <= 60'900'000; bad.time_us += kFrame) {
    const Outputs* outputs = flight.navigator.step(bad);
    ASSERT_NE(outputs, nullptr);
    EXPECT_EQ(outputs->sahrs.time_us, bad.time_us);
    EXPECT_TRUE(outputs->sahrs.q_NB.coeffs().allFinite());
    EXPECT_EQ(outputs->sahrs.valid, bad.time_us <= 60'500'000);
  }
  flight.next_us = 61'000'000;
  flight.fly(90'000'000);
  EXPECT_TRUE(flight.outputs.back().sahrs.valid);
  EXPECT_GE(flight.outputs.back().sahrs.reset_count, 1);
}

TEST(Navigator, AJumpOfTheTimeBaseStartsOverAndSaysSo) {
  LevelFlight flight;
  flight.fly(60'000'000);
  const std::int16_t resets = flight.outputs.back().sahrs.reset_count;
  flight.next_us = 1'000'000;
  int refused = 0;
  while (flight.navigator.step(flight.rates(flight.next_us)) == nullptr) {
    flight.next_us += kFrame;
    ASSERT_LT(++refused, 20);
  }
  flight.next_us += kFrame;
  flight.fly(61'000'000);
  EXPECT_TRUE(flight.outputs.back().sahrs.valid);
  EXPECT_GT(flight.outputs.back().sahrs.reset_count, resets);
  EXPECT_EQ(flight.rejected(Channel::kBodyRates, Reason::kTimeBackwards), refused);
}

TEST(Navigator, EveryMessageIsCountedOnce) {
  LevelFlight flight;
  flight.fly(5'000'000);
  flight.navigator.count_rejection(Channel::kGps, Reason::kFingerprint);
  flight.navigator.offer(samples::RadarAltitude{5'000'000, 100.0, true});
  const samples::Health health = flight.navigator.health();
  EXPECT_EQ(of(health.counters, Channel::kBodyRates).received, 251);
  EXPECT_EQ(of(health.counters, Channel::kBodyRates).used, 251);
  EXPECT_EQ(of(health.counters, Channel::kGps).received, 7);
  EXPECT_EQ(flight.rejected(Channel::kGps, Reason::kFingerprint), 1);
  EXPECT_EQ(of(health.counters, Channel::kRadarAltitude).received, 1);
  EXPECT_EQ(health.sensor_state[9], samples::SensorState::kGood);
  EXPECT_EQ(health.sensor_state[7], samples::SensorState::kNeverSeen);
}

TEST(Navigator, AFloodBetweenTwoFramesLosesTheOldestAndCountsThem) {
  LevelFlight flight;
  flight.fly(2'000'000);
  for (std::int64_t i = 1; i <= 100; ++i) flight.navigator.offer(flight.field(2'000'000 + i));
  flight.navigator.step(flight.rates(2'020'000));
  EXPECT_EQ(flight.rejected(Channel::kMagneticField, Reason::kQueueFull), 84);
}

}  // namespace
}  // namespace lodestar::navigator
