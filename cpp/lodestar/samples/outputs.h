// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

// What the core answers: one plain struct per output channel. Units, frames and signs are those of
// the LCM types of the same channel (lcm_types/).

namespace lodestar::samples {

enum class AttitudeMode : std::int8_t {
  kWaiting = 0,     // nothing to align on yet
  kAligning = 1,    // attitude known, sigma above its limit
  kRunning = 2,     // vector measurements arrive and are used
  kCoasting = 3,    // gyros only
  kRealigning = 4,  // after a gap in the body rates
};

enum class FusionMode : std::int8_t {
  kWaiting = 0,        // no position yet
  kAiding = 1,         // GPS is used
  kDeadReckoning = 2,  // GPS is lost
  kReacquiring = 3,    // GPS is back and being examined
};

/// SAHRS, AHRS.
struct Attitude {
  std::int64_t time_us = 0;
  Eigen::Quaterniond q_NB = Eigen::Quaterniond::Identity();
  double roll = 0.0;                                       // rad
  double pitch = 0.0;                                      // rad
  double heading = 0.0;                                    // rad, true, [0, 2 pi)
  Eigen::Matrix3d P_B = Eigen::Matrix3d::Zero();           // rad^2, small rotation in B
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();       // rad/s, bias removed (not published)
  Eigen::Vector3d gyro_bias_B = Eigen::Vector3d::Zero();   // rad/s
  Eigen::Vector3d field_bias_B = Eigen::Vector3d::Zero();  // nT
  std::int32_t used = 0;                                   // bit per measurement
  std::int32_t rejected = 0;                               // bit per measurement
  std::int16_t reset_count = 0;
  Eigen::Vector3d reset_delta_B = Eigen::Vector3d::Zero();  // rad
  AttitudeMode mode = AttitudeMode::kWaiting;
  bool valid = false;

  /// rad, standard deviation of the small rotation about the body axes.
  Eigen::Vector3d sigma_B() const { return P_B.diagonal().cwiseSqrt(); }
};

/// What SAHRS is made of; the measurements that bits and rows speak of are those of its form.
enum class SahrsForm : std::int8_t { kVelocity = 0, kPaper = 1 };

/// What gives NAV.
enum class FusionFilter : std::int8_t { kIntegrated = 0, kCascade = 1 };

/// NAV.
struct Navigation {
  std::int64_t time_us = 0;
  double lat = 0.0;                                          // rad
  double lon = 0.0;                                          // rad
  double h = 0.0;                                            // m
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();             // m/s
  double roll = 0.0;                                         // rad
  double pitch = 0.0;                                        // rad
  double heading = 0.0;                                      // rad, true, [0, 2 pi)
  Eigen::Vector3d wind_N = Eigen::Vector3d::Zero();          // m/s
  Eigen::Vector3d sigma_position = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d sigma_velocity = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d sigma_attitude = Eigen::Vector3d::Zero();  // rad, roll, pitch, heading
  Eigen::Vector2d sigma_wind = Eigen::Vector2d::Zero();      // m/s
  Eigen::Vector2d gps_error = Eigen::Vector2d::Zero();       // m, measured - true
  double gps_age = -1.0;                                     // s; -1 before the first fix
  double horizontal_protection_level = -1.0;                 // m; -1 none
  std::int16_t reset_count = 0;
  Eigen::Vector2d reset_delta = Eigen::Vector2d::Zero();  // m
  FusionMode mode = FusionMode::kWaiting;
  bool valid = false;
};

enum class InsState : std::int8_t {
  kNone = 0,        // no INS, or no valid SAHRS to compare it with
  kAgree = 1,       // every difference within its threshold
  kSuspect = 2,     // one is not, or not clearly
  kMiscompare = 3,  // one has been over its threshold for too long
};

/// INS.MONITOR. Axes: along the heading, to its right, down; in level flight roll, pitch, heading.
struct InsMonitor {
  std::int64_t time_us = 0;
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();  // rad, INS - SAHRS
  Eigen::Vector3d threshold = Eigen::Vector3d::Zero();   // rad, of its absolute value
  Eigen::Vector3d time_over = Eigen::Vector3d::Zero();   // s
  InsState state = InsState::kNone;
};

enum class CalibrationState : std::int8_t {
  kIdle = 0,        // nothing to calibrate by yet, or switched off
  kRunning = 1,     // samples come in, not enough yet
  kObservable = 2,  // would be stored if the flight ended now
  kRefused = 3,     // the INS failed: nothing of this flight will be stored
};

/// SMDU.CALIBRATION.
struct SmduCalibration {
  using Vector = Eigen::Matrix<double, 12, 1>;
  std::int64_t time_us = 0;
  Vector x = Vector::Zero();      // bias (3) in nT, scale (3) and misalignment (6)
  Vector sigma = Vector::Zero();  // same units
  CalibrationState state = CalibrationState::kIdle;
};

}  // namespace lodestar::samples
