// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/fusion/cascade_parameters.h"
#include "lodestar/fusion/fusion_parameters.h"
#include "lodestar/fusion/integrated_parameters.h"
#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"
#include "lodestar/monitor/parameters.h"
#include "lodestar/sahrs/calibration_record.h"
#include "lodestar/sahrs/ground_swing.h"
#include "lodestar/sahrs/parameters.h"
#include "lodestar/sahrs/smdu_calibration.h"
#include "lodestar/strapdown/parameters.h"

namespace lodestar::navigator {

/// [airframe]
struct AirframeParameters {
  std::string id;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.id, {"id", sahrs::smdu::kLongestAirframe,
                    "Name of this very aircraft; a stored calibration belongs to one"});
  }
};

/// [earth]
struct EarthParameters {
  double epoch_year = 2026.5;  // decimal year
  earth::GeomagneticKind geomagnetic_model = earth::GeomagneticKind::kIgrf14;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.epoch_year, {"epoch_year", "decimal year", 1900.0, 2100.0,
                            "Date of the flight, for the geomagnetic model"});
    visit(self.geomagnetic_model, {"geomagnetic_model", earth::kGeomagneticNames, 2,
                                   "Model of the Earth's magnetic field"});
  }
};

/// [initial]: what is known before the first measurement.
struct InitialParameters {
  double lat = 57.5 * math::kDegree;            // rad
  double lon = 16.0 * math::kDegree;            // rad
  double h = 0.0;                               // m
  std::optional<double> position_sigma;         // m
  std::optional<double> roll;                   // rad
  std::optional<double> pitch;                  // rad
  std::optional<double> heading;                // rad
  double attitude_sigma = 2.0 * math::kDegree;  // rad
  double heading_sigma = 2.0 * math::kDegree;   // rad

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    using math::kDegree;
    visit(self.lat, {"lat_deg", "deg", -90.0, 90.0,
                     "Latitude until the first GPS fix, for the geomagnetic model", kDegree});
    visit(self.lon, {"lon_deg", "deg", -180.0, 360.0,
                     "Longitude until the first GPS fix, for the geomagnetic model", kDegree});
    visit(self.h,
          {"h_m", "m", -1000.0, 40e3, "Height until the first GPS fix, for the geomagnetic model"});
    visit(self.position_sigma,
          {"position_sigma_m", "m", 0.01, 1e6,
           "1 sigma of that position per axis; unset: navigation waits for the first fix"});
    visit(self.roll,
          {"roll_deg", "deg", -180.0, 180.0,
           "Roll at the start; with pitch and heading it replaces the alignment", kDegree});
    visit(self.pitch, {"pitch_deg", "deg", -90.0, 90.0, "Pitch at the start", kDegree});
    visit(self.heading, {"heading_deg", "deg", -180.0, 360.0,
                         "True heading at the start, as the "
                         "INS had it last",
                         kDegree});
    visit(self.attitude_sigma, {"attitude_sigma_deg", "deg", 0.01, 90.0,
                                "1 sigma of roll and pitch at the start", kDegree});
    visit(self.heading_sigma,
          {"heading_sigma_deg", "deg", 0.01, 180.0, "1 sigma of heading at the start", kDegree});
  }
};

/// [timeout]: silence after which a sensor is called stale.
struct TimeoutParameters {
  double body_rates = 0.2;      // s
  double load_factor = 0.2;     // s
  double magnetic_field = 0.5;  // s
  double air_data = 0.5;        // s
  double gps = 3.0;             // s
  double ins = 0.5;             // s
  double other = 3.0;           // s

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.body_rates,
          {"body_rates_s", "s", 0.01, 60.0, "Silence that makes EFCS.RATES stale"});
    visit(self.load_factor,
          {"load_factor_s", "s", 0.01, 60.0, "Silence that makes EFCS.LOAD_FACTOR stale"});
    visit(self.magnetic_field,
          {"magnetic_field_s", "s", 0.01, 60.0, "Silence that makes SMDU stale"});
    visit(self.air_data, {"air_data_s", "s", 0.01, 60.0, "Silence that makes ADC stale"});
    visit(self.gps, {"gps_s", "s", 0.1, 60.0, "Silence that makes GPS stale"});
    visit(self.ins, {"ins_s", "s", 0.01, 60.0, "Silence that makes INS stale"});
    visit(self.other, {"other_s", "s", 0.1, 600.0, "Silence that makes any other sensor stale"});
  }
};

/// Everything a person may set: one member per section of the configuration file.
struct Config {
  AirframeParameters airframe;
  EarthParameters earth;
  InitialParameters initial;
  TimeoutParameters timeout;
  sahrs::FieldCalibration smdu_calibration;
  sahrs::smdu::FilterParameters smdu_calibration_filter;
  sahrs::smdu::SwingParameters smdu_ground_swing;
  sahrs::Parameters sahrs;
  strapdown::Parameters strapdown;
  fusion::FusionParameters fusion;
  fusion::CascadeParameters cascade;
  fusion::IntegratedParameters integrated;
  monitor::InsMonitorParameters ins_monitor;
  std::uint32_t hash = 0;  // CRC-32 of the text it was read from; 0 for the built-in defaults

  /// Calls `section(name, parameters)` for each section, in the order of the docs.
  template <class Self, class Section>
  static void describe(Self& self, Section&& section) {
    section("airframe", self.airframe);
    section("earth", self.earth);
    section("initial", self.initial);
    section("timeout", self.timeout);
    section("smdu_calibration", self.smdu_calibration);
    section("smdu_calibration_filter", self.smdu_calibration_filter);
    section("smdu_ground_swing", self.smdu_ground_swing);
    section("sahrs", self.sahrs);
    section("strapdown", self.strapdown);
    section("fusion", self.fusion);
    section("fusion.integrated", self.integrated);
    section("fusion.cascade", self.cascade);
    section("monitor.ins", self.ins_monitor);
  }
};

/// One line: file, line, key, what was wrong, what is allowed.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads TOML `text` over the built-in defaults. `source` names it in errors.
/// Throws ConfigError on bad syntax, an unknown section or key, a wrong type, a value out of range.
Config parse_config(std::string_view text, const std::string& source);

/// Reads the section [smdu_calibration] of `text` over `config` and leaves the rest as it is.
/// Throws ConfigError as parse_config does, and for any other section.
void apply_calibration(Config& config, std::string_view text, const std::string& source);

/// Puts a stored calibration in the place of the configuration's, with its sigma and what may have
/// changed since.
void apply_calibration(Config& config, const sahrs::smdu::Record& record);

/// The table of all parameters, in Markdown: section, key, default, unit, range, meaning.
std::string parameter_table();

/// CRC-32 of the calibration's numbers; 0 when it is the identity.
std::uint32_t calibration_id(const sahrs::FieldCalibration& calibration);

}  // namespace lodestar::navigator
