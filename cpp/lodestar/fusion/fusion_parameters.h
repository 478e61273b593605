// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/parameter.h"
#include "lodestar/samples/outputs.h"

namespace lodestar::fusion {

inline constexpr const char* kFilterNames[] = {"integrated", "cascade"};

/// [fusion]
struct FusionParameters {
  samples::FusionFilter filter = samples::FusionFilter::kIntegrated;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.filter, {"filter", kFilterNames, 2,
                        "One filter of attitude, wind and position, or one behind SAHRS"});
  }
};

}  // namespace lodestar::fusion
