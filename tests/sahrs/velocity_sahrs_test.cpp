// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/velocity_sahrs.h"

#include <gtest/gtest.h>

#include "../strapdown/simulated_flight.h"
#include "fly.h"

namespace lodestar::sahrs_test {
namespace {

using math::kDegree;
using sahrs::VelocitySahrs;
using samples::AttitudeMode;
using strapdown::SimulatedFlight;

double error(const SimulatedFlight& flight, const VelocitySahrs& sahrs) {
  return math::log_quaternion(sahrs.attitude().q_NB.conjugate() * Eigen::Quaterniond(flight.C_NB()))
      .norm();
}

/// Flies for `duration` (s); `look` sees every frame after it was answered.
template <class Look>
void fly_on(SimulatedFlight& flight, VelocitySahrs& sahrs, double duration, Look look) {
  const std::int64_t end_us = flight.time_us() + std::llround(1e6 * duration);
  for (bool slow = true; flight.time_us() < end_us; slow = !slow) {
    flight.advance();
    sahrs.propagate(flight.rates());
    sahrs.update(flight.load_factor());
    if (slow) {
      sahrs.update(flight.field());
      sahrs.update(flight.air_data());
    }
    sahrs.finish_frame();
    look();
  }
}

VelocitySahrs somewhere() {
  VelocitySahrs sahrs({}, {}, {}, earth::GeomagneticKind::kIgrf14, FlightGenerator::kYear);
  sahrs.set_position(SimulatedFlight::kLat, 16.0 * kDegree, SimulatedFlight::kHeight);
  return sahrs;
}

struct Start {
  const char* name;
  double roll;
};
class FromAnyAttitude : public testing::TestWithParam<Start> {};

TEST_P(FromAnyAttitude, AlignsByItselfSaysSoAndIsValidOnlyWhileSigmaIsSmall) {
  std::mt19937 generator(11);
  SimulatedFlight flight(GetParam().roll, 0.0, 1.0, strapdown::SensorErrors::fighter(generator), 5);
  VelocitySahrs sahrs = somewhere();
  const sahrs::Parameters limits;
  bool waited = false;
  fly_on(flight, sahrs, 240.0, [&] {
    const samples::Attitude& a = sahrs.attitude();
    waited |= a.mode == AttitudeMode::kWaiting && !a.valid;
    if (!a.valid) return;
    const Eigen::Matrix3d C_NB = a.q_NB.toRotationMatrix();
    const Eigen::Vector3d sigma_N =
        (C_NB * a.P_B * C_NB.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
    EXPECT_LE(sigma_N.head<2>().maxCoeff(), limits.max_valid_tilt_sigma + 1e-9);
    EXPECT_LE(sigma_N.z(), limits.max_valid_heading_sigma + 1e-9);
  });
  EXPECT_TRUE(waited);
  EXPECT_EQ(sahrs.attitude().mode, AttitudeMode::kRunning);
  EXPECT_TRUE(sahrs.attitude().valid);
  EXPECT_EQ(sahrs.attitude().reset_count, 0);
  // 500 nT of hard iron turn heading by 2 degrees in straight flight, where they cannot be told.
  EXPECT_LT(error(flight, sahrs), 6.0 * kDegree);
}

INSTANTIATE_TEST_SUITE_P(Starts, FromAnyAttitude,
                         testing::Values(Start{"Level", 0.0}, Start{"InATurn", 45.0 * kDegree},
                                         Start{"InASteepTurn", -65.0 * kDegree},
                                         Start{"UpsideDown", 180.0 * kDegree}),
                         [](const auto& start) { return start.param.name; });

TEST(VelocitySahrs, StaysOrthonormalThroughAnHourAt100Hz) {
  VelocitySahrs sahrs = make_sahrs<VelocitySahrs>();
  sahrs.start({0.1, 0.2, 0.3}, Eigen::Vector3d::Constant(0.01), 0);
  for (std::int64_t k = 1; k <= 3600 * 100; ++k) {
    const double t = 0.01 * static_cast<double>(k);
    sahrs.propagate({k * 10'000, {0.5 * std::sin(t), 0.3 * std::cos(0.7 * t), 0.1}, true});
  }
  sahrs.finish_frame();
  const Eigen::Matrix3d C_NB = sahrs.attitude().q_NB.toRotationMatrix();
  EXPECT_LT((C_NB.transpose() * C_NB - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE(sahrs.filter().covariance().allFinite());
}

TEST(VelocitySahrs, FollowsABaroThatMovesToAnotherScale) {
  FlightGenerator flight(3);
  VelocitySahrs sahrs = make_sahrs<VelocitySahrs>();
  sahrs.start(flight.truth(), Eigen::Vector3d::Constant(0.5 * kDegree), 0);
  fly(flight, sahrs, 120.0);
  double worst = 0.0;
  int rejected = 0;
  for (int k = 0; k < 60 * 60; ++k) {
    flight.step();
    sahrs.propagate(flight.body_rates());
    sahrs.update(flight.load_factor());
    if (flight.slow_sensors_due()) {
      sahrs.update(flight.magnetic_field());
      samples::AirData air = flight.air_data();
      air.baro_altitude += 400.0;  // another pressure at the ground
      sahrs.update(air);
    }
    sahrs.finish_frame();
    worst = std::max(worst, error_B(flight, sahrs.attitude()).head<2>().norm());
    if ((sahrs.attitude().rejected >> strapdown::VelocityFilter::kBaro & 1) != 0) ++rejected;
  }
  EXPECT_GT(rejected, 30);
  EXPECT_LT(rejected, 120);  // 2 s, and what the gate lets go
  EXPECT_LT(worst, 2.0 * kDegree);
}

}  // namespace
}  // namespace lodestar::sahrs_test
