// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/vertical_channel.h"

#include <gtest/gtest.h>

#include <random>

namespace lodestar::fusion {
namespace {

/// A climb of 10 m/s and back, seen by a baro with bias, noise and lag, and by GPS.
class Climb {
 public:
  explicit Climb(double baro_bias, double air_error = 0.0)
      : channel_(parameters_), bias_(baro_bias), air_error_(air_error) {}

  void fly(double seconds, double rate) {
    for (int i = 0; i < static_cast<int>(60.0 * seconds); ++i) {
      channel_.propagate(kInterval, -(rate - air_error_));
      h_ += rate * kInterval;
      lagged_ += (h_ - lagged_) * kInterval / 0.3;
      if (++frame_ % 2 == 0) channel_.update_baro(lagged_ - bias_ + 0.5 * normal_(generator_), 0.0);
      if (frame_ % 60 == 0 && gps_) {
        channel_.update_gps(h_ + gps_jump_ + normal_(generator_) - channel_.baro_height(), 5.1);
      }
    }
    rate_error_ = rate - (channel_.climb_correction() + rate - air_error_);
  }

  double height_error() const { return h_ - channel_.baro_height() - channel_.bias(); }
  double rate_error() const { return rate_error_; }

  CascadeParameters parameters_;
  VerticalChannel channel_;
  bool gps_ = true;
  double gps_jump_ = 0.0;

 private:
  static constexpr double kInterval = 1.0 / 60.0;
  std::mt19937_64 generator_{4};
  std::normal_distribution<double> normal_;
  double bias_;
  double air_error_;
  double h_ = 3000.0;
  double lagged_ = 3000.0;
  double rate_error_ = 0.0;
  int frame_ = 0;
};

TEST(VerticalChannel, StartsAtTheFirstBaroAltitude) {
  VerticalChannel channel{CascadeParameters{}};
  EXPECT_FALSE(channel.started());
  channel.propagate(0.1, 5.0);
  channel.update_baro(1234.0, 0.0);
  EXPECT_TRUE(channel.started());
  EXPECT_EQ(channel.baro_height(), 1234.0);
  EXPECT_EQ(channel.bias(), 0.0);
  EXPECT_NEAR(channel.sigma_height(), std::hypot(20.0, 0.5), 1e-12);
}

TEST(VerticalChannel, FindsTheBiasOfBaroAltitude) {
  Climb climb(35.0);
  climb.fly(60.0, 0.0);
  EXPECT_LT(std::abs(climb.height_error()), 3.0 * climb.channel_.sigma_height());
  EXPECT_LT(climb.channel_.sigma_height(), 6.0);
  EXPECT_NEAR(climb.channel_.bias(), 35.0, 12.0);
}

TEST(VerticalChannel, LagDoesNotShowInASteadyClimb) {
  Climb climb(0.0);
  climb.gps_ = false;
  climb.fly(20.0, 0.0);
  climb.fly(60.0, 50.0);  // uncorrected, 0.3 s of it are 15 m
  EXPECT_LT(std::abs(climb.height_error()), 1.0);
}

TEST(VerticalChannel, FindsTheErrorOfTheAirDataClimbRate) {
  Climb climb(0.0, 2.0);
  climb.fly(60.0, 10.0);
  EXPECT_LT(std::abs(climb.rate_error()), 0.6);
}

TEST(VerticalChannel, OldBaroAltitudeIsComparedWithItsOwnTime) {
  CascadeParameters parameters;
  parameters.baro_lag = 0.0;
  VerticalChannel channel(parameters);
  channel.update_baro(1000.0, 0.0);
  for (int i = 0; i < 600; ++i) {
    channel.propagate(0.1, -20.0);
    const double h = 1000.0 + 2.0 * (i + 1);
    channel.update_baro(h - 0.5 * 20.0, 0.5);
  }
  EXPECT_NEAR(channel.baro_height(), 2200.0, 0.1);
}

TEST(VerticalChannel, ASingleWildGpsHeightIsRefusedAndALastingJumpIsNot) {
  Climb climb(0.0);
  climb.fly(60.0, 0.0);
  const double bias = climb.channel_.bias();
  climb.gps_jump_ = 300.0;
  climb.fly(1.0, 0.0);
  EXPECT_NEAR(climb.channel_.bias(), bias, 1.0);
  climb.fly(5.0, 0.0);
  EXPECT_NEAR(climb.height_error(), -300.0, 20.0);
}

TEST(VerticalChannel, UncertaintyGrowsBackWithoutGps) {
  Climb climb(10.0);
  climb.fly(60.0, 0.0);
  const double with_gps = climb.channel_.sigma_height();
  climb.gps_ = false;
  climb.fly(600.0, 0.0);
  EXPECT_GT(climb.channel_.sigma_height(), 2.0 * with_gps);
  EXPECT_LT(climb.channel_.sigma_height(), 20.1);
}

}  // namespace
}  // namespace lodestar::fusion
