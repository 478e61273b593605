// SPDX-License-Identifier: Apache-2.0
#include "lodestar/monitor/gyro_reference.h"

#include <gtest/gtest.h>

namespace lodestar::monitor {
namespace {

const Eigen::Vector3d kRate(0.3, -0.2, 0.1);  // rad/s, in B

samples::Attitude turning(std::int64_t time_us) {
  samples::Attitude attitude;
  attitude.time_us = time_us;
  attitude.omega_B = kRate;
  return attitude;
}

TEST(GyroAttitude, IsTheIntegralOfItsRates) {
  GyroAttitude gyros;
  for (std::int64_t t = 20'000; t <= 1'020'000; t += 20'000) gyros.propagate(turning(t), 1e9);
  EXPECT_LT((math::log_quaternion(gyros.q_GB()) - kRate).norm(), 1e-12);
  EXPECT_NEAR(gyros.turned(), kRate.norm(), 1e-6);
}

TEST(GyroAttitude, ForgetsHowFarItTurnedAndDoesNotBridgeAGap) {
  GyroAttitude gyros;
  gyros.propagate(turning(20'000), 10.0);
  gyros.propagate(turning(5'000'000), 10.0);  // nobody knows what it did meanwhile
  EXPECT_EQ(gyros.turned(), 0.0);
  for (std::int64_t t = 5'020'000; t <= 205'000'000; t += 20'000) gyros.propagate(turning(t), 10.0);
  EXPECT_NEAR(gyros.turned(), 10.0 * kRate.norm(), 0.01);
}

TEST(GyroReference, WhatTurnsAsTheGyrosSayDoesNotDepart) {
  GyroReference reference;
  const Eigen::Quaterniond q_NG = math::exp_quaternion({0.4, 1.0, -2.0});
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q_GB = math::exp_quaternion(0.1 * i * kRate);
    EXPECT_LT(reference.departure(q_NG * q_GB, q_GB).norm(), 1e-12) << i;
  }
}

TEST(GyroReference, DepartureIsTheRotationInNAndFades) {
  GyroReference reference;
  const Eigen::Quaterniond q_GB = math::exp_quaternion({0.0, 0.0, 1.0});
  EXPECT_LT(reference.departure(q_GB, q_GB).norm(), 1e-12);
  const Eigen::Vector3d away(0.01, -0.02, 0.05);
  const Eigen::Quaterniond q_NB = math::exp_quaternion(away) * q_GB;
  EXPECT_LT((reference.departure(q_NB, q_GB) - away).norm(), 1e-12);
  reference.follow(q_NB, q_GB, 0.25);
  EXPECT_LT((reference.departure(q_NB, q_GB) - 0.75 * away).norm(), 1e-12);
  reference.restart();
  EXPECT_LT(reference.departure(q_NB, q_GB).norm(), 1e-12);
}

}  // namespace
}  // namespace lodestar::monitor
