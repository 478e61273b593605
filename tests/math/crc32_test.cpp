// SPDX-License-Identifier: Apache-2.0
#include "lodestar/math/crc32.h"

#include <gtest/gtest.h>

namespace lodestar::math {
namespace {

TEST(Crc32, GivesThePublishedCheckValue) { EXPECT_EQ(crc32("123456789"), 0xCBF43926U); }

TEST(Crc32, OfNothingIsNought) { EXPECT_EQ(crc32(""), 0U); }

TEST(Crc32, SeesOneBit) { EXPECT_NE(crc32("lodestar"), crc32("lodestas")); }

}  // namespace
}  // namespace lodestar::math
