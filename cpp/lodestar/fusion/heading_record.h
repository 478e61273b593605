// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace lodestar::fusion {

/// What the filter and SAHRS had as heading over the last two minutes, second by second, so that
/// what is said of one then can be told of the other now.
class HeadingRecord {
 public:
  struct Entry {
    std::int64_t time_us = 0;
    double ahead_of_sahrs = 0.0;  // rad, heading of the filter - that of SAHRS
    double corrected = 0.0;       // rad, sum of all corrections of the filter's heading until then
  };

  void add(const Entry& entry) {
    if (count_ > 0 && entry.time_us - newest().time_us < kStep_us) return;
    newest_ = (newest_ + 1) % kCapacity;
    entries_[newest_] = entry;
    if (count_ < kCapacity) ++count_;
  }

  void restart() { count_ = 0; }

  /// The entry of that time, to a second; none if it is too long ago.
  std::optional<Entry> at(std::int64_t time_us) const {
    for (std::size_t age = 0; age < count_; ++age) {
      const Entry& entry = entries_[(newest_ + kCapacity - age) % kCapacity];
      if (entry.time_us > time_us) continue;
      if (time_us - entry.time_us > 2 * kStep_us) return std::nullopt;
      return entry;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kCapacity = 128;
  static constexpr std::int64_t kStep_us = 1'000'000;

  const Entry& newest() const { return entries_[newest_]; }

  std::array<Entry, kCapacity> entries_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace lodestar::fusion
