// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/cycle_recorder.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lodestar::app {

void CycleRecorder::add(double seconds) {
  times_[count_ % kCapacity] = seconds;
  ++count_;
  const int exponent = std::ilogb(std::max(seconds * 1e6, 1.0));
  ++histogram_[std::min(static_cast<std::size_t>(exponent), histogram_.size() - 1)];
}

samples::CycleTimes CycleRecorder::take() {
  samples::CycleTimes result;
  result.histogram = histogram_;
  const std::size_t kept = std::min(count_, kCapacity);
  count_ = 0;
  if (kept == 0) return result;
  const auto begin = times_.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(kept);
  const auto p99 = begin + static_cast<std::ptrdiff_t>((kept - 1) * 99 / 100);
  result.mean = std::accumulate(begin, end, 0.0) / static_cast<double>(kept);
  std::nth_element(begin, p99, end);
  result.p99 = *p99;
  result.max = *std::max_element(p99, end);
  return result;
}

}  // namespace lodestar::app
