// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/cycle_recorder.h"

#include <gtest/gtest.h>

#include <numeric>

namespace lodestar::app {
namespace {

TEST(CycleRecorder, GivesMeanPercentileAndMaximumOfTheFramesSinceTheLastTime) {
  CycleRecorder recorder;
  for (int i = 100; i >= 1; --i) recorder.add(i * 1e-6);
  const samples::CycleTimes times = recorder.take();
  EXPECT_NEAR(times.mean, 50.5e-6, 1e-15);
  EXPECT_DOUBLE_EQ(times.p99, 99e-6);
  EXPECT_DOUBLE_EQ(times.max, 100e-6);
  recorder.add(3e-6);
  EXPECT_DOUBLE_EQ(recorder.take().max, 3e-6);
}

TEST(CycleRecorder, SaysZeroWithoutFrames) {
  CycleRecorder recorder;
  const samples::CycleTimes times = recorder.take();
  EXPECT_EQ(times.mean, 0.0);
  EXPECT_EQ(times.p99, 0.0);
  EXPECT_EQ(times.max, 0.0);
}

TEST(CycleRecorder, BinsByPowersOfTwoMicrosecondsSinceTheStart) {
  CycleRecorder recorder;
  recorder.add(0.1e-6);
  recorder.add(1.5e-6);
  recorder.add(2.0e-6);
  recorder.add(1000e-6);
  recorder.take();
  recorder.add(5.0);
  const auto histogram = recorder.take().histogram;
  EXPECT_EQ(histogram[0], 2);  // below 2 us
  EXPECT_EQ(histogram[1], 1);
  EXPECT_EQ(histogram[9], 1);   // 512..1024 us
  EXPECT_EQ(histogram[15], 1);  // and longer
  EXPECT_EQ(std::accumulate(histogram.begin(), histogram.end(), std::int64_t{0}), 5);
}

TEST(CycleRecorder, KeepsTheLatestWhenThereAreMoreThanItHolds) {
  CycleRecorder recorder;
  for (int i = 0; i < 1000; ++i) recorder.add(1.0);
  for (int i = 0; i < 1024; ++i) recorder.add(1e-6);
  EXPECT_DOUBLE_EQ(recorder.take().max, 1e-6);
}

}  // namespace
}  // namespace lodestar::app
