// SPDX-License-Identifier: Apache-2.0
// What both forms of SAHRS do.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "fly.h"

namespace lodestar::sahrs_test {
namespace {

using math::kDegree;
using sahrs::PaperSahrs;
using sahrs::VelocitySahrs;
using samples::AttitudeMode;
using samples::Use;

const sahrs::Covariance& covariance_of(const PaperSahrs& sahrs) { return sahrs.covariance(); }
const strapdown::Covariance& covariance_of(const VelocitySahrs& sahrs) {
  return sahrs.filter().covariance();
}

template <class Form>
class SahrsForms : public testing::Test {
 protected:
  void start_at_truth(double sigma = 1.0 * kDegree) {
    sahrs_.start(flight_.truth(), Eigen::Vector3d::Constant(sigma), flight_.time_us());
  }
  double error() const { return error_B(flight_, sahrs_.attitude()).norm(); }

  FlightGenerator flight_{1};
  Form sahrs_ = make_sahrs<Form>();
};
using Forms = testing::Types<PaperSahrs, VelocitySahrs>;
TYPED_TEST_SUITE(SahrsForms, Forms);

TYPED_TEST(SahrsForms, WaitsForItsSensorsThenAlignsThenRuns) {
  fly(this->flight_, this->sahrs_, 3.0);
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kWaiting);
  EXPECT_FALSE(this->sahrs_.attitude().valid);
  fly(this->flight_, this->sahrs_, 30.0);
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(this->sahrs_.attitude().valid);
  EXPECT_EQ(this->sahrs_.attitude().reset_count, 0);
}

TYPED_TEST(SahrsForms, ReachesTheTruthWithPerfectSensors) {
  FlightGenerator flight(2, 0.0);
  fly(flight, this->sahrs_, 300.0);
  double worst = 0.0;
  fly(flight, this->sahrs_, 600.0,
      [&] { worst = std::max(worst, error_B(flight, this->sahrs_.attitude()).norm()); });
  // What V' = 0 leaves out of the roll measurement while the aircraft rolls in and out of turns.
  EXPECT_LT(worst, 1.0 * kDegree);
}

TYPED_TEST(SahrsForms, TakesAGivenAttitudeInPlaceOfTheAlignment) {
  this->start_at_truth();
  frame(this->flight_, this->sahrs_);
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(this->sahrs_.attitude().valid);
  EXPECT_LT(this->error(), 1.0 * kDegree);
}

TYPED_TEST(SahrsForms, SameSamplesGiveTheSameBits) {
  FlightGenerator twin(1);
  TypeParam other = make_sahrs<TypeParam>();
  fly(this->flight_, this->sahrs_, 60.0);
  fly(twin, other, 60.0);
  EXPECT_EQ(this->sahrs_.attitude().q_NB.coeffs(), other.attitude().q_NB.coeffs());
  EXPECT_EQ(covariance_of(this->sahrs_), covariance_of(other));
}

TYPED_TEST(SahrsForms, TakesTheRotationOfTheEarthOffTheRates) {
  const math::Euler attitude{0.0, 0.0, 1.0};
  this->sahrs_.start(attitude, Eigen::Vector3d::Constant(0.01), 0);
  const Eigen::Vector3d omega_B =
      math::C_NB_from_euler(attitude).transpose() * earth::earth_rate_N(FlightGenerator::kLat);
  for (std::int64_t k = 1; k <= 3600 * 60; ++k) this->sahrs_.propagate({k * 16'667, omega_B, true});
  this->sahrs_.finish_frame();
  EXPECT_NEAR(this->sahrs_.attitude().heading, 1.0, 1e-9);  // 15 degrees otherwise
  EXPECT_NEAR(this->sahrs_.attitude().roll, 0.0, 1e-9);
}

TYPED_TEST(SahrsForms, AppliesALateMeasurementAtItsOwnTime) {
  // All but the rates arrive 0.5 s late, in a flight full of turns.
  TypeParam late = make_sahrs<TypeParam>();
  late.start(this->flight_.truth(), Eigen::Vector3d::Constant(1.0 * kDegree),
             this->flight_.time_us());
  this->start_at_truth();
  struct Slow {
    samples::LoadFactor load;
    samples::MagneticField field;
    samples::AirData air;
  };
  std::vector<Slow> waiting;
  double worst = 0.0;
  for (int k = 0; k < 60 * 300; ++k) {
    this->flight_.step();
    const samples::BodyRates rates = this->flight_.body_rates();
    waiting.push_back(
        {this->flight_.load_factor(), this->flight_.magnetic_field(), this->flight_.air_data()});
    this->sahrs_.propagate(rates);
    this->sahrs_.update(waiting.back().load);
    this->sahrs_.update(waiting.back().field);
    this->sahrs_.update(waiting.back().air);
    this->sahrs_.finish_frame();
    late.propagate(rates);
    if (k >= 30) {
      const Slow& slow = waiting[static_cast<std::size_t>(k - 30)];
      late.update(slow.load);
      const Use use = late.update(slow.field);
      // The velocity form starts its history with the first air data.
      if (k >= 60) {
        EXPECT_NE(use, Use::kHeld);
      }
      late.update(slow.air);
    }
    late.finish_frame();
    const Eigen::Quaterniond difference =
        this->sahrs_.attitude().q_NB.conjugate() * late.attitude().q_NB;
    if (k > 60 * 60) worst = std::max(worst, math::log_quaternion(difference).norm());
  }
  EXPECT_LT(worst, 1.0 * kDegree);  // half a second of a turn alone is 1 to 2 degrees
}

TYPED_TEST(SahrsForms, AlignsOnLateMeasurementsToo) {
  FlightGenerator flight(2, 0.0);
  std::vector<samples::LoadFactor> loads;
  std::vector<samples::MagneticField> fields;
  std::vector<samples::AirData> airs;
  for (std::size_t k = 0; k < 60 * 19; ++k) {
    flight.step();
    loads.push_back(flight.load_factor());
    fields.push_back(flight.magnetic_field());
    airs.push_back(flight.air_data());
    this->sahrs_.propagate(flight.body_rates());
    if (k >= 48) {  // 0.8 s
      this->sahrs_.update(loads[k - 48]);
      this->sahrs_.update(fields[k - 48]);
      this->sahrs_.update(airs[k - 48]);
    }
    this->sahrs_.finish_frame();
  }
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_LT(error_B(flight, this->sahrs_.attitude()).norm(), 1.0 * kDegree);
}

TYPED_TEST(SahrsForms, HoldsAMeasurementFromBeforeItsHistory) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 1.0);
  samples::MagneticField old = this->flight_.magnetic_field();
  old.time_us -= 5'000'000;
  EXPECT_EQ(this->sahrs_.update(old), Use::kHeld);
}

TYPED_TEST(SahrsForms, BridgesAShortGapInTheRatesWithGrownCovariance) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 30.0);
  const double before = this->sahrs_.attitude().P_B.trace();
  for (int k = 0; k < 24; ++k) this->flight_.step();  // 0.4 s
  this->sahrs_.propagate(this->flight_.body_rates());
  this->sahrs_.finish_frame();
  EXPECT_GT(this->sahrs_.attitude().P_B.trace(), 1.5 * before);
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_EQ(this->sahrs_.attitude().reset_count, 0);
  EXPECT_LT(this->error(), 3.0 * this->sahrs_.attitude().sigma_B().norm());
}

TYPED_TEST(SahrsForms, RealignsAfterALongGapAndSaysSo) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 120.0);
  const Eigen::Vector3d gyro_bias_B = this->sahrs_.attitude().gyro_bias_B;
  for (int k = 0; k < 60 * 20; ++k) this->flight_.step();
  frame(this->flight_, this->sahrs_);
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRealigning);
  EXPECT_FALSE(this->sahrs_.attitude().valid);
  const Eigen::Quaterniond lost = this->sahrs_.attitude().q_NB;
  Eigen::Quaterniond found = lost;
  fly(this->flight_, this->sahrs_, 60.0, [&] {
    if (this->sahrs_.attitude().reset_count == 1 && found.coeffs() == lost.coeffs()) {
      found = this->sahrs_.attitude().q_NB;
    }
  });
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(this->sahrs_.attitude().valid);
  EXPECT_EQ(this->sahrs_.attitude().reset_count, 1);
  const Eigen::Vector3d delta_B = math::log_quaternion(lost.conjugate() * found);
  // The measurements of the frame of the reset come on top of it.
  EXPECT_LT((this->sahrs_.attitude().reset_delta_B - delta_B).norm(), 5.0 * kDegree);
  EXPECT_LT((this->sahrs_.attitude().gyro_bias_B - gyro_bias_B).norm(), 0.2 * kDegree);
}

TYPED_TEST(SahrsForms, CoastsOnTheGyrosAloneAndGoesOnAfterwards) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 120.0);
  const double sigma = this->sahrs_.attitude().sigma_B().norm();
  for (int k = 0; k < 60 * 60; ++k) {
    this->flight_.step();
    this->sahrs_.propagate(this->flight_.body_rates());
    this->sahrs_.finish_frame();
    if (k == 60) {
      EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
    }
  }
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kCoasting);
  EXPECT_GT(this->sahrs_.attitude().sigma_B().norm(), sigma);
  EXPECT_LT(this->error(), 3.0 * this->sahrs_.attitude().sigma_B().norm());
  fly(this->flight_, this->sahrs_, 30.0);
  EXPECT_EQ(this->sahrs_.attitude().mode, AttitudeMode::kRunning);
}

TYPED_TEST(SahrsForms, RealignsWhenItCoastedTooLongToKnowAnything) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 30.0);
  for (int k = 0; k < 60 * 3600; ++k) {
    this->flight_.step();
    this->sahrs_.propagate(this->flight_.body_rates());
  }
  this->sahrs_.finish_frame();
  EXPECT_FALSE(this->sahrs_.attitude().valid);
  fly(this->flight_, this->sahrs_, 120.0);
  EXPECT_TRUE(this->sahrs_.attitude().valid);
  EXPECT_EQ(this->sahrs_.attitude().reset_count, 1);
  EXPECT_LT(this->error(), 15.0 * kDegree);
}

TYPED_TEST(SahrsForms, DoubtsAHeadingThatTheFieldContradictsAndTakesItAnew) {
  this->flight_.fly_straight();
  math::Euler wrong = this->flight_.truth();
  wrong.heading = math::wrap_2pi(wrong.heading + 2.0);
  this->sahrs_.start(wrong, Eigen::Vector3d::Constant(1.0 * kDegree), this->flight_.time_us());
  fly(this->flight_, this->sahrs_, 9.0);
  EXPECT_TRUE(this->sahrs_.attitude().valid);  // a disturbance may pass
  EXPECT_EQ(this->sahrs_.attitude().rejected & 7, 7);
  fly(this->flight_, this->sahrs_, 25.0);
  EXPECT_FALSE(this->sahrs_.attitude().valid);
  EXPECT_LT(std::abs(math::wrap_pi(this->sahrs_.attitude().heading - wrong.heading)), 0.1);
  fly(this->flight_, this->sahrs_, 60.0);
  EXPECT_TRUE(this->sahrs_.attitude().valid);
  EXPECT_GE(this->sahrs_.attitude().reset_count, 1);
  EXPECT_NEAR(this->sahrs_.attitude().reset_delta_B.norm(), 2.0, 0.3);
  EXPECT_LT(this->error(), 10.0 * kDegree);
}

TYPED_TEST(SahrsForms, GatesASpikeOfTheFieldAndLeavesTheStateAlone) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 60.0);
  samples::MagneticField spike = this->flight_.magnetic_field();
  spike.b_B += Eigen::Vector3d(0.0, 20000.0, 0.0);
  const auto P = covariance_of(this->sahrs_);
  const Eigen::Quaterniond q_NB = this->sahrs_.attitude().q_NB;
  EXPECT_NE(this->sahrs_.update(spike), Use::kUsed);
  this->sahrs_.finish_frame();
  EXPECT_EQ(covariance_of(this->sahrs_), P);
  EXPECT_EQ(this->sahrs_.attitude().q_NB.coeffs(), q_NB.coeffs());
  EXPECT_EQ(this->sahrs_.attitude().rejected & 7, 7);
}

TYPED_TEST(SahrsForms, AMagnetNearbyNeitherTurnsTheHeadingNorMakesItDoubted) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 240.0);
  double worst = 0.0;
  for (int k = 0; k < 60 * 120; ++k) {
    this->flight_.step();
    this->sahrs_.propagate(this->flight_.body_rates());
    this->sahrs_.update(this->flight_.load_factor());
    if (this->flight_.slow_sensors_due()) {
      samples::MagneticField field = this->flight_.magnetic_field();
      field.b_B += Eigen::Vector3d::Constant(10500.0);  // nT
      this->sahrs_.update(field);
      this->sahrs_.update(this->flight_.air_data());
    }
    this->sahrs_.finish_frame();
    EXPECT_TRUE(this->sahrs_.attitude().valid);
    worst = std::max(worst, this->error());
  }
  const auto strength = static_cast<std::size_t>(sahrs::Assumption::kFieldStrength);
  EXPECT_GT(this->sahrs_.assumption_rejects()[strength], 100);
  EXPECT_EQ(this->sahrs_.attitude().reset_count, 0);
  EXPECT_LT(worst, 10.0 * kDegree);
}

TYPED_TEST(SahrsForms, AFrozenPitotIsLeftOutAndCounted) {
  this->start_at_truth();
  fly(this->flight_, this->sahrs_, 60.0);
  const double frozen = this->flight_.air_data().true_airspeed;
  const auto live = static_cast<std::size_t>(sahrs::Assumption::kLiveFlow);
  EXPECT_EQ(this->sahrs_.assumption_rejects()[live], 0);
  for (int k = 0; k < 60 * 10; ++k) {
    this->flight_.step();
    this->sahrs_.propagate(this->flight_.body_rates());
    this->sahrs_.update(this->flight_.load_factor());
    if (this->flight_.slow_sensors_due()) {
      samples::AirData air = this->flight_.air_data();
      air.true_airspeed = frozen;
      this->sahrs_.update(air);
    }
    this->sahrs_.finish_frame();
  }
  EXPECT_GE(this->sahrs_.assumption_rejects()[live], 30 * 9 - 2);  // all but the first second
}

TYPED_TEST(SahrsForms, AGyroAtTheEndOfItsRangeWidensSigma) {
  this->start_at_truth(0.1 * kDegree);
  fly(this->flight_, this->sahrs_, 30.0);
  const double before = this->sahrs_.attitude().sigma_B().x();
  for (int k = 0; k < 60; ++k) {
    this->flight_.step();
    samples::BodyRates rates = this->flight_.body_rates();
    rates.omega_B.x() = 15.0 * kDegree;
    this->sahrs_.propagate(rates);
    this->sahrs_.finish_frame();
  }
  EXPECT_GT(this->sahrs_.attitude().sigma_B().x(), before + 8.0 * kDegree);
}

TYPED_TEST(SahrsForms, AppliesTheCalibrationOfTheField) {
  sahrs::FieldCalibration calibration;
  calibration.matrix << 1.02, 0.01, 0.0, -0.01, 0.97, 0.02, 0.0, 0.01, 1.01;
  calibration.bias << 40000.0, -16000.0, 41000.0;  // nT: iron nearly as strong as the field
  TypeParam calibrated = make_sahrs<TypeParam>({}, calibration);
  FlightGenerator twin(1);
  fly(this->flight_, this->sahrs_, 60.0);
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
      this->sahrs_.attitude().q_NB.conjugate() * calibrated.attitude().q_NB;
  EXPECT_LT(math::log_quaternion(difference).norm(), 1e-9);
}

}  // namespace
}  // namespace lodestar::sahrs_test
