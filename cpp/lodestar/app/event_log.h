// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "lodestar/samples/counters.h"
#include "lodestar/samples/outputs.h"

namespace lodestar::app {

/// Something worth a line in the log, in the form the frame path can afford to note.
struct Event {
  enum class Kind : std::uint8_t {
    kSahrsMode,
    kFusionMode,
    kInsState,
    kFieldModel,
    kRejected,
    kUnsent
  };
  Kind kind = Kind::kUnsent;
  std::int64_t time_us = 0;  // flight time
  std::uint8_t subject = 0;  // new mode or state, or samples::Channel
  std::uint8_t detail = 0;   // samples::Reason
  std::int64_t count = 0;    // messages
};

/// The line that a person reads.
std::string describe(const Event& event);

/// A bounded queue between the frame path and the log. note() takes no lock and waits for nobody; a
/// thread of its own writes the lines. What does not fit is dropped and counted.
class EventLog {
 public:
  EventLog();
  /// Writes what is left.
  ~EventLog();
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// From one thread only.
  void note(const Event& event) noexcept;

  std::int64_t dropped() const noexcept { return dropped_; }

 private:
  static constexpr std::size_t kCapacity = 256;

  void write_pending();
  void run();

  std::array<Event, kCapacity> ring_{};
  std::atomic<std::size_t> written_{0};  // by note()
  std::atomic<std::size_t> read_{0};     // by the thread
  std::int64_t dropped_ = 0;

  std::mutex stop_mutex_;  // never taken by note()
  std::condition_variable stop_condition_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace lodestar::app
