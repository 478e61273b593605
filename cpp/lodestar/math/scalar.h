// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace lodestar::math {

constexpr double square(double x) { return x * x; }

constexpr double seconds(std::int64_t microseconds) {
  return 1e-6 * static_cast<double>(microseconds);
}

}  // namespace lodestar::math
