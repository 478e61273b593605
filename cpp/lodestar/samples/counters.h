// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace lodestar::samples {

/// Input channels, in the order of the rows of HEALTH.
enum class Channel : std::uint8_t {
  kBodyRates,
  kLoadFactor,
  kMagneticField,
  kAirData,
  kSpecificForce,
  kGps,
  kGpsObservables,
  kIns,
  kSar,
  kRadarAltitude,
};
inline constexpr int kChannels = 10;

/// Why a message did not reach a state, in the order of the columns of HEALTH.rejected.
enum class Reason : std::uint8_t {
  kSize,           // not exactly the size of the channel's type
  kFingerprint,    // another type, or another version of it
  kDecode,         // the decoder refused it
  kNotFinite,      // NaN or infinity
  kOutOfRange,     // outside what is physically possible
  kTimeBackwards,  // not later than the channel's last message
  kLate,           // more than 1 s old
  kFuture,         // more than 50 ms ahead of the frame
  kStuck,          // bit-identical for 1 s where noise is expected
  kInvalid,        // the sensor says so itself
  kQueueFull,      // more messages than a frame can hold
  kGate,           // innovation beyond its gate
};
inline constexpr int kReasons = 12;

/// What happened to the messages of one channel since start.
struct ChannelCounters {
  std::int64_t received = 0;
  std::int64_t used = 0;
  std::array<std::int64_t, kReasons> rejected{};

  void reject(Reason reason) { ++rejected[static_cast<std::size_t>(reason)]; }
};

using Counters = std::array<ChannelCounters, kChannels>;

inline ChannelCounters& of(Counters& counters, Channel channel) {
  return counters[static_cast<std::size_t>(channel)];
}
inline const ChannelCounters& of(const Counters& counters, Channel channel) {
  return counters[static_cast<std::size_t>(channel)];
}

}  // namespace lodestar::samples
