// SPDX-License-Identifier: Apache-2.0
#include "lodestar/strapdown/propagation.h"

#include <gtest/gtest.h>

#include "flight_points.h"

namespace lodestar::strapdown {
namespace {

/// Steps of central differences, of the size of each state's error.
StateVector steps() {
  StateVector h;
  part<3>(h, kAttitude).setConstant(1e-4);
  part<3>(h, kVelocity).setConstant(1e-2);
  h(kHeight.offset) = h(kBaroHeight.offset) = 1e-1;
  part<3>(h, kForceBias).setConstant(1e-3);
  part<9>(h, kGyroMatrix).setConstant(1e-4);
  part<3>(h, kGyroBias).setConstant(1e-4);
  part<3>(h, kFieldDrift).setConstant(1.0);
  part<3>(h, kGust).setConstant(1e-2);
  part<3>(h, kFieldBias).setConstant(1.0);
  part<9>(h, kFieldMatrix).setConstant(1e-4);
  h(kAirspeedScale.offset) = 1e-4;
  h(kAirspeedBias.offset) = 1e-2;
  part<2>(h, kFlowBias).setConstant(1e-4);
  part<2>(h, kFlowScale).setConstant(1e-4);
  return h;
}

Covariance numeric_transition(const FlightPoint& point, double dt) {
  const StateVector h = steps();
  Covariance Phi;
  for (int j = 0; j < kStates; ++j) {
    std::array<StateVector, 2> moved;
    Estimate nominal = point.x;
    move(nominal, point.omega_B, point.force_B, sweden(), dt);
    for (int side = 0; side < 2; ++side) {
      Estimate x = point.x;
      x.correct(StateVector::Unit(j) * (side == 0 ? h(j) : -h(j)));
      move(x, point.omega_B, point.force_B, sweden(), dt);
      moved[static_cast<std::size_t>(side)] = error_between(nominal, x);
    }
    Phi.col(j) = (moved[0] - moved[1]) / (2.0 * h(j));
  }
  return Phi;
}

Covariance transition_of(const FlightPoint& point, double dt) {
  Estimate x = point.x;
  const Step step = move(x, point.omega_B, point.force_B, sweden(), dt);
  Covariance Phi;
  for (int j = 0; j < kStates; ++j) {
    StateVector column = StateVector::Unit(j);
    propagate_error(column, step, sweden(), ProcessNoise{});
    Phi.col(j) = column;
  }
  return Phi;
}

TEST(Propagation, TransitionMatchesCentralDifferences) {
  for (const FlightPoint& point : flight_points()) {
    // The transition is second order in dt: over a short frame what is left is below 1e-6.
    const double dt = 1e-3;
    const Covariance numeric = numeric_transition(point, dt);
    const Covariance analytic = transition_of(point, dt);
    for (int i = 0; i < kStates; ++i) {
      for (int j = 0; j < kStates; ++j) {
        const double scale = std::max(1.0, std::abs(numeric(i, j)));
        EXPECT_NEAR(analytic(i, j), numeric(i, j), 1e-6 * scale)
            << point.name << " row " << i << " column " << j;
      }
    }
  }
}

}  // namespace
}  // namespace lodestar::strapdown
