// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/parameters.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace lodestar::sahrs {
namespace {

TEST(SahrsParameters, AreDeclaredOnceEachWithDefaultsInRange) {
  Parameters parameters;
  std::set<std::string> keys;
  Parameters::describe(parameters, [&keys](double& member, const math::Parameter& p) {
    EXPECT_TRUE(keys.insert(p.key).second) << p.key;
    EXPECT_GE(member / p.scale, p.min) << p.key;
    EXPECT_LE(member / p.scale, p.max) << p.key;
  });
  // Every member is a double: none is left undeclared.
  EXPECT_EQ(keys.size(), sizeof(Parameters) / sizeof(double));
}

}  // namespace
}  // namespace lodestar::sahrs
