// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/paper_sahrs.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fly.h"

namespace lodestar::sahrs_test {
namespace {

using math::kDegree;
using sahrs::PaperSahrs;
using samples::AttitudeMode;
using samples::Use;

class PaperSahrsTest : public testing::Test {
 protected:
  void start_at_truth(double sigma = 1.0 * kDegree) {
    sahrs_.start(flight_.truth(), Eigen::Vector3d::Constant(sigma), flight_.time_us());
  }
  double error() const { return error_B(flight_, sahrs_.attitude()).norm(); }

  FlightGenerator flight_{1};
  PaperSahrs sahrs_ = make_sahrs<PaperSahrs>();
};

TEST_F(PaperSahrsTest, ItsOutputsAgreeWithOneAnother) {
  start_at_truth();
  fly(flight_, sahrs_, 60.0);
  const samples::Attitude& a = sahrs_.attitude();
  EXPECT_EQ(a.time_us, flight_.time_us());
  const Eigen::Matrix3d C_NB = math::C_NB_from_euler({a.roll, a.pitch, a.heading});
  EXPECT_LT((a.q_NB.toRotationMatrix() - C_NB).norm(), 1e-12);
  EXPECT_EQ(a.P_B, Eigen::Matrix3d(sahrs_.covariance().topLeftCorner<3, 3>()));
  EXPECT_EQ(sahrs_.covariance(), sahrs::Covariance(sahrs_.covariance().transpose()));
}

TEST_F(PaperSahrsTest, StaysOrthonormalOver24HoursAt100Hz) {
  sahrs_.start({0.1, 0.2, 0.3}, Eigen::Vector3d::Constant(0.01), 0);
  for (std::int64_t k = 1; k <= 24 * 3600 * 100; ++k) {
    const double t = 0.01 * static_cast<double>(k);
    sahrs_.propagate({k * 10'000, {0.5 * std::sin(t), 0.3 * std::cos(0.7 * t), 0.1}, true});
  }
  sahrs_.finish_frame();
  const Eigen::Matrix3d C_NB = sahrs_.attitude().q_NB.toRotationMatrix();
  EXPECT_LT((C_NB.transpose() * C_NB - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE(sahrs_.covariance().allFinite());
}

class AtRate : public testing::TestWithParam<double> {};

TEST_P(AtRate, EstimatesWellAtAnyRateOfTheBodyRates) {
  FlightGenerator flight(4, 1.0, GetParam());
  PaperSahrs sahrs = make_sahrs<PaperSahrs>();
  fly(flight, sahrs, 120.0);
  double worst = 0.0;
  fly(flight, sahrs, 60.0,
      [&] { worst = std::max(worst, error_B(flight, sahrs.attitude()).norm()); });
  EXPECT_LT(worst, 5.0 * kDegree);
  EXPECT_TRUE(sahrs.attitude().valid);
}

INSTANTIATE_TEST_SUITE_P(FromLowestToHighest, AtRate, testing::Values(30.0, 100.0, 400.0, 1000.0));

TEST_F(PaperSahrsTest, TellsWhichMeasurementsItUsed) {
  start_at_truth();
  fly(flight_, sahrs_, 60.0);
  while (!flight_.slow_sensors_due()) {
    flight_.step();
    frame(flight_, sahrs_);
  }
  EXPECT_EQ(sahrs_.attitude().used | sahrs_.attitude().rejected, 31);
  for (int row = 0; row < PaperSahrs::kRows; ++row) {
    EXPECT_GT(sahrs_.innovation_sigma()[static_cast<std::size_t>(row)], 0.0);
  }
}

}  // namespace
}  // namespace lodestar::sahrs_test
