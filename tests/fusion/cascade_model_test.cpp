// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/cascade_model.h"

#include <gtest/gtest.h>

#include <random>

namespace lodestar::fusion {
namespace {

using math::kDegree;

constexpr AttitudeError kEuler = AttitudeError::kEuler;
constexpr int kNorth = kPositionError.offset;
constexpr int kEast = kPositionError.offset + 1;

TrackPoint point_of(const math::Euler& attitude, const Eigen::Vector3d& v_air_B,
                    double lat = 57.0 * kDegree) {
  TrackPoint point;
  point.lat = lat;
  point.h = 3000.0;
  point.attitude = attitude;
  point.v_air_B = v_air_B;
  point.v_air_N = math::C_NB_from_euler(attitude) * v_air_B;
  point.rates = earth::position_rates(lat, point.h, point.v_air_N).head<2>();
  return point;
}

StateVector state(math::Block block, double value, int element = 0) {
  StateVector x = StateVector::Zero();
  x(block.offset + element) = value;
  return x;
}

// Hand cases: which way does the true position leave the computed one?

TEST(CascadeModel, WindMovesThePositionAsItBlows) {
  const TrackPoint point = point_of({0.0, 0.0, 1.0}, {200.0, 0.0, 0.0});
  EXPECT_LT(
      (position_error_rate(kEuler, point, state(kWind, 6.0, 0)) - Eigen::Vector2d(6.0, 0.0)).norm(),
      1e-12);
  EXPECT_LT(
      (position_error_rate(kEuler, point, state(kWind, 7.0, 1)) - Eigen::Vector2d(0.0, 7.0)).norm(),
      1e-12);
}

TEST(CascadeModel, TrueHeadingRightOfSahrsMovesThePositionRight) {
  const StateVector x = state(kHeadingError, 0.01);
  const Eigen::Vector2d north = position_error_rate(kEuler, point_of({}, {200.0, 0.0, 0.0}), x);
  EXPECT_NEAR(north.y(), 2.0, 1e-3);  // flying north: to the east
  const Eigen::Vector2d east =
      position_error_rate(kEuler, point_of({0.0, 0.0, 90.0 * kDegree}, {200.0, 0.0, 0.0}), x);
  EXPECT_NEAR(east.x(), -2.0, 1e-3);  // flying east: to the south
}

TEST(CascadeModel, TruePitchAboveSahrsSlowsAClimbOverTheGround) {
  const TrackPoint climbing = point_of({0.0, 0.3, 0.0}, {200.0, 0.0, 0.0});
  const Eigen::Vector2d rate = position_error_rate(kEuler, climbing, state(kPitchError, 0.001));
  EXPECT_NEAR(rate.x(), -200.0 * std::sin(0.3) * 0.001, 1e-4);
}

TEST(CascadeModel, TrueRollRightOfSahrsTurnsTheAngleOfAttackLeft) {
  // With w > 0 the air velocity lies below the nose; rolling right swings it left.
  const TrackPoint point = point_of({}, {200.0, 0.0, 20.0});
  const Eigen::Vector2d rate = position_error_rate(kEuler, point, state(kRollError, 0.01));
  EXPECT_NEAR(rate.y(), -20.0 * 0.01, 1e-4);
}

TEST(CascadeModel, APositionErrorNorthMeansShorterParallels) {
  // Flying east on the northern half: north of where we think, so further east than we think.
  const TrackPoint point = point_of({0.0, 0.0, 90.0 * kDegree}, {200.0, 0.0, 0.0}, 60.0 * kDegree);
  EXPECT_GT(position_error_rate(kEuler, point, state(kPositionError, 1000.0)).y(), 0.0);
}

TEST(CascadeModel, GpsErrorIsMeasuredMinusTrue) {
  StateVector x = state(kPositionError, 30.0);  // true position 30 m north of the computed
  x(kGpsError.offset) = 4.0;                    // GPS 4 m north of the true
  EXPECT_EQ((position_measurement() * x)(0), 34.0);
  EXPECT_EQ((position_measurement() * x)(1), 0.0);
}

// The position rows against geodesy alone: two positions dead-reckoned side by side.
TEST(CascadeModel, PositionErrorRateIsThatOfTwoTracksOnTheEllipsoid) {
  const TrackPoint point = point_of({0.1, 0.05, 2.0}, {190.0, 3.0, 12.0});
  StateVector x = StateVector::Zero();
  x.segment<2>(kPositionError.offset) << 150.0, -120.0;
  x.segment<2>(kWind.offset) << 6.0, -7.0;
  x(kHeadingError.offset) = 0.02;
  x(kPitchError.offset) = -0.004;
  x(kRollError.offset) = 0.006;
  Eigen::Vector3d v_true_N =
      math::C_NB_from_euler(corrected_attitude(kEuler, point, x)) * point.v_air_B;
  v_true_N.head<2>() += x.segment<2>(kWind.offset);
  v_true_N.z() = 0.0;

  constexpr double kStep = 0.5;  // s
  const auto moved = [](earth::Geodetic from, const Eigen::Vector3d& v_N, double dt) {
    const Eigen::Vector3d rates = earth::position_rates(from.lat, from.h, v_N);
    return earth::Geodetic{from.lat + rates.x() * dt, from.lon + rates.y() * dt, from.h};
  };
  const Eigen::Vector2d error = x.segment<2>(kPositionError.offset);
  const earth::Geodetic computed = point.position();
  const earth::Geodetic truth = earth::displaced(computed, {error.x(), error.y(), 0.0});
  Eigen::Vector3d v_air_N = point.v_air_N;
  v_air_N.z() = 0.0;
  const auto error_at = [&](double dt) {
    return earth::displacement_N(moved(computed, v_air_N, dt), moved(truth, v_true_N, dt));
  };
  const Eigen::Vector3d rate = (error_at(kStep) - error_at(-kStep)) / (2.0 * kStep);
  // The convergence term has the computed velocity, not the true one: 10 m/s of wind and 200 m of
  // error leave 10 * 200 tan(lat) / r = 5e-4 m/s.
  EXPECT_LT((rate.head<2>() - position_error_rate(kEuler, point, x)).norm(), 5e-4);
}

/// Central differences of the position rows.
PositionMatrix numeric_position_rows(AttitudeError form, const TrackPoint& point,
                                     const StateVector& x) {
  PositionMatrix J;
  for (int i = 0; i < kStates; ++i) {
    const double step = i < kHeadingError.offset ? 1e-2 : 1e-5;
    StateVector up = x;
    StateVector down = x;
    up(i) += step;
    down(i) -= step;
    J.col(i) = (position_error_rate(form, point, up) - position_error_rate(form, point, down)) /
               (2.0 * step);
  }
  return J;
}

class CascadeJacobians : public testing::TestWithParam<math::Euler> {};

TEST_P(CascadeJacobians, AgreeWithCentralDifferences) {
  CascadeParameters parameters;
  const TrackPoint point = point_of(GetParam(), {198.0, -4.0, 15.0});
  for (const AttitudeError form : {AttitudeError::kEuler, AttitudeError::kSmallAngle}) {
    parameters.attitude_error = form;
    for (const double size : {0.0, 1e-4, 1.0}) {
      StateVector x;
      x << 120.0, -80.0, 3.0, 4.0, 6.0, 7.0, 0.03, -0.01, 0.02, 0.015, -0.04;
      x *= size;
      const ErrorDynamics model = error_dynamics(parameters, point, x);
      const PositionMatrix numeric = numeric_position_rows(form, point, x);
      const PositionMatrix rows = model.F.topRows<2>();
      // Relative to each column's scale: metres per second and radian reach 200.
      for (int i = 0; i < kStates; ++i) {
        const double scale = std::max(1.0, rows.col(i).norm());
        EXPECT_LT((rows.col(i) - numeric.col(i)).norm(), 1e-6 * scale) << "state " << i;
      }
      PositionMatrix velocity = velocity_by_states(form, point, x);
      EXPECT_LT((velocity - rows).rightCols<7>().norm(), 1e-9);
    }
  }
}

TEST_P(CascadeJacobians, AirDataColumnsAgreeWithCentralDifferences) {
  samples::AirData air;
  air.true_airspeed = 200.0;
  air.alpha = 0.08;
  air.beta = -0.03;
  const TrackPoint point = point_of(GetParam(), air_velocity_B(air));
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(GetParam());
  const ErrorDynamics model = error_dynamics({}, point, StateVector::Zero());
  const auto difference = [&](double samples::AirData::* member, double step) {
    samples::AirData up = air;
    samples::AirData down = air;
    up.*member += step;
    down.*member -= step;
    const Eigen::Vector3d v_N = C_NB * (air_velocity_B(up) - air_velocity_B(down));
    return Eigen::Vector2d(v_N.head<2>() / (2.0 * step));
  };
  const auto column = [&](int i) {
    return Eigen::Vector2d(model.G.block<2, 1>(kNorth, kAirDataNoise.offset + i));
  };
  EXPECT_LT((column(0) - difference(&samples::AirData::alpha, 1e-5)).norm(), 2e-4 * 1e-2);
  EXPECT_LT((column(1) - difference(&samples::AirData::beta, 1e-5)).norm(), 2e-4 * 1e-2);
  EXPECT_LT((column(2) - difference(&samples::AirData::true_airspeed, 1e-2)).norm(), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Attitudes, CascadeJacobians,
                         testing::Values(math::Euler{0.0, 0.0, 0.0}, math::Euler{0.8, 0.1, 2.5},
                                         math::Euler{-1e-7, 1e-7, 6.28},
                                         math::Euler{3.0, -0.4, -1.0},
                                         math::Euler{0.3, 89.9 * kDegree, 1.0}));

TEST(CascadeModel, AirDataColumnsVanishAtRest) {
  EXPECT_TRUE(velocity_by_air_data(Eigen::Vector3d::Zero()).isZero(0.0));
}

TEST(CascadeModel, EachErrorDecaysWithItsOwnTimeConstant) {
  CascadeParameters parameters;
  const TrackPoint point = point_of({}, {200.0, 0.0, 0.0});
  const StateMatrix F = error_dynamics(parameters, point, StateVector::Zero()).F;
  EXPECT_EQ(F(kGpsError.offset, kGpsError.offset), -1.0 / 150.0);
  EXPECT_EQ(F(kWind.offset + 1, kWind.offset + 1), -1.0 / parameters.wind.tau);
  EXPECT_EQ(F(kHeadingError.offset, kHeadingError.offset), -1.0 / parameters.heading_error.tau);
  EXPECT_EQ(F(kPitchError.offset, kPitchError.offset), -1.0 / parameters.pitch_error.tau);
  EXPECT_EQ(F(kRollError.offset, kRollError.offset), -1.0 / parameters.roll_error.tau);
  EXPECT_EQ(F(kDeviation.offset, kDeviation.offset), -1.0 / parameters.heading_deviation.tau);
  EXPECT_EQ(F(kNorth, kNorth), 0.0);
  EXPECT_NE(F(kEast, kEast), 0.0);
}

}  // namespace
}  // namespace lodestar::fusion
