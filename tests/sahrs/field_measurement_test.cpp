// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/field_measurement.h"

#include <gtest/gtest.h>

#include "jacobian.h"

namespace lodestar::sahrs {
namespace {

const Eigen::Vector3d kField_N(15000.0, 1500.0, 49000.0);  // nT, southern Sweden

TEST(FieldMeasurement, IsNoughtForWhatTheModelPredicts) {
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler({0.3, -0.2, 4.0});
  const Eigen::Vector3d bias_B(300.0, -200.0, 100.0);
  const Eigen::Vector3d b_B = C_NB.transpose() * kField_N + bias_B;
  const Measurement<3> m = field_measurement({b_B, bias_B, C_NB, kField_N}, 80.0, {0.0, 0.0});
  EXPECT_LT(m.innovation.norm(), 1e-9);
  EXPECT_EQ(m.R, Eigen::Matrix3d(6400.0 * Eigen::Matrix3d::Identity()));
}

TEST(FieldMeasurement, OfANoseTooFarRightPointsWest) {
  // The aircraft heads north along a field to the north, the estimate 0.01 rad east of it: the
  // field is seen ahead, and so, by the estimate, east of north.
  const Eigen::Vector3d b_N(15000.0, 0.0, 0.0);
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler({0.0, 0.0, 0.01});
  const Measurement<3> m =
      field_measurement({b_N, Eigen::Vector3d::Zero(), C_NB, b_N}, 80.0, {0.0, 0.0});
  EXPECT_NEAR(m.innovation.y(), 150.0, 0.01);
  EXPECT_NEAR(m.H(1, 2), -15000.0, 1e-9 + 15000.0 * 1e-4);  // a turn to the left corrects it
}

TEST(FieldMeasurement, ItsJacobianIsThatOfTheSensorAtEveryAttitude) {
  for (const math::Euler& e : {math::Euler{0.1, 0.05, 1.0}, math::Euler{0.0, 0.0, 0.0},
                               math::Euler{1.0, 1.5707, 3.0}, math::Euler{3.1, -1.57, 6.0}}) {
    const Eigen::Matrix3d C_NB = math::C_NB_from_euler(e);
    const Eigen::Vector3d bias_B(400.0, -300.0, 200.0);
    const auto measure = [&](const sahrs_test::StateError& x) {
      const Eigen::Matrix3d truth = C_NB * math::exp_so3(x.segment<3>(kAttitude.offset));
      const Eigen::Vector3d b_B =
          truth.transpose() * kField_N + bias_B + x.segment<3>(kFieldBias.offset);
      return field_measurement({b_B, bias_B, C_NB, kField_N}, 80.0, {0.0, 0.0});
    };
    sahrs_test::expect_jacobian<3>(
        measure(sahrs_test::StateError::Zero()),
        [&](const sahrs_test::StateError& x) { return measure(x).innovation; });
  }
}

}  // namespace
}  // namespace lodestar::sahrs
