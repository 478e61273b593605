// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/event_log.h"

#include <spdlog/spdlog.h>

#include <chrono>

#include "lodestar/bus/channels.h"

namespace lodestar::app {
namespace {

constexpr std::chrono::milliseconds kPeriod{100};

constexpr const char* kAttitudeModes[] = {"waiting", "aligning", "running", "coasting",
                                          "re-aligning after a gap"};
constexpr const char* kFusionModes[] = {"waiting for a position", "aiding", "dead reckoning",
                                        "re-acquiring GPS"};
constexpr const char* kInsStates[] = {"none to watch", "agrees with SAHRS", "suspect",
                                      "miscompare with SAHRS"};
constexpr const char* kReasons[] = {
    "size", "fingerprint", "decode", "not finite",   "out of range", "time backwards",
    "late", "future",      "stuck",  "invalid flag", "queue full",   "innovation gate"};
static_assert(std::size(kReasons) == samples::kReasons);

}  // namespace

std::string describe(const Event& event) {
  const double seconds = 1e-6 * static_cast<double>(event.time_us);
  switch (event.kind) {
    case Event::Kind::kSahrsMode:
      return fmt::format("t={:.3f} s SAHRS: {}", seconds, kAttitudeModes[event.subject]);
    case Event::Kind::kFusionMode:
      return fmt::format("t={:.3f} s NAV: {}", seconds, kFusionModes[event.subject]);
    case Event::Kind::kInsState:
      return fmt::format("t={:.3f} s INS: {}", seconds, kInsStates[event.subject]);
    case Event::Kind::kFieldModel:
      return fmt::format("t={:.3f} s outside the geomagnetic model's validity", seconds);
    case Event::Kind::kRejected:
      return fmt::format("t={:.3f} s {}: {} rejected: {}", seconds,
                         bus::name(static_cast<samples::Channel>(event.subject)), event.count,
                         kReasons[event.detail]);
    case Event::Kind::kUnsent:
      break;
  }
  return fmt::format("t={:.3f} s {} messages could not be sent", seconds, event.count);
}

EventLog::EventLog() : thread_([this] { run(); }) {}

EventLog::~EventLog() {
  {
    const std::lock_guard lock(stop_mutex_);
    stop_ = true;
  }
  stop_condition_.notify_one();
  thread_.join();
}

void EventLog::note(const Event& event) noexcept {
  const std::size_t written = written_.load(std::memory_order_relaxed);
  if (written - read_.load(std::memory_order_acquire) == kCapacity) {
    ++dropped_;
    return;
  }
  ring_[written % kCapacity] = event;
  written_.store(written + 1, std::memory_order_release);
}

void EventLog::write_pending() {
  std::size_t read = read_.load(std::memory_order_relaxed);
  while (read != written_.load(std::memory_order_acquire)) {
    const Event event = ring_[read % kCapacity];
    read_.store(++read, std::memory_order_release);
    spdlog::info(describe(event));
  }
}

void EventLog::run() {
  std::unique_lock lock(stop_mutex_);
  while (!stop_) {
    stop_condition_.wait_for(lock, kPeriod);
    write_pending();
  }
  write_pending();
}

}  // namespace lodestar::app
