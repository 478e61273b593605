// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/rate_filter.h"

#include <gtest/gtest.h>

namespace lodestar::sahrs {
namespace {

constexpr double kDt = 1.0 / 30.0;

TEST(RateFilter, FindsTheRateOfARamp) {
  RateFilter filter(1.0);
  filter.restart(100.0);
  for (int k = 1; k < 900; ++k) filter.update(100.0 + 7.0 * k * kDt, kDt);
  EXPECT_NEAR(filter.rate(), 7.0, 1e-6);
  EXPECT_NEAR(filter.value(), 100.0 + 7.0 * 899 * kDt, 1e-6);
}

TEST(RateFilter, TakesTheLagOfTheSensorOutOfARamp) {
  constexpr double kLag = 0.3;
  RateFilter filter(1.0, kLag);
  filter.restart(0.0);
  for (int k = 1; k < 1800; ++k) filter.update(7.0 * (k * kDt - kLag), kDt);
  EXPECT_NEAR(filter.rate(), 7.0, 1e-6);
  EXPECT_NEAR(filter.value(), 7.0 * 1799 * kDt, 1e-6);
}

TEST(RateFilter, FollowsAnAccelerationItIsToldOfWithoutLag) {
  constexpr double kLag = 0.3;
  RateFilter filter(1.0, kLag);
  filter.restart(0.0);
  double height = 0.0, rate = 0.0, lagged = 0.0;
  double worst = 0.0;
  for (int k = 1; k < 900; ++k) {
    const double acceleration = k < 300 ? 0.0 : (k / 100 % 2 == 0 ? 4.0 : -4.0);
    for (int i = 0; i < 100; ++i) {
      const double dt = kDt / 100.0;
      height += rate * dt + 0.5 * acceleration * dt * dt;
      rate += acceleration * dt;
      lagged += (height - lagged) * -std::expm1(-dt / kLag);
    }
    filter.update(lagged, kDt, acceleration * kDt);
    worst = std::max(worst, std::abs(filter.rate() - rate));
  }
  EXPECT_LT(worst, 0.01);  // m/s; steps of the acceleration fall between two samples
}

TEST(RateFilter, IsStableForEveryLagAndForStepsUpToItsTime) {
  for (const double lag : {0.0, 0.3, 3.0}) {
    for (const double dt : {1e-3, 0.1, 1.0}) {
      RateFilter filter(1.0, lag);
      filter.restart(0.0);
      filter.update(100.0, dt);
      for (double t = 0.0; t < 1000.0; t += dt) filter.update(0.0, dt);
      EXPECT_NEAR(filter.rate(), 0.0, 1e-6) << lag << " " << dt;
    }
  }
}

TEST(RateFilter, HasSettledWhenItsStartNoLongerShows) {
  RateFilter filter(1.0);
  filter.restart(0.0);
  int k = 0;
  while (!filter.settled()) filter.update(10.0 * ++k * kDt, kDt);
  EXPECT_NEAR(k * kDt, 4.0, 2.0 * kDt);
  EXPECT_NEAR(filter.rate(), 10.0, 1.0);
}

class OutlierTest : public testing::Test {
 protected:
  OutlierTest() {
    filter_.restart(0.0);
    for (int k = 0; k < 300; ++k) filter_.update(0.0, kDt);
  }
  RateFilter filter_{1.0, 0.0, 20.0};
};

TEST_F(OutlierTest, ASpikeIsLeftOut) {
  filter_.update(500.0, kDt);
  EXPECT_EQ(filter_.rate(), 0.0);
  EXPECT_TRUE(filter_.settled());
}

TEST_F(OutlierTest, AStepIsFollowedByANewStart) {
  for (int k = 0; k < 45; ++k) filter_.update(500.0, kDt);
  EXPECT_EQ(filter_.value(), 500.0);
  EXPECT_EQ(filter_.rate(), 0.0);
  EXPECT_FALSE(filter_.settled());
}

}  // namespace
}  // namespace lodestar::sahrs
