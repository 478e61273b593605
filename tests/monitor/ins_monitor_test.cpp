// SPDX-License-Identifier: Apache-2.0
#include "lodestar/monitor/ins_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

namespace lodestar::monitor {
namespace {

using math::Euler;
using math::kDegree;
using samples::InsState;

constexpr std::int64_t kFrame = 20'000;  // us; the INS comes with every frame
constexpr double kTimeout = 0.5;         // s

/// SAHRS and INS as functions of time (s).
struct Scene {
  std::function<Euler(double)> sahrs = [](double) { return Euler{}; };
  std::function<Euler(double)> ins_error = [](double) { return Euler{}; };
  std::function<Euler(double)> flown;  // as SAHRS, if empty
  double sahrs_sigma = 0.3 * kDegree;
  std::int64_t latency_us = 0;
  bool sahrs_valid = true;
  bool ins_sends = true;

  InsMonitor monitor{{}, kTimeout};
  std::optional<TrustedHeading> failure;
  std::int64_t now_us = 0;
  int frame = 0;

  /// What the gyros have: of how SAHRS moves, or of `flown`, where SAHRS errs.
  Eigen::Vector3d omega_B(double t) const {
    constexpr double kStep = 1e-4;  // s
    const auto q = [&](double at) {
      return Eigen::Quaterniond(math::C_NB_from_euler(flown ? flown(at) : sahrs(at)));
    };
    return math::log_quaternion(q(t - kStep).conjugate() * q(t + kStep)) / (2.0 * kStep);
  }
  samples::Attitude attitude(std::int64_t time_us) const {
    samples::Attitude s;
    s.time_us = time_us;
    s.q_NB = Eigen::Quaterniond(math::C_NB_from_euler(sahrs(1e-6 * static_cast<double>(time_us))));
    s.omega_B = omega_B(1e-6 * static_cast<double>(time_us));
    s.P_B = sahrs_sigma * sahrs_sigma * Eigen::Matrix3d::Identity();
    s.valid = sahrs_valid;
    return s;
  }
  samples::InsSolution solution(std::int64_t time_us) const {
    const double t = 1e-6 * static_cast<double>(time_us);
    const Euler true_attitude = sahrs(t), error = ins_error(t);
    samples::InsSolution s;
    s.time_us = time_us;
    const double jitter = 1e-5 * std::sin(static_cast<double>(frame));
    s.roll = true_attitude.roll + error.roll + jitter;
    s.pitch = true_attitude.pitch + error.pitch + jitter;
    s.heading = math::wrap_2pi(true_attitude.heading + error.heading + jitter);
    return s;
  }
  /// Until `seconds`, or until the state is `stop`; the time (s) of the end.
  double fly(double seconds, std::optional<InsState> stop = std::nullopt) {
    while (1e-6 * static_cast<double>(now_us) < seconds) {
      now_us += kFrame;
      ++frame;
      monitor.propagate(attitude(now_us));
      if (ins_sends) monitor.compare(solution(now_us - latency_us));
      if (const auto failed = monitor.take_failure()) failure = failed;
      if (stop && state() == *stop) break;
    }
    return 1e-6 * static_cast<double>(now_us);
  }
  InsState state() const { return monitor.state().state; }
};

/// Degrees of roll, pitch and heading after `start` s, growing by so many per second.
std::function<Euler(double)> ramp(Euler rate_deg, double start) {
  return [=](double t) {
    const double dt = std::max(0.0, t - start) * kDegree;
    return Euler{rate_deg.roll * dt, rate_deg.pitch * dt, rate_deg.heading * dt};
  };
}

TEST(InsMonitor, ThereIsNothingToSayWithoutInsOrWithoutSahrs) {
  Scene scene;
  scene.ins_sends = false;
  scene.fly(2.0);
  EXPECT_EQ(scene.state(), InsState::kNone);
  scene.ins_sends = true;
  scene.sahrs_valid = false;
  scene.fly(4.0);
  EXPECT_EQ(scene.state(), InsState::kNone);
  EXPECT_EQ(scene.monitor.state().difference, Eigen::Vector3d::Zero());
}

TEST(InsMonitor, DifferenceIsInsMinusSahrsInRollPitchAndHeading) {
  Scene scene;
  scene.sahrs = [](double) { return Euler{0.0, 0.0, 359.5 * kDegree}; };
  scene.ins_error = [](double) { return Euler{0.4 * kDegree, -0.3 * kDegree, 1.0 * kDegree}; };
  scene.fly(1.0);
  const Eigen::Vector3d expected(0.4, -0.3, 1.0);
  // Rotations of a degree do not add up as numbers do: to second order in the angles.
  EXPECT_LT((scene.monitor.state().difference / kDegree - expected).norm(), 0.02);
  EXPECT_EQ(scene.state(), InsState::kAgree);
  // 6 sigma of INS and SAHRS together are less than the least thresholds.
  EXPECT_NEAR(scene.monitor.state().threshold(0), 2.5 * kDegree, 1e-12);
  // ... and those of a departure from the gyros, by half a sigma more, on top of where it has been.
  EXPECT_NEAR(scene.monitor.state().threshold(2),
              (1.0 + 3.5 + 0.5 * std::hypot(0.3, 0.2)) * kDegree, 0.02 * kDegree);
}

TEST(InsMonitor, ThresholdFollowsTheSigmaOfBoth) {
  Scene scene;
  scene.sahrs_sigma = 0.9 * kDegree;
  scene.fly(1.0);
  const double both = std::hypot(0.9, 0.2) * kDegree;
  // Of the least of 6 sigma, 2.5 sigma or 6.5 degrees of change, 3.5 and half a sigma of departure.
  EXPECT_NEAR(scene.monitor.state().threshold(2), 3.5 * kDegree + 0.5 * both, 1e-3 * kDegree);
}

TEST(InsMonitor, SmallDisagreementStaysSmallStraightUp) {
  Scene scene;
  scene.sahrs = [](double t) { return Euler{0.0, (80.0 + 9.9 * std::sin(t)) * kDegree, 0.0}; };
  scene.fly(1.0);
  // Near the vertical 40 degrees of heading and of roll, against each other, are nearly nothing.
  scene.ins_error = [](double) { return Euler{40.0 * kDegree, 0.0, 40.0 * kDegree}; };
  scene.sahrs = [](double) { return Euler{0.0, 89.9 * kDegree, 0.0}; };
  scene.fly(1.0 + 1e-6 * kFrame);
  EXPECT_LT(scene.monitor.state().difference.norm(), 0.1 * kDegree);
}

TEST(InsMonitor, SurvivesALoopWithAnInsThatIsRight) {
  Scene scene;
  const auto looping = [](double t) {
    const Eigen::Quaterniond q = math::exp_quaternion({0.0, 0.35 * t, 0.0});
    return math::euler_from_C_NB(q.toRotationMatrix());
  };
  scene.sahrs = looping;
  for (double t = 1.0; t < 40.0; t += 0.5) {
    scene.fly(t);
    ASSERT_EQ(scene.state(), InsState::kAgree) << t;
    ASSERT_LT(scene.monitor.state().difference.norm(), 0.01 * kDegree);
  }
}

struct RampCase {
  const char* name;
  Euler rate_deg;
  double worst_deg;
};

class Ramp : public testing::TestWithParam<RampCase> {};

TEST_P(Ramp, OfHalfADegreePerSecondIsFlaggedInTime) {
  Scene scene;
  scene.ins_error = ramp(GetParam().rate_deg, 60.0);
  scene.fly(60.0);
  ASSERT_EQ(scene.state(), InsState::kAgree);
  const double flagged = scene.fly(200.0, InsState::kMiscompare);
  EXPECT_LT(0.5 * (flagged - 60.0), GetParam().worst_deg);
  EXPECT_GT(scene.monitor.state().time_over.maxCoeff(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(InEachAxis, Ramp,
                         testing::Values(RampCase{"Roll", {0.5, 0.0, 0.0}, 5.0},
                                         RampCase{"Pitch", {0.0, -0.5, 0.0}, 5.0},
                                         RampCase{"Heading", {0.0, 0.0, 0.5}, 10.0}),
                         [](const auto& info) { return info.param.name; });

/// How far (deg) a heading ramp of `rate_deg` per second has come when it is told, while SAHRS,
/// whose own threshold is 12 degrees, has been `slow_deg` to the left of the INS for minutes.
double ramped_when_told(double slow_deg, double rate_deg) {
  Scene scene;
  scene.sahrs_sigma = 2.0 * kDegree;
  const auto ramped = ramp({0.0, 0.0, rate_deg}, 200.0);
  scene.ins_error = [&](double t) {
    Euler e = ramped(t);
    e.heading += slow_deg * kDegree;
    return e;
  };
  scene.fly(200.0);
  EXPECT_EQ(scene.state(), InsState::kAgree);
  return std::abs(rate_deg) * (scene.fly(300.0, InsState::kMiscompare) - 200.0);
}

TEST(InsMonitor, ARampAgainstASlowErrorOfSahrsIsFlaggedByTheChange) {
  EXPECT_LT(ramped_when_told(-4.0, 0.5), 10.0);
}

TEST(InsMonitor, ARampThatTakesBackALargeErrorOfSahrsIsFlagged) {
  EXPECT_LT(ramped_when_told(8.0, -0.5), 8.0);  // at first the INS seems to come nearer
}

TEST(InsMonitor, WhatSahrsCorrectsIsNoDepartureOfTheIns) {
  Scene scene;
  scene.sahrs_sigma = 1.5 * kDegree;
  scene.flown = [](double) { return Euler{}; };
  scene.sahrs = [](double t) { return Euler{0.0, 0.0, (t < 100.0 ? 0.0 : 5.0) * kDegree}; };
  scene.ins_error = [](double t) { return Euler{0.0, 0.0, (t < 100.0 ? 0.0 : -5.0) * kDegree}; };
  for (double t = 1.0; t < 300.0; t += 1.0) {
    scene.fly(t);
    ASSERT_EQ(scene.state(), InsState::kAgree) << t;
  }
}

TEST(InsMonitor, ARampThatSahrsFollowsIsFlaggedByTheGyros) {
  Scene scene;
  scene.sahrs_sigma = 1.5 * kDegree;
  scene.flown = [](double) { return Euler{}; };
  const auto pulled = ramp({0.0, 0.0, 0.45}, 100.0);  // by a magnet, say
  scene.sahrs = pulled;
  scene.ins_error = ramp({0.0, 0.0, 0.05}, 100.0);
  scene.fly(100.0);
  ASSERT_EQ(scene.state(), InsState::kAgree);
  EXPECT_LT(0.5 * (scene.fly(200.0, InsState::kMiscompare) - 100.0), 10.0);
}

TEST(InsMonitor, AfterAFalseAlarmByTheGyrosTheInsIsTrustedAgain) {
  Scene scene;
  scene.sahrs = [](double t) {
    return Euler{0.0, 0.0, (t < 100.0 ? 0.0 : 0.5 * (t - 100.0)) * kDegree};
  };
  scene.flown = [](double) { return Euler{}; };  // the gyros say nothing of a turn of 20 s
  const auto turn = scene.sahrs;
  scene.sahrs = [=](double t) { return turn(std::min(t, 120.0)); };
  scene.fly(140.0);
  ASSERT_EQ(scene.state(), InsState::kMiscompare);
  scene.fly(300.0);
  EXPECT_EQ(scene.state(), InsState::kAgree);
}

TEST(InsMonitor, AnInsThatWasWrongWhenFirstHeardIsTrustedOnceItIsRight) {
  Scene scene;
  scene.sahrs_sigma = 1.0 * kDegree;
  scene.ins_error = [](double t) { return Euler{0.0, t < 20.0 ? 5.0 * kDegree : 0.0, 0.0}; };
  scene.fly(25.0);
  ASSERT_EQ(scene.state(), InsState::kMiscompare);  // it left what was usual
  scene.fly(120.0);
  EXPECT_EQ(scene.state(), InsState::kAgree);
}

TEST(InsMonitor, ASlowErrorOfSahrsWithinItsSigmaIsNormal) {
  Scene scene;
  scene.sahrs_sigma = 1.2 * kDegree;
  scene.ins_error = [](double t) { return Euler{0.0, 0.0, 4.5 * kDegree * std::sin(t / 50.0)}; };
  for (double t = 1.0; t < 600.0; t += 1.0) {
    scene.fly(t);
    ASSERT_EQ(scene.state(), InsState::kAgree) << t;
  }
}

TEST(InsMonitor, AFrozenInsIsFlaggedAsSoonAsTheAircraftTurns) {
  for (const double rate_deg : {0.5, 10.0, 120.0}) {
    Scene scene;
    scene.sahrs = [=](double t) { return Euler{math::wrap_pi(rate_deg * kDegree * t), 0.0, 0.0}; };
    scene.fly(30.0);
    ASSERT_EQ(scene.state(), InsState::kAgree);
    const samples::InsSolution last = scene.solution(scene.now_us);
    scene.monitor.compare(last);
    scene.ins_sends = false;
    double turned = 0.0;
    while (scene.state() != InsState::kMiscompare && turned < 10.0) {
      scene.fly(1e-6 * static_cast<double>(scene.now_us + kFrame));
      samples::InsSolution frozen = last;
      frozen.time_us = scene.now_us;
      scene.monitor.compare(frozen);
      turned = rate_deg * (1e-6 * static_cast<double>(scene.now_us - last.time_us));
    }
    // A degree of turn, and what the aircraft turns between two solutions.
    EXPECT_LT(turned, 1.0 + 1.01e-6 * kFrame * rate_deg) << rate_deg;
    EXPECT_TRUE(scene.monitor.take_failure()) << rate_deg;
  }
}

TEST(InsMonitor, ASingleSpikeIsSuspectAndNoMore) {
  Scene scene;
  scene.fly(20.0);
  scene.ins_error = [](double) { return Euler{0.2, 0.0, 0.0}; };
  scene.fly(20.0 + 1e-6 * kFrame);
  EXPECT_EQ(scene.state(), InsState::kSuspect);
  scene.ins_error = [](double) { return Euler{}; };
  scene.fly(20.0 + 2e-6 * kFrame);
  EXPECT_EQ(scene.state(), InsState::kAgree);
  EXPECT_FALSE(scene.failure);
}

TEST(InsMonitor, AfterAMiscompareTheInsHasToAgreeForAWhile) {
  Scene scene;
  scene.fly(20.0);
  scene.ins_error = [](double) { return Euler{0.0, 0.1, 0.0}; };
  EXPECT_LT(scene.fly(30.0, InsState::kMiscompare), 20.2);
  // Less than the threshold, but not clearly: 2 of 2.5 degrees.
  scene.ins_error = [](double) { return Euler{0.0, 2.0 * kDegree, 0.0}; };
  scene.fly(50.0);
  EXPECT_EQ(scene.state(), InsState::kMiscompare);
  scene.ins_error = [](double) { return Euler{}; };
  EXPECT_NEAR(scene.fly(100.0, InsState::kAgree), 60.0, 0.1);
}

TEST(InsMonitor, ALateSolutionIsComparedWithTheAttitudeOfItsTime) {
  Scene scene;
  scene.sahrs = [](double t) { return Euler{math::wrap_pi(2.0 * t), 0.0, 0.0}; };
  scene.latency_us = 990'000;
  scene.fly(20.0);
  EXPECT_EQ(scene.state(), InsState::kAgree);
  EXPECT_LT(scene.monitor.state().difference.norm(), 0.01 * kDegree);
}

TEST(InsMonitor, SilenceIsAFailureAndTheLastHeadingIsHandedOver) {
  Scene scene;
  scene.ins_error = [](double) { return Euler{0.0, 0.0, -3.0 * kDegree}; };
  scene.fly(60.0);
  scene.ins_sends = false;
  scene.fly(60.4);
  EXPECT_FALSE(scene.failure);
  scene.fly(61.0);
  EXPECT_EQ(scene.state(), InsState::kNone);
  ASSERT_TRUE(scene.failure);
  EXPECT_EQ(scene.failure->time_us, 60'000'000);
  EXPECT_NEAR(scene.failure->error, -3.0 * kDegree, 2e-5);  // the INS's jitter
  EXPECT_NEAR(scene.failure->sigma, 0.2 * kDegree, 1e-12);
}

TEST(InsMonitor, AMiscompareHandsOverTheHeadingOfBeforeTheFault) {
  Scene scene;
  scene.ins_error = ramp({0.0, 0.0, 0.5}, 100.0);
  scene.fly(200.0, InsState::kMiscompare);
  ASSERT_TRUE(scene.failure);
  EXPECT_LT(scene.failure->time_us, 100'000'000);
  EXPECT_NEAR(scene.failure->error, 0.0, 2e-5);
}

TEST(InsMonitor, AnInsThatWasNeverTrustedHandsOverNothing) {
  Scene scene;
  scene.fly(5.0);
  scene.ins_sends = false;
  scene.fly(10.0);
  EXPECT_EQ(scene.state(), InsState::kNone);
  EXPECT_FALSE(scene.failure);
}

TEST(InsMonitor, LosingSahrsIsNoFailureOfTheIns) {
  Scene scene;
  scene.fly(60.0);
  scene.sahrs_valid = false;
  scene.fly(70.0);
  EXPECT_EQ(scene.state(), InsState::kNone);
  EXPECT_FALSE(scene.failure);
}

}  // namespace
}  // namespace lodestar::monitor
