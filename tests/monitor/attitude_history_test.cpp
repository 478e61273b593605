// SPDX-License-Identifier: Apache-2.0
#include "lodestar/monitor/attitude_history.h"

#include <gtest/gtest.h>

namespace lodestar::monitor {
namespace {

const Eigen::Quaterniond kGyros = Eigen::Quaterniond::Identity();

samples::Attitude rolled(std::int64_t time_us, double roll) {
  samples::Attitude attitude;
  attitude.time_us = time_us;
  attitude.q_NB = math::exp_quaternion({roll, 0.0, 0.0});
  return attitude;
}

double roll(const StatedAttitude& attitude) {
  return math::euler_from_C_NB(attitude.q_NB.toRotationMatrix()).roll;
}

TEST(AttitudeHistory, AnswersBetweenTwoFramesOnTheShortestWay) {
  AttitudeHistory history;
  history.push(rolled(0, 3.0), kGyros);
  samples::Attitude over = rolled(20'000, -3.0);  // 0.28 rad further, through half a turn
  over.q_NB.coeffs() *= -1.0;                     // the same attitude
  history.push(over, kGyros);
  EXPECT_NEAR(roll(*history.at(0)), 3.0, 1e-12);
  EXPECT_NEAR(math::wrap_pi(roll(*history.at(10'000)) - math::kPi), 0.0, 1e-12);
  EXPECT_NEAR(roll(*history.at(20'000)), -3.0, 1e-12);
}

TEST(AttitudeHistory, AnswersWhatTheGyrosMakeOfItBetweenTwoFramesToo) {
  AttitudeHistory history;
  history.push(rolled(0, 0.0), kGyros);
  history.push(rolled(20'000, 0.0), math::exp_quaternion({0.0, 0.2, 0.0}));
  const Eigen::Vector3d turned = math::log_quaternion(history.at(5'000)->q_GB);
  EXPECT_LT((turned - Eigen::Vector3d(0.0, 0.05, 0.0)).norm(), 1e-12);
}

TEST(AttitudeHistory, AnswersNothingOutsideWhatItHolds) {
  AttitudeHistory history;
  EXPECT_FALSE(history.at(0));
  for (std::int64_t t = 0; t < 2'000'000; t += 1'000)
    history.push(rolled(t, 1e-6 * static_cast<double>(t)), kGyros);
  EXPECT_FALSE(history.at(1'999'001));
  EXPECT_NEAR(roll(*history.at(999'500)), 0.9995, 1e-9);
  EXPECT_FALSE(history.at(900'000));
  history.clear();
  EXPECT_FALSE(history.at(1'500'000));
}

}  // namespace
}  // namespace lodestar::monitor
