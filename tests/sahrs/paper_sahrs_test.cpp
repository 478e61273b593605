// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/paper_sahrs.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

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
  PaperSahrs sahrs_ = make_sahrs();
};

TEST_F(PaperSahrsTest, WaitsForItsSensorsThenAlignsThenRuns) {
  fly(flight_, sahrs_, 3.0);
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kWaiting);
  EXPECT_FALSE(sahrs_.attitude().valid);
  fly(flight_, sahrs_, 30.0);
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(sahrs_.attitude().valid);
  EXPECT_EQ(sahrs_.attitude().reset_count, 0);
}

TEST_F(PaperSahrsTest, ReachesTheTruthWithPerfectSensors) {
  FlightGenerator flight(2, 0.0);
  fly(flight, sahrs_, 300.0);
  double worst = 0.0;
  fly(flight, sahrs_, 600.0,
      [&] { worst = std::max(worst, error_B(flight, sahrs_.attitude()).norm()); });
  // What V' = 0 leaves out of the roll measurement while the aircraft rolls in and out of turns.
  EXPECT_LT(worst, 1.0 * kDegree);
}

TEST_F(PaperSahrsTest, TakesAGivenAttitudeInPlaceOfTheAlignment) {
  start_at_truth();
  frame(flight_, sahrs_);
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(sahrs_.attitude().valid);
  EXPECT_LT(error(), 1.0 * kDegree);
}

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

TEST_F(PaperSahrsTest, SameSamplesGiveTheSameBits) {
  FlightGenerator twin(1);
  PaperSahrs other = make_sahrs();
  fly(flight_, sahrs_, 60.0);
  fly(twin, other, 60.0);
  EXPECT_EQ(sahrs_.attitude().q_NB.coeffs(), other.attitude().q_NB.coeffs());
  EXPECT_EQ(sahrs_.covariance(), other.covariance());
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

TEST_F(PaperSahrsTest, TakesTheRotationOfTheEarthOffTheRates) {
  const math::Euler attitude{0.0, 0.0, 1.0};
  sahrs_.start(attitude, Eigen::Vector3d::Constant(0.01), 0);
  const Eigen::Vector3d omega_B =
      math::C_NB_from_euler(attitude).transpose() * earth::earth_rate_N(FlightGenerator::kLat);
  for (std::int64_t k = 1; k <= 3600 * 60; ++k) sahrs_.propagate({k * 16'667, omega_B, true});
  sahrs_.finish_frame();
  EXPECT_NEAR(sahrs_.attitude().heading, 1.0, 1e-9);  // 15 degrees otherwise
  EXPECT_NEAR(sahrs_.attitude().roll, 0.0, 1e-9);
}

class AtRate : public testing::TestWithParam<double> {};

TEST_P(AtRate, EstimatesWellAtAnyRateOfTheBodyRates) {
  FlightGenerator flight(4, 1.0, GetParam());
  PaperSahrs sahrs = make_sahrs();
  fly(flight, sahrs, 120.0);
  double worst = 0.0;
  fly(flight, sahrs, 60.0,
      [&] { worst = std::max(worst, error_B(flight, sahrs.attitude()).norm()); });
  EXPECT_LT(worst, 5.0 * kDegree);
  EXPECT_TRUE(sahrs.attitude().valid);
}

INSTANTIATE_TEST_SUITE_P(FromLowestToHighest, AtRate, testing::Values(30.0, 100.0, 400.0, 1000.0));

TEST_F(PaperSahrsTest, AppliesALateMeasurementAtItsOwnTime) {
  // All but the rates arrive 0.5 s late, in a flight full of turns.
  PaperSahrs late = make_sahrs();
  late.start(flight_.truth(), Eigen::Vector3d::Constant(1.0 * kDegree), flight_.time_us());
  start_at_truth();
  struct Slow {
    samples::LoadFactor load;
    samples::MagneticField field;
    samples::AirData air;
  };
  std::vector<Slow> waiting;
  double worst = 0.0;
  for (int k = 0; k < 60 * 300; ++k) {
    flight_.step();
    const samples::BodyRates rates = flight_.body_rates();
    waiting.push_back({flight_.load_factor(), flight_.magnetic_field(), flight_.air_data()});
    sahrs_.propagate(rates);
    sahrs_.update(waiting.back().load);
    sahrs_.update(waiting.back().field);
    sahrs_.update(waiting.back().air);
    sahrs_.finish_frame();
    late.propagate(rates);
    if (k >= 30) {
      const Slow& slow = waiting[static_cast<std::size_t>(k - 30)];
      late.update(slow.load);
      EXPECT_NE(late.update(slow.field), Use::kHeld);
      late.update(slow.air);
    }
    late.finish_frame();
    const Eigen::Quaterniond difference = sahrs_.attitude().q_NB.conjugate() * late.attitude().q_NB;
    if (k > 60 * 60) worst = std::max(worst, math::log_quaternion(difference).norm());
  }
  EXPECT_LT(worst, 1.0 * kDegree);  // half a second of a turn alone is 1 to 2 degrees
}

TEST_F(PaperSahrsTest, AlignsOnLateMeasurementsToo) {
  FlightGenerator flight(2, 0.0);
  std::vector<samples::LoadFactor> loads;
  std::vector<samples::MagneticField> fields;
  std::vector<samples::AirData> airs;
  for (std::size_t k = 0; k < 60 * 19; ++k) {
    flight.step();
    loads.push_back(flight.load_factor());
    fields.push_back(flight.magnetic_field());
    airs.push_back(flight.air_data());
    sahrs_.propagate(flight.body_rates());
    if (k >= 48) {  // 0.8 s
      sahrs_.update(loads[k - 48]);
      sahrs_.update(fields[k - 48]);
      sahrs_.update(airs[k - 48]);
    }
    sahrs_.finish_frame();
  }
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_LT(error_B(flight, sahrs_.attitude()).norm(), 1.0 * kDegree);
}

TEST_F(PaperSahrsTest, HoldsAMeasurementFromBeforeItsHistory) {
  start_at_truth();
  fly(flight_, sahrs_, 1.0);
  samples::MagneticField old = flight_.magnetic_field();
  old.time_us -= 5'000'000;
  EXPECT_EQ(sahrs_.update(old), Use::kHeld);
}

TEST_F(PaperSahrsTest, BridgesAShortGapInTheRatesWithGrownCovariance) {
  start_at_truth();
  fly(flight_, sahrs_, 30.0);
  const double before = sahrs_.attitude().P_B.trace();
  for (int k = 0; k < 24; ++k) flight_.step();  // 0.4 s
  sahrs_.propagate(flight_.body_rates());
  sahrs_.finish_frame();
  EXPECT_GT(sahrs_.attitude().P_B.trace(), 1.5 * before);
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_EQ(sahrs_.attitude().reset_count, 0);
  EXPECT_LT(error(), 3.0 * sahrs_.attitude().sigma_B().norm());
}

TEST_F(PaperSahrsTest, RealignsAfterALongGapAndSaysSo) {
  start_at_truth();
  fly(flight_, sahrs_, 120.0);
  const Eigen::Vector3d gyro_bias_B = sahrs_.attitude().gyro_bias_B;
  for (int k = 0; k < 60 * 20; ++k) flight_.step();
  frame(flight_, sahrs_);
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRealigning);
  EXPECT_FALSE(sahrs_.attitude().valid);
  const Eigen::Quaterniond lost = sahrs_.attitude().q_NB;
  Eigen::Quaterniond found = lost;
  fly(flight_, sahrs_, 60.0, [&] {
    if (sahrs_.attitude().reset_count == 1 && found.coeffs() == lost.coeffs()) {
      found = sahrs_.attitude().q_NB;
    }
  });
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(sahrs_.attitude().valid);
  EXPECT_EQ(sahrs_.attitude().reset_count, 1);
  const Eigen::Vector3d delta_B = math::log_quaternion(lost.conjugate() * found);
  // The measurements of the frame of the reset come on top of it.
  EXPECT_LT((sahrs_.attitude().reset_delta_B - delta_B).norm(), 5.0 * kDegree);
  EXPECT_LT((sahrs_.attitude().gyro_bias_B - gyro_bias_B).norm(), 0.2 * kDegree);
}

TEST_F(PaperSahrsTest, CoastsOnTheGyrosAloneAndGoesOnAfterwards) {
  start_at_truth();
  fly(flight_, sahrs_, 120.0);
  const double sigma = sahrs_.attitude().sigma_B().norm();
  for (int k = 0; k < 60 * 60; ++k) {
    flight_.step();
    sahrs_.propagate(flight_.body_rates());
    sahrs_.finish_frame();
    if (k == 60) {
      EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
    }
  }
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kCoasting);
  EXPECT_GT(sahrs_.attitude().sigma_B().norm(), sigma);
  EXPECT_LT(error(), 3.0 * sahrs_.attitude().sigma_B().norm());
  fly(flight_, sahrs_, 30.0);
  EXPECT_EQ(sahrs_.attitude().mode, AttitudeMode::kRunning);
}

TEST_F(PaperSahrsTest, RealignsWhenItCoastedTooLongToKnowAnything) {
  start_at_truth();
  fly(flight_, sahrs_, 30.0);
  for (int k = 0; k < 60 * 3600; ++k) {
    flight_.step();
    sahrs_.propagate(flight_.body_rates());
  }
  sahrs_.finish_frame();
  EXPECT_FALSE(sahrs_.attitude().valid);
  fly(flight_, sahrs_, 120.0);
  EXPECT_TRUE(sahrs_.attitude().valid);
  EXPECT_EQ(sahrs_.attitude().reset_count, 1);
  EXPECT_LT(error(), 15.0 * kDegree);
}

TEST_F(PaperSahrsTest, DoubtsAHeadingThatTheFieldContradictsAndTakesItAnew) {
  flight_.fly_straight();
  math::Euler wrong = flight_.truth();
  wrong.heading = math::wrap_2pi(wrong.heading + 2.0);
  sahrs_.start(wrong, Eigen::Vector3d::Constant(1.0 * kDegree), flight_.time_us());
  fly(flight_, sahrs_, 9.0);
  EXPECT_TRUE(sahrs_.attitude().valid);  // a disturbance may pass
  EXPECT_EQ(sahrs_.attitude().rejected & 7, 7);
  fly(flight_, sahrs_, 25.0);
  EXPECT_FALSE(sahrs_.attitude().valid);
  EXPECT_LT(std::abs(math::wrap_pi(sahrs_.attitude().heading - wrong.heading)), 0.1);
  fly(flight_, sahrs_, 60.0);
  EXPECT_TRUE(sahrs_.attitude().valid);
  EXPECT_GE(sahrs_.attitude().reset_count, 1);
  EXPECT_NEAR(sahrs_.attitude().reset_delta_B.norm(), 2.0, 0.3);
  EXPECT_LT(error(), 10.0 * kDegree);
}

TEST_F(PaperSahrsTest, GatesASpikeOfTheFieldAndLeavesTheStateAlone) {
  start_at_truth();
  fly(flight_, sahrs_, 60.0);
  samples::MagneticField spike = flight_.magnetic_field();
  spike.b_B += Eigen::Vector3d(0.0, 20000.0, 0.0);
  const sahrs::Covariance P = sahrs_.covariance();
  const Eigen::Quaterniond q_NB = sahrs_.attitude().q_NB;
  EXPECT_EQ(sahrs_.update(spike), Use::kGated);
  sahrs_.finish_frame();
  EXPECT_EQ(sahrs_.covariance(), P);
  EXPECT_EQ(sahrs_.attitude().q_NB.coeffs(), q_NB.coeffs());
  EXPECT_EQ(sahrs_.attitude().rejected & 7, 7);
}

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

TEST_F(PaperSahrsTest, AppliesTheCalibrationOfTheField) {
  sahrs::FieldCalibration calibration;
  calibration.matrix << 1.02, 0.01, 0.0, -0.01, 0.97, 0.02, 0.0, 0.01, 1.01;
  calibration.bias << 40000.0, -16000.0, 41000.0;  // nT: iron nearly as strong as the field
  PaperSahrs calibrated({}, calibration, earth::GeomagneticKind::kIgrf14, FlightGenerator::kYear);
  calibrated.set_position(FlightGenerator::kLat, FlightGenerator::kLon, 2000.0);
  FlightGenerator twin(1);
  fly(flight_, sahrs_, 60.0);
  const Eigen::Matrix3d raw_from_true = calibration.matrix.inverse();
  for (int k = 0; k < 60 * 60; ++k) {
    twin.step();
    calibrated.propagate(twin.body_rates());
    calibrated.update(twin.load_factor());
    if (twin.slow_sensors_due()) {
      samples::MagneticField field = twin.magnetic_field();
      field.b_B = raw_from_true * (field.b_B - calibration.bias);
      calibrated.update(field);
      calibrated.update(twin.air_data());
    }
    calibrated.finish_frame();
  }
  const Eigen::Quaterniond difference =
      sahrs_.attitude().q_NB.conjugate() * calibrated.attitude().q_NB;
  EXPECT_LT(math::log_quaternion(difference).norm(), 1e-9);
}

}  // namespace
}  // namespace lodestar::sahrs_test
