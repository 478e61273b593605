// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/pose_history.h"

#include <gtest/gtest.h>

#include <memory>

namespace lodestar::sahrs {
namespace {

const Eigen::Vector3d kOmega_B(0.3, -0.2, 0.5);  // rad/s

Pose pose_at(std::int64_t time_us) {
  const double t = 1e-6 * static_cast<double>(time_us);
  return {time_us, math::exp_quaternion(t * kOmega_B), kOmega_B * (1.0 + t), 9.0 * t};
}

void expect_pose(const Pose& pose, std::int64_t time_us) {
  const Pose expected = pose_at(time_us);
  EXPECT_EQ(pose.time_us, time_us);
  EXPECT_LT(pose.q_SB.angularDistance(expected.q_SB), 1e-7);  // acos near 1 has half the digits
  EXPECT_LT((pose.omega_B - expected.omega_B).norm(), 1e-12);
  EXPECT_NEAR(pose.climb_integral, expected.climb_integral, 1e-12);
}

class PoseHistoryTest : public testing::Test {
 protected:
  void fill(std::int64_t first_us, std::int64_t step_us, int count) {
    for (int k = 0; k < count; ++k) history_->push(pose_at(first_us + k * step_us));
  }
  std::unique_ptr<PoseHistory> history_ = std::make_unique<PoseHistory>();
  Pose pose_;
};

TEST_F(PoseHistoryTest, HasNothingBeforeTheFirstPose) { EXPECT_FALSE(history_->at(0, pose_)); }

TEST_F(PoseHistoryTest, GivesBackEveryPose) {
  fill(1'000'000, 16'667, 61);
  for (int k = 0; k <= 60; ++k) {
    ASSERT_TRUE(history_->at(1'000'000 + k * 16'667, pose_));
    expect_pose(pose_, 1'000'000 + k * 16'667);
  }
}

TEST_F(PoseHistoryTest, InterpolatesBetweenPoses) {
  fill(0, 33'333, 31);
  for (std::int64_t t = 1; t < 30 * 33'333; t += 7'919) {
    ASSERT_TRUE(history_->at(t, pose_));
    expect_pose(pose_, t);
  }
}

TEST_F(PoseHistoryTest, GoesOnAtTheLastRateAfterTheNewest) {
  history_->push({1'000'000, Eigen::Quaterniond::Identity(), kOmega_B, 2.0});
  ASSERT_TRUE(history_->at(1'010'000, pose_));
  EXPECT_LT((math::log_quaternion(pose_.q_SB) - 0.01 * kOmega_B).norm(), 1e-15);
  EXPECT_EQ(pose_.climb_integral, 2.0);
}

TEST_F(PoseHistoryTest, ReachesBackOneSecondAt1000HzAndNoFurtherThanItsRing) {
  fill(0, 1'000, 5000);
  ASSERT_TRUE(history_->at(3'999'000, pose_));
  expect_pose(pose_, 3'999'000);
  EXPECT_FALSE(history_->at(3'900'000, pose_));
}

TEST_F(PoseHistoryTest, ForgetsWhenCleared) {
  fill(0, 1'000, 10);
  history_->clear();
  EXPECT_FALSE(history_->at(5'000, pose_));
  history_->push(pose_at(20'000));
  EXPECT_FALSE(history_->at(5'000, pose_));
  EXPECT_TRUE(history_->at(20'000, pose_));
}

}  // namespace
}  // namespace lodestar::sahrs
