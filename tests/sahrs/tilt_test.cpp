// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/tilt.h"

#include <gtest/gtest.h>

#include "lodestar/math/rotation.h"

namespace lodestar::sahrs {
namespace {

TEST(Tilt, HasTheSinesAndCosinesOfRollAndPitch) {
  const math::Euler e{-2.0, 1.2, 3.0};
  const Tilt tilt(math::C_NB_from_euler(e));
  EXPECT_NEAR(tilt.sin_roll, std::sin(e.roll), 1e-15);
  EXPECT_NEAR(tilt.cos_roll, std::cos(e.roll), 1e-15);
  EXPECT_NEAR(tilt.sin_pitch, std::sin(e.pitch), 1e-15);
  EXPECT_NEAR(tilt.cos_pitch, std::cos(e.pitch), 1e-15);
}

TEST(Tilt, ItsDerivativesAreThoseOfTheEulerAngles) {
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler({0.7, -0.9, 2.0});
  const Tilt tilt(C_NB);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d phi = kStep * Eigen::Vector3d::Unit(i);
    const math::Euler ahead = math::euler_from_C_NB(C_NB * math::exp_so3(phi));
    const math::Euler behind = math::euler_from_C_NB(C_NB * math::exp_so3(-phi));
    EXPECT_NEAR(tilt.d_roll()(i), (ahead.roll - behind.roll) / (2.0 * kStep), 1e-8);
    EXPECT_NEAR(tilt.d_pitch()(i), (ahead.pitch - behind.pitch) / (2.0 * kStep), 1e-8);
  }
}

TEST(Tilt, IsFiniteStraightUp) {
  Eigen::Matrix3d C_NB;
  C_NB << 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0;
  const Tilt tilt(C_NB);
  EXPECT_EQ(tilt.sin_pitch, 1.0);
  EXPECT_EQ(tilt.cos_pitch, 0.0);
  EXPECT_TRUE(std::isfinite(tilt.sin_roll) && std::isfinite(tilt.cos_roll));
}

}  // namespace
}  // namespace lodestar::sahrs
