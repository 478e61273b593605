// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/parameters.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace lodestar::sahrs {
namespace {

/// Looks at every declaration.
struct Declared {
  std::set<std::string> keys;

  void operator()(double& member, const math::Parameter& p) {
    EXPECT_TRUE(keys.insert(p.key).second) << p.key;
    EXPECT_GE(member / p.scale, p.min) << p.key;
    EXPECT_LE(member / p.scale, p.max) << p.key;
  }
  void operator()(samples::SahrsForm& member, const math::Choice& p) {
    EXPECT_TRUE(keys.insert(p.key).second) << p.key;
    EXPECT_EQ(member, samples::SahrsForm::kVelocity) << p.key;
  }
};

TEST(SahrsParameters, AreDeclaredOnceEachWithDefaultsInRange) {
  Parameters parameters;
  Declared declared;
  Parameters::describe(parameters, declared);
  // Every member is a double, but for the form, which is padded to one: none is left undeclared.
  EXPECT_EQ(declared.keys.size(), sizeof(Parameters) / sizeof(double));
}

}  // namespace
}  // namespace lodestar::sahrs
