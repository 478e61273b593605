// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace lodestar::math {

/// What a person needs to know of one parameter. It is declared once, beside the member that holds
/// its default, in a static `describe(self, visit)` of the parameter struct; the configuration
/// reader, `lodestar-fc --parameters` and the table in the docs all visit that declaration.
///
///     struct Parameters {
///       double heading_sigma = 2.0 * kDegree;
///       template <class Self, class Visitor>
///       static void describe(Self& self, Visitor&& visit) {
///         visit(self.heading_sigma,
///               {"heading_sigma_deg", "deg", 0.01, 180.0, "Initial heading, 1 sigma", kDegree});
///       }
///     };
struct Parameter {
  const char* key;      // name in the configuration; carries the unit where that is not SI
  const char* unit;     // unit of the key
  double min;           // smallest allowed, in the key's unit
  double max;           // largest allowed
  const char* summary;  // one sentence
  double scale = 1.0;   // member = scale * key
};

/// A parameter that is a text of printable ASCII characters; the member is a std::string.
struct Text {
  const char* key;
  std::size_t longest;  // characters
  const char* summary;
};

/// A parameter that is one of a few names; the member is an enum whose values index `names`.
struct Choice {
  const char* key;
  const char* const* names;
  std::size_t count;
  const char* summary;
};

}  // namespace lodestar::math
