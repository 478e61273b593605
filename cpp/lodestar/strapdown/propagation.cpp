// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/propagation.h"

#include <array>
#include <cmath>
#include <utility>

#include "lodestar/earth/wgs84.h"
#include "lodestar/strapdown/sparse_update.h"

namespace lodestar::strapdown {
namespace {

constexpr int kMoving = kMotion.size;
constexpr int kDriving = math::end(kGyroBias);  // the motion depends on the states before this
static_assert(kMotion.offset == 0);
static_assert(kVelocity.offset == 3 && kHeight.offset == 6 && kBaroHeight.offset == 7);

double baro_decay(double dt, double lag) { return lag > 0.0 ? std::exp(-dt / lag) : 0.0; }

/// Phi over one frame, as it acts on the motion states.
class Transition {
 public:
  Transition(const Step& step, const Place& place)
      : step_(step),
        turn_(Eigen::Matrix3d::Identity() -
              step.dt * math::skew(place.earth_rate_N + place.transport_rate_N)),
        velocity_cross_(math::skew(step.air_velocity_N)),
        tilt_(step.dt * (math::skew(Eigen::Vector3d(0.0, 0.0, place.gravity)) +
                         velocity_cross_ * math::skew(place.earth_rate_N))),
        coriolis_(Eigen::Matrix3d::Identity() -
                  step.dt * math::skew(2.0 * place.earth_rate_N + place.transport_rate_N)),
        decay_(baro_decay(step.dt, place.baro_lag)) {}

  /// Columns of Y are states, as far as the motion depends on them: the motion columns of Y Phi'.
  template <int Rows>
  Eigen::Matrix<double, Rows, kMoving> apply(const Eigen::Matrix<double, Rows, kDriving>& Y) const {
    using Columns = Eigen::Matrix<double, Rows, 3>;
    using Column = Eigen::Matrix<double, Rows, 1>;
    const double dt = step_.dt;
    Columns rate_error = Y.template middleCols<3>(kGyroBias.offset);
    for (int j = 0; j < 3; ++j) {
      rate_error += step_.omega_B(j) * Y.template middleCols<3>(kGyroMatrix.offset + 3 * j);
    }
    const Eigen::Matrix3d Ct = -dt * step_.C_NB.transpose();
    const Columns turned = rate_error.lazyProduct(Ct);
    const auto phi = Y.template middleCols<3>(kAttitude.offset);
    const auto velocity = Y.template middleCols<3>(kVelocity.offset);
    const Columns phi_middle = phi + 0.5 * turned;

    Eigen::Matrix<double, Rows, kMoving> out;
    out.template middleCols<3>(kAttitude.offset) = phi.lazyProduct(turn_.transpose()) + turned;
    auto velocity_out = out.template middleCols<3>(kVelocity.offset);
    velocity_out = velocity.lazyProduct(coriolis_.transpose()) +
                   phi_middle.lazyProduct(tilt_.transpose()) +
                   turned.lazyProduct(velocity_cross_.transpose()) +
                   Y.template middleCols<3>(kForceBias.offset).lazyProduct(Ct);
    const Column height = Y.col(kHeight.offset);
    const Column climbed = phi_middle.lazyProduct((dt * velocity_cross_.row(2)).transpose()) -
                           (0.5 * dt) * (velocity.col(2) + velocity_out.col(2));
    out.col(kHeight.offset) = height + climbed;
    out.col(kBaroHeight.offset) =
        decay_ * Y.col(kBaroHeight.offset) + (1.0 - decay_) * (height + 0.5 * climbed);
    return out;
  }

 private:
  const Step& step_;
  Eigen::Matrix3d turn_;
  Eigen::Matrix3d velocity_cross_;
  Eigen::Matrix3d tilt_;
  Eigen::Matrix3d coriolis_;
  double decay_;
};

template <int N>
void decay(CovarianceOf<N>& P, math::Block block, double factor) {
  if (factor == 1.0) return;
  for (int i = block.offset; i < math::end(block); ++i) {
    P.col(i).tail(N - i) *= factor;
    P.row(i).head(i + 1) *= factor;
  }
}

/// Turns the errors from `offset` on by R: P <- T P T'.
template <int Width, int N>
void turn(CovarianceOf<N>& P, int offset, const Eigen::Matrix<double, Width, Width>& R) {
  Eigen::Matrix<double, N, Width> columns = symmetric_columns<Width>(P, offset);
  columns = (columns * R.transpose()).eval();
  columns.template middleRows<Width>(offset) =
      (R * columns.template middleRows<Width>(offset)).eval();
  for (int j = 0; j < Width; ++j) {
    const int c = offset + j;
    P.col(c).tail(N - c) = columns.col(j).tail(N - c);
    P.row(c).head(c) = columns.col(j).head(c).transpose();
  }
}

template <int N>
void add_noise(CovarianceOf<N>& P, const Step& step, const ProcessNoise& noise) {
  const double dt = step.dt;
  const Eigen::Matrix3d velocity_cross = math::skew(step.air_velocity_N);
  const Eigen::Matrix3d coupled = (noise.gyro * dt) * velocity_cross;
  auto diagonal = P.diagonal();
  part<3>(diagonal, kAttitude).array() += noise.gyro * dt;
  P.template block<3, 3>(kVelocity.offset, kAttitude.offset) += coupled;
  P.template block<3, 3>(kVelocity.offset, kVelocity.offset) +=
      coupled * velocity_cross.transpose();
  part<3>(diagonal, kVelocity) +=
      dt * Eigen::Vector3d(noise.force + noise.wind, noise.force + noise.wind,
                           noise.force + noise.vertical_wind);
  diagonal(kHeight.offset) += noise.height * dt;
  part<3>(diagonal, kGyroBias).array() += noise.gyro_bias * dt;
  part<3>(diagonal, kFieldDrift).array() += noise.field_drift_variance;
  part<3>(diagonal, kGust) += noise.gust_variance;
  if constexpr (kOverGround<N>) {
    for (int axis = 0; axis < 2; ++axis) {
      const int v = kVelocity.offset + axis, w = kWind.offset + axis, m = kMeanWind.offset + axis;
      P(w, v) -= dt * noise.wind;
      P(m, v) -= dt * noise.mean_wind;
      P(m, w) += dt * noise.mean_wind;
    }
    part<2>(diagonal, kWind).array() += dt * noise.wind;
    part<2>(diagonal, kMeanWind).array() += dt * noise.mean_wind;
    part<3>(diagonal, kGpsError).array() += noise.gps_error_variance;
    diagonal(kBaroBias.offset) += noise.baro_bias_variance;
  }
}

/// P <- A P A' with A = I + share (wind towards its mean, air velocity the other way).
void return_wind(CovarianceOf<kGroundStates>& P, double share) {
  constexpr int kN = kGroundStates;
  const Eigen::Matrix<double, kN, 2> apart =
      symmetric_columns<2>(P, kMeanWind.offset) - symmetric_columns<2>(P, kWind.offset);
  const Eigen::Matrix2d variance =
      apart.middleRows<2>(kMeanWind.offset) - apart.middleRows<2>(kWind.offset);
  const std::array<std::pair<int, double>, 2> moved = {
      {{kVelocity.offset, -share}, {kWind.offset, share}}};
  for (const auto& [from, part] : moved) {
    for (int axis = 0; axis < 2; ++axis) {
      const int r = from + axis;
      P.row(r).head(r + 1) += part * apart.col(axis).head(r + 1).transpose();
      P.col(r).tail(kN - r) += part * apart.col(axis).tail(kN - r);
    }
    for (const auto& [to, other] : moved) {
      if (to >= from) P.block<2, 2>(to, from) += part * other * variance;
    }
  }
}

/// P <- A P A' with A = I + D, where D has rows only from `offset` on: `moved` is P D', `twice` the
/// corner of D P D'.
template <int Rows>
void add_rows(CovarianceOf<kGroundStates>& P, int offset,
              const Eigen::Matrix<double, kGroundStates, Rows>& moved,
              const Eigen::Matrix<double, Rows, Rows>& twice) {
  const Eigen::Matrix<double, Rows, Rows> corner = moved.template middleRows<Rows>(offset);
  const int after = kGroundStates - offset - Rows;
  for (int j = 0; j < Rows; ++j) {
    P.row(offset + j).head(offset) += moved.col(j).head(offset).transpose();
    P.col(offset + j).tail(after) += moved.col(j).tail(after);
  }
  P.block<Rows, Rows>(offset, offset) += corner + corner.transpose() + twice;
}

/// The Coriolis acceleration is that of the ground velocity, wind included: without it filters that
/// fly long without air data take it for news of the wind.
void turn_wind(CovarianceOf<kGroundStates>& P, const Step& step, const Place& place) {
  const Eigen::Matrix<double, 3, 2> by_wind =
      -step.dt * math::skew(2.0 * place.earth_rate_N + place.transport_rate_N).leftCols<2>();
  const Eigen::Matrix<double, kGroundStates, 3> moved =
      symmetric_columns<2>(P, kWind.offset).lazyProduct(by_wind.transpose());
  const Eigen::Matrix3d twice = by_wind * moved.middleRows<2>(kWind.offset);
  add_rows<3>(P, kVelocity.offset, moved, twice);
}

/// How the east error grows with the position error, (m/s)/m: meridians converge.
Eigen::Vector2d curvature(const Step& step, const Place& place) {
  const double tangent = std::tan(place.lat) / earth::kSemiMajorAxis;
  return {tangent * step.v_N.y(), -tangent * step.v_N.x()};
}

/// P <- A P A' with A = I + dt (rows of the position by velocity, attitude, wind and position).
void move_position(CovarianceOf<kGroundStates>& P, const Step& step, const Place& place) {
  constexpr int kN = kGroundStates;
  using Columns = Eigen::Matrix<double, kN, 2>;
  const Eigen::Matrix<double, 2, 3> by_attitude =
      -step.dt * math::skew(step.air_velocity_N).topRows<2>();
  const Columns position = symmetric_columns<2>(P, kPosition.offset);
  Columns moved = P.middleCols<3>(kAttitude.offset).lazyProduct(by_attitude.transpose());
  moved += step.dt * symmetric_columns<2>(P, kVelocity.offset);
  moved += step.dt * symmetric_columns<2>(P, kWind.offset);
  moved.col(1) += position * (step.dt * curvature(step, place));
  Eigen::Matrix2d twice =
      by_attitude * moved.middleRows<3>(kAttitude.offset) +
      step.dt * (moved.middleRows<2>(kVelocity.offset) + moved.middleRows<2>(kWind.offset));
  twice.row(1) +=
      step.dt * curvature(step, place).transpose() * moved.middleRows<2>(kPosition.offset);
  add_rows<2>(P, kPosition.offset, moved, twice);
}

}  // namespace

Step move(Estimate& x, const Eigen::Vector3d& omega_B, const Eigen::Vector3d& force_B,
          const Place& place, double dt) {
  const Eigen::Matrix3d C_before = x.C_NB;
  const Eigen::Vector3d v_before = x.air_velocity_N;
  const Eigen::Vector3d omega_IB_B = omega_B - x.gyro_matrix * omega_B - x.gyro_bias_B;
  const Eigen::Vector3d omega_IN_N = place.earth_rate_N + place.transport_rate_N;
  x.q_NB = (math::exp_quaternion(-dt * omega_IN_N) * x.q_NB * math::exp_quaternion(dt * omega_IB_B))
               .normalized();
  x.C_NB = x.q_NB.toRotationMatrix();

  Step step;
  step.dt = dt;
  step.omega_B = omega_B;
  step.C_NB = 0.5 * (C_before + x.C_NB);
  const Eigen::Vector3d coriolis_rate = 2.0 * place.earth_rate_N + place.transport_rate_N;
  const Eigen::Vector3d acceleration_N = step.C_NB * (force_B - x.force_bias_B) +
                                         Eigen::Vector3d(0.0, 0.0, place.gravity) -
                                         coriolis_rate.cross(x.v_N());
  x.air_velocity_N += dt * acceleration_N;
  step.air_velocity_N = 0.5 * (v_before + x.air_velocity_N);
  step.v_N = step.air_velocity_N + x.v_N() - x.air_velocity_N;

  const double climbed = -dt * step.air_velocity_N.z();
  const double a = baro_decay(dt, place.baro_lag);
  x.baro_height = a * x.baro_height + (1.0 - a) * (x.height + 0.5 * climbed);
  x.height += climbed;
  return step;
}

template <int N>
void propagate(CovarianceOf<N>& P, const Step& step, const Place& place,
               const ProcessNoise& noise) {
  const Transition transition(step, place);
  const Eigen::Matrix<double, N, kMoving> columns =
      transition.apply<N>(symmetric_columns<kDriving>(P, 0));
  const Eigen::Matrix<double, kMoving, kDriving> rows =
      columns.template topRows<kDriving>().transpose();
  P.template leftCols<kMoving>() = columns;
  P.template topLeftCorner<kMoving, kMoving>() = transition.apply<kMoving>(rows).transpose();
  decay<N>(P, kFieldDrift, noise.field_drift_decay);
  decay<N>(P, kGust, noise.gust_decay);
  if constexpr (kOverGround<N>) {
    turn_wind(P, step, place);
    move_position(P, step, place);
    if (noise.wind_return > 0.0) return_wind(P, noise.wind_return);
    decay<N>(P, kGpsError, noise.gps_error_decay);
    decay<N>(P, kBaroBias, noise.baro_bias_decay);
  }
  add_noise<N>(P, step, noise);
}

template <int N>
void propagate_error(StateVectorOf<N>& x, const Step& step, const Place& place,
                     const ProcessNoise& noise) {
  const Eigen::Matrix<double, 1, kDriving> row = x.template head<kDriving>().transpose();
  x.template head<kMoving>() = Transition(step, place).apply<1>(row).transpose();
  part<3>(x, kFieldDrift) *= noise.field_drift_decay;
  part<3>(x, kGust) *= noise.gust_decay;
}

Eigen::Vector2d move_over_ground(Estimate& x, const Eigen::Vector3d& v_N, double dt) {
  const Eigen::Vector2d moved = dt * v_N.head<2>();
  x.displace(moved);
  return moved;
}

template <int N>
void turn_errors(CovarianceOf<N>& P, const Eigen::Vector3d& phi_N, const Eigen::Matrix3d& C_NB) {
  const Eigen::Matrix3d R_N = math::exp_so3(phi_N);
  const Eigen::Matrix3d R_B = C_NB.transpose() * R_N.transpose() * C_NB;
  for (const math::Block block : {kForceBias, kGyroBias, kFieldDrift, kFieldBias}) {
    turn<3>(P, block.offset, R_B);
  }
}

template void propagate<kStates>(CovarianceOf<kStates>&, const Step&, const Place&,
                                 const ProcessNoise&);
template void propagate<kGroundStates>(CovarianceOf<kGroundStates>&, const Step&, const Place&,
                                       const ProcessNoise&);
template void propagate_error<kStates>(StateVectorOf<kStates>&, const Step&, const Place&,
                                       const ProcessNoise&);
template void propagate_error<kGroundStates>(StateVectorOf<kGroundStates>&, const Step&,
                                             const Place&, const ProcessNoise&);
template void turn_errors<kStates>(CovarianceOf<kStates>&, const Eigen::Vector3d&,
                                   const Eigen::Matrix3d&);
template void turn_errors<kGroundStates>(CovarianceOf<kGroundStates>&, const Eigen::Vector3d&,
                                         const Eigen::Matrix3d&);

}  // namespace lodestar::strapdown
