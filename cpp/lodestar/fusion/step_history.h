// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "lodestar/fusion/error_filter.h"

namespace lodestar::fusion {

/// The filter at the end of one step, and what made the step.
struct Step {
  TrackPoint point;
  StepConditions conditions;
  ErrorEstimate estimate;
};

/// The last steps of the filter, oldest first: a late fix is taken in after the last step before it
/// and the later steps are done again.
class StepHistory {
 public:
  // One second of the shortest steps, and two more for each fix at 10 Hz.
  static constexpr int kCapacity = 48;

  int size() const { return count_; }
  bool empty() const { return count_ == 0; }
  void clear() { count_ = 0; }

  Step& operator[](int i) { return steps_[index(i)]; }
  const Step& operator[](int i) const { return steps_[index(i)]; }
  Step& back() { return (*this)[count_ - 1]; }
  const Step& back() const { return (*this)[count_ - 1]; }

  /// The oldest step goes when there is no room.
  void push(const Step& step) {
    if (count_ == kCapacity) {
      first_ = (first_ + 1) % kCapacity;
      --count_;
    }
    ++count_;
    back() = step;
  }

  /// Before step `i`; answers where it went (`i`, or `i` - 1 when the oldest had to go).
  int insert(int i, const Step& step) {
    const bool full = count_ == kCapacity;
    push(step);
    const int at = full ? i - 1 : i;
    for (int j = count_ - 1; j > at; --j) (*this)[j] = (*this)[j - 1];
    (*this)[at] = step;
    return at;
  }

  /// The last step at or before `time_us`; -1 if all are later.
  int last_until(std::int64_t time_us) const {
    int i = count_ - 1;
    while (i >= 0 && (*this)[i].point.time_us > time_us) --i;
    return i;
  }

 private:
  std::size_t index(int i) const { return static_cast<std::size_t>((first_ + i) % kCapacity); }

  std::array<Step, kCapacity> steps_{};
  int first_ = 0;
  int count_ = 0;
};

}  // namespace lodestar::fusion
