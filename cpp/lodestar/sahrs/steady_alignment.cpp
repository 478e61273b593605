// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/steady_alignment.h"

#include <Eigen/Geometry>
#include <cmath>

#include "lodestar/samples/samples.h"

namespace lodestar::sahrs {
namespace {

constexpr double kDuration = 5.0;                         // s
constexpr double kRateSpread = 3.0 * math::kDegree;       // rad/s, of steady flight
constexpr double kLargestGyroBias = 1.0 * math::kDegree;  // rad/s, that rates may disagree by

}  // namespace

std::optional<Eigen::Matrix3d> SteadyAlignment::add(std::int64_t time_us, const AlignmentInput& in,
                                                    double max_imbalance) {
  if (count_ > 0 && (in.omega_B - first_omega_B_).cwiseAbs().maxCoeff() > kRateSpread) restart();
  if (count_ == 0) {
    *this = SteadyAlignment{};
    start_us_ = time_us;
    first_omega_B_ = in.omega_B;
  }
  const double t = 1e-6 * static_cast<double>(time_us - start_us_);
  ++count_;
  t_ += t;
  tt_ += t * t;
  omega_B_ += in.omega_B;
  n_B_ += in.n_B;
  v_air_B_ += in.v_air_B;
  b_B_ += in.b_B;
  tb_B_ += t * in.b_B;
  if (t < kDuration) return std::nullopt;
  const std::optional<Eigen::Matrix3d> C_NB = solve(t, in, max_imbalance);
  restart();
  return C_NB;
}

std::optional<Eigen::Matrix3d> SteadyAlignment::solve(double duration, const AlignmentInput& in,
                                                      double max_imbalance) const {
  const double n = count_;
  AlignmentInput mean = in;
  mean.n_B = n_B_ / n;
  mean.v_air_B = v_air_B_ / n;
  mean.b_B = b_B_ / n;
  const Eigen::Vector3d b_rate_B = (tb_B_ - (t_ / n) * b_B_) / (tt_ - t_ * t_ / n);
  Eigen::Vector3d down_B = mean.n_B.normalized();
  mean.omega_B.setZero();
  for (int i = 0; i < 10; ++i) {
    // b' = -omega x b with omega along down.
    const Eigen::Vector3d lever = down_B.cross(mean.b_B);
    if (!(lever.squaredNorm() > 0.0)) return std::nullopt;
    mean.omega_B = (-lever.dot(b_rate_B) / lever.squaredNorm()) * down_B;
    down_B = (samples::kStandardGravity * mean.n_B + mean.omega_B.cross(mean.v_air_B)).normalized();
  }
  if (!((omega_B_ / n - mean.omega_B).cwiseAbs().maxCoeff() < kLargestGyroBias)) {
    return std::nullopt;
  }
  const std::optional<math::Euler> middle = align(mean, max_imbalance);
  if (!middle) return std::nullopt;
  return math::C_NB_from_euler(*middle) * math::exp_so3((0.5 * duration) * mean.omega_B);
}

}  // namespace lodestar::sahrs
