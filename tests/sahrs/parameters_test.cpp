// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/parameters.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <type_traits>

namespace lodestar::sahrs {
namespace {

TEST(SahrsParameters, AreDeclaredOnceEachWithDefaultsInRange) {
  Parameters parameters;
  std::set<std::string> keys;
  Parameters::describe(parameters, [&keys](auto& member, const auto& p) {
    EXPECT_TRUE(keys.insert(p.key).second) << p.key;
    if constexpr (std::is_same_v<decltype(member), double&>) {
      EXPECT_GE(member / p.scale, p.min) << p.key;
      EXPECT_LE(member / p.scale, p.max) << p.key;
    } else {
      EXPECT_EQ(member, samples::SahrsForm::kVelocity) << p.key;
    }
  });
  // Every member is a double, but for the form, which is padded to one: none is left undeclared.
  EXPECT_EQ(keys.size(), sizeof(Parameters) / sizeof(double));
}

}  // namespace
}  // namespace lodestar::sahrs
