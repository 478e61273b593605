// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "lodestar/samples/health.h"

namespace lodestar::app {

/// How long frames took, for HEALTH. Fixed memory.
class CycleRecorder {
 public:
  /// One frame took `seconds`.
  void add(double seconds);

  /// Mean, 99th percentile and maximum since the last call (zero if there was no frame), and the
  /// histogram since start. The first and the last bin hold what is beyond them.
  samples::CycleTimes take();

 private:
  static constexpr std::size_t kCapacity = 1024;  // one second at the highest rate

  std::array<double, kCapacity> times_{};  // s, the latest
  std::size_t count_ = 0;                  // since the last take()
  std::array<std::int64_t, 16> histogram_{};
};

}  // namespace lodestar::app
