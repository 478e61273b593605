// SPDX-License-Identifier: Apache-2.0
#include "lodestar/math/gauss_markov.h"

#include <gtest/gtest.h>

namespace lodestar::math {
namespace {

constexpr GaussMarkov kProcess{3.0, 20.0};

TEST(GaussMarkov, KeepsItsStationaryVarianceOverAnyStep) {
  for (const double dt : {1e-6, 0.01, 1.0, 20.0, 1e4}) {
    const double decay = kProcess.decay(dt);
    EXPECT_NEAR(decay * decay * 9.0 + kProcess.added_variance(dt), 9.0, 1e-14) << dt;
  }
}

TEST(GaussMarkov, TwoStepsAreOneOfTheirSum) {
  const double decay = kProcess.decay(3.0);
  EXPECT_NEAR(kProcess.decay(2.0) * decay, kProcess.decay(5.0), 1e-15);
  EXPECT_NEAR(decay * decay * kProcess.added_variance(2.0) + kProcess.added_variance(3.0),
              kProcess.added_variance(5.0), 1e-14);
}

TEST(GaussMarkov, AddsItsSpectralDensityOverAShortStep) {
  const double dt = 1e-7;  // s; the next order is dt / tau
  EXPECT_NEAR(kProcess.added_variance(dt) / dt, kProcess.spectral_density(),
              1e-7 * kProcess.spectral_density());
}

TEST(GaussMarkov, ForgetsAfterALongTime) {
  EXPECT_EQ(kProcess.decay(1e6), 0.0);
  EXPECT_EQ(kProcess.added_variance(1e6), 9.0);
}

}  // namespace
}  // namespace lodestar::math
