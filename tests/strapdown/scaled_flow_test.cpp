// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/scaled_flow.h"

#include <gtest/gtest.h>

namespace lodestar::strapdown {
namespace {

constexpr double kPlay = ScaledFlow::kAnglePlay;

TEST(ScaledFlow, KeepsStillWhileTheFlowStaysWithinThePlay) {
  ScaledFlow scaled;
  const Eigen::Vector3d first = scaled.follow({200.0, 0.05, 0.0});
  for (const double share : {-0.9, 0.9, -0.5, 0.0}) {
    const Eigen::Vector3d flow =
        first + share * Eigen::Vector3d(ScaledFlow::kSpeedPlay * 198.0, kPlay, kPlay);
    EXPECT_EQ(scaled.follow(flow), first);
  }
}

TEST(ScaledFlow, IsDraggedByAFlowThatLeavesThePlay) {
  ScaledFlow scaled;
  scaled.follow({200.0, 0.05, 0.0});
  const Eigen::Vector3d up = scaled.follow({250.0, 0.2, 0.1});
  EXPECT_DOUBLE_EQ(up.x(), 250.0 * (1.0 - ScaledFlow::kSpeedPlay));
  EXPECT_DOUBLE_EQ(up.y(), 0.2 - kPlay);
  EXPECT_DOUBLE_EQ(up.z(), 0.1 - kPlay);
  const Eigen::Vector3d down = scaled.follow({150.0, -0.1, -0.1});
  EXPECT_DOUBLE_EQ(down.x(), 150.0 * (1.0 + ScaledFlow::kSpeedPlay));
  EXPECT_DOUBLE_EQ(down.y(), -0.1 + kPlay);
  EXPECT_DOUBLE_EQ(down.z(), -0.1 + kPlay);
}

TEST(ScaledFlow, EachAngleIsFollowedByItself) {
  ScaledFlow scaled;
  const Eigen::Vector3d before = scaled.follow({200.0, 0.05, 0.0});
  const Eigen::Vector3d after = scaled.follow({200.0, 0.15, 0.0});
  EXPECT_EQ(after.x(), before.x());
  EXPECT_EQ(after.z(), before.z());
  EXPECT_GT(after.y(), before.y());
}

}  // namespace
}  // namespace lodestar::strapdown
