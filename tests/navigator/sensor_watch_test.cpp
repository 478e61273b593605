// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/sensor_watch.h"

#include <gtest/gtest.h>

#include <limits>

#include "lodestar/navigator/pending.h"

namespace lodestar::navigator {
namespace {

using samples::MagneticField;
using samples::Reason;
using samples::SensorState;

MagneticField field_at(std::int64_t time_us, double x = 15'000.0) {
  MagneticField sample;
  sample.time_us = time_us;
  sample.b_B = {x, 100.0, 48'000.0};
  return sample;
}

TEST(SensorWatch, AcceptsWhatIsFiniteInRangeAndLater) {
  SensorWatch<MagneticField> watch(0.5);
  EXPECT_EQ(watch.judge(field_at(0)), std::nullopt);
  EXPECT_EQ(watch.judge(field_at(33'000, 15'001.0)), std::nullopt);
}

TEST(SensorWatch, NamesTheReasonAgainstASample) {
  SensorWatch<MagneticField> watch(0.5);
  EXPECT_EQ(watch.judge(field_at(0, std::numeric_limits<double>::quiet_NaN())), Reason::kNotFinite);
  EXPECT_EQ(watch.judge(field_at(0, std::numeric_limits<double>::infinity())), Reason::kNotFinite);
  EXPECT_EQ(watch.judge(field_at(0, 1e6)), Reason::kOutOfRange);
  MagneticField invalid = field_at(0);
  invalid.valid = false;
  EXPECT_EQ(watch.judge(invalid), Reason::kInvalid);
  EXPECT_EQ(watch.judge(field_at(10)), std::nullopt);
  EXPECT_EQ(watch.judge(field_at(10)), Reason::kTimeBackwards);
  EXPECT_EQ(watch.judge(field_at(9)), Reason::kTimeBackwards);
}

TEST(SensorWatch, ARefusedSampleLeavesNoTrace) {
  SensorWatch<MagneticField> watch(0.5);
  EXPECT_EQ(watch.judge(field_at(1'000'000, 1e6)), Reason::kOutOfRange);
  EXPECT_EQ(watch.state(1'000'000), SensorState::kNeverSeen);
  EXPECT_EQ(watch.judge(field_at(0)), std::nullopt);
}

TEST(SensorWatch, ASensorThatFreezesIsStuckAfterOneSecondUntilItMoves) {
  SensorWatch<MagneticField> watch(0.5);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(watch.judge(field_at(i * 100'000)), std::nullopt) << i;
  }
  EXPECT_EQ(watch.judge(field_at(1'000'000)), Reason::kStuck);
  EXPECT_EQ(watch.state(1'000'000), SensorState::kStuck);
  EXPECT_EQ(watch.judge(field_at(1'100'000, 15'000.5)), std::nullopt);
  EXPECT_EQ(watch.state(1'100'000), SensorState::kGood);
}

TEST(SensorWatch, TwoEqualSamplesFarApartAreNotYetStuck) {
  SensorWatch<MagneticField> watch(5.0);
  EXPECT_EQ(watch.judge(field_at(0)), std::nullopt);
  EXPECT_EQ(watch.judge(field_at(2'000'000)), std::nullopt);
  EXPECT_EQ(watch.judge(field_at(4'000'000)), Reason::kStuck);
}

TEST(SensorWatch, SilenceMakesASensorStale) {
  SensorWatch<MagneticField> watch(0.5);
  EXPECT_EQ(watch.judge(field_at(0)), std::nullopt);
  EXPECT_EQ(watch.state(500'000), SensorState::kGood);
  EXPECT_EQ(watch.state(500'001), SensorState::kStale);
}

TEST(Pending, GivesBackInOrderThroughManyTurnsOfTheRing) {
  Pending<int, 3> pending;
  int next_in = 0;
  int next_out = 0;
  for (int round = 0; round < 10; ++round) {
    while (!pending.full()) pending.push(next_in++);
    EXPECT_EQ(pending.back(), next_in - 1);
    EXPECT_EQ(pending.front(), next_out++);
    pending.pop();
    EXPECT_EQ(pending.front(), next_out++);
    pending.pop();
  }
  pending.pop_back();
  EXPECT_TRUE(pending.empty());
}

}  // namespace
}  // namespace lodestar::navigator
