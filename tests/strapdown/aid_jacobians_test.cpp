// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "flight_points.h"
#include "lodestar/strapdown/air_data_aid.h"
#include "lodestar/strapdown/delayed.h"
#include "lodestar/strapdown/magnetic_aid.h"

namespace lodestar::strapdown {
namespace {

const Eigen::Vector3d kField_N(15200.0, 1600.0, 48900.0);  // nT

template <class Measurement>
Eigen::Matrix<double, Measurement::kRows, kStates> dense_H(const Measurement& m) {
  constexpr int kM = Measurement::kRows;
  Eigen::Matrix<double, kM, kStates> H = Eigen::Matrix<double, kM, kStates>::Zero();
  m.visit_H([&H](int offset, const auto& part_of_H) {
    using Part = std::decay_t<decltype(part_of_H)>;
    if constexpr (std::is_same_v<Part, double>) {
      H.template middleCols<kM>(offset).diagonal().array() += part_of_H;
    } else {
      H.template middleCols<Part::ColsAtCompileTime>(offset) += part_of_H;
    }
  });
  return H;
}

/// H by central differences of the innovation, whose sign is the prediction's reversed.
template <int M, class Measure>
Eigen::Matrix<double, M, kStates> numeric_H(const Estimate& x, Measure&& measure) {
  Eigen::Matrix<double, M, kStates> H;
  const StateVector h = steps();
  for (int j = 0; j < kStates; ++j) {
    Estimate plus = x;
    Estimate minus = x;
    const StateVector error = StateVector::Unit(j) * h(j);
    plus.correct(error);
    minus.correct<kStates>(-error);
    H.col(j) = (measure(minus).innovation - measure(plus).innovation) / (2.0 * h(j));
  }
  return H;
}

/// Within 1e-6 of the row's largest element, and of what a second-order step of 1e-4 rad leaves.
template <class Matrix>
void expect_alike(const Matrix& analytic, const Matrix& numeric, const char* where) {
  for (int i = 0; i < analytic.rows(); ++i) {
    const double scale = std::max(1.0, numeric.row(i).cwiseAbs().maxCoeff());
    for (int j = 0; j < kStates; ++j) {
      EXPECT_NEAR(analytic(i, j), numeric(i, j), 1e-6 * scale)
          << where << " row " << i << " column " << j;
    }
  }
}

TEST(MagneticAid, JacobianMatchesCentralDifferences) {
  for (const FlightPoint& point : flight_points()) {
    const auto measure = [](const Estimate& x) {
      return measure_field(Eigen::Vector3d(15000.0, -2000.0, 48000.0), x, kField_N, 80.0);
    };
    expect_alike(dense_H(measure(point.x)), numeric_H<3>(point.x, measure), point.name);
  }
}

TEST(MagneticAid, AHeadingTooSmallByALittleShowsAsAFieldTurnedToTheLeft) {
  // Level and heading north in a field to the north and down: if the true heading is a little east
  // of the estimate, the horizontal field comes a little from the left.
  const Estimate x = [] {
    Estimate level;
    level.air_velocity_N << 180.0, 0.0, 0.0;
    return level;
  }();
  const Eigen::Vector3d b_N(15000.0, 0.0, 48000.0);
  const Eigen::Vector3d b_B = math::exp_so3(Eigen::Vector3d(0.0, 0.0, 0.01)).transpose() * b_N;
  const MagneticMeasurement m = measure_field(b_B, x, b_N, 80.0);
  EXPECT_NEAR(m.innovation.y(), -150.0, 0.1);  // second order in 0.01 rad
  EXPECT_GT(m.innovation.dot(m.H_attitude.col(2)), 0.0);
}

TEST(AirDataAid, JacobianMatchesCentralDifferences) {
  for (const FlightPoint& point : flight_points()) {
    samples::AirData sample;
    sample.true_airspeed = 180.0;
    sample.alpha = 0.05;
    sample.beta = -0.02;
    sample.baro_altitude = 2500.0;
    Estimate x = point.x;
    x.gust_B.setZero();  // H stands on the flow without it
    const auto measure = [&sample](const Estimate& changed) {
      return measure_air(sample, changed, {190.0, 0.06, -0.01}, {0.5, 0.002, 0.5});
    };
    expect_alike(dense_H(measure(x)), numeric_H<4>(x, measure), point.name);
  }
}

TEST(AirDataAid, TheEstimateItselfLeavesNoInnovation) {
  Estimate x;
  x.C_NB = math::C_NB_from_euler({0.5, 0.2, 1.0});
  x.q_NB = Eigen::Quaterniond(x.C_NB);
  samples::AirData sample;
  sample.true_airspeed = 150.0;
  sample.alpha = 0.1;
  sample.beta = -0.05;
  sample.baro_altitude = 1000.0;
  x.air_velocity_N = x.C_NB * air_velocity_B(sample);
  x.baro_height = 1000.0;
  EXPECT_LT(measure_air(sample, x, flow_without_gust(x), {0.5, 0.002, 0.5}).innovation.norm(),
            1e-12);
}

TEST(AirDataAid, DoesNotSeeTheAttitude) {
  for (const FlightPoint& point : flight_points()) {
    const auto H = dense_H(
        measure_air(samples::AirData{}, point.x, flow_without_gust(point.x), {0.5, 0.002, 0.5}));
    EXPECT_EQ(H.middleCols<3>(kAttitude.offset).norm(), 0.0) << point.name;
  }
}

TEST(Delayed, MapsTheErrorsOfNowToThoseOfThen) {
  // The error of a moment ago is that of now carried back by the transition over the age; both are
  // first order in it, so that what differs is second order: 1e-3 of the parts for 10 ms.
  for (const FlightPoint& point : flight_points()) {
    const double age = 0.01;
    Estimate now = point.x;
    const Step step = move(now, point.omega_B, point.force_B, sweden(), age);
    const MagneticMeasurement then =
        measure_field(Eigen::Vector3d::Zero(), point.x, kField_N, 80.0);
    Delay delay;
    delay.age = age;
    delay.gravity = sweden().gravity;
    delay.omega_B = point.omega_B;
    delay.C_NB = step.C_NB;
    delay.air_velocity_N = point.x.air_velocity_N;
    const auto H_now = dense_H(Delayed<MagneticMeasurement>(then, delay));
    const auto H_then = dense_H(then);
    for (int j = 0; j < kStates; ++j) {
      StateVector carried = StateVector::Unit(j);
      propagate_error<kStates>(carried, step, sweden(), ProcessNoise{});
      const Eigen::Vector3d expected = H_then.col(j);
      const Eigen::Vector3d mapped = H_now * carried;
      EXPECT_LT((mapped - expected).norm(), 1e-3 * std::max(1.0, expected.norm()))
          << point.name << " column " << j;
    }
  }
}

}  // namespace
}  // namespace lodestar::strapdown
