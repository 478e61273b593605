// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/ground_swing.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <iostream>

#include "calibration_flight.h"

namespace lodestar::sahrs_test {
namespace {

/// How a synthetic swing goes: stops of 20 s on as many headings, evenly over `arc`.
struct Swing {
  int stops = 12;
  double arc = 2.0 * math::kPi;  // rad
  double tilt = 1.0 * kDegree;   // rad
  double noise_factor = 1.0;
};

struct Swung {
  GroundSwing result;
  Calibration truth;
};

Swung swing(unsigned seed, const Swing& how) {
  const FilterParameters errors;
  const SwingParameters parameters;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian;
  const auto normal = [&](double sigma) { return sigma * gaussian(random); };
  const auto normal3 = [&](double sigma) -> Eigen::Vector3d {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  };
  Swung swung{GroundSwing(parameters, errors), {}};
  swung.truth.x.head<3>() = normal3(1000.0);
  for (int i = 3; i < kCalibrationStates; ++i) swung.truth.x(i) = normal(parameters.element_sigma);
  swung.truth.x.segment<3>(kScale.offset).array() += normal(0.02);
  const math::Euler ins_error{normal(errors.ins_tilt_sigma), normal(errors.ins_tilt_sigma),
                              normal(errors.ins_heading_sigma)};
  const math::GaussMarkov drift{errors.drift_sigma, errors.drift_tau};
  const Eigen::Vector3d model_N(15600.0, 1700.0, 48500.0);
  const Eigen::Vector3d b_N = model_N + normal3(errors.field_model_sigma);
  Eigen::Vector3d slow = normal3(drift.sigma);
  constexpr double kInterval = 0.5;  // s
  for (int i = 0; i < how.stops * 40; ++i) {
    const double heading = how.arc * (i / 40) / how.stops;
    const math::Euler at{how.tilt, -how.tilt, heading};
    slow = drift.decay(kInterval) * slow + normal3(std::sqrt(drift.added_variance(kInterval)));
    const Eigen::Vector3d b_cal = math::C_NB_from_euler(at).transpose() * b_N + slow;
    const Eigen::Vector3d b_raw = swung.truth.matrix().inverse() * (b_cal - swung.truth.bias()) +
                                  normal3(how.noise_factor * errors.noise);
    const Eigen::Matrix3d C_NB = math::C_NB_from_euler(
        {at.roll + ins_error.roll, at.pitch + ins_error.pitch, at.heading + ins_error.heading});
    swung.result.add(500'000 * i, C_NB, b_raw, model_N);
  }
  return swung;
}

TEST(GroundSwing, FindsTheBiasAndOneScaleWithinTheirSigma) {
  constexpr int kSwings = 60;
  double sum = 0.0;
  double horizontal = 0.0;
  for (unsigned seed = 1; seed <= kSwings; ++seed) {
    const Swung s = swing(seed, {});
    EXPECT_EQ(s.result.verdict(), SwingVerdict::kGood) << seed;
    sum += normalised_error(s.result.calibration(), s.truth);
    const StateVector error = s.result.calibration().x - s.truth.x;
    horizontal = std::max(horizontal, error.head<2>().cwiseAbs().maxCoeff());
  }
  std::cout << kSwings << " swings: NEES / 12 " << sum / kSwings / 12.0
            << ", largest error of the horizontal bias " << horizontal << " nT\n";
  // 95 % of the means of 60 draws of chi-square with twelve degrees.
  EXPECT_NEAR(sum / kSwings, 12.0, 1.96 * std::sqrt(24.0 / kSwings));
}

TEST(GroundSwing, GivesACommonScaleAndNoMisalignment) {
  const Calibration c = swing(1, {}).result.calibration();
  EXPECT_EQ(c.x(kScale.offset), c.x(kScale.offset + 1));
  EXPECT_EQ(c.x(kScale.offset), c.x(kScale.offset + 2));
  EXPECT_TRUE(c.x.segment<kMisalignment.size>(kMisalignment.offset).isZero(0.0));
  EXPECT_TRUE(c.P.isApprox(c.P.transpose(), 0.0));
  EXPECT_EQ(c.P.llt().info(), Eigen::Success);
}

TEST(GroundSwing, CorrectsTheLevelFieldWithinItsSigma) {
  constexpr int kSwings = 60;
  const Eigen::Vector3d b_B = math::C_NB_from_euler({0.0, 0.0, 1.0}).transpose() *
                              Eigen::Vector3d(15600.0, 1700.0, 48500.0);
  double sum = 0.0;
  double before = 0.0;
  double after = 0.0;
  for (unsigned seed = 1; seed <= kSwings; ++seed) {
    const Swung s = swing(seed, {});
    const Calibration c = s.result.calibration();
    const Eigen::Vector3d b_raw = s.truth.matrix().inverse() * (b_B - s.truth.bias());
    const Eigen::Vector3d error = c.matrix() * b_raw + c.bias() - b_B;
    const auto J = jacobian(b_raw);
    const Eigen::Matrix3d P = J * c.P * J.transpose();
    sum += error.dot(P.inverse() * error);
    before += (b_raw - b_B).squaredNorm();
    after += error.squaredNorm();
  }
  // 95 % of the means of 60 draws of chi-square with three degrees.
  EXPECT_NEAR(sum / kSwings, 3.0, 1.96 * std::sqrt(6.0 / kSwings));
  EXPECT_LT(after, 0.01 * before);
}

TEST(GroundSwing, RefusesAnArcByName) {
  EXPECT_EQ(swing(1, {12, 0.5 * math::kPi}).result.verdict(), SwingVerdict::kHeadings);
  EXPECT_LE(swing(1, {12, 0.5 * math::kPi}).result.sectors(), 5);
}

TEST(GroundSwing, RefusesATiltedAircraftAndNoiseByName) {
  EXPECT_EQ(swing(1, {12, 2.0 * math::kPi, 7.0 * kDegree}).result.verdict(),
            SwingVerdict::kNoSamples);
  EXPECT_EQ(swing(1, {12, 2.0 * math::kPi, 0.0, 3.0}).result.verdict(), SwingVerdict::kGated);
  EXPECT_EQ(swing(1, {12, 2.0 * math::kPi, 0.0, 1.35}).result.verdict(), SwingVerdict::kResidual);
}

}  // namespace
}  // namespace lodestar::sahrs_test
