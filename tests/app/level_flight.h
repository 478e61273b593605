// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <lodestar/air_data_t.hpp>
#include <lodestar/body_rates_t.hpp>
#include <lodestar/gps_fix_t.hpp>
#include <lodestar/ins_solution_t.hpp>
#include <lodestar/load_factor_t.hpp>
#include <lodestar/magnetic_field_t.hpp>
#include <vector>

#include "lodestar/samples/counters.h"

// A straight and level flight to the north as messages: body rates and load factor at 60 Hz,
// magnetic field and air data at 30 Hz, GPS at 1 Hz. Plain enough to be checked by hand; the
// sensors carry a ripple, because a sensor without noise is taken for stuck.

namespace lodestar::app {

struct Sent {
  samples::Channel channel{};
  std::int64_t time_us = 0;
  std::vector<std::uint8_t> bytes;
};

template <class Wire>
Sent sent(samples::Channel channel, const Wire& message) {
  Sent result{channel, message.time_us, {}};
  result.bytes.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(result.bytes.data(), 0, static_cast<int>(result.bytes.size()));
  return result;
}

inline std::vector<Sent> level_flight(int seconds, int start = 1) {
  using samples::Channel;
  constexpr double kSpeed = 200.0;                        // m/s
  constexpr double kField[3] = {15e3, 1200.0, 48e3};      // nT
  constexpr double kEarthRate[3] = {3.9e-5, 0, -6.1e-5};  // rad/s, at 57.5 degrees north
  constexpr double kLatStart = 1.0036;                    // rad
  std::vector<Sent> messages;
  for (int frame = 0; frame < seconds * 60; ++frame) {
    const std::int64_t time_us =
        start * std::int64_t{1'000'000} + frame * std::int64_t{1'000'000} / 60;
    const double ripple = std::sin(0.7 * frame);
    const double distance = kSpeed * frame / 60.0;
    const double lat = kLatStart + distance / 6.38e6;
    messages.push_back(
        sent(Channel::kLoadFactor, load_factor_t{time_us, {1e-3 * ripple, 1e-3 * ripple, 1.0}, 1}));
    if (frame % 2 == 0) {
      messages.push_back(
          sent(Channel::kMagneticField,
               magnetic_field_t{time_us, {kField[0] + ripple, kField[1] + ripple, kField[2]}, 1}));
      messages.push_back(sent(Channel::kAirData, air_data_t{time_us, kSpeed + 0.01 * ripple, 0.0,
                                                            0.0, 5000.0, 255.0, 1}));
      messages.push_back(sent(Channel::kIns, ins_solution_t{time_us,
                                                            1e-5 * ripple,
                                                            1e-5 * ripple,
                                                            0.001 + 1e-5 * ripple,
                                                            lat,
                                                            0.28,
                                                            5000.0,
                                                            {kSpeed, 0.0, 0.0},
                                                            1}));
    }
    if (frame % 60 == 0) {
      messages.push_back(sent(
          Channel::kGps,
          gps_fix_t{time_us, lat, 0.28, 5000.0, {kSpeed, 0.0, 0.0}, 1, 5.0, 10.0, 0.1, 3, 9, 0.9}));
    }
    messages.push_back(
        sent(Channel::kBodyRates,
             body_rates_t{time_us, {kEarthRate[0] + 1e-5 * ripple, 0.0, kEarthRate[2]}, 1}));
  }
  return messages;
}

}  // namespace lodestar::app
