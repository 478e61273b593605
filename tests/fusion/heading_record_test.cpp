// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/heading_record.h"

#include <gtest/gtest.h>

namespace lodestar::fusion {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

TEST(HeadingRecord, KnowsEverySecondOfTheLastTwoMinutes) {
  HeadingRecord record;
  for (int i = 0; i < 200 * 60; ++i) record.add({i * kSecond / 60, 0.001 * i, 0.0});
  const auto entry = record.at(150 * kSecond + 400'000);
  ASSERT_TRUE(entry);
  EXPECT_NEAR(entry->ahead_of_sahrs, 0.001 * 150 * 60, 0.07);  // the second before
  EXPECT_FALSE(record.at(60 * kSecond));
}

TEST(HeadingRecord, DoesNotBridgeAGap) {
  HeadingRecord record;
  record.add({0, 0.1, 0.0});
  record.add({10 * kSecond, 0.2, 0.0});
  EXPECT_FALSE(record.at(5 * kSecond));
  EXPECT_TRUE(record.at(10 * kSecond));
  record.restart();
  EXPECT_FALSE(record.at(10 * kSecond));
}

}  // namespace
}  // namespace lodestar::fusion
