// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/alignment.h"

#include <algorithm>
#include <cmath>

#include "lodestar/math/scalar.h"
#include "lodestar/sahrs/pitch_measurement.h"
#include "lodestar/samples/samples.h"

namespace lodestar::sahrs {
namespace {

using math::seconds;

constexpr double kLongestStep = 0.5;      // s; after a longer silence everything starts anew
constexpr double kWeakestField = 1000.0;  // nT, horizontal
constexpr double kSteadyRate = 2.0 * math::kDegree;  // rad/s, about other axes than down
constexpr double kStraight = 0.15;                   // of gravity, centripetal acceleration
const Eigen::Vector3d kStraightSigma_B = math::kDegree * Eigen::Vector3d(2.0, 2.0, 10.0);
const Eigen::Vector3d kTurningSigma_B = math::kDegree * Eigen::Vector3d(5.0, 5.0, 20.0);

}  // namespace

void Alignment::VectorFilter::update(const Eigen::Vector3d& value, std::int64_t at_us) {
  const double dt = seconds(at_us - time_us);
  const bool goes_on = started && dt > 0.0 && dt <= kLongestStep;
  for (std::size_t i = 0; i < 3; ++i) {
    const double component = value(static_cast<Eigen::Index>(i));
    if (goes_on) {
      axes[i].update(component, dt);
    } else {
      axes[i].restart(component);
    }
  }
  latest = value;
  started = true;
  time_us = at_us;
}

Eigen::Vector3d Alignment::VectorFilter::value() const {
  return {axes[0].value(), axes[1].value(), axes[2].value()};
}

Eigen::Vector3d Alignment::VectorFilter::rate() const {
  return {axes[0].rate(), axes[1].rate(), axes[2].rate()};
}

void Alignment::restart() {
  turn_B_.started = false;
  gravity_B_.started = false;
  field_B_.started = false;
}

void Alignment::observe_rates(const Eigen::Vector3d& omega_B, std::int64_t time_us) {
  omega_B_ = omega_B;
  const double dt = turn_B_.started ? seconds(time_us - turn_B_.time_us) : 0.0;
  turn_B_.update(turn_B_.latest + dt * omega_B, time_us);
}

void Alignment::observe_field(const Eigen::Vector3d& b_B, std::int64_t time_us) {
  field_B_.update(b_B, time_us);
}

void Alignment::observe_load(const Eigen::Vector3d& n_B, const Eigen::Vector3d& v_air_B,
                             std::int64_t time_us) {
  v_air_B_ = v_air_B;
  gravity_B_.update(samples::kStandardGravity * n_B + omega_B_.cross(v_air_B), time_us);
}

double Alignment::field_rate(const Eigen::Vector3d& down_B) const {
  const Eigen::Vector3d across_B = field_B_.value().cross(down_B);
  return field_B_.rate().dot(across_B) / std::max(across_B.squaredNorm(), 1.0);
}

bool Alignment::straight(const AlignmentInput& in) const {
  const Eigen::Vector3d omega_B = turn_B_.rate();
  const Eigen::Vector3d down_B = gravity_B_.value().normalized();
  const Eigen::Vector3d other_B = omega_B - omega_B.dot(down_B) * down_B;
  const double centripetal = field_rate(down_B) * v_air_B_.norm();
  return other_B.norm() < kSteadyRate && std::abs(centripetal) < kStraight * in.gravity;
}

std::optional<Aligned> Alignment::solve(const AlignmentInput& in) const {
  if (!turn_B_.settled() || !gravity_B_.settled() || !field_B_.settled()) return std::nullopt;
  const bool averaged = straight(in);
  const Eigen::Vector3d b_B = averaged ? field_B_.value() : field_B_.latest;
  const Eigen::Vector3d observed_B = averaged ? gravity_B_.value() : gravity_B_.latest;
  const double max_bias = averaged ? in.max_gyro_bias : 0.0;

  Aligned aligned;
  aligned.averaged = averaged;
  aligned.sigma_B = averaged ? kStraightSigma_B : kTurningSigma_B;
  aligned.omega_B = averaged ? turn_B_.rate() : omega_B_;
  aligned.gyro_bias_B.setZero();
  Eigen::Vector3d down_B;
  // Down needs the bias and the bias needs down. kStraight is such that each turn leaves at most
  // half of the error, with a field that dips by 72 degrees.
  for (int iteration = 0; iteration < 4; ++iteration) {
    const Eigen::Vector3d gravity_B = observed_B - aligned.gyro_bias_B.cross(v_air_B_);
    const double size = gravity_B.norm();
    if (!(std::abs(size / in.gravity - 1.0) <= in.max_imbalance)) return std::nullopt;
    down_B = gravity_B / size;
    if (b_B.cross(down_B).norm() < kWeakestField) return std::nullopt;
    const double bias = turn_B_.rate().dot(down_B) - field_rate(down_B);
    aligned.gyro_bias_B = std::clamp(bias, -max_bias, max_bias) * down_B;
  }

  math::Euler& attitude = aligned.attitude;
  attitude.roll = std::atan2(down_B.y(), down_B.z());
  attitude.pitch = std::atan2(-down_B.x(), std::hypot(down_B.y(), down_B.z()));
  const Tilt tilt(math::C_NB_from_euler(attitude));
  const PitchInput air{v_air_B_, in.climb_rate, tilt};
  if (std::abs(air.climb_rate) > 0.9 * pitch_plane_airspeed(air)) return std::nullopt;
  attitude.pitch += pitch_measurement(air, 0.0, SlowNoise{0.0, 0.0}).innovation(0);
  const Eigen::Vector3d b_level = math::C_NB_from_euler(attitude) * b_B;  // heading still 0
  attitude.heading =
      math::wrap_2pi(std::atan2(in.b_N.y(), in.b_N.x()) - std::atan2(b_level.y(), b_level.x()));
  return aligned;
}

}  // namespace lodestar::sahrs
