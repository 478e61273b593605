// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "lodestar/samples/counters.h"

namespace lodestar::bus {

/// Names of the input channels, indexed by samples::Channel. This is all that is ever listened to:
/// TRUTH, above all, is not in it.
inline constexpr std::array<const char*, samples::kChannels> kInputNames = {
    "EFCS.RATES", "EFCS.LOAD_FACTOR", "SMDU", "ADC", "IMU.ACCEL",
    "GPS",        "GPS.RAW",          "INS",  "SAR", "RALT",
};

inline constexpr const char* kSahrs = "SAHRS";
inline constexpr const char* kNav = "NAV";
inline constexpr const char* kInsMonitor = "INS.MONITOR";
inline constexpr const char* kSmduCalibration = "SMDU.CALIBRATION";
inline constexpr const char* kHealth = "HEALTH";

constexpr const char* name(samples::Channel channel) {
  return kInputNames[static_cast<std::size_t>(channel)];
}

/// The input channel of that name, compared to the last character; nothing for any other channel.
constexpr std::optional<samples::Channel> input_channel(std::string_view channel_name) {
  for (std::size_t i = 0; i < kInputNames.size(); ++i) {
    if (channel_name == kInputNames[i]) return static_cast<samples::Channel>(i);
  }
  return std::nullopt;
}

}  // namespace lodestar::bus
