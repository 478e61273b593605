// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <lodestar/air_data_t.hpp>
#include <lodestar/body_rates_t.hpp>
#include <lodestar/gps_fix_t.hpp>
#include <lodestar/gps_observables_t.hpp>
#include <lodestar/ins_solution_t.hpp>
#include <lodestar/load_factor_t.hpp>
#include <lodestar/magnetic_field_t.hpp>
#include <lodestar/radar_altitude_t.hpp>
#include <lodestar/sar_measurement_t.hpp>
#include <lodestar/specific_force_t.hpp>
#include <vector>

#include "lodestar/samples/counters.h"

// One plausible message per input channel, as another program would send it.

namespace lodestar::bus {

using Bytes = std::vector<std::uint8_t>;

template <class Wire>
Bytes bytes_of(const Wire& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

inline body_rates_t wire_body_rates() { return {1'000'000, {0.01, -0.02, 0.03}, 1}; }
inline load_factor_t wire_load_factor() { return {1'000'001, {0.01, 0.02, 1.03}, 1}; }
inline magnetic_field_t wire_magnetic_field() { return {1'000'002, {15000.0, 1200.0, 48000.0}, 1}; }
inline air_data_t wire_air_data() { return {1'000'003, 220.0, 0.05, -0.01, 6000.0, 249.0, 1}; }
inline specific_force_t wire_specific_force() { return {1'000'004, {0.1, -0.2, -9.8}, 300.0, 1}; }
inline gps_fix_t wire_gps() {
  return {1'000'005, 1.0, 0.28, 6000.0, {200.0, 10.0, -1.0}, 1, 5.0, 9.0, 0.2, 3, 9, 0.9};
}
inline ins_solution_t wire_ins() {
  return {1'000'006, 0.1, 0.05, 1.5, 1.0, 0.28, 6000.0, {200.0, 10.0, -1.0}, 1};
}
inline sar_measurement_t wire_sar() { return {1'000'007, 42, 30e3, -150.0, {3.2e6, 0.9e6, 5.4e6}}; }
inline radar_altitude_t wire_radar_altitude() { return {1'000'008, 431.5, 1}; }
inline gps_observables_t wire_gps_observables() {
  gps_observables_t m{};
  m.time_us = 1'000'009;
  m.kind = 1;
  m.count = 2;
  for (int i = 0; i < 2; ++i) {
    m.prn[i] = static_cast<std::int8_t>(5 + i);
    m.pseudorange[i] = 2.1e7 + i;
    m.carrier_phase[i] = 2.2e7 + i;
    for (int axis = 0; axis < 3; ++axis) m.sv_p_E[i][axis] = 1e7 * (axis + 1) + i;
    m.sigma[i] = 3.0 + i;
  }
  return m;
}

inline Bytes wire_message(samples::Channel channel) {
  using samples::Channel;
  switch (channel) {
    case Channel::kBodyRates:
      return bytes_of(wire_body_rates());
    case Channel::kLoadFactor:
      return bytes_of(wire_load_factor());
    case Channel::kMagneticField:
      return bytes_of(wire_magnetic_field());
    case Channel::kAirData:
      return bytes_of(wire_air_data());
    case Channel::kSpecificForce:
      return bytes_of(wire_specific_force());
    case Channel::kGps:
      return bytes_of(wire_gps());
    case Channel::kGpsObservables:
      return bytes_of(wire_gps_observables());
    case Channel::kIns:
      return bytes_of(wire_ins());
    case Channel::kSar:
      return bytes_of(wire_sar());
    case Channel::kRadarAltitude:
      return bytes_of(wire_radar_altitude());
  }
  return {};
}

inline std::vector<samples::Channel> all_channels() {
  std::vector<samples::Channel> channels;
  for (int i = 0; i < samples::kChannels; ++i) channels.push_back(static_cast<samples::Channel>(i));
  return channels;
}

}  // namespace lodestar::bus
