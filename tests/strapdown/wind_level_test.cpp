// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/wind_level.h"

#include <gtest/gtest.h>

#include <random>

namespace lodestar::strapdown {
namespace {

constexpr double kInterval = 1.0 / 30.0;  // s
constexpr double kFloor = 0.02;           // m/s/sqrt(s)

/// What the innovations of the air data are made of, over their standard deviations.
struct Mix {
  double noise = 0.87;  // white; what calm flights have, and less while the level is too high
  double wander = 0.0;  // 1 sigma of a Gauss-Markov part of 3 s: a wind that lives
  double steady = 0.0;  // a wind that steps
};

class Air {
 public:
  explicit Air(std::uint32_t seed) : generator_(seed) {}

  /// Answers the rms of the level on the way.
  double blow(WindLevel& level, double duration, const Mix& mix = {}) {
    const double decay = std::exp(-kInterval / 3.0);
    double square = 0.0;
    int count = 0;
    for (double t = 0.0; t < duration; t += kInterval, ++count) {
      std::array<double, WindLevel::kRows> normalised{};
      for (std::size_t row = 0; row < normalised.size(); ++row) {
        wind_[row] = decay * wind_[row] + std::sqrt(1.0 - decay * decay) * normal_(generator_);
        normalised[row] = mix.noise * normal_(generator_) + mix.wander * wind_[row] + mix.steady;
      }
      level.learn(normalised, kInterval);
      square += level.walk() * level.walk();
    }
    return std::sqrt(square / count);
  }

 private:
  std::mt19937 generator_;
  std::normal_distribution<double> normal_;
  std::array<double, WindLevel::kRows> wind_{};
};

WindLevel shipped() { return WindLevel(0.1, kFloor, 2.0, 3.0, 50.0); }

TEST(WindLevel, StaysNearItsFloorInStillAir) {
  WindLevel level = shipped();
  Air air(1);
  air.blow(level, 300.0);
  EXPECT_LT(air.blow(level, 600.0), 2.0 * kFloor);
}

TEST(WindLevel, RisesWithinSecondsWhenTheWindSteps) {
  WindLevel level = shipped();
  Air air(2);
  air.blow(level, 300.0);
  air.blow(level, 3.0, {0.87, 0.0, 1.0});
  EXPECT_GT(level.walk(), 1.0);
}

TEST(WindLevel, LearnsThatTheAirLivesAndKeepsItBeyondAStep) {
  WindLevel level = shipped();
  Air air(3);
  air.blow(level, 300.0);
  const double living = air.blow(level, 250.0, {0.87, 0.07, 0.0});
  EXPECT_GT(living, 2.0 * kFloor);
  EXPECT_EQ(level.step(), 0.0);
  air.blow(level, 10.0, {0.87, 0.07, 1.0});
  EXPECT_GT(level.step(), 0.9 * level.walk());
  air.blow(level, 30.0, {0.3, 0.0, 0.0});  // the level of the step is too high by far
  EXPECT_GT(level.walk(), 0.8 * living);
  EXPECT_LT(level.walk(), 4.0 * living);
}

TEST(WindLevel, AStepHardlyMovesTheLevelThatLasts) {
  WindLevel level = shipped();
  Air air(4);
  air.blow(level, 300.0);
  air.blow(level, 10.0, {0.87, 0.0, 3.0});
  air.blow(level, 40.0, {0.3, 0.0, 0.0});
  EXPECT_LT(level.walk(), 2.5 * kFloor);
}

TEST(WindLevel, CanBeHeldUpAndFallsAgain) {
  WindLevel level = shipped();
  Air air(5);
  air.blow(level, 300.0);
  level.raise(0.1);
  EXPECT_DOUBLE_EQ(level.walk(), 0.1);
  EXPECT_EQ(level.step(), 0.0);  // a level that stays is no step
  level.raise(0.05);             // is exceeded already
  EXPECT_DOUBLE_EQ(level.walk(), 0.1);
  level.raise(100.0);
  EXPECT_DOUBLE_EQ(level.walk(), 2.0);  // the greatest
  level = shipped();
  level.raise(0.1);
  air.blow(level, 200.0, {0.3, 0.0, 0.0});  // too high by far
  EXPECT_LT(level.walk(), 2.0 * kFloor);
}

TEST(WindLevel, CanSettleToTheLevelThatStays) {
  WindLevel level = shipped();
  level.settle();
  EXPECT_DOUBLE_EQ(level.walk(), kFloor);
  level.raise(0.1);
  level.settle();
  EXPECT_DOUBLE_EQ(level.walk(), 0.1);
}

TEST(WindLevel, FallsInStillAirWhateverTheAirDataSeem) {
  WindLevel level = shipped();
  level.raise(0.1);
  for (double t = 0.0; t < 200.0; t += kInterval) level.learn({0.1, 0.1, 0.1}, kInterval, true);
  EXPECT_LT(level.walk(), 1.1 * kFloor);
}

TEST(WindLevel, WhatIsBelowTheLevelOfTheStartIsNoStep) {
  WindLevel level = shipped();
  EXPECT_GT(level.walk(), 3.0 * kFloor);
  EXPECT_EQ(level.step(), 0.0);
}

TEST(WindLevel, NothingIsLearntInNoTime) {
  WindLevel level = shipped();
  level.learn({9.0, 9.0, 9.0}, 0.0);
  EXPECT_DOUBLE_EQ(level.walk(), 0.1);
}

}  // namespace
}  // namespace lodestar::strapdown
