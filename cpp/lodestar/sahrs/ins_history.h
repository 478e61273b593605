// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "lodestar/math/rotation.h"
#include "lodestar/samples/samples.h"

namespace lodestar::sahrs::smdu {

/// The INS's attitude over the last second, and its latest solution.
class InsHistory {
 public:
  /// In order of time.
  void push(const samples::InsSolution& solution) {
    latest_ = solution;
    newest_ = (newest_ + 1) % kCapacity;
    ring_[newest_] = {solution.time_us, Eigen::Quaterniond(math::C_NB_from_euler(
                                            {solution.roll, solution.pitch, solution.heading}))};
    if (count_ < kCapacity) ++count_;
  }

  bool empty() const { return count_ == 0; }
  const samples::InsSolution& latest() const { return latest_; }

  /// C_NB at `time_us`, on the shortest way from one solution to the next. False, and `C_NB`
  /// unchanged, if no two solutions enclose that time, or they lie too far apart.
  bool attitude_at(std::int64_t time_us, Eigen::Matrix3d& C_NB) const {
    if (count_ == 0 || time_us > back(0).time_us) return false;
    std::size_t age = 0;
    while (back(age).time_us > time_us) {
      if (++age == count_) return false;
    }
    const Pose& before = back(age);
    if (before.time_us == time_us) {
      C_NB = before.q_NB.toRotationMatrix();
      return true;
    }
    const Pose& after = back(age - 1);
    const std::int64_t span = after.time_us - before.time_us;
    if (span > kLongestGap_us) return false;
    const double fraction =
        static_cast<double>(time_us - before.time_us) / static_cast<double>(span);
    const Eigen::Vector3d turn_B = math::log_quaternion(before.q_NB.conjugate() * after.q_NB);
    C_NB = (before.q_NB * math::exp_quaternion(fraction * turn_B)).toRotationMatrix();
    return true;
  }

 private:
  struct Pose {
    std::int64_t time_us = 0;
    Eigen::Quaterniond q_NB = Eigen::Quaterniond::Identity();
  };
  static constexpr std::size_t kCapacity = 64;             // 1 s at 50 Hz
  static constexpr std::int64_t kLongestGap_us = 200'000;  // 10 Hz and one lost

  const Pose& back(std::size_t age) const { return ring_[(newest_ + kCapacity - age) % kCapacity]; }

  samples::InsSolution latest_;
  std::array<Pose, kCapacity> ring_{};
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

}  // namespace lodestar::sahrs::smdu
