// SPDX-License-Identifier: Apache-2.0
#include "lodestar/bus/codec.h"

#include <algorithm>
#include <lodestar/air_data_t.hpp>
#include <lodestar/attitude_t.hpp>
#include <lodestar/body_rates_t.hpp>
#include <lodestar/gps_fix_t.hpp>
#include <lodestar/gps_observables_t.hpp>
#include <lodestar/health_t.hpp>
#include <lodestar/ins_monitor_t.hpp>
#include <lodestar/ins_solution_t.hpp>
#include <lodestar/load_factor_t.hpp>
#include <lodestar/magnetic_field_t.hpp>
#include <lodestar/navigation_t.hpp>
#include <lodestar/radar_altitude_t.hpp>
#include <lodestar/sar_measurement_t.hpp>
#include <lodestar/smdu_calibration_t.hpp>
#include <lodestar/specific_force_t.hpp>

namespace lodestar::bus {
namespace {

using samples::Channel;
using samples::Reason;

// us, either way (73 000 years): the difference of any two such times fits an int64_t.
constexpr std::int64_t kTimeLimit = std::int64_t{1} << 61;

Eigen::Vector3d vector(const double (&v)[3]) { return Eigen::Vector3d(v[0], v[1], v[2]); }

template <int kSize>
void store(const Eigen::Matrix<double, kSize, 1>& v, double (&out)[kSize]) {
  for (int i = 0; i < kSize; ++i) out[i] = v[i];
}

template <class Value, std::size_t kSize>
void store(const std::array<Value, kSize>& values, Value (&out)[kSize]) {
  std::copy(values.begin(), values.end(), out);
}

/// False for a byte that is no boolean.
bool read_flag(std::int8_t byte, bool& flag) {
  flag = byte == 1;
  return byte == 0 || byte == 1;
}

// Wire type to sample, one overload per input channel. False if a boolean is neither 0 nor 1.

bool convert(const body_rates_t& m, samples::BodyRates& s) {
  s.time_us = m.time_us;
  s.omega_B = vector(m.omega_B);
  return read_flag(m.valid, s.valid);
}

bool convert(const load_factor_t& m, samples::LoadFactor& s) {
  s.time_us = m.time_us;
  s.n_B = vector(m.n_B);
  return read_flag(m.valid, s.valid);
}

bool convert(const magnetic_field_t& m, samples::MagneticField& s) {
  s.time_us = m.time_us;
  s.b_B = vector(m.b_B);
  return read_flag(m.valid, s.valid);
}

bool convert(const air_data_t& m, samples::AirData& s) {
  s.time_us = m.time_us;
  s.true_airspeed = m.true_airspeed;
  s.alpha = m.alpha;
  s.beta = m.beta;
  s.baro_altitude = m.baro_altitude;
  s.static_temperature = m.static_temperature;
  return read_flag(m.valid, s.valid);
}

bool convert(const specific_force_t& m, samples::SpecificForce& s) {
  s.time_us = m.time_us;
  s.f_B = vector(m.f_B);
  s.temperature = m.temperature;
  return read_flag(m.valid, s.valid);
}

bool convert(const gps_fix_t& m, samples::GpsFix& s) {
  s.time_us = m.time_us;
  s.lat = m.lat;
  s.lon = m.lon;
  s.h = m.h;
  s.v_N = vector(m.v_N);
  s.sigma_horizontal = m.sigma_horizontal;
  s.sigma_vertical = m.sigma_vertical;
  s.sigma_velocity = m.sigma_velocity;
  s.fix_type = m.fix_type;
  s.satellites = m.satellites;
  s.hdop = m.hdop;
  return read_flag(m.has_velocity, s.has_velocity);
}

bool convert(const gps_observables_t& m, samples::GpsObservables& s) {
  s.time_us = m.time_us;
  s.kind = m.kind;
  s.count = m.count;
  for (int i = 0; i < samples::GpsObservables::kMaximum; ++i) {
    s.prn[i] = m.prn[i];
    s.pseudorange[i] = m.pseudorange[i];
    s.carrier_phase[i] = m.carrier_phase[i];
    for (int axis = 0; axis < 3; ++axis) s.sv_p_E[i][axis] = m.sv_p_E[i][axis];
    s.sigma[i] = m.sigma[i];
  }
  return true;
}

bool convert(const ins_solution_t& m, samples::InsSolution& s) {
  s.time_us = m.time_us;
  s.roll = m.roll;
  s.pitch = m.pitch;
  s.heading = m.heading;
  s.lat = m.lat;
  s.lon = m.lon;
  s.h = m.h;
  s.v_N = vector(m.v_N);
  return read_flag(m.valid, s.valid);
}

bool convert(const sar_measurement_t& m, samples::SarMeasurement& s) {
  s.time_us = m.time_us;
  s.target_id = m.target_id;
  s.range = m.range;
  s.range_rate = m.range_rate;
  s.nominal_target_p_E = vector(m.nominal_target_p_E);
  return true;
}

bool convert(const radar_altitude_t& m, samples::RadarAltitude& s) {
  s.time_us = m.time_us;
  s.height = m.height;
  return read_flag(m.valid, s.valid);
}

std::int64_t fingerprint(const std::uint8_t* data) {
  std::uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value = value << 8 | data[i];
  return static_cast<std::int64_t>(value);
}

template <class Wire, class Sample>
Decoded decode_as(const void* data, std::size_t size) {
  Wire wire{};
  const int expected = wire.getEncodedSize();
  if (size != static_cast<std::size_t>(expected)) return Reason::kSize;
  if (fingerprint(static_cast<const std::uint8_t*>(data)) != Wire::getHash()) {
    return Reason::kFingerprint;
  }
  Sample sample;
  if (wire.decode(data, 0, expected) != expected || !convert(wire, sample)) return Reason::kDecode;
  if (sample.time_us < -kTimeLimit || sample.time_us > kTimeLimit) return Reason::kOutOfRange;
  return sample;
}

template <class Wire>
void write(const Wire& wire, Message& message) {
  const int size = wire.encode(message.bytes.data(), 0, static_cast<int>(Message::kCapacity));
  message.size = static_cast<std::size_t>(std::max(size, 0));
}

}  // namespace

Decoded decode(Channel channel, const void* data, std::size_t size) noexcept {
  try {
    switch (channel) {
      case Channel::kBodyRates:
        return decode_as<body_rates_t, samples::BodyRates>(data, size);
      case Channel::kLoadFactor:
        return decode_as<load_factor_t, samples::LoadFactor>(data, size);
      case Channel::kMagneticField:
        return decode_as<magnetic_field_t, samples::MagneticField>(data, size);
      case Channel::kAirData:
        return decode_as<air_data_t, samples::AirData>(data, size);
      case Channel::kSpecificForce:
        return decode_as<specific_force_t, samples::SpecificForce>(data, size);
      case Channel::kGps:
        return decode_as<gps_fix_t, samples::GpsFix>(data, size);
      case Channel::kGpsObservables:
        return decode_as<gps_observables_t, samples::GpsObservables>(data, size);
      case Channel::kIns:
        return decode_as<ins_solution_t, samples::InsSolution>(data, size);
      case Channel::kSar:
        return decode_as<sar_measurement_t, samples::SarMeasurement>(data, size);
      case Channel::kRadarAltitude:
        return decode_as<radar_altitude_t, samples::RadarAltitude>(data, size);
    }
  } catch (...) {  // the generated decoder is not ours: whatever it throws ends here
  }
  return Reason::kDecode;
}

void encode(const samples::Attitude& s, Message& message) noexcept {
  attitude_t m{};
  m.time_us = s.time_us;
  m.roll = s.roll;
  m.pitch = s.pitch;
  m.heading = s.heading;
  m.q_NB[0] = s.q_NB.w();
  m.q_NB[1] = s.q_NB.x();
  m.q_NB[2] = s.q_NB.y();
  m.q_NB[3] = s.q_NB.z();
  store(s.sigma_B(), m.sigma_B);
  store(s.gyro_bias_B, m.gyro_bias_B);
  store(s.field_bias_B, m.field_bias_B);
  m.used = s.used;
  m.rejected = s.rejected;
  m.reset_count = s.reset_count;
  store(s.reset_delta_B, m.reset_delta_B);
  m.mode = static_cast<std::int8_t>(s.mode);
  m.valid = s.valid ? 1 : 0;
  write(m, message);
}

void encode(const samples::Navigation& s, Message& message) noexcept {
  navigation_t m{};
  m.time_us = s.time_us;
  m.lat = s.lat;
  m.lon = s.lon;
  m.h = s.h;
  store(s.v_N, m.v_N);
  m.roll = s.roll;
  m.pitch = s.pitch;
  m.heading = s.heading;
  store(s.wind_N, m.wind_N);
  store(s.sigma_position, m.sigma_position);
  store(s.sigma_velocity, m.sigma_velocity);
  store(s.sigma_attitude, m.sigma_attitude);
  store(s.sigma_wind, m.sigma_wind);
  store(s.gps_error, m.gps_error);
  m.gps_age = s.gps_age;
  m.horizontal_protection_level = s.horizontal_protection_level;
  m.reset_count = s.reset_count;
  store(s.reset_delta, m.reset_delta);
  m.mode = static_cast<std::int8_t>(s.mode);
  m.valid = s.valid ? 1 : 0;
  write(m, message);
}

void encode(const samples::InsMonitor& s, Message& message) noexcept {
  ins_monitor_t m{};
  m.time_us = s.time_us;
  store(s.difference, m.difference);
  store(s.threshold, m.threshold);
  store(s.time_over, m.time_over);
  m.state = static_cast<std::int8_t>(s.state);
  write(m, message);
}

void encode(const samples::SmduCalibration& s, Message& message) noexcept {
  smdu_calibration_t m{};
  m.time_us = s.time_us;
  store(s.x, m.x);
  store(s.sigma, m.sigma);
  m.state = static_cast<std::int8_t>(s.state);
  write(m, message);
}

void encode(const samples::Health& s, Message& message) noexcept {
  health_t m{};
  m.time_us = s.time_us;
  for (std::size_t i = 0; i < samples::kChannels; ++i) {
    m.received[i] = s.counters[i].received;
    m.used[i] = s.counters[i].used;
    store(s.counters[i].rejected, m.rejected[i]);
    m.sensor_state[i] = static_cast<std::int8_t>(s.sensor_state[i]);
  }
  m.cycle_mean = s.cycle.mean;
  m.cycle_p99 = s.cycle.p99;
  m.cycle_max = s.cycle.max;
  store(s.cycle.histogram, m.cycle_histogram);
  m.sahrs_form = static_cast<std::int8_t>(s.sahrs_form);
  m.fusion_filter = static_cast<std::int8_t>(s.fusion_filter);
  m.sahrs_mode = static_cast<std::int8_t>(s.sahrs_mode);
  m.fusion_mode = static_cast<std::int8_t>(s.fusion_mode);
  m.ahrs_mode = static_cast<std::int8_t>(s.ahrs_mode);
  store(s.assumption_rejects, m.assumption_rejects);
  store(s.innovation, m.innovation);
  store(s.innovation_sigma, m.innovation_sigma);
  m.calibration_id = s.calibration_id;
  m.config_hash = s.config_hash;
  m.log_dropped = s.log_dropped;
  m.warning = s.warning;
  std::copy(s.build_version.begin(), s.build_version.end(), m.build_version);
  write(m, message);
}

}  // namespace lodestar::bus
