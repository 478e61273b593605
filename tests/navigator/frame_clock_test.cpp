// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/frame_clock.h"

#include <gtest/gtest.h>

namespace lodestar::navigator {
namespace {

using Verdict = FrameClock::Verdict;

FrameClock running_at(std::int64_t time_us) {
  FrameClock clock;
  EXPECT_EQ(clock.judge(time_us), Verdict::kFrame);
  return clock;
}

TEST(FrameClock, FollowsStepsOfUpToOneSecond) {
  FrameClock clock = running_at(5'000'000);
  EXPECT_EQ(clock.judge(5'001'000), Verdict::kFrame);
  EXPECT_EQ(clock.judge(6'001'000), Verdict::kFrame);
  EXPECT_EQ(clock.now(), 6'001'000);
}

TEST(FrameClock, RefusesATimeThatDoesNotAdvance) {
  FrameClock clock = running_at(5'000'000);
  EXPECT_EQ(clock.judge(5'000'000), Verdict::kBackwards);
  EXPECT_EQ(clock.judge(4'000'000), Verdict::kBackwards);
  EXPECT_EQ(clock.now(), 5'000'000);
}

TEST(FrameClock, OneWildTimeStampNeitherMovesNorLocksTheClock) {
  FrameClock clock = running_at(5'000'000);
  EXPECT_EQ(clock.judge(9'000'000'000'000), Verdict::kAhead);
  EXPECT_EQ(clock.judge(5'020'000), Verdict::kFrame);
}

TEST(FrameClock, TimesThatAgreeWithNoOtherAreNeverFollowed) {
  FrameClock clock = running_at(0);
  for (std::int64_t i = 1; i < 100; ++i) {
    EXPECT_EQ(clock.judge(i * 10'000'000), Verdict::kAhead);
  }
}

TEST(FrameClock, FollowsANewTimeBaseOnceSeveralSamplesAgreeOnIt) {
  for (const std::int64_t base : {1'000'000LL, 900'000'000LL}) {
    FrameClock clock = running_at(60'000'000);
    int refused = 0;
    std::int64_t time_us = base;
    while (clock.judge(time_us) != Verdict::kJump) {
      time_us += 20'000;
      ASSERT_LT(++refused, 20);
    }
    EXPECT_EQ(refused, 10);
    EXPECT_EQ(clock.now(), time_us);
    EXPECT_EQ(clock.judge(time_us + 20'000), Verdict::kFrame);
  }
}

}  // namespace
}  // namespace lodestar::navigator
