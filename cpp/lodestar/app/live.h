// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "lodestar/app/cycle_recorder.h"
#include "lodestar/app/event_log.h"
#include "lodestar/app/reporter.h"
#include "lodestar/app/session.h"
#include "lodestar/app/stop_signals.h"
#include "lodestar/bus/bus.h"

namespace lodestar::app {

/// A session on the bus.
///
/// HEALTH is sent at the start, then once per second of wall time until the first frame, so that
/// whoever started the process can see that it listens; from the first frame on, once per second of
/// flight time.
class Live : private bus::Receiver, private Sink {
 public:
  /// Throws bus::BusError; nothing has been sent by then.
  Live(const navigator::Config& config, const std::string& url, bool realtime);

  /// Flies until a signal asks to stop, always between two messages.
  void run(const StopSignals& stop);

  std::int64_t frames() const { return frames_; }
  navigator::CalibrationResult calibration_result() const {
    return session_.navigator().calibration_result();
  }

 private:
  void receive(samples::Channel channel, const void* data, std::size_t size) override;
  void send(const char* channel, const bus::Message& message) override;
  void complete(samples::Health& health) override;

  EventLog log_;  // first: its thread must not inherit realtime scheduling
  Reporter reporter_{log_};
  CycleRecorder cycle_;
  std::int64_t frames_ = 0;
  std::int64_t unsent_ = 0;
  std::int8_t warning_ = 0;
  Session session_;
  bus::Bus bus_;
};

}  // namespace lodestar::app
