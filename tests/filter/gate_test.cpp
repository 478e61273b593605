// SPDX-License-Identifier: Apache-2.0
#include "lodestar/filter/gate.h"

#include <gtest/gtest.h>

#include <limits>

namespace lodestar::filter {
namespace {

TEST(ChiSquare, HasThePublishedQuantiles) {
  // Abramowitz and Stegun, table 26.8; six figures are printed there.
  const struct {
    int dof;
    double exceeded;
    double threshold;
  } rows[] = {{1, 0.05, 3.84146}, {2, 0.05, 5.99147}, {3, 0.05, 7.81473},
              {4, 0.01, 13.2767}, {5, 0.01, 15.0863}, {6, 0.001, 22.4577},
              {1, 1e-4, 15.1367}, {3, 1e-4, 21.1075}, {2, 1e-4, 18.4207}};
  for (const auto& row : rows) {
    EXPECT_NEAR(chi_square_threshold(row.dof, row.exceeded), row.threshold, 1e-4 * row.threshold);
  }
}

TEST(ChiSquare, TheThresholdIsExceededWithTheProbabilityAskedFor) {
  for (int dof = 1; dof <= 12; ++dof) {
    for (const double exceeded : {0.5, 0.05, 1e-3, 1e-9}) {
      const double threshold = chi_square_threshold(dof, exceeded);
      EXPECT_NEAR(chi_square_survival(threshold, dof) / exceeded, 1.0, 1e-9);
    }
  }
}

TEST(ChiSquare, IsExceededForSureAtNoughtAndNeverAtInfinity) {
  for (int dof = 1; dof <= 6; ++dof) {
    EXPECT_EQ(chi_square_survival(0.0, dof), 1.0);
    EXPECT_LT(chi_square_survival(1e3, dof), 1e-100);
  }
}

TEST(Gate, PassesWhatLiesWithinAndStopsWhatLiesBeyond) {
  const Gate gate(0.05);
  EXPECT_TRUE(gate.passes(3.84, 1));
  EXPECT_FALSE(gate.passes(3.85, 1));
  EXPECT_TRUE(gate.passes(7.81, 3));
  EXPECT_FALSE(gate.passes(7.82, 3));
}

TEST(Gate, StopsWhatIsNotANumber) {
  const Gate gate(1e-4);
  EXPECT_FALSE(gate.passes(std::numeric_limits<double>::quiet_NaN(), 1));
  EXPECT_FALSE(gate.passes(std::numeric_limits<double>::infinity(), 1));
}

}  // namespace
}  // namespace lodestar::filter
