// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace lodestar::strapdown {

/// Whether something near the detector is to be reckoned with: the field was of another strength
/// than the model's, not in a few single samples but for half a second at the detector's 30 Hz,
/// within the last minute.
class FieldSuspicion {
 public:
  void see(bool strong_enough, std::int64_t time_us) {
    strange_ = std::clamp(strange_ + (strong_enough ? -1 : 1), 0, 2 * kMany);
    if (!strong_enough && strange_ >= kMany) {
      suspected_ = true;
      last_us_ = time_us;
    }
  }

  bool lasts(std::int64_t now_us) const { return suspected_ && now_us - last_us_ < kLength_us; }

 private:
  static constexpr int kMany = 15;
  static constexpr std::int64_t kLength_us = 60'000'000;

  int strange_ = 0;
  bool suspected_ = false;
  std::int64_t last_us_ = 0;
};

}  // namespace lodestar::strapdown
