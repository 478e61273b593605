// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/attitude_error.h"

#include <gtest/gtest.h>

namespace lodestar::fusion {
namespace {

using math::kDegree;

constexpr AttitudeError kForms[] = {AttitudeError::kEuler, AttitudeError::kSmallAngle};

TrackPoint point_at(const math::Euler& attitude) {
  TrackPoint point;
  point.attitude = attitude;
  return point;
}

StateVector some_errors() {
  StateVector x = StateVector::Zero();
  x.segment<kAngles.size>(kAngles.offset) << 0.03, -0.01, 0.02, 0.015, -0.04;
  return x;
}

// Hand cases.

TEST(AttitudeErrorTest, ACompassPulledToTheRightWingReadsLeftOfTrueNorth) {
  // Heading north. The field it feels leans right, so north seems to lie right of the nose and the
  // heading left of it: true - computed > 0. The error true - measured of the right component is
  // negative.
  EXPECT_NEAR(deviation(0.0).dot(Eigen::Vector2d(0.0, -0.02)), 0.02, 1e-15);
  // Heading east, north is on the left wing; a field that is too strong forward turns it towards
  // the nose, and the computed heading is short of east.
  EXPECT_NEAR(deviation(90.0 * kDegree).dot(Eigen::Vector2d(-0.02, 0.0)), 0.02, 1e-15);
}

TEST(AttitudeErrorTest, DeviationIsTheDifferenceOfTwoCompasses) {
  for (const double heading : {0.3, 2.0, 4.0, 6.0}) {
    const Eigen::Vector2d error(3e-5, -2e-5);  // of the components, true - measured
    const Eigen::Vector2d truth(std::cos(heading), -std::sin(heading));
    const Eigen::Vector2d measured = truth - error;
    const double computed = -std::atan2(measured.y(), measured.x());
    EXPECT_NEAR(deviation(heading).dot(error), math::wrap_pi(heading - computed), 2e-9);
  }
}

TEST(AttitudeErrorTest, ARotationAboutDownIsAHeadingErrorAtAnyHeading) {
  for (const double heading : {0.0, 1.0, 3.0, 5.0}) {
    const TrackPoint point = point_at({0.4, 0.2, heading});
    StateVector x = StateVector::Zero();
    x(kHeadingError.offset) = 0.1;
    for (const AttitudeError form : kForms) {
      const math::Euler corrected = corrected_attitude(form, point, x);
      EXPECT_NEAR(math::wrap_pi(corrected.heading - heading), 0.1, 1e-12);
      EXPECT_NEAR(corrected.pitch, 0.2, 1e-12);
      EXPECT_NEAR(corrected.roll, 0.4, 1e-12);
      EXPECT_NEAR(heading_error(form, point, x), 0.1, 1e-12);
    }
  }
}

TEST(AttitudeErrorTest, ARotationAboutNorthIsRollAtHeadingNorthAndLessPitchAtHeadingEast) {
  StateVector x = StateVector::Zero();
  x(kRollError.offset) = 0.01;
  const AttitudeError form = AttitudeError::kSmallAngle;
  EXPECT_NEAR(corrected_attitude(form, point_at({0.0, 0.0, 0.0}), x).roll, 0.01, 1e-12);
  const math::Euler east = corrected_attitude(form, point_at({0.0, 0.0, 90.0 * kDegree}), x);
  EXPECT_NEAR(east.pitch, -0.01, 1e-12);
  EXPECT_NEAR(east.roll, 0.0, 1e-12);
}

TEST(AttitudeErrorTest, BothFormsHaveTheSameFirstOrderAtHeadingNorth) {
  const TrackPoint level = point_at({0.0, 0.0, 0.0});
  const StateVector x = 1e-4 * some_errors();
  const math::Euler a = corrected_attitude(AttitudeError::kEuler, level, x);
  const math::Euler b = corrected_attitude(AttitudeError::kSmallAngle, level, x);
  EXPECT_NEAR(a.roll, b.roll, 1e-10);
  EXPECT_NEAR(a.pitch, b.pitch, 1e-10);
  EXPECT_NEAR(math::wrap_pi(a.heading - b.heading), 0.0, 1e-10);
}

class AttitudeErrorAt : public testing::TestWithParam<math::Euler> {};

TEST_P(AttitudeErrorAt, EulerByStatesAgreesWithCentralDifferences) {
  constexpr double kStep = 1e-6;
  const TrackPoint point = point_at(GetParam());
  for (const AttitudeError form : kForms) {
    for (const StateVector& x : {StateVector(StateVector::Zero()), some_errors()}) {
      const AngleMatrix J = euler_by_states(form, point, x);
      for (int i = 0; i < kStates; ++i) {
        StateVector up = x;
        StateVector down = x;
        up(i) += kStep;
        down(i) -= kStep;
        const math::Euler a = corrected_attitude(form, point, up);
        const math::Euler b = corrected_attitude(form, point, down);
        const Eigen::Vector3d difference(math::wrap_pi(a.heading - b.heading), a.pitch - b.pitch,
                                         math::wrap_pi(a.roll - b.roll));
        EXPECT_LT((J.col(i) - difference / (2.0 * kStep)).norm(), 1e-6 * (1.0 + J.col(i).norm()))
            << "state " << i;
      }
    }
  }
}

TEST_P(AttitudeErrorAt, ARotationInBIsTheSameOneAlongTheLevelAxes) {
  const AttitudeError form = AttitudeError::kSmallAngle;
  const Eigen::Vector3d phi_B(0.01, -0.02, 0.03);
  const Eigen::Vector3d along = angles_by_rotation_B(form, GetParam()) * phi_B;
  const Eigen::Vector3d in_N = math::C_NB_from_euler(GetParam()) * phi_B;
  const Eigen::Vector3d states = angle_axes(form, GetParam().heading) * along;  // down, east, north
  EXPECT_LT((states.reverse() - in_N).norm(), 1e-15);
}

INSTANTIATE_TEST_SUITE_P(Attitudes, AttitudeErrorAt,
                         testing::Values(math::Euler{0.0, 0.0, 0.0}, math::Euler{0.8, 0.1, 2.5},
                                         math::Euler{-1e-7, 1e-7, 6.28},
                                         math::Euler{3.0, -0.4, -1.0},
                                         math::Euler{0.3, 80.0 * kDegree, 1.0}));

TEST(AttitudeErrorTest, SmallAngleStatesHaveFiniteVarianceStraightUp) {
  const math::Euler up{0.0, 90.0 * kDegree, 0.0};
  const Eigen::Matrix3d E = angles_by_rotation_B(AttitudeError::kSmallAngle, up);
  EXPECT_LT((E * E.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_GT(angles_by_rotation_B(AttitudeError::kEuler, up).norm(), 10.0);
}

TEST(AttitudeErrorTest, AxesOfTheSmallAngleTurnWithTheHeading) {
  const Eigen::Vector3d variance(1.0, 2.0, 3.0);  // about down, right, forward
  const AttitudeError form = AttitudeError::kSmallAngle;
  const Eigen::Matrix3d east = angle_covariance(form, 90.0 * kDegree, variance);
  // Forward is east, right is south.
  const Eigen::Vector3d expected(1.0, 3.0, 2.0);
  EXPECT_LT((east - Eigen::Matrix3d(expected.asDiagonal())).norm(), 1e-14);
  EXPECT_EQ(angle_covariance(AttitudeError::kEuler, 1.0, variance).diagonal(), variance);
}

}  // namespace
}  // namespace lodestar::fusion
