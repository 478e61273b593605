// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/roll_measurement.h"

#include <gtest/gtest.h>

#include "jacobian.h"
#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {
namespace {

using math::kDegree;
constexpr double kGravity = 9.81;  // m/s^2

struct Flight {
  math::Euler attitude;
  double true_airspeed;
  double alpha;
  double beta;
  double p;  // rad/s
  double q;  // rad/s
};

const Flight kFlights[] = {
    {{0.0, 5.0 * kDegree, 1.0}, 180.0, 5.0 * kDegree, 0.0, 0.0, 0.0},           // cruise
    {{0.0, 0.0, 0.0}, 180.0, 0.0, 0.0, 0.0, 0.0},                               // nought
    {{60.0 * kDegree, 8.0 * kDegree, 2.0}, 200.0, 0.17, 0.02, -0.01, 0.08},     // turn
    {{-170.0 * kDegree, -20.0 * kDegree, 3.0}, 150.0, 0.07, -0.05, 0.2, 0.05},  // back
    {{30.0 * kDegree, 80.0 * kDegree, 4.0}, 120.0, 0.14, 0.01, 0.1, 0.1},       // up
    {{0.8, 0.1, 5.0}, 15.0, 0.1, 0.1, 0.3, 0.2},                                // small
};

Eigen::Vector3d air_velocity(double V, double alpha, double beta) {
  return V * Eigen::Vector3d(std::cos(alpha) * std::cos(beta), std::sin(beta),
                             std::sin(alpha) * std::cos(beta));
}

/// What the sensors say if the truth is off the estimate by x, in flight that balances.
Measurement<1> measure(const Flight& flight, const sahrs_test::StateError& x) {
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(flight.attitude);
  const Eigen::Matrix3d truth = C_NB * math::exp_so3(x.segment<3>(kAttitude.offset));
  const Eigen::Vector3d v = air_velocity(flight.true_airspeed, flight.alpha, flight.beta);
  const double r = (kGravity * truth(2, 1) + flight.p * v.z()) / v.x();
  const double normal_force = kGravity * truth(2, 2) + flight.q * v.x() - flight.p * v.y();
  const Eigen::Vector3d omega_B =
      Eigen::Vector3d(flight.p, flight.q, r) + x.segment<3>(kGyroBias.offset);
  return roll_measurement({omega_B, normal_force,
                           air_velocity(flight.true_airspeed, flight.alpha + x(kAlphaBias.offset),
                                        flight.beta + x(kBetaBias.offset)),
                           Tilt(C_NB)},
                          {1e-3, 0.2}, {0.01, 1.0});
}

TEST(RollMeasurement, OfALevelTurnIsItsBank) {
  // The textbook: n_z = 1 / cos(roll), rate g tan(roll) / V about the vertical.
  const double roll = 45.0 * kDegree, V = 180.0;
  const double rate = kGravity * std::tan(roll) / V;
  const Eigen::Vector3d omega_B(0.0, rate * std::sin(roll), rate * std::cos(roll));
  const Measurement<1> m =
      roll_measurement({omega_B, kGravity * std::sqrt(2.0), Eigen::Vector3d(V, 0.0, 0.0),
                        Tilt(Eigen::Matrix3d::Identity())},
                       {0.0, 0.0}, {0.0, 0.0});
  EXPECT_NEAR(m.innovation(0), roll, 1e-14);
}

TEST(RollMeasurement, IsNoughtAtTheTrueRoll) {
  for (const Flight& flight : kFlights) {
    EXPECT_NEAR(measure(flight, sahrs_test::StateError::Zero()).innovation(0), 0.0, 1e-12);
  }
}

TEST(RollMeasurement, ItsBalanceHasTheSizeOfGravityAcrossTheNose) {
  const Eigen::Vector3d omega_B(0.0, 0.0, 0.0);
  const Tilt tilt(math::C_NB_from_euler({0.5, 0.3, 0.0}));
  const Balance b = balance({omega_B, 8.0, Eigen::Vector3d(180.0, 0.0, 0.0), tilt});
  EXPECT_EQ(b.lateral, 0.0);
  EXPECT_EQ(b.size(), 8.0);
}

TEST(RollMeasurement, ItsJacobianIsThatOfTheSensors) {
  for (const Flight& flight : kFlights) {
    sahrs_test::expect_jacobian<1>(
        measure(flight, sahrs_test::StateError::Zero()),
        [&](const sahrs_test::StateError& x) { return measure(flight, x).innovation; });
  }
}

TEST(RollMeasurement, OfAYawRateBiasIsOffByAirspeedOverGravity) {
  const Measurement<1> m = measure(kFlights[1], sahrs_test::StateError::Zero());
  EXPECT_NEAR(m.H(0, kGyroBias.offset + 2), 180.0 / kGravity, 1e-12);
  EXPECT_NEAR(m.R(0, 0), std::pow(180.0 / kGravity * 1e-3, 2) + 0.01 / (kGravity * kGravity),
              1e-12);
  EXPECT_NEAR(m.excess, 1.0 / (kGravity * kGravity), 1e-15);
}

TEST(RollMeasurement, TakesTheShortWayRound) {
  const Eigen::Vector3d v(180.0, 0.0, 0.0);
  // On its back: measured at -179 degrees, predicted at 179.
  const double measured = -179.0 * kDegree;
  const Eigen::Vector3d omega_B(0.0, 0.0, kGravity * std::sin(measured) / 180.0);
  const Measurement<1> m =
      roll_measurement({omega_B, kGravity * std::cos(measured), v,
                        Tilt(math::C_NB_from_euler({179.0 * kDegree, 0.0, 0.0}))},
                       {0.0, 0.0}, {0.0, 0.0});
  EXPECT_NEAR(m.innovation(0), 2.0 * kDegree, 1e-12);
}

}  // namespace
}  // namespace lodestar::sahrs
