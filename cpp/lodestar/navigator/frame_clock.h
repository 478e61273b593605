// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace lodestar::navigator {

inline constexpr std::int64_t kMicrosecond = 1;
inline constexpr std::int64_t kSecond = 1'000'000 * kMicrosecond;
inline constexpr std::int64_t kOldest = kSecond;               // a measurement may be this old
inline constexpr std::int64_t kAhead = 50'000 * kMicrosecond;  // ... or this far ahead
// Before any time. Not the smallest number: time - kNever must not overflow.
inline constexpr std::int64_t kNever = -(std::int64_t{1} << 62);
inline constexpr std::int64_t kLongestStep = kSecond;                  // of the master clock
inline constexpr std::int64_t kLongestCoast = 500'000 * kMicrosecond;  // bridged without body rates

/// The master clock: which times of EFCS.RATES make a frame.
///
/// A single wild time stamp must neither move the clock nor lock it out, and a time base that
/// really jumped (a recording that goes on later, a sender that restarted) must be followed. So a
/// step of up to 1 s forward is a frame; any other time is refused until `kConfirmations` samples
/// in a row agree on the new base.
class FrameClock {
 public:
  enum class Verdict { kFrame, kJump, kBackwards, kAhead };

  Verdict judge(std::int64_t time_us) {
    if (!started_) {
      started_ = true;
      return accept(time_us, Verdict::kFrame);
    }
    const std::int64_t step = time_us - now_;
    if (step > 0 && step <= kLongestStep) return accept(time_us, Verdict::kFrame);
    const std::int64_t candidate_step = time_us - candidate_;
    const bool agrees = confirmations_ > 0 && candidate_step > 0 && candidate_step <= kLongestStep;
    confirmations_ = agrees ? confirmations_ + 1 : 1;
    candidate_ = time_us;
    if (confirmations_ > kConfirmations) return accept(time_us, Verdict::kJump);
    return step > 0 ? Verdict::kAhead : Verdict::kBackwards;
  }

  bool started() const { return started_; }
  std::int64_t now() const { return now_; }

 private:
  static constexpr int kConfirmations = 10;

  Verdict accept(std::int64_t time_us, Verdict verdict) {
    now_ = time_us;
    confirmations_ = 0;
    return verdict;
  }

  bool started_ = false;
  std::int64_t now_ = 0;
  std::int64_t candidate_ = 0;
  int confirmations_ = 0;
};

}  // namespace lodestar::navigator
