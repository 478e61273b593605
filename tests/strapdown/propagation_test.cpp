// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/propagation.h"

#include <gtest/gtest.h>

#include <random>

#include "flight_points.h"

namespace lodestar::strapdown {
namespace {

Covariance numeric_transition(const FlightPoint& point, double dt) {
  const StateVector h = steps();
  Covariance Phi;
  for (int j = 0; j < kStates; ++j) {
    std::array<StateVector, 2> moved;
    Estimate nominal = point.x;
    move(nominal, point.omega_B, point.force_B, sweden(), dt);
    for (int side = 0; side < 2; ++side) {
      Estimate x = point.x;
      const StateVector error = StateVector::Unit(j) * (side == 0 ? h(j) : -h(j));
      x.correct(error);
      move(x, point.omega_B, point.force_B, sweden(), dt);
      moved[static_cast<std::size_t>(side)] = error_between(nominal, x);
    }
    Phi.col(j) = (moved[0] - moved[1]) / (2.0 * h(j));
  }
  return Phi;
}

Covariance transition_of(const FlightPoint& point, double dt) {
  Estimate x = point.x;
  const Step step = move(x, point.omega_B, point.force_B, sweden(), dt);
  Covariance Phi;
  for (int j = 0; j < kStates; ++j) {
    StateVector column = StateVector::Unit(j);
    propagate_error<kStates>(column, step, sweden(), ProcessNoise{});
    Phi.col(j) = column;
  }
  return Phi;
}

TEST(Propagation, TransitionMatchesCentralDifferences) {
  for (const FlightPoint& point : flight_points()) {
    // The transition is second order in dt: over a short frame what is left is below 1e-6.
    const double dt = 1e-3;
    const Covariance numeric = numeric_transition(point, dt);
    const Covariance analytic = transition_of(point, dt);
    for (int i = 0; i < kPadding.offset; ++i) {
      for (int j = 0; j < kPadding.offset; ++j) {
        const double scale = std::max(1.0, std::abs(numeric(i, j)));
        EXPECT_NEAR(analytic(i, j), numeric(i, j), 1e-6 * scale)
            << point.name << " row " << i << " column " << j;
      }
    }
  }
}

TEST(Propagation, CovarianceFollowsItsTransition) {
  const double dt = 1.0 / 60.0;
  for (const FlightPoint& point : flight_points()) {
    Estimate x = point.x;
    const Step step = move(x, point.omega_B, point.force_B, sweden(), dt);
    ProcessNoise noise;
    noise.field_drift_decay = 0.99;
    noise.gust_decay = 0.97;
    Covariance Phi;
    for (int j = 0; j < kStates; ++j) {
      StateVector column = StateVector::Unit(j);
      propagate_error<kStates>(column, step, sweden(), noise);
      Phi.col(j) = column;
    }
    const Covariance root = Covariance::Random();
    const Covariance full = root * root.transpose();
    Covariance P = full;
    propagate<kStates>(P, step, sweden(), noise);
    const Covariance expected = Phi * full * Phi.transpose();
    const Covariance got = P.selfadjointView<Eigen::Lower>();
    EXPECT_LT((got - expected).norm(), 1e-12 * expected.norm()) << point.name;
  }
}

using GroundMatrix = CovarianceOf<kGroundStates>;
using GroundVector = StateVectorOf<kGroundStates>;

Estimate over_ground(const FlightPoint& point) {
  Estimate x = point.x;
  x.lat = sweden().lat;
  x.lon = 0.3;
  x.wind_N << 8.0, -12.0;
  x.mean_wind_N = x.wind_N;  // else the attitude error turns what the air velocity goes back by
  x.height = 2500.0;
  return x;
}

constexpr double kWindReturn = 1e-2;  // in one frame: more than there ever is

/// Central differences of one frame of flight over the ground.
GroundMatrix numeric_ground_transition(const FlightPoint& point, double dt) {
  const GroundVector h = steps<kGroundStates>();
  const auto fly = [&](Estimate x) {
    const Step step = move(x, point.omega_B, point.force_B, sweden(), dt);
    move_over_ground(x, step.v_N, dt);
    x.return_wind(kWindReturn);
    return x;
  };
  const Estimate nominal = fly(over_ground(point));
  GroundMatrix Phi;
  for (int j = 0; j < kGroundStates; ++j) {
    const GroundVector error = GroundVector::Unit(j) * h(j);
    Estimate plus = over_ground(point), minus = over_ground(point);
    plus.correct(error);
    minus.correct<kGroundStates>(-error);
    Phi.col(j) = (error_between<kGroundStates>(nominal, fly(plus)) -
                  error_between<kGroundStates>(nominal, fly(minus))) /
                 (2.0 * h(j));
  }
  return Phi;
}

bool is_padding(int state) { return state == kPadding.offset || state >= kGroundPadding.offset; }

TEST(Propagation, OverTheGroundTheCovarianceFollowsCentralDifferences) {
  const double dt = 1e-3;  // what is left is second order in it
  const GroundVector scale = steps<kGroundStates>();
  for (const FlightPoint& point : flight_points()) {
    GroundMatrix Phi = numeric_ground_transition(point, dt);
    for (const math::Block pad : {kPadding, kGroundPadding}) {
      Phi.middleCols(pad.offset, pad.size).setZero();
    }
    const GroundMatrix root = scale.asDiagonal() * GroundMatrix::Random();
    GroundMatrix P = root * root.transpose();
    const GroundMatrix expected = Phi * P * Phi.transpose();
    Estimate x = over_ground(point);
    const Step step = move(x, point.omega_B, point.force_B, sweden(), dt);
    ProcessNoise noise;
    noise.wind_return = kWindReturn;
    propagate<kGroundStates>(P, step, sweden(), noise);
    const GroundMatrix got = P.selfadjointView<Eigen::Lower>();
    for (int i = 0; i < kGroundStates; ++i) {
      for (int j = 0; j < kGroundStates; ++j) {
        if (is_padding(i) || is_padding(j)) continue;
        EXPECT_NEAR(got(i, j), expected(i, j), 1e-5 * scale(i) * scale(j) * kGroundStates)
            << point.name << " row " << i << " column " << j;
      }
    }
  }
}

TEST(Propagation, WindAndAirVelocityOverTheSameGroundStayKnownTogetherOnly) {
  for (const FlightPoint& point : flight_points()) {
    GroundVector apart = GroundVector::Zero();  // 3 and 4 m/s more wind, and less air velocity
    part<2>(apart, kWind) << 3.0, 4.0;
    apart.segment<2>(kVelocity.offset) << -3.0, -4.0;
    GroundMatrix P = apart * apart.transpose();
    Estimate x = over_ground(point);
    const Step step = move(x, point.omega_B, point.force_B, sweden(), 1.0 / 60.0);
    propagate<kGroundStates>(P, step, sweden(), ProcessNoise{});
    const GroundMatrix got = P.selfadjointView<Eigen::Lower>();
    // Of second order in the frame is what the climb has of it.
    EXPECT_LT((got - apart * apart.transpose()).norm(), 2e-6) << point.name;
  }
}

TEST(Propagation, AChangeOfWindIsNoneOfGroundVelocity) {
  Step step;
  step.dt = 0.01;
  ProcessNoise noise;
  noise.wind = 4.0;
  noise.mean_wind = 3.0;
  GroundMatrix P = GroundMatrix::Zero();
  propagate<kGroundStates>(P, step, Place{}, noise);
  for (int axis = 0; axis < 2; ++axis) {
    const int v = kVelocity.offset + axis, w = kWind.offset + axis;
    EXPECT_NEAR(P(w, w), 0.04, 1e-15);
    EXPECT_NEAR(P(v, v) + 2.0 * P(w, v) + P(w, w), 0.0, 1e-15);
    // The mean goes along with its part of the wind's change and has no other.
    const int m = kMeanWind.offset + axis;
    EXPECT_NEAR(P(m, m), 0.03, 1e-15);
    EXPECT_NEAR(P(m, w), 0.03, 1e-15);
    EXPECT_NEAR(P(m, v), -0.03, 1e-15);
  }
}

TEST(Propagation, WindReturnsToItsMeanAndGroundVelocityDoesNotKnow) {
  Estimate x;
  x.air_velocity_N << 100.0, 50.0, -3.0;
  x.wind_N << 8.0, -12.0;
  x.mean_wind_N << 5.0, -9.0;
  const Eigen::Vector3d v_N = x.v_N();
  x.return_wind(0.25);
  EXPECT_LT((x.wind_N - Eigen::Vector2d(7.25, -11.25)).norm(), 1e-12);
  EXPECT_LT((x.v_N() - v_N).norm(), 1e-12);
}

TEST(Propagation, NoiseOfGyrosDrivesAttitudeAndVelocityTogether) {
  Step step;
  step.dt = 0.01;
  step.air_velocity_N << 180.0, 20.0, -5.0;
  ProcessNoise noise;
  noise.gyro = 1e-8;
  Covariance P = Covariance::Zero();
  propagate<kStates>(P, step, sweden(), noise);
  // What turns the attitude by e turns the true velocity with it: dv = v x e.
  const Eigen::Matrix3d coupled = P.block<3, 3>(kVelocity.offset, kAttitude.offset);
  EXPECT_LT((coupled - math::skew(step.air_velocity_N) * 1e-10).norm(), 1e-20);
}

TEST(Propagation, LevelFlightStaysLevelOverTheRotatingEarth) {
  // Steady level flight: the load factor carries the weight and turns the velocity with the Earth.
  Estimate x;
  x.air_velocity_N << 200.0, 0.0, 0.0;
  const Place place = sweden();
  const Eigen::Vector3d coriolis =
      (2.0 * place.earth_rate_N + place.transport_rate_N).cross(x.air_velocity_N);
  const Eigen::Vector3d force = coriolis - Eigen::Vector3d(0.0, 0.0, place.gravity);
  const Eigen::Vector3d rate = place.earth_rate_N + place.transport_rate_N;
  for (int i = 0; i < 600; ++i) move(x, rate, force, place, 0.1);
  EXPECT_LT(math::log_quaternion(x.q_NB).norm(), 1e-12);
  EXPECT_LT((x.air_velocity_N - Eigen::Vector3d(200.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_NEAR(x.height, 0.0, 1e-9);
}

TEST(Propagation, TheBaroFollowsAClimbBehindItsLag) {
  Estimate x;
  x.air_velocity_N << 100.0, 0.0, -10.0;
  Place place;
  place.baro_lag = 0.3;
  place.gravity = 0.0;
  for (int i = 0; i < 600; ++i)
    move(x, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), place, 0.01);
  EXPECT_NEAR(x.height, 60.0, 1e-9);
  EXPECT_NEAR(x.height - x.baro_height, 3.0, 3e-4);  // lag times climb, to (dt / lag)^2 / 12 of it
}

TEST(Propagation, NeglectedClimbIsThatOfTheRotationsSecondOrder) {
  const Eigen::Vector3d v(150.0, 120.0, 0.0);
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (const double rho : {0.0, 0.7, 1.0}) {  // of bank and heading
    Covariance P = Covariance::Zero();
    double square = 0.0;
    constexpr int kDraws = 20000;
    for (int i = 0; i < kDraws; ++i) {
      const double heading = normal(generator);
      const double bank = rho * heading + std::sqrt(1.0 - rho * rho) * normal(generator);
      const Eigen::Vector3d phi =
          0.002 * bank * v.normalized() + Eigen::Vector3d(0.0, 0.0, 0.02 * heading);
      P.topLeftCorner<3, 3>() += phi * phi.transpose() / kDraws;
      const Eigen::Vector3d left_out = math::exp_so3(phi) * v - v - phi.cross(v);
      square += left_out.z() * left_out.z() / kDraws;
    }
    const double lasting = neglected_climb<kStates>(P, v) / (2.0 * 60.0);
    EXPECT_GT(lasting, 0.6 * square) << rho;
    EXPECT_LT(lasting, 2.2 * square) << rho;
  }
}

TEST(Propagation, TheClimbStaysOfUseHoweverPoorlyAttitudeIsKnown) {
  Covariance P = Covariance::Zero();
  P.topLeftCorner<3, 3>().setIdentity();
  EXPECT_DOUBLE_EQ(neglected_climb<kStates>(P, {200.0, 0.0, 0.0}), 0.25);
}

TEST(Propagation, AttitudeStaysARotationForADay) {
  Estimate x;
  const Place place = sweden();
  for (int i = 0; i < 24 * 3600; ++i) {
    move(x, Eigen::Vector3d(0.3, -0.2, 0.5), Eigen::Vector3d::Zero(), place, 1.0);
  }
  EXPECT_LT((x.C_NB * x.C_NB.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

}  // namespace
}  // namespace lodestar::strapdown
