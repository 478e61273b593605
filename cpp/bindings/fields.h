// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "lodestar/samples/health.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"

// Names of the fields of each channel, as NumPy sees them: those of the LCM type. `visit(name,
// member)` is called for each; it reads the member or writes it.

namespace lodestar::bindings {

template <class Visit>
void fields(samples::BodyRates& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("omega_B", s.omega_B);
  visit("valid", s.valid);
}

template <class Visit>
void fields(samples::LoadFactor& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("n_B", s.n_B);
  visit("valid", s.valid);
}

template <class Visit>
void fields(samples::MagneticField& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("b_B", s.b_B);
  visit("valid", s.valid);
}

template <class Visit>
void fields(samples::AirData& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("true_airspeed", s.true_airspeed);
  visit("alpha", s.alpha);
  visit("beta", s.beta);
  visit("baro_altitude", s.baro_altitude);
  visit("static_temperature", s.static_temperature);
  visit("valid", s.valid);
}

template <class Visit>
void fields(samples::GpsFix& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("lat", s.lat);
  visit("lon", s.lon);
  visit("h", s.h);
  visit("v_N", s.v_N);
  visit("has_velocity", s.has_velocity);
  visit("sigma_horizontal", s.sigma_horizontal);
  visit("sigma_vertical", s.sigma_vertical);
  visit("sigma_velocity", s.sigma_velocity);
  visit("fix_type", s.fix_type);
  visit("satellites", s.satellites);
  visit("hdop", s.hdop);
}

template <class Visit>
void fields(samples::InsSolution& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("roll", s.roll);
  visit("pitch", s.pitch);
  visit("heading", s.heading);
  visit("lat", s.lat);
  visit("lon", s.lon);
  visit("h", s.h);
  visit("v_N", s.v_N);
  visit("valid", s.valid);
}

template <class Visit>
void fields(const samples::Attitude& s, Visit&& visit) {
  const std::array<double, 4> q_NB{s.q_NB.w(), s.q_NB.x(), s.q_NB.y(), s.q_NB.z()};
  visit("time_us", s.time_us);
  visit("roll", s.roll);
  visit("pitch", s.pitch);
  visit("heading", s.heading);
  visit("q_NB", q_NB);
  visit("sigma_B", s.sigma_B());
  visit("gyro_bias_B", s.gyro_bias_B);
  visit("field_bias_B", s.field_bias_B);
  visit("used", s.used);
  visit("rejected", s.rejected);
  visit("reset_count", s.reset_count);
  visit("reset_delta_B", s.reset_delta_B);
  visit("mode", static_cast<std::int8_t>(s.mode));
  visit("valid", s.valid);
}

template <class Visit>
void fields(const samples::Navigation& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("lat", s.lat);
  visit("lon", s.lon);
  visit("h", s.h);
  visit("v_N", s.v_N);
  visit("roll", s.roll);
  visit("pitch", s.pitch);
  visit("heading", s.heading);
  visit("wind_N", s.wind_N);
  visit("sigma_position", s.sigma_position);
  visit("sigma_velocity", s.sigma_velocity);
  visit("sigma_attitude", s.sigma_attitude);
  visit("sigma_wind", s.sigma_wind);
  visit("gps_error", s.gps_error);
  visit("gps_age", s.gps_age);
  visit("horizontal_protection_level", s.horizontal_protection_level);
  visit("reset_count", s.reset_count);
  visit("reset_delta", s.reset_delta);
  visit("mode", static_cast<std::int8_t>(s.mode));
  visit("valid", s.valid);
}

template <class Visit>
void fields(const samples::InsMonitor& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("difference", s.difference);
  visit("threshold", s.threshold);
  visit("time_over", s.time_over);
  visit("state", static_cast<std::int8_t>(s.state));
}

template <class Visit>
void fields(const samples::SmduCalibration& s, Visit&& visit) {
  visit("time_us", s.time_us);
  visit("x", s.x);
  visit("sigma", s.sigma);
  visit("state", static_cast<std::int8_t>(s.state));
}

/// The numbers of HEALTH that an in-process run has: those that no shell adds.
template <class Visit>
void fields(const samples::Health& s, Visit&& visit) {
  std::array<std::int64_t, samples::kChannels> received{};
  std::array<std::int64_t, samples::kChannels> used{};
  std::array<std::int64_t, samples::kChannels * samples::kReasons> rejected{};
  std::array<std::int8_t, samples::kChannels> sensor_state{};
  for (std::size_t c = 0; c < samples::kChannels; ++c) {
    received[c] = s.counters[c].received;
    used[c] = s.counters[c].used;
    sensor_state[c] = static_cast<std::int8_t>(s.sensor_state[c]);
    for (std::size_t r = 0; r < samples::kReasons; ++r) {
      rejected[c * samples::kReasons + r] = s.counters[c].rejected[r];
    }
  }
  visit("time_us", s.time_us);
  visit("received", received);
  visit("used", used);
  visit("rejected", rejected);
  visit("sensor_state", sensor_state);
  visit("cycle_mean", s.cycle.mean);
  visit("cycle_p99", s.cycle.p99);
  visit("cycle_max", s.cycle.max);
  visit("cycle_histogram", s.cycle.histogram);
  visit("sahrs_form", static_cast<std::int8_t>(s.sahrs_form));
  visit("fusion_filter", static_cast<std::int8_t>(s.fusion_filter));
  visit("sahrs_mode", static_cast<std::int8_t>(s.sahrs_mode));
  visit("fusion_mode", static_cast<std::int8_t>(s.fusion_mode));
  visit("ahrs_mode", static_cast<std::int8_t>(s.ahrs_mode));
  visit("assumption_rejects", s.assumption_rejects);
  visit("innovation", s.innovation);
  visit("innovation_sigma", s.innovation_sigma);
  visit("calibration_id", s.calibration_id);
  visit("config_hash", s.config_hash);
  visit("log_dropped", s.log_dropped);
  visit("warning", s.warning);
  std::array<std::uint8_t, 16> version{};
  for (std::size_t i = 0; i < version.size(); ++i) {
    version[i] = static_cast<std::uint8_t>(s.build_version[i]);
  }
  visit("build_version", version);
}

}  // namespace lodestar::bindings
