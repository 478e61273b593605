// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

// What the core is told: one plain struct per input channel. Units, frames and signs are those of
// the LCM types of the same channel (lcm_types/), SI and radians throughout; `time_us` is the time
// of validity in microseconds on the flight time base.

namespace lodestar::samples {

inline constexpr double kStandardGravity = 9.80665;  // m/s^2, of the load factor's definition only

/// EFCS.RATES: rate of B relative to the inertial frame, in B.
struct BodyRates {
  std::int64_t time_us = 0;
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // rad/s
  bool valid = true;
};

/// EFCS.LOAD_FACTOR: n_B = -f_B / g0.
struct LoadFactor {
  std::int64_t time_us = 0;
  Eigen::Vector3d n_B = Eigen::Vector3d(0.0, 0.0, 1.0);  // g0
  bool valid = true;
};

/// SMDU: raw magnetic field.
struct MagneticField {
  std::int64_t time_us = 0;
  Eigen::Vector3d b_B = Eigen::Vector3d::Zero();  // nT
  bool valid = true;
};

/// ADC: air data.
struct AirData {
  std::int64_t time_us = 0;
  double true_airspeed = 0.0;         // m/s
  double alpha = 0.0;                 // rad, atan2(w, u)
  double beta = 0.0;                  // rad, asin(v / true_airspeed)
  double baro_altitude = 0.0;         // m
  double static_temperature = 288.0;  // K
  bool valid = true;
};

/// IMU.ACCEL: specific force, for the AHRS only.
struct SpecificForce {
  std::int64_t time_us = 0;
  Eigen::Vector3d f_B = Eigen::Vector3d::Zero();  // m/s^2
  double temperature = 288.0;                     // K
  bool valid = true;
};

/// GPS: position fix, with velocity where the receiver gives it.
struct GpsFix {
  std::int64_t time_us = 0;
  double lat = 0.0;                               // rad
  double lon = 0.0;                               // rad
  double h = 0.0;                                 // m above the ellipsoid
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  // m/s
  bool has_velocity = false;
  double sigma_horizontal = 5.0;  // m per axis
  double sigma_vertical = 10.0;   // m
  double sigma_velocity = 0.1;    // m/s per axis
  std::int8_t fix_type = 3;       // 0 none, 2, 3, 4 differential
  std::int8_t satellites = 8;
  double hdop = 1.0;
};

/// GPS.RAW: ranges of one epoch.
struct GpsObservables {
  static constexpr int kMaximum = 16;
  std::int64_t time_us = 0;
  std::int8_t kind = 0;  // 0 stand-alone, 1 differential, 2 carrier phase
  std::int8_t count = 0;
  std::int8_t prn[kMaximum] = {};
  double pseudorange[kMaximum] = {};    // m
  double carrier_phase[kMaximum] = {};  // m
  double sv_p_E[kMaximum][3] = {};      // m
  double sigma[kMaximum] = {};          // m
};

/// INS: solution of the inertial navigation system.
struct InsSolution {
  std::int64_t time_us = 0;
  double roll = 0.0;                              // rad
  double pitch = 0.0;                             // rad
  double heading = 0.0;                           // rad, true
  double lat = 0.0;                               // rad
  double lon = 0.0;                               // rad
  double h = 0.0;                                 // m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  // m/s
  bool valid = true;
};

/// SAR: range and range rate to an imaged target.
struct SarMeasurement {
  std::int64_t time_us = 0;
  std::int32_t target_id = 0;
  double range = 0.0;                                            // m
  double range_rate = 0.0;                                       // m/s
  Eigen::Vector3d nominal_target_p_E = Eigen::Vector3d::Zero();  // m
};

/// RALT: radar altimeter.
struct RadarAltitude {
  std::int64_t time_us = 0;
  double height = 0.0;  // m above ground
  bool valid = true;
};

}  // namespace lodestar::samples
