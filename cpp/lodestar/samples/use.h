// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace lodestar::samples {

/// What an estimator did with a sample.
enum class Use : std::uint8_t {
  kUsed,        // it corrected a state
  kGated,       // its innovation was beyond the gate
  kAssumption,  // an assumption that the measurement stands on does not hold
  kHeld,        // kept for the use of others, or nothing there yet to correct
};

}  // namespace lodestar::samples
