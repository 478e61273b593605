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

constexpr double kWeakestField = 1000.0;  // nT, horizontal

}  // namespace

std::optional<Eigen::Matrix3d> attitude_of(const MomentVectors& in, double max_imbalance) {
  const Eigen::Vector3d gravity_B =
      samples::kStandardGravity * in.n_B + in.omega_B.cross(in.v_air_B);
  const double size = gravity_B.norm();
  if (!(std::abs(size / in.gravity - 1.0) <= max_imbalance)) return std::nullopt;
  // Columns: down and magnetic east, in N and in B, and the third beside them.
  const auto axes = [](const Eigen::Vector3d& down, const Eigen::Vector3d& field) {
    Eigen::Matrix3d axes;
    axes.col(2) = down.normalized();
    axes.col(1) = down.cross(field).normalized();
    axes.col(0) = axes.col(1).cross(axes.col(2));
    return axes;
  };
  if (!(gravity_B.cross(in.b_B).norm() > kWeakestField * size)) return std::nullopt;
  if (!(in.b_N.head<2>().norm() > kWeakestField)) return std::nullopt;
  return Eigen::Matrix3d(axes(Eigen::Vector3d::UnitZ(), in.b_N) *
                         axes(gravity_B, in.b_B).transpose());
}

std::optional<Eigen::Matrix3d> SteadyAlignment::add(std::int64_t time_us, const MomentVectors& in,
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

std::optional<Eigen::Matrix3d> SteadyAlignment::solve(double duration, const MomentVectors& in,
                                                      double max_imbalance) const {
  const double n = count_;
  MomentVectors mean = in;
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
  const std::optional<Eigen::Matrix3d> middle = attitude_of(mean, max_imbalance);
  if (!middle) return std::nullopt;
  return *middle * math::exp_so3((0.5 * duration) * mean.omega_B);
}

}  // namespace lodestar::sahrs
