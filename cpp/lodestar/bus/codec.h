// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "lodestar/samples/counters.h"
#include "lodestar/samples/health.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"

namespace lodestar::bus {

/// A message from outside: the sample it carries, or the reason why it carries none.
using Decoded =
    std::variant<samples::Reason, samples::BodyRates, samples::LoadFactor, samples::MagneticField,
                 samples::AirData, samples::SpecificForce, samples::GpsFix, samples::GpsObservables,
                 samples::InsSolution, samples::SarMeasurement, samples::RadarAltitude>;

/// The border between the bus and the core. Nothing is believed: the message must have exactly the
/// size and the fingerprint of the channel's type, the decoder must use every byte of it, a boolean
/// must be 0 or 1, and the time such that arithmetic with it cannot overflow. Other values are
/// checked later, with samples::refusal().
///
/// `data` may be anything of `size` bytes. Allocates nothing, throws nothing.
Decoded decode(samples::Channel channel, const void* data, std::size_t size) noexcept;

/// An encoded output message, in place.
struct Message {
  static constexpr std::size_t kCapacity = 2048;  // HEALTH, the largest, needs 1535
  std::array<std::uint8_t, kCapacity> bytes{};
  std::size_t size = 0;
};

// Encode without allocation: SAHRS, NAV, INS.MONITOR, SMDU.CALIBRATION, HEALTH.
void encode(const samples::Attitude& sample, Message& message) noexcept;
void encode(const samples::Navigation& sample, Message& message) noexcept;
void encode(const samples::InsMonitor& sample, Message& message) noexcept;
void encode(const samples::SmduCalibration& sample, Message& message) noexcept;
void encode(const samples::Health& sample, Message& message) noexcept;

}  // namespace lodestar::bus
