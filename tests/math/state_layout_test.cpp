// SPDX-License-Identifier: Apache-2.0
#include "lodestar/math/state_layout.h"

#include <gtest/gtest.h>

namespace lodestar::math {
namespace {

TEST(StateLayout, BlocksFollowOneAnotherWithoutGap) {
  constexpr Block kFirst{0, 3};
  constexpr Block kSecond = after(kFirst, 2);
  constexpr Block kThird = after(kSecond, 1);
  EXPECT_EQ(kSecond.offset, 3);
  EXPECT_EQ(kThird.offset, 5);
  EXPECT_EQ(end(kThird), 6);
}

}  // namespace
}  // namespace lodestar::math
