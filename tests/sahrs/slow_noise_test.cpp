// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/slow_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lodestar::sahrs {
namespace {

TEST(SlowNoise, GivesTheMeanOfManySamplesTheVarianceItHas) {
  constexpr double kSigma = 3.0, kTau = 2.0, kInterval = 1.0 / 30.0;
  constexpr int kSamples = 60000;
  // Variance of the mean of correlated samples, summed over their lags.
  double variance = 0.0;
  for (int lag = -kSamples + 1; lag < kSamples; ++lag) {
    const double correlation = std::exp(-std::abs(lag) * kInterval / kTau);
    variance += kSigma * kSigma * correlation * (kSamples - std::abs(lag));
  }
  variance /= static_cast<double>(kSamples) * kSamples;
  const SlowNoise noise = SlowNoise::of(kSigma, kTau, kInterval);
  EXPECT_NEAR((noise.variance + noise.excess) / kSamples, variance, 2e-3 * variance);
}

TEST(SlowNoise, OfSamplesFarApartIsWhite) {
  const SlowNoise noise = SlowNoise::of(3.0, 2.0, 10.0);
  EXPECT_EQ(noise.variance, 9.0);
  EXPECT_EQ(noise.excess, 0.0);
}

TEST(SlowNoise, OfTwoCausesAddsUp) {
  const SlowNoise sum = SlowNoise{1.0, 2.0} + SlowNoise{3.0, 4.0};
  EXPECT_EQ(sum.variance, 4.0);
  EXPECT_EQ(sum.excess, 6.0);
}

}  // namespace
}  // namespace lodestar::sahrs
