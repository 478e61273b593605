// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "lodestar/bus/codec.h"
#include "lodestar/navigator/navigator.h"

namespace lodestar::app {

/// Where the answers of a session go: the bus in flight, a file in replay.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void send(const char* channel, const bus::Message& message) = 0;
  /// Adds to HEALTH what only the shell knows. Replay knows nothing more: it reads no clock.
  virtual void complete(samples::Health&) {}
};

/// The way of every message, in flight as in replay: bytes -> sample -> navigator -> outputs ->
/// bytes. Allocates nothing after construction.
class Session {
 public:
  Session(const navigator::Config& config, Sink& sink) : navigator_(config), sink_(sink) {}

  /// One message of an input channel. EFCS.RATES sends SAHRS and NAV before this returns, and
  /// SMDU.CALIBRATION and HEALTH when they are due. The outputs of the frame if there was one,
  /// valid until the next call.
  const navigator::Outputs* receive(samples::Channel channel, const void* data, std::size_t size);

  const navigator::Navigator& navigator() const { return navigator_; }

  /// HEALTH as it stands.
  void send_health();

 private:
  const navigator::Outputs* step(const samples::BodyRates& rates);
  template <class Sample>
  void send(const char* channel, const Sample& sample);

  navigator::Navigator navigator_;
  Sink& sink_;
  bus::Message message_;
};

}  // namespace lodestar::app
