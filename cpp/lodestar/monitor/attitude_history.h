// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "lodestar/math/rotation.h"
#include "lodestar/samples/outputs.h"

namespace lodestar::monitor {

/// What SAHRS said at one time.
struct StatedAttitude {
  std::int64_t time_us = 0;
  Eigen::Quaterniond q_NB = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d P_B = Eigen::Matrix3d::Zero();             // rad^2, small rotation in B
  Eigen::Quaterniond q_GB = Eigen::Quaterniond::Identity();  // by its gyros alone, since some time
};

/// The last second of SAHRS, one entry per frame at up to 1000 Hz: a late solution is compared with
/// the attitude of its own time.
class AttitudeHistory {
 public:
  static constexpr std::size_t kCapacity = 1024;

  void clear() { count_ = 0; }

  void push(const samples::Attitude& sahrs, const Eigen::Quaterniond& q_GB) {
    newest_ = (newest_ + 1) % kCapacity;
    ring_[newest_] = {sahrs.time_us, sahrs.q_NB, sahrs.P_B, q_GB};
    if (count_ < kCapacity) ++count_;
  }

  /// The attitude at `time_us`, between two frames on the shortest way, with the covariance of the
  /// later. Nothing if that is newer than the newest or older than the oldest.
  std::optional<StatedAttitude> at(std::int64_t time_us) const {
    if (count_ == 0 || time_us > back(0).time_us) return std::nullopt;
    std::size_t age = 0;
    while (age < count_ && back(age).time_us > time_us) ++age;
    if (age == count_) return std::nullopt;
    const StatedAttitude& before = back(age);
    if (before.time_us == time_us) return before;
    return between(before, back(age - 1), time_us);
  }

 private:
  const StatedAttitude& back(std::size_t age) const {
    return ring_[(newest_ + kCapacity - age) % kCapacity];
  }

  static StatedAttitude between(const StatedAttitude& a, const StatedAttitude& b,
                                std::int64_t time_us) {
    const double fraction =
        static_cast<double>(time_us - a.time_us) / static_cast<double>(b.time_us - a.time_us);
    return {time_us, between(a.q_NB, b.q_NB, fraction), b.P_B, between(a.q_GB, b.q_GB, fraction)};
  }

  static Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b,
                                    double fraction) {
    return a * math::exp_quaternion(fraction * math::log_quaternion(a.conjugate() * b));
  }

  std::array<StatedAttitude, kCapacity> ring_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace lodestar::monitor
