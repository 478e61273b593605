// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "fly.h"

namespace lodestar::sahrs_test {
namespace {

using math::kDegree;
using sahrs::Assumption;
using samples::Use;

/// Each test breaks one assumption in a flight that is otherwise fine.
class Assumptions : public testing::Test {
 protected:
  Assumptions() {
    flight_.fly_straight();
    sahrs_.start(flight_.truth(), Eigen::Vector3d::Constant(1.0 * kDegree), flight_.time_us());
    fly(flight_, sahrs_, 15.0);
    counts_ = sahrs_.assumption_rejects();
    flight_.step();
    sahrs_.propagate(flight_.body_rates());
  }

  std::int64_t rejects(Assumption which) const {
    const std::size_t i = static_cast<std::size_t>(which);
    return sahrs_.assumption_rejects()[i] - counts_[i];
  }

  void expect_only(Assumption which) const {
    for (int i = 0; i < sahrs::kAssumptions; ++i) {
      const Assumption other = static_cast<Assumption>(i);
      EXPECT_EQ(rejects(other) > 0, other == which) << sahrs::kAssumptionNames[i];
    }
  }

  FlightGenerator flight_{3};
  sahrs::PaperSahrs sahrs_ = make_sahrs<sahrs::PaperSahrs>();
  std::array<std::int64_t, sahrs::kAssumptions> counts_{};
};

TEST_F(Assumptions, HoldInStraightFlight) {
  EXPECT_EQ(sahrs_.update(flight_.load_factor()), Use::kUsed);
  EXPECT_EQ(sahrs_.update(flight_.air_data()), Use::kUsed);
}

TEST_F(Assumptions, AnAircraftOnTheGroundHasNoAirData) {
  samples::AirData air = flight_.air_data();
  air.true_airspeed = 20.0;
  EXPECT_EQ(sahrs_.update(air), Use::kAssumption);
  EXPECT_EQ(sahrs_.update(flight_.load_factor()), Use::kAssumption);
  expect_only(Assumption::kAirspeed);
}

TEST_F(Assumptions, OldAirDataSayNothingOfRoll) {
  for (int k = 0; k < 40; ++k) {
    flight_.step();
    sahrs_.propagate(flight_.body_rates());
  }
  EXPECT_EQ(sahrs_.update(flight_.load_factor()), Use::kAssumption);
  expect_only(Assumption::kAirspeed);
}

TEST_F(Assumptions, TheRateOfClimbNeedsTimeAfterASilenceOfTheAirData) {
  for (int k = 0; k < 60; ++k) {
    flight_.step();
    sahrs_.propagate(flight_.body_rates());
  }
  EXPECT_EQ(sahrs_.update(flight_.air_data()), Use::kAssumption);
  expect_only(Assumption::kClimbRate);
}

TEST_F(Assumptions, AChangingAirspeedSpoilsRoll) {
  for (int k = 0; k < 60; ++k) {
    flight_.step();
    sahrs_.propagate(flight_.body_rates());
    samples::AirData air = flight_.air_data();
    air.true_airspeed += 0.15 * k;  // 9 m/s^2
    sahrs_.update(air);
  }
  EXPECT_EQ(sahrs_.update(flight_.load_factor()), Use::kAssumption);
  expect_only(Assumption::kSteadyVelocity);
}

TEST_F(Assumptions, SideslipSpoilsPitchAndRoll) {
  samples::AirData air = flight_.air_data();
  air.beta = 8.0 * kDegree;
  EXPECT_EQ(sahrs_.update(air), Use::kAssumption);
  EXPECT_EQ(rejects(Assumption::kSideslip), 1);
}

TEST_F(Assumptions, ALateralLoadSpoilsRoll) {
  samples::LoadFactor load = flight_.load_factor();
  load.n_B.y() = 0.3;
  EXPECT_EQ(sahrs_.update(load), Use::kAssumption);
  expect_only(Assumption::kLateralLoad);
}

TEST_F(Assumptions, AFastRollSpoilsRoll) {
  flight_.step();
  samples::BodyRates rates = flight_.body_rates();
  rates.omega_B.x() = 60.0 * kDegree;
  sahrs_.propagate(rates);
  EXPECT_EQ(sahrs_.update(flight_.load_factor()), Use::kAssumption);
  expect_only(Assumption::kBodyRate);
}

TEST_F(Assumptions, ALoadFactorThatGravityDoesNotExplainSpoilsRoll) {
  samples::LoadFactor load = flight_.load_factor();
  load.n_B.z() = 3.0;  // pulling up, and no pitch rate to show for it yet
  EXPECT_EQ(sahrs_.update(load), Use::kAssumption);
  expect_only(Assumption::kBalance);
}

TEST_F(Assumptions, NearTheVerticalThereIsNoRollAndNoPitchFromAirData) {
  sahrs::PaperSahrs climbing = make_sahrs<sahrs::PaperSahrs>();
  climbing.start({0.0, 80.0 * kDegree, 0.0}, Eigen::Vector3d::Constant(1.0 * kDegree),
                 flight_.time_us());
  for (int k = 0; k < 60 * 6; ++k) {
    flight_.step();
    samples::BodyRates rates = flight_.body_rates();
    rates.omega_B.setZero();
    climbing.propagate(rates);
    samples::AirData air = flight_.air_data();
    climbing.update(air);
  }
  climbing.update(flight_.load_factor());
  EXPECT_GT(climbing.assumption_rejects()[static_cast<std::size_t>(Assumption::kPitchAngle)], 1);
}

}  // namespace
}  // namespace lodestar::sahrs_test
