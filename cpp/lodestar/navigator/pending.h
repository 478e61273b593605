// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace lodestar::navigator {

/// Samples of one channel that wait for the frame of their time, oldest first. Fixed size.
template <class Sample, std::size_t Capacity>
class Pending {
 public:
  bool empty() const { return count_ == 0; }
  bool full() const { return count_ == Capacity; }
  const Sample& front() const { return ring_[head_]; }
  const Sample& back() const { return ring_[(head_ + count_ - 1) % Capacity]; }

  /// Only when not full.
  void push(const Sample& sample) {
    ring_[(head_ + count_) % Capacity] = sample;
    ++count_;
  }

  void pop() {
    head_ = (head_ + 1) % Capacity;
    --count_;
  }

  void pop_back() { --count_; }

  void clear() { count_ = 0; }

 private:
  std::array<Sample, Capacity> ring_{};
  std::size_t head_ = 0;
  std::size_t count_ = 0;
};

}  // namespace lodestar::navigator
