// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/whiteness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lodestar::strapdown {
namespace {

TEST(Whiteness, IsOneOnAverageForWhiteInnovationsAndExceedsAsChiSquareSays) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  Whiteness<2> whiteness(10.0);
  double sum = 0.0;
  int beyond = 0;
  constexpr int kSamples = 200'000;
  for (int i = 0; i < kSamples; ++i) {
    const double seen = whiteness.see({normal(generator), normal(generator)}, 1.0);
    sum += seen;
    beyond += seen > 2.0;
  }
  EXPECT_NEAR(sum / kSamples, 1.0, 0.03);
  EXPECT_NEAR(static_cast<double>(beyond) / kSamples, std::exp(-2.0), 0.01);
}

TEST(Whiteness, GrowsWithTheMemoryWhereInnovationsLeanOneWay) {
  Whiteness<2> shorter(5.0), longer(50.0);
  double in_short = 0.0, in_long = 0.0;
  for (int i = 0; i < 500; ++i) {
    in_short = shorter.see({0.5, 0.5}, 1.0);
    in_long = longer.see({0.5, 0.5}, 1.0);
  }
  EXPECT_NEAR(in_short, 0.25 * 11.0, 1e-3);  // (2 - w) / w, w = 1 / (1 + memory)
  EXPECT_NEAR(in_long, 0.25 * 101.0, 1e-2);
}

TEST(Whiteness, SaysNothingWhereNoTimeHasPassed) {
  Whiteness<3> whiteness(1.0);
  EXPECT_EQ(whiteness.see({9.0, 9.0, 9.0}, 0.0), 0.0);
}

}  // namespace
}  // namespace lodestar::strapdown
