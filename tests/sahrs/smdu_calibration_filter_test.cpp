// SPDX-License-Identifier: Apache-2.0
#include "lodestar/sahrs/smdu_calibration_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "calibration_flight.h"

namespace lodestar::sahrs_test {
namespace {

TEST(SmduCalibrationFilter, ItsSigmaCoversTheErrorsOfAllTwelveStates) {
  constexpr int kFlights = 60;
  double sum = 0.0;
  StateVector squares = StateVector::Zero();
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    CalibrationSimulator simulator(seed, {}, {});
    CalibrationFilter filter = make_filter();
    fly(simulator, filter);
    EXPECT_EQ(filter.verdict(), Verdict::kGood) << seed;
    const Calibration estimate = filter.calibration();
    sum += normalised_error(estimate, simulator.truth());
    squares += (estimate.x - simulator.truth().x).cwiseQuotient(estimate.sigma()).cwiseAbs2();
  }
  std::cout << kFlights << " flights: NEES / 12 " << sum / kFlights / 12.0 << ", state by state "
            << (squares / kFlights).transpose() << '\n';
  // 95 % of the means of 60 draws of chi-square with twelve degrees: 12 +- 1.96 sqrt(24 / 60).
  EXPECT_NEAR(sum / kFlights, 12.0, 1.96 * std::sqrt(24.0 / kFlights));
}

TEST(SmduCalibrationFilter, HoldsItsSigmaWithLargeErrorsToo) {
  constexpr int kFlights = 30;
  CalibrationFlight large;
  large.bias_sigma = 2000.0;
  large.matrix_sigma = 0.02;
  double sum = 0.0;
  for (unsigned seed = 101; seed < 101 + kFlights; ++seed) {
    CalibrationSimulator simulator(seed, large, {});
    CalibrationFilter filter = make_filter();
    fly(simulator, filter);
    sum += normalised_error(filter.calibration(), simulator.truth());
  }
  EXPECT_NEAR(sum / kFlights, 12.0, 1.96 * std::sqrt(24.0 / kFlights));
}

struct Case {
  const char* what;
  CalibrationFlight flight;
  Verdict verdict;
};

class OfAFlight : public testing::TestWithParam<Case> {};

TEST_P(OfAFlight, TheVerdictNamesWhatIsWrong) {
  CalibrationSimulator simulator(1, GetParam().flight, {});
  CalibrationFilter filter = make_filter();
  fly(simulator, filter);
  EXPECT_EQ(name(filter.verdict()), name(GetParam().verdict));
}

CalibrationFlight with(void (*change)(CalibrationFlight&)) {
  CalibrationFlight flight;
  change(flight);
  return flight;
}

INSTANTIATE_TEST_SUITE_P(
    SmduCalibrationFilter, OfAFlight,
    testing::Values(
        Case{"good", {}, Verdict::kGood},
        Case{"short", with([](auto& f) { f.duration = 500.0; }), Verdict::kTooShort},
        Case{"straight", with([](auto& f) { f.turns = false; }), Verdict::kNotObservable},
        Case{"flat turns", with([](auto& f) {
               f.bank_max = 3.0 * kDegree;
               f.pitch_max = 0.5 * kDegree;
             }),
             Verdict::kNotObservable},
        Case{"slow error twice as large", with([](auto& f) { f.drift_factor = 2.0; }),
             Verdict::kNotWhite},
        Case{"noise half as large again", with([](auto& f) { f.white_factor = 1.3; }),
             Verdict::kResidual},
        Case{"noise twice as large", with([](auto& f) { f.white_factor = 2.0; }), Verdict::kGated},
        Case{"INS late by 0.1 s", with([](auto& f) { f.ins_offset = 0.1; }), Verdict::kGated},
        Case{"never off the ground", with([](auto& f) { f.speed = 10.0; }), Verdict::kNoReference}),
    [](const auto& info) {
      std::string text = info.param.what;
      std::replace_if(text.begin(), text.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
      return text;
    });

TEST(SmduCalibrationFilter, SaysHowFarItIs) {
  CalibrationSimulator simulator(1, {}, {});
  CalibrationFilter filter = make_filter();
  EXPECT_EQ(filter.status(0).state, samples::CalibrationState::kIdle);
  EXPECT_EQ(filter.verdict(), Verdict::kNoReference);
  feed(simulator, filter);
  feed(simulator, filter);
  EXPECT_EQ(filter.status(0).state, samples::CalibrationState::kRunning);
  fly(simulator, filter);
  const samples::SmduCalibration status = filter.status(7);
  EXPECT_EQ(status.time_us, 7);
  EXPECT_EQ(status.state, samples::CalibrationState::kObservable);
  EXPECT_EQ(status.x, filter.calibration().x);
  EXPECT_EQ(status.sigma, filter.calibration().sigma());
}

TEST(SmduCalibrationFilter, RefusesTheFlightOnceTheInsHasFailed) {
  CalibrationSimulator simulator(1, {}, {});
  CalibrationFilter filter = make_filter();
  filter.fail_ins();  // before take-off, while it aligns: no harm
  fly(simulator, filter);
  EXPECT_EQ(filter.verdict(), Verdict::kGood);
  const StateVector before = filter.calibration().x;
  filter.fail_ins();
  EXPECT_EQ(filter.verdict(), Verdict::kInsFailed);
  EXPECT_EQ(filter.status(0).state, samples::CalibrationState::kRefused);
  for (int i = 0; i < 100; ++i) feed(simulator, filter);
  EXPECT_EQ(filter.calibration().x, before);
  EXPECT_EQ(filter.verdict(), Verdict::kInsFailed);
}

TEST(SmduCalibrationFilter, TakesLongSilenceOfTheInsForItsFailureAndBridgesAShortOne) {
  for (const double silence : {4.0, 6.0}) {
    CalibrationSimulator simulator(1, {}, {});
    CalibrationFilter filter = make_filter();
    for (int i = 0; i < 800; ++i) feed(simulator, filter);
    for (double t = 0.0; t < silence; t += 0.125) {
      simulator.step();
      filter.update(simulator.magnetic_field());
    }
    fly(simulator, filter);
    EXPECT_EQ(filter.verdict(), silence > 5.0 ? Verdict::kInsFailed : Verdict::kGood);
  }
}

TEST(SmduCalibrationFilter, DoesNothingWhenSwitchedOff) {
  FilterParameters off;
  off.enabled = false;
  CalibrationSimulator simulator(1, {}, {});
  CalibrationFilter filter = make_filter(off);
  fly(simulator, filter);
  EXPECT_EQ(filter.verdict(), Verdict::kDisabled);
  EXPECT_EQ(filter.status(0).state, samples::CalibrationState::kIdle);
  EXPECT_TRUE(filter.calibration().x.isZero(0.0));
}

TEST(SmduCalibrationFilter, WaitsForAnInsThatIsLateOnTheBus) {
  CalibrationSimulator simulator(1, {}, {});
  CalibrationFilter prompt = make_filter();
  CalibrationFilter patient = make_filter();
  std::vector<samples::InsSolution> on_the_way;
  for (int i = 0; i < 2000; ++i) {
    simulator.step();
    const samples::MagneticField field = simulator.magnetic_field();
    prompt.update(field);
    prompt.update(simulator.ins());
    patient.update(field);
    on_the_way.push_back(simulator.ins());
    if (i >= 2) patient.update(on_the_way[static_cast<std::size_t>(i - 2)]);
  }
  EXPECT_GT(patient.checks().duration, 240.0);
  EXPECT_LT(patient.checks().gated, 0.002);
  EXPECT_GT(prompt.checks().duration, 240.0);
}

TEST(SmduCalibrationFilter, OneOutlierChangesNothing) {
  CalibrationSimulator simulator(1, {}, {});
  CalibrationFilter filter = make_filter();
  for (int i = 0; i < 801; ++i) feed(simulator, filter);
  const StateVector before = filter.calibration().x;
  for (int i = 0; i < 2; ++i) {  // one of them is due
    simulator.step();
    samples::MagneticField field = simulator.magnetic_field();
    field.b_B.x() += 3000.0;
    filter.update(field);
    filter.update(simulator.ins());
  }
  EXPECT_EQ(filter.calibration().x, before);
  EXPECT_GT(filter.checks().gated, 0.0);
}

TEST(InsHistory, GivesTheAttitudeBetweenTwoSolutions) {
  InsHistory history;
  Eigen::Matrix3d C_NB;
  EXPECT_FALSE(history.attitude_at(0, C_NB));
  samples::InsSolution s;
  s.time_us = 100'000;
  s.heading = 359.0 * kDegree;
  history.push(s);
  EXPECT_TRUE(history.attitude_at(100'000, C_NB));
  EXPECT_FALSE(history.attitude_at(90'000, C_NB));
  EXPECT_FALSE(history.attitude_at(110'000, C_NB));
  s.time_us = 200'000;
  s.heading = 1.0 * kDegree;
  history.push(s);
  ASSERT_TRUE(history.attitude_at(175'000, C_NB));
  EXPECT_TRUE(C_NB.isApprox(math::C_NB_from_euler({0.0, 0.0, 0.5 * kDegree}), 1e-12));
  s.time_us = 300'000;
  history.push(s);
  ASSERT_TRUE(history.attitude_at(175'000, C_NB));  // of a detector that is late itself
  EXPECT_TRUE(C_NB.isApprox(math::C_NB_from_euler({0.0, 0.0, 0.5 * kDegree}), 1e-12));
  s.time_us = 600'000;  // too long a way to know what was between
  history.push(s);
  EXPECT_FALSE(history.attitude_at(400'000, C_NB));
}

TEST(InsHistory, TurnsEulerErrorsIntoARotationOfB) {
  for (const math::Euler e : {math::Euler{0.1, 0.2, 0.3}, math::Euler{-2.5, -1.0, 4.0},
                              math::Euler{0.0, 0.0, 0.0}, math::Euler{1.5, 1.3, 6.0}}) {
    const Eigen::Matrix3d C_NB = math::C_NB_from_euler(e);
    const Eigen::Matrix3d E = rotation_from_euler_errors(C_NB);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
      const auto turned = [&](double sign) {
        return math::C_NB_from_euler(
            {e.roll + sign * d.x(), e.pitch + sign * d.y(), e.heading + sign * d.z()});
      };
      const Eigen::Matrix3d turn = turned(-1.0).transpose() * turned(1.0);
      const Eigen::Vector3d phi = math::log_quaternion(Eigen::Quaterniond(turn)) / (2.0 * kStep);
      EXPECT_TRUE(phi.isApprox(E.col(i), 1e-6)) << i;
    }
  }
}

TEST(SmduCalibration, JacobianIsTheDerivative) {
  Calibration c;
  c.x << 100.0, -200.0, 300.0, 0.01, -0.02, 0.03, 0.001, -0.002, 0.003, -0.004, 0.005, -0.006;
  const Eigen::Vector3d b_raw(15e3, -3e3, 47e3);
  const auto calibrated = [&](const Calibration& at) -> Eigen::Vector3d {
    return at.matrix() * b_raw + at.bias();
  };
  for (int i = 0; i < kCalibrationStates; ++i) {
    Calibration up = c;
    Calibration down = c;
    up.x(i) += 0.5;
    down.x(i) -= 0.5;  // linear in x: the step does not matter
    EXPECT_TRUE((calibrated(up) - calibrated(down)).isApprox(jacobian(b_raw).col(i), 1e-6)) << i;
  }
}

TEST(SmduCalibration, SpreadTellsBiasFromMatrix) {
  StateMatrix P = StateMatrix::Zero();
  P.diagonal().setConstant(4e-6);
  P.diagonal().head<3>().setConstant(900.0);
  const Spread independent = spread(P);
  EXPECT_DOUBLE_EQ(independent.bias, 30.0);
  EXPECT_DOUBLE_EQ(independent.matrix, 0.002);
  // A bias that moves with D_xz, D_yz, D_zz as it does where b_z is always 45 000 nT.
  for (int i = 0; i < 3; ++i) {
    const int j = state_of_D(i, 2);
    P(i, j) = P(j, i) = -45e3 * P(j, j);
    P(i, i) = 900.0 + 45e3 * 45e3 * P(j, j);
  }
  const Spread together = spread(P);
  EXPECT_NEAR(together.bias, 30.0, 1e-6);
  EXPECT_DOUBLE_EQ(together.matrix, 0.002);
}

}  // namespace
}  // namespace lodestar::sahrs_test
