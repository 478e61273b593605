// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "lodestar/samples/samples.h"

namespace lodestar::strapdown {

/// Airspeed, alpha and beta one by one: a value that comes back bit for bit for a second, where
/// noise is expected, is that of a blocked pitot or a stuck vane, whatever the other two do.
class FrozenFlow {
 public:
  enum Bit { kAirspeed = 1, kAlpha = 2, kBeta = 4 };

  /// Sees a sample; answers the bits of what is frozen.
  int see(const samples::AirData& sample) {
    const std::array<double, 3> values = {sample.true_airspeed, sample.alpha, sample.beta};
    int frozen = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] != last_[i]) since_us_[i] = sample.time_us;
      last_[i] = values[i];
      if (sample.time_us - since_us_[i] >= kPatience_us) frozen |= 1 << i;
    }
    return frozen;
  }

 private:
  static constexpr std::int64_t kPatience_us = 1'000'000;

  std::array<double, 3> last_{};
  std::array<std::int64_t, 3> since_us_{};
};

}  // namespace lodestar::strapdown
