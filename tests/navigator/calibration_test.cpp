// SPDX-License-Identifier: Apache-2.0
// The calibration of the magnetic detector through the navigator.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lodestar/navigator/navigator.h"

namespace lodestar::navigator {
namespace {

using sahrs::smdu::Verdict;

/// Turns with bank at 200 m/s with an INS; the detector has a bias of (500, -300, 200) nT.
class TurningFlight {
 public:
  explicit TurningFlight(const Config& config = {}) : navigator_(config) {
    earth::GeomagneticModel model(earth::GeomagneticKind::kIgrf14);
    b_N_ = model.field_N(1.0, 0.28, 3000.0, config.earth.epoch_year);
  }

  const Navigator& navigator() const { return navigator_; }
  const Outputs& outputs() const { return *outputs_; }

  void fly(double seconds, bool ins_valid = true, bool ins_frozen = false) {
    for (const double end = time_ + seconds; time_ < end; time_ += 0.1) {
      const double t = ins_frozen ? 0.0 : time_;
      const std::int64_t time_us = std::llround(1e6 * time_);
      const math::Euler e = attitude(time_);
      const Eigen::Matrix3d C_NB = math::C_NB_from_euler(e);
      navigator_.offer(samples::MagneticField{
          time_us, C_NB.transpose() * b_N_ - Eigen::Vector3d(500.0, -300.0, 200.0) + noise3(80.0),
          true});
      samples::InsSolution ins;
      ins.time_us = time_us;
      ins.roll = attitude(t).roll;
      ins.pitch = attitude(t).pitch;
      ins.heading = math::wrap_2pi(attitude(t).heading);
      ins.lat = 1.0;
      ins.lon = 0.28;
      ins.h = 3000.0;
      ins.v_N = {200.0, 0.0, 0.0};
      ins.valid = ins_valid;
      navigator_.offer(ins);
      outputs_ = navigator_.step({time_us, noise3(1e-3), true});
    }
  }

 private:
  static math::Euler attitude(double t) {
    return {0.8 * std::sin(0.05 * t), 0.2 * std::sin(0.11 * t), 0.06 * t};
  }
  Eigen::Vector3d noise3(double sigma) {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return sigma * Eigen::Vector3d(x, y, z);
  }

  Navigator navigator_;
  const Outputs* outputs_ = nullptr;
  Eigen::Vector3d b_N_;
  double time_ = 0.0;
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
};

TEST(NavigatorCalibration, FindsTheBiasAndOffersItForTheNextFlight) {
  Config config;
  config.airframe.id = "39-101";
  TurningFlight flight(config);
  flight.fly(700.0);
  const CalibrationResult result = flight.navigator().calibration_result();
  EXPECT_EQ(result.verdict, Verdict::kGood);
  EXPECT_EQ(result.record.airframe, "39-101");
  EXPECT_EQ(result.record.epoch_year, config.earth.epoch_year);
  EXPECT_NEAR(1e-6 * static_cast<double>(result.record.time_us), 700.0, 1.0);
  const Eigen::Vector3d error =
      result.record.calibration.bias() - Eigen::Vector3d(500.0, -300.0, 200.0);
  EXPECT_LT(error.cwiseQuotient(result.record.calibration.sigma().head<3>()).norm(), 4.0);
  EXPECT_EQ(flight.outputs().smdu_calibration.state, samples::CalibrationState::kObservable);
}

TEST(NavigatorCalibration, IsNotUsedInItsOwnFlight) {
  TurningFlight flight;
  flight.fly(700.0);
  EXPECT_EQ(flight.navigator().health().calibration_id, 0);
}

TEST(NavigatorCalibration, AnInsThatCallsItselfInvalidEndsIt) {
  TurningFlight flight;
  flight.fly(700.0);
  flight.fly(0.1, false);
  EXPECT_EQ(flight.navigator().calibration_result().verdict, Verdict::kInsFailed);
}

TEST(NavigatorCalibration, AFrozenInsEndsIt) {
  TurningFlight flight;
  flight.fly(700.0);
  flight.fly(2.0, true, true);
  EXPECT_EQ(flight.navigator().calibration_result().verdict, Verdict::kInsFailed);
}

TEST(NavigatorCalibration, AStoredOneBringsItsSigmaAndWhatMayHaveChanged) {
  sahrs::smdu::Record record;
  record.calibration.x(0) = 500.0;
  record.calibration.x(3) = 0.01;
  record.calibration.P.diagonal().setConstant(1e-6);
  record.calibration.P.diagonal().head<3>().setConstant(100.0 * 100.0);
  Config config;
  apply_calibration(config, record);
  EXPECT_EQ(config.smdu_calibration.bias, Eigen::Vector3d(500.0, 0.0, 0.0));
  EXPECT_EQ(config.smdu_calibration.matrix(0, 0), 1.01);
  EXPECT_DOUBLE_EQ(config.smdu_calibration.bias_sigma.value(), 125.0);
  EXPECT_DOUBLE_EQ(config.smdu_calibration.matrix_sigma.value(), std::sqrt(1e-6 + 0.25e-6));
  EXPECT_NE(calibration_id(config.smdu_calibration), 0u);
}

}  // namespace
}  // namespace lodestar::navigator
