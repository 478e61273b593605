// SPDX-License-Identifier: Apache-2.0
// What fixes, gusts and innovations say of themselves: FixLine, FixMotion, FixNoise, Reacquisition,
// InnovationWatch, GustMeter.
#include <gtest/gtest.h>

#include <random>

#include "lodestar/filter/gate.h"
#include "lodestar/fusion/fix_motion.h"
#include "lodestar/fusion/fix_noise.h"
#include "lodestar/fusion/gust_meter.h"
#include "lodestar/fusion/innovation_watch.h"
#include "lodestar/fusion/reacquisition.h"
#include "lodestar/math/gauss_markov.h"

namespace lodestar::fusion {
namespace {

using Eigen::Vector2d;

std::int64_t us(double seconds) { return static_cast<std::int64_t>(std::llround(1e6 * seconds)); }

class Noise {
 public:
  explicit Noise(unsigned seed) : generator_(seed) {}
  double operator()() { return normal_(generator_); }
  Vector2d pair(double sigma) { return {sigma * normal_(generator_), sigma * normal_(generator_)}; }

 private:
  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
};

TEST(FixLine, ADriftingOffsetLeavesNoResidual) {
  FixLine line;
  const Vector2d drift(3.0, -4.0);
  line.push(us(1.0), 1.0 * drift);
  line.push(us(2.0), 2.0 * drift);
  ASSERT_EQ(line.size(), 2);
  const FixLine::Residual residual = line.residual(us(4.0), 4.0 * drift);
  EXPECT_LT(residual.value.norm(), 1e-12);
  EXPECT_NEAR(residual.noise_gain, 1.0 + 9.0 + 4.0, 1e-12);  // two intervals ahead of one
}

TEST(FixLine, APauseBeginsANewLine) {
  FixLine line;
  line.push(us(1.0), {0.0, 0.0});
  line.push(us(2.0), {0.0, 0.0});
  EXPECT_TRUE(line.continues(us(5.0)));
  EXPECT_FALSE(line.continues(us(5.1)));
  EXPECT_FALSE(line.continues(us(2.0)));
  line.push(us(9.0), {0.0, 0.0});
  EXPECT_EQ(line.size(), 1);
}

samples::GpsFix fix_at(double time, double north) {
  samples::GpsFix fix;
  fix.time_us = us(time);
  fix.lat = 1.0 + north / 6.4e6;
  fix.lon = 0.3;
  return fix;
}

const Vector2d kFast(200.0, 0.0);  // m/s, through the air
const Vector2d kSlow(50.0, 0.0);

TEST(FixMotion, ARepeatedPlaceStandsStillAtOnceAtAnySpeed) {
  FixMotion motion;
  EXPECT_FALSE(motion.stands_still(fix_at(0.0, 0.0), kSlow));
  EXPECT_TRUE(motion.stands_still(fix_at(0.1, 0.0), kSlow));
  EXPECT_FALSE(motion.stands_still(fix_at(0.2, 4.0), kSlow));
}

TEST(FixMotion, APlaceThatOnlyTremblesStandsStillInFastFlight) {
  Noise noise(4);
  FixMotion fast, slow;
  int still = 0;
  for (int i = 0; i < 60; ++i) {
    const samples::GpsFix fix = fix_at(i, noise.pair(2.0).x());
    still += fast.stands_still(fix, kFast) ? 1 : 0;
    EXPECT_FALSE(slow.stands_still(fix, kSlow));  // a wind can hold that in place
  }
  EXPECT_EQ(still, 58);  // from 2 s on
}

TEST(FixMotion, MovesAgainWithinTwoSecondsOfAReceiverThatDoes) {
  FixMotion motion;
  Noise noise(4);
  for (int i = 0; i < 10; ++i) motion.stands_still(fix_at(i, noise.pair(2.0).x()), kFast);
  EXPECT_TRUE(motion.stands_still(fix_at(10.0, 0.0), kFast));
  motion.stands_still(fix_at(11.0, 200.0), kFast);
  EXPECT_FALSE(motion.stands_still(fix_at(12.0, 400.0), kFast));
}

TEST(FixMotion, LetsAnAircraftGoUpwardsOrTurnBackOnItsPlace) {
  FixMotion vertical, loop;
  Noise noise(5);
  for (int i = 0; i < 60; ++i) {
    EXPECT_FALSE(vertical.stands_still(fix_at(i, noise.pair(2.0).x()), Vector2d::Zero()));
    // North for a second, south for a second: where it was two seconds ago.
    const Vector2d v_air = (i % 2 == 0 ? 1.0 : -1.0) * kFast;
    EXPECT_FALSE(loop.stands_still(fix_at(i, noise.pair(2.0).x()), v_air));
  }
}

TEST(FixMotion, SaysNothingOfFixesLongApart) {
  FixMotion motion;
  EXPECT_FALSE(motion.stands_still(fix_at(0.0, 0.0), kFast));
  EXPECT_FALSE(motion.stands_still(fix_at(60.0, 3.0), kFast));
}

double measured_noise(double true_sigma, double stated_sigma) {
  Noise noise(7);
  FixNoise fix_noise(0.5);
  for (int i = 0; i < 400; ++i) {
    const Vector2d drift(4.0 * i, -3.0 * i);
    fix_noise.add(us(i), drift + noise.pair(true_sigma), stated_sigma);
  }
  return std::sqrt(fix_noise.variance(stated_sigma));
}

TEST(FixNoise, FindsTheWhitePartOfWhatTheReceiverStates) {
  // 25 %: some 60 squared residuals of two axes, two thirds of them independent.
  EXPECT_NEAR(measured_noise(1.0, 5.1), 1.0, 0.25);
  EXPECT_NEAR(measured_noise(3.0, 5.1), 3.0, 0.75);
}

TEST(FixNoise, StaysBetweenItsFloorAndTheReceiversWord) {
  EXPECT_EQ(measured_noise(0.01, 5.1), 0.5);
  EXPECT_NEAR(measured_noise(50.0, 5.1), 5.1, 1e-12);
  EXPECT_NEAR(std::sqrt(FixNoise(0.5).variance(7.0)), 7.0, 1e-12);  // nothing measured yet
  EXPECT_EQ(std::sqrt(FixNoise(0.5).variance(0.1)), 0.5);
}

TEST(FixNoise, OneWildFixDoesNotSetIt) {
  FixNoise fix_noise(0.5);
  Noise noise(3);
  for (int i = 0; i < 200; ++i) fix_noise.add(us(i), noise.pair(1.0), 5.0);
  fix_noise.add(us(200), {1000.0, 0.0}, 5.0);
  EXPECT_LT(std::sqrt(fix_noise.variance(5.0)), 1.6);
}

TEST(Reacquisition, BelievesFixesOnALineAfterItsTime) {
  Noise noise(1);
  Reacquisition reacquisition(3.0);
  const Vector2d drift(20.0, -60.0);  // as of a heading that is 18 degrees wrong
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(
        reacquisition.examine(us(i), Vector2d(500.0, 300.0) + i * drift + noise.pair(1.0), 1.0));
  }
  EXPECT_TRUE(
      reacquisition.examine(us(3), Vector2d(500.0, 300.0) + 3 * drift + noise.pair(1.0), 1.0));
  EXPECT_LT((reacquisition.drift() - drift).norm(), 2.0);
}

TEST(Reacquisition, DoesNotBelieveScatteredFixes) {
  Noise noise(2);
  Reacquisition reacquisition(3.0);
  for (int i = 0; i < 300; ++i) EXPECT_FALSE(reacquisition.examine(us(i), noise.pair(200.0), 1.0));
}

TEST(Reacquisition, TakesItsTimeAtAnyRate) {
  Reacquisition reacquisition(3.0);
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(reacquisition.examine(us(0.1 * i), {0.0, 0.0}, 1.0));
  EXPECT_TRUE(reacquisition.examine(us(3.0), {0.0, 0.0}, 1.0));
}

TEST(Reacquisition, EndsWhenTheFixesStop) {
  Reacquisition reacquisition(3.0);
  EXPECT_FALSE(reacquisition.running());
  reacquisition.examine(us(1.0), {0.0, 0.0}, 1.0);
  EXPECT_TRUE(reacquisition.running());
  EXPECT_FALSE(reacquisition.stale(us(4.0)));
  EXPECT_TRUE(reacquisition.stale(us(4.1)));
  reacquisition.cancel();
  EXPECT_FALSE(reacquisition.stale(us(4.1)));
}

TEST(InnovationWatch, IsQuietOnWhiteInnovationsAtItsRate) {
  Noise noise(5);
  InnovationWatch watch(filter::chi_square_threshold(2, 1e-2), 3.0);
  int alarms = 0;
  for (int i = 0; i < 20000; ++i) alarms += watch.alarms(noise.pair(1.0), 1.0) ? 1 : 0;
  EXPECT_GT(alarms, 20);
  EXPECT_LT(alarms, 250);  // 200 if each mean were a draw of its own
}

TEST(InnovationWatch, NoticesInnovationsThatAllPointOneWay) {
  Noise noise(6);
  InnovationWatch watch(filter::chi_square_threshold(2, 1e-3), 3.0);
  int seconds = 0;
  while (!watch.alarms(Vector2d(2.5, 0.0) + noise.pair(1.0), 1.0)) ++seconds;
  EXPECT_LT(seconds, 6);
}

/// Estimated standard deviation of Gauss-Markov gusts of `sigma` (m/s) in half an hour.
double measured_gust(double sigma, double sample_noise) {
  Noise noise(8);
  GustMeter meter;
  const math::GaussMarkov gusts{sigma, 2.7};
  constexpr double kInterval = 1.0 / 30.0;
  double gust = 0.0;
  double sum = 0.0;
  for (int i = 0; i < 30 * 1800; ++i) {
    gust = gust * gusts.decay(kInterval) + std::sqrt(gusts.added_variance(kInterval)) * noise();
    meter.add(1.0 + gust + sample_noise * noise(), kInterval,
              sample_noise * sample_noise * kInterval);
    sum += meter.variance();
  }
  return std::sqrt(sum / (30 * 1800));
}

TEST(GustMeter, MeasuresTurbulenceThroughBiasAndSampleNoise) {
  // 15 %: some 500 independent second differences.
  EXPECT_NEAR(measured_gust(2.0, 0.35), 2.0, 0.3);
  EXPECT_NEAR(measured_gust(0.7, 0.35), 0.7, 0.11);
}

TEST(GustMeter, SeesNoneInCalmAir) { EXPECT_LT(measured_gust(0.0, 0.35), 0.15); }

}  // namespace
}  // namespace lodestar::fusion
