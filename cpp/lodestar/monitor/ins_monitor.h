// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "lodestar/monitor/attitude_history.h"
#include "lodestar/monitor/gyro_reference.h"
#include "lodestar/monitor/parameters.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"

namespace lodestar::monitor {

/// By how much the heading of SAHRS differed from that of an INS that was trusted.
struct TrustedHeading {
  std::int64_t time_us = 0;
  double error = 0.0;  // rad, INS - SAHRS
  double sigma = 0.0;  // rad, of the INS
};

/// Compares the attitude of the INS with that of SAHRS, while there are both.
///
/// The difference is the small rotation from one attitude to the other about level axes: along the
/// heading of SAHRS, to its right, down. In level flight these are roll, pitch and heading; unlike
/// differences of Euler angles they stay small at any pitch. An axis is over when its difference
/// exceeds what INS and SAHRS state of themselves, or departs from its own usual value by more than
/// the slow errors of SAHRS ever do; or when the INS departs from what the gyros of SAHRS make of
/// where it was half a minute ago, which what SAHRS corrects has no part in. An INS that repeats
/// itself bit by bit while the aircraft turns is frozen.
///
/// SAHRS learns nothing from here. After construction nothing allocates or throws.
class InsMonitor {
 public:
  /// `timeout` (s): silence after which there is no INS.
  InsMonitor(const InsMonitorParameters& parameters, double timeout);

  /// One frame, before the solutions that have come by then.
  void propagate(const samples::Attitude& sahrs);

  /// A solution of the last second up to the last frame, at its own time.
  void compare(const samples::InsSolution& ins);

  const samples::InsMonitor& state() const { return state_; }

  /// If the INS failed since the last call, having been trusted: the heading it had. It fails by a
  /// miscompare or by silence (which an invalid or a stuck one comes to).
  std::optional<TrustedHeading> take_failure();

 private:
  void restart();
  void stop();
  void set_difference(const samples::InsSolution& ins, const StatedAttitude& sahrs);
  void set_threshold(const Eigen::Vector3d& sigma, const Eigen::Vector3d& departure);
  void follow(const samples::InsSolution& ins, const StatedAttitude& sahrs, double dt);
  void time_axes(double dt);
  bool frozen(const samples::InsSolution& ins, const StatedAttitude& sahrs);
  void judge(bool frozen, double dt);
  void fail(const std::optional<TrustedHeading>& last);
  void remember(const samples::InsSolution& ins, const StatedAttitude& sahrs);
  void distrust();

  InsMonitorParameters parameters_;
  double timeout_;
  AttitudeHistory history_;
  std::int64_t now_us_ = 0;
  std::int16_t sahrs_resets_ = 0;

  std::int64_t heard_us_ = 0;     // frame of the last solution
  std::int64_t compared_us_ = 0;  // ... of the last one that could be compared
  samples::InsSolution last_ins_;
  Eigen::Quaterniond q_NB_of_change_ = Eigen::Quaterniond::Identity();  // SAHRS when it last moved
  bool compared_before_ = false;
  Eigen::Vector3d usual_ = Eigen::Vector3d::Zero();  // rad, slow mean of the difference
  GyroAttitude gyros_;
  GyroReference reference_;  // the INS of late
  double agreed_for_ = 0.0;  // s
  samples::InsMonitor state_;

  std::optional<TrustedHeading> trusted_;         // at the last solution
  std::optional<TrustedHeading> trusted_before_;  // at least doubt_time ago, if not empty
  std::optional<TrustedHeading> trusted_next_;    // becomes that one
  std::optional<TrustedHeading> failure_;
};

}  // namespace lodestar::monitor
