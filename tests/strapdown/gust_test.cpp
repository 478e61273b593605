// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/gust.h"

#include <gtest/gtest.h>

namespace lodestar::strapdown {
namespace {

TEST(GustLevel, RisesWhileInnovationsAreTooLargeAndFallsWhileTheyAreTooSmall) {
  GustLevel level(1.0, 0.1, 5.0, 10.0);
  level.learn(2.0, 1.0);
  EXPECT_NEAR(level.sigma(), std::exp(0.05), 1e-12);
  level.learn(0.0, 2.0);
  EXPECT_NEAR(level.sigma(), std::exp(-0.05), 1e-12);
}

TEST(GustLevel, StaysWithinItsBounds) {
  GustLevel level(1.0, 0.1, 5.0, 10.0);
  for (int i = 0; i < 1000; ++i) level.learn(0.0, 1.0);
  EXPECT_NEAR(level.sigma(), 0.1, 1e-12);
  for (int i = 0; i < 1000; ++i) level.learn(100.0, 1.0);
  EXPECT_NEAR(level.sigma(), 5.0, 1e-12);
}

TEST(GustLevel, FallsInStillAirWhereTheInnovationsHardlyTell) {
  GustLevel level(1.0, 0.1, 5.0, 10.0);
  level.learn(1.0, 10.0, true);
  EXPECT_NEAR(level.sigma(), std::exp(-0.015), 1e-12);
}

TEST(GustLevel, CanBeSetWithinItsBounds) {
  GustLevel level(1.0, 0.1, 5.0, 10.0);
  level.set(0.5);
  EXPECT_NEAR(level.sigma(), 0.5, 1e-12);
  level.set(0.01);
  EXPECT_NEAR(level.sigma(), 0.1, 1e-12);
}

TEST(GustLevel, OneOutlierIsNoStorm) {
  GustLevel level(1.0, 0.1, 5.0, 10.0);
  level.learn(1e9, 1.0 / 30.0);
  EXPECT_LT(level.sigma(), 1.02);
}

}  // namespace
}  // namespace lodestar::strapdown
