// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <iostream>

#include "fly.h"

namespace lodestar::sahrs_test {
namespace {

using math::kDegree;

/// Errors of roll, pitch and heading against their sigma, over a Monte Carlo of flights.
struct Statistics {
  Eigen::Array3d square_sum = Eigen::Array3d::Zero();  // rad^2
  Eigen::Array3d worst = Eigen::Array3d::Zero();       // rad
  Eigen::Array3d within_1_sigma = Eigen::Array3d::Zero();
  Eigen::Array3d within_2_sigma = Eigen::Array3d::Zero();
  double nees = 0.0;
  double samples = 0.0;

  void add(const FlightGenerator& flight, const samples::Attitude& a) {
    const math::Euler t = flight.truth();
    const Eigen::Array3d error(math::wrap_pi(a.roll - t.roll), a.pitch - t.pitch,
                               math::wrap_pi(a.heading - t.heading));
    const double sin_roll = std::sin(a.roll), cos_roll = std::cos(a.roll);
    Eigen::Matrix3d euler_from_B;
    euler_from_B << 1.0, sin_roll * std::tan(a.pitch), cos_roll * std::tan(a.pitch),  //
        0.0, cos_roll, -sin_roll,                                                     //
        0.0, sin_roll / std::cos(a.pitch), cos_roll / std::cos(a.pitch);
    const Eigen::Array3d sigma =
        (euler_from_B * a.P_B * euler_from_B.transpose()).diagonal().array().sqrt();
    square_sum += error.square();
    worst = worst.max(error.abs());
    within_1_sigma += (error.abs() < sigma).cast<double>();
    within_2_sigma += (error.abs() < 2.0 * sigma).cast<double>();
    const Eigen::Vector3d phi = error_B(flight, a);
    nees += phi.dot(a.P_B.inverse() * phi);
    samples += 1.0;
  }

  void print(const char* name) const {
    const Eigen::IOFormat row(3, 0, " ", " ");
    std::cout << name << ", roll pitch heading: rms "
              << ((square_sum / samples).sqrt() / kDegree).transpose().format(row) << " deg, worst "
              << (worst / kDegree).transpose().format(row) << " deg, within 1 sigma "
              << (within_1_sigma / samples).transpose().format(row) << ", within 2 sigma "
              << (within_2_sigma / samples).transpose().format(row) << "; NEES / 3 "
              << nees / samples / 3.0 << '\n';
  }
};

Statistics monte_carlo(int flights, double duration, const SensorErrors& errors) {
  Statistics statistics;
  for (int seed = 1; seed <= flights; ++seed) {
    FlightGenerator flight(static_cast<unsigned>(seed), 1.0, 60.0, errors);
    sahrs::PaperSahrs sahrs = make_sahrs<sahrs::PaperSahrs>();
    fly(flight, sahrs, 60.0);
    fly(flight, sahrs, duration - 60.0, [&] { statistics.add(flight, sahrs.attitude()); });
  }
  return statistics;
}

class Consistency : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    calm_ = new Statistics(monte_carlo(24, 600.0, {}));
    calm_->print("calm air");
  }
  static void TearDownTestSuite() { delete calm_; }
  static Statistics* calm_;
};
Statistics* Consistency::calm_ = nullptr;

TEST_F(Consistency, ErrorsMeetTheRequirementForCalmFlight) {
  const Eigen::Array3d rms = (calm_->square_sum / calm_->samples).sqrt() / kDegree;
  EXPECT_LT(rms(0), 1.0);
  EXPECT_LT(rms(1), 1.0);
  EXPECT_LT(rms(2), 2.5);
  EXPECT_LT(calm_->worst(0), 10.0 * kDegree);
  EXPECT_LT(calm_->worst(1), 5.0 * kDegree);
}

TEST_F(Consistency, SigmaCoversTheErrors) {
  const Eigen::Array3d one = calm_->within_1_sigma / calm_->samples;
  const Eigen::Array3d two = calm_->within_2_sigma / calm_->samples;
  // 68 and 95 % ideally. 24 flights are 24 draws of the biases that most of the error comes from:
  // one binomial sigma of them is 10 and 5 points.
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(one(i), 0.55) << i;
    EXPECT_LT(one(i), 0.88) << i;
    EXPECT_GT(two(i), 0.88) << i;
  }
}

TEST_F(Consistency, TheNormalisedErrorIsThatOfThreeDegreesOfFreedom) {
  const double nees = calm_->nees / calm_->samples;
  // 95 % of the means of 24 draws of chi-square with three degrees of freedom.
  EXPECT_GT(nees, 2.0);
  EXPECT_LT(nees, 4.1);
}

TEST(ConsistencyInGusts, HoldsInUpAndDownDraughtsToo) {
  SensorErrors errors;
  errors.vertical_gust.sigma = 1.0;
  const Statistics gusty = monte_carlo(8, 600.0, errors);
  gusty.print("vertical gusts of 1 m/s");
  const Eigen::Array3d rms = (gusty.square_sum / gusty.samples).sqrt() / kDegree;
  EXPECT_LT(rms(0), 1.0);
  EXPECT_LT(rms(1), 1.0);
  EXPECT_LT(rms(2), 2.5);
  EXPECT_LT(gusty.nees / gusty.samples, 5.0);  // 8 draws: 97.5 % of their means lie below
}

}  // namespace
}  // namespace lodestar::sahrs_test
