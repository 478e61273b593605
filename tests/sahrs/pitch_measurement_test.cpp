// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/pitch_measurement.h"

#include <gtest/gtest.h>

#include "jacobian.h"
#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {
namespace {

using math::kDegree;

struct Flight {
  math::Euler attitude;
  double true_airspeed;
  double alpha;
  double beta;
};

Eigen::Vector3d air_velocity(double V, double alpha, double beta) {
  return V * Eigen::Vector3d(std::cos(alpha) * std::cos(beta), std::sin(beta),
                             std::sin(alpha) * std::cos(beta));
}

const Flight kFlights[] = {
    {{0.0, 5.0 * kDegree, 1.0}, 180.0, 5.0 * kDegree, 0.0},                        // cruise
    {{0.0, 0.0, 0.0}, 180.0, 0.0, 0.0},                                            // all nought
    {{60.0 * kDegree, 8.0 * kDegree, 2.0}, 200.0, 10.0 * kDegree, 2.0 * kDegree},  // turn
    {{-170.0 * kDegree, -20.0 * kDegree, 3.0},
     150.0,
     4.0 * kDegree,
     -3.0 * kDegree},                                                              // on its back
    {{30.0 * kDegree, 80.0 * kDegree, 4.0}, 120.0, 8.0 * kDegree, 1.0 * kDegree},  // nearly up
    {{0.2, 0.3, 5.0}, 12.0, 12.0 * kDegree, 10.0 * kDegree},                       // small and slow
};

Measurement<1> measure(const Flight& flight, const sahrs_test::StateError& x) {
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler(flight.attitude);
  const Eigen::Matrix3d truth = C_NB * math::exp_so3(x.segment<3>(kAttitude.offset));
  const double climb_rate =
      -truth.row(2).dot(air_velocity(flight.true_airspeed, flight.alpha, flight.beta));
  return pitch_measurement({air_velocity(flight.true_airspeed, flight.alpha + x(kAlphaBias.offset),
                                         flight.beta + x(kBetaBias.offset)),
                            climb_rate, Tilt(C_NB)},
                           0.1 * kDegree, {1.0, 99.0});
}

TEST(PitchMeasurement, IsNoughtAtTheTruePitch) {
  for (const Flight& flight : kFlights) {
    EXPECT_NEAR(measure(flight, sahrs_test::StateError::Zero()).innovation(0), 0.0, 1e-12);
  }
}

TEST(PitchMeasurement, OfAClimbWithWingsLevelIsPathAngleAndAngleOfAttack) {
  const double path_angle = 4.0 * kDegree, alpha = 6.0 * kDegree;
  const Measurement<1> m =
      pitch_measurement({air_velocity(100.0, alpha, 0.0), 100.0 * std::sin(path_angle),
                         Tilt(Eigen::Matrix3d::Identity())},
                        0.0, {0.0, 0.0});
  EXPECT_NEAR(m.innovation(0), path_angle + alpha, 1e-14);
}

TEST(PitchMeasurement, ItsJacobianIsThatOfTheSensors) {
  for (const Flight& flight : kFlights) {
    sahrs_test::expect_jacobian<1>(
        measure(flight, sahrs_test::StateError::Zero()),
        [&](const sahrs_test::StateError& x) { return measure(flight, x).innovation; });
  }
}

TEST(PitchMeasurement, ItsNoiseIsThatOfAlphaAndOfTheClimbOverTheAirspeed) {
  const Measurement<1> m = measure(kFlights[1], sahrs_test::StateError::Zero());
  const double alpha_variance = 0.1 * kDegree * 0.1 * kDegree;
  EXPECT_NEAR(m.R(0, 0), alpha_variance + 1.0 / (180.0 * 180.0), 1e-12);
  EXPECT_NEAR(m.excess, 99.0 / (180.0 * 180.0), 1e-12);
}

}  // namespace
}  // namespace lodestar::sahrs
