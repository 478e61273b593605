// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/alignment.h"

#include <gtest/gtest.h>

#include "lodestar/samples/samples.h"

namespace lodestar::sahrs {
namespace {

using math::kDegree;
constexpr double kGravity = 9.81;
constexpr double kAirspeed = 180.0;
const Eigen::Vector3d kField_N(15000.0, 1500.0, 49000.0);

/// Steady level flight at `bank`, seen by perfect sensors but for a gyro bias.
class SteadyFlight {
 public:
  SteadyFlight(double bank, const Eigen::Vector3d& gyro_bias_B)
      : bank_(bank), rate_(kGravity * std::tan(bank) / kAirspeed), gyro_bias_B_(gyro_bias_B) {}

  void observe(Alignment& alignment, double duration) {
    const int frames = static_cast<int>(std::lround(duration * 60.0));
    for (int k = 0; k < frames; ++k) {
      time_us_ += 16'667;
      const Eigen::Matrix3d C_NB = this->C_NB();
      const Eigen::Vector3d down(0.0, 0.0, 1.0);
      const Eigen::Vector3d v_B(kAirspeed, 0.0, 0.0);
      const Eigen::Vector3d omega_B = rate_ * (C_NB.transpose() * down);
      const Eigen::Vector3d f_B = omega_B.cross(v_B) - kGravity * (C_NB.transpose() * down);
      alignment.observe_rates(omega_B + gyro_bias_B_, time_us_);
      alignment.observe_load(-f_B / samples::kStandardGravity, v_B, time_us_);
      if (k % 2 == 0) alignment.observe_field(C_NB.transpose() * kField_N, time_us_);
    }
  }

  Eigen::Matrix3d C_NB() const {
    return math::C_NB_from_euler({bank_, 0.0, 0.1 + rate_ * 1e-6 * static_cast<double>(time_us_)});
  }

 private:
  double bank_;
  double rate_;
  Eigen::Vector3d gyro_bias_B_;
  std::int64_t time_us_ = 0;
};

AlignmentInput input() { return {0.0, kField_N, kGravity, 0.6 * kDegree, 0.15}; }

double angle_between(const math::Euler& e, const Eigen::Matrix3d& C_NB) {
  return Eigen::AngleAxisd(math::C_NB_from_euler(e).transpose() * C_NB).angle();
}

TEST(Alignment, NeedsAFewSeconds) {
  Alignment alignment;
  SteadyFlight flight(0.0, Eigen::Vector3d::Zero());
  flight.observe(alignment, 3.5);
  EXPECT_FALSE(alignment.solve(input()));
  flight.observe(alignment, 1.0);
  EXPECT_TRUE(alignment.solve(input()));
}

TEST(Alignment, FindsAttitudeAndTheBiasAboutDownInStraightFlight) {
  Alignment alignment;
  SteadyFlight flight(0.0, Eigen::Vector3d(0.1, -0.2, 0.3) * kDegree);
  flight.observe(alignment, 10.0);
  const std::optional<Aligned> aligned = alignment.solve(input());
  ASSERT_TRUE(aligned);
  EXPECT_NEAR(aligned->gyro_bias_B.z(), 0.3 * kDegree, 0.01 * kDegree);
  EXPECT_LT(angle_between(aligned->attitude, flight.C_NB()), 0.3 * kDegree);
}

TEST(Alignment, WithoutTheBiasItWouldBeOffByTwelveDegrees) {
  Alignment alignment;
  SteadyFlight flight(0.0, Eigen::Vector3d(0.0, 0.0, 0.2) * kDegree);
  flight.observe(alignment, 10.0);
  AlignmentInput in = input();
  in.max_gyro_bias = 0.0;
  const std::optional<Aligned> aligned = alignment.solve(in);
  ASSERT_TRUE(aligned);
  EXPECT_GT(angle_between(aligned->attitude, flight.C_NB()), 10.0 * kDegree);
}

TEST(Alignment, FindsAttitudeInATurn) {
  Alignment alignment;
  SteadyFlight flight(40.0 * kDegree, Eigen::Vector3d::Zero());
  flight.observe(alignment, 10.0);
  const std::optional<Aligned> aligned = alignment.solve(input());
  ASSERT_TRUE(aligned);
  EXPECT_TRUE(aligned->gyro_bias_B.isZero(0.0));
  // The field of up to two frames ago, in a turn of 2.6 degrees/s.
  EXPECT_LT(angle_between(aligned->attitude, flight.C_NB()), 0.3 * kDegree);
  EXPECT_GT(aligned->sigma_B.z(), 10.0 * kDegree);
}

TEST(Alignment, WaitsWhileTheAircraftManoeuvres) {
  Alignment alignment;
  SteadyFlight flight(0.0, Eigen::Vector3d::Zero());
  flight.observe(alignment, 10.0);
  AlignmentInput in = input();
  in.gravity = 0.7 * kGravity;  // as in a pull-up
  EXPECT_FALSE(alignment.solve(in));
}

TEST(Alignment, StartsAnewAfterARestartAndAfterSilence) {
  Alignment alignment;
  SteadyFlight flight(0.0, Eigen::Vector3d::Zero());
  flight.observe(alignment, 10.0);
  alignment.restart();
  EXPECT_FALSE(alignment.solve(input()));
  flight.observe(alignment, 10.0);
  EXPECT_TRUE(alignment.solve(input()));
  alignment.observe_field(kField_N, 30'000'000);  // nothing for ten seconds
  EXPECT_FALSE(alignment.solve(input()));
}

}  // namespace
}  // namespace lodestar::sahrs
