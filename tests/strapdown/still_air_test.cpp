// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/still_air.h"

#include <gtest/gtest.h>

#include <random>

namespace lodestar::strapdown {
namespace {

constexpr double kUnknown = 0.012;  // m/s/sqrt(s), least level of air of which nothing is known
constexpr double kAir = 1.0 / 30.0;

const GroundParameters kParameters;

StillAir shipped() { return StillAir(kParameters, kUnknown); }

void blow(StillAir& air, double seconds, double gust_sigma, double step = 0.0, bool lost = false) {
  for (double t = 0.0; t < seconds; t += kAir) air.see_air(gust_sigma, step, lost, kAir);
}

/// Fixes once a second whose innovations have this mean, in standard deviations; answers how many
/// spoke against still air.
int fly(StillAir& air, int fixes, double mean, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(mean, 1.0);
  int spoken = 0;
  for (int i = 0; i < fixes; ++i) {
    spoken += air.see_fix({normal(generator), normal(generator)}, 1.0) > 0.0;
  }
  return spoken;
}

TEST(StillAir, IsStillUntilSomethingSpeaksAgainstIt) {
  StillAir air = shipped();
  blow(air, 10.0, 0.001);
  EXPECT_TRUE(air.still());
  EXPECT_DOUBLE_EQ(air.least_walk(), kParameters.still_wind_walk);
}

TEST(StillAir, GustsSpeakAgainstItAsLongAsTheyBlow) {
  StillAir air = shipped();
  blow(air, 1.0, 2.0);
  EXPECT_FALSE(air.still());
  const double gusts = std::sqrt(2.0 * 2.0 - StillAir::kCalm * StillAir::kCalm);
  EXPECT_NEAR(air.least_walk(), gusts * kParameters.gust_wind_walk, 1e-12);
  blow(air, 1.0, 0.99 * StillAir::kCalm);
  EXPECT_TRUE(air.still());
  EXPECT_DOUBLE_EQ(air.least_walk(), kParameters.still_wind_walk);
}

TEST(StillAir, WithoutFixesGustsSpeakLouder) {
  StillAir air = shipped();
  blow(air, 1.0, 2.0);
  const double heard = air.least_walk();
  blow(air, 1.0, 2.0, 0.0, true);
  EXPECT_NEAR(air.least_walk() / heard, kParameters.lost_wind_walk / kParameters.gust_wind_walk,
              1e-9);
}

TEST(StillAir, AStepOfWindIsRememberedForMinutes) {
  StillAir air = shipped();
  blow(air, 1.0, 0.01, 0.5);
  EXPECT_FALSE(air.still());
  EXPECT_DOUBLE_EQ(air.least_walk(), kUnknown);
  blow(air, kParameters.still_after, 0.01);
  EXPECT_TRUE(air.still());
  EXPECT_NEAR(air.least_walk(), kUnknown * std::exp(-1.0), 1e-6);
}

TEST(StillAir, IsForgottenWithoutFixesUntilTheyAreBack) {
  StillAir air = shipped();
  blow(air, kParameters.still_lost, 0.01, 0.0, true);
  EXPECT_FALSE(air.still());
  EXPECT_NEAR(air.least_walk(), kUnknown * (1.0 - std::exp(-1.0)), 1e-6);
  blow(air, 60.0, 0.01);
  EXPECT_TRUE(air.still());
  blow(air, 600.0, 0.01);
  EXPECT_DOUBLE_EQ(air.least_walk(), kParameters.still_wind_walk);
}

TEST(StillAir, GoodFixesSpeakAgainstItOnceInTwoHours) {
  int alarmed = 0;  // of 20 flights of 50 min
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    StillAir air = shipped();
    alarmed += fly(air, 3000, 0.0, seed) > 0;
  }
  EXPECT_LE(alarmed, 12);
}

TEST(StillAir, FixesThatLeanOneWaySpeakAgainstItAndSayHowLittleTheWindIsKnown) {
  StillAir air = shipped();
  EXPECT_GT(fly(air, 120, 0.5, 1), 0);
  EXPECT_FALSE(air.still());
  EXPECT_DOUBLE_EQ(air.least_walk(), kUnknown);

  StillAir sure = shipped();
  double doubt = 0.0;
  while (doubt == 0.0) doubt = sure.see_fix({3.0, 3.0}, 1.0);
  EXPECT_NEAR(doubt, kUnknown * std::sqrt(200.0), 1e-12);
  EXPECT_EQ(sure.see_fix({3.0, 3.0}, 1.0), 0.0);  // it is told once
}

TEST(StillAir, NeverExceedsTheLevelOfAirOfWhichNothingIsKnown) {
  StillAir air(kParameters, 5e-5);
  blow(air, 1.0, 0.001);
  EXPECT_DOUBLE_EQ(air.least_walk(), 5e-5);
}

}  // namespace
}  // namespace lodestar::strapdown
