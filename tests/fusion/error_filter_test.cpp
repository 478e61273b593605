// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/error_filter.h"

#include <gtest/gtest.h>

#include "lodestar/fusion/step_history.h"

namespace lodestar::fusion {
namespace {

using math::kDegree;

StepConditions calm() {
  StepConditions conditions;
  conditions.angle_variance << 4e-4, 5e-5, 1e-4;
  conditions.turn_rate = 0.03;
  return conditions;
}

/// A turning, slightly climbing flight.
TrackPoint point_at(double time) {
  TrackPoint point;
  point.time_us = static_cast<std::int64_t>(std::llround(1e6 * time));
  point.lat = 57.0 * kDegree;
  point.h = 3000.0;
  point.attitude = {0.4, 0.05, math::wrap_2pi(0.03 * time)};
  point.v_air_B = {198.0, -2.0, 12.0};
  point.v_air_N = math::C_NB_from_euler(point.attitude) * point.v_air_B;
  return point;
}

ErrorEstimate start(CovarianceForm form) {
  StateVector sigma;
  sigma << 10.0, 10.0, 5.0, 5.0, 7.0, 7.0, 0.02, 0.007, 0.01, 0.01, 0.01;
  const StateMatrix P = sigma.cwiseAbs2().asDiagonal();
  return {StateVector::Zero(), ErrorCovariance(form, P)};
}

/// Ten minutes of flight with a fix each second.
ErrorEstimate fly(const CascadeParameters& parameters) {
  ErrorEstimate estimate = start(parameters.covariance);
  for (int i = 0; i < 6000; ++i) {
    estimate.propagate(parameters, calm(), point_at(0.1 * i), point_at(0.1 * (i + 1)));
    if (i % 10 != 9) continue;
    const Eigen::Vector2d measured(20.0 * std::sin(0.01 * i), 6.0 + 0.5 * i);
    const PositionMatrix H = position_measurement();
    estimate.x += estimate.P.update(H, 1.0, measured - H * estimate.x);
  }
  return estimate;
}

void expect_both_forms_agree(CascadeParameters parameters) {
  const ErrorEstimate joseph = fly(parameters);
  parameters.covariance = CovarianceForm::kUd;
  const ErrorEstimate ud = fly(parameters);
  const StateMatrix P = joseph.P.matrix();
  const StateVector scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const StateMatrix difference = scale.asDiagonal() * (ud.P.matrix() - P) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((ud.x - joseph.x).norm(), 1e-9 * joseph.x.norm());
  const PositionMatrix H = position_measurement();
  EXPECT_LT((ud.P.projected(H) - joseph.P.projected(H)).norm(), 1e-9);
}

TEST(ErrorFilter, UdAndJosephAgree) {
  for (const Linearisation linearisation : {Linearisation::kExtended, Linearisation::kLinearised}) {
    CascadeParameters parameters;
    parameters.linearisation = linearisation;
    expect_both_forms_agree(parameters);
  }
}

TEST(ErrorFilter, UdAndJosephAgreeWithEachOption) {
  CascadeParameters small_angle;
  small_angle.attitude_error = AttitudeError::kSmallAngle;
  expect_both_forms_agree(small_angle);
  CascadeParameters compass;
  compass.heading_deviation.sigma = 1.0 * kDegree;
  expect_both_forms_agree(compass);
  CascadeParameters turning;
  turning.heading_turn_gain = 3.0;
  turning.wind_turn_gain = 5.0;
  expect_both_forms_agree(turning);
  CascadeParameters all = turning;
  all.attitude_error = AttitudeError::kSmallAngle;
  all.heading_deviation.sigma = 1.0 * kDegree;
  expect_both_forms_agree(all);
}

TEST(ErrorFilter, CovarianceStaysSymmetricAndPositive) {
  for (const CovarianceForm form : {CovarianceForm::kJoseph, CovarianceForm::kUd}) {
    CascadeParameters parameters;
    parameters.covariance = form;
    const StateMatrix P = fly(parameters).P.matrix();
    EXPECT_LT((P - P.transpose()).norm(), 1e-12 * P.norm());
    EXPECT_GT(filter::UdCovariance<kStates>(P).D().minCoeff(), 0.0);
  }
}

TEST(ErrorFilter, GaussMarkovStatesReachTheirStationaryLevel) {
  CascadeParameters parameters;
  parameters.wind.tau = 400.0;
  ErrorEstimate estimate = start(CovarianceForm::kJoseph);
  for (int i = 0; i < 30000; ++i) {
    estimate.propagate(parameters, calm(), point_at(0.1 * i), point_at(0.1 * (i + 1)));
  }
  const Eigen::VectorXd variance = estimate.P.matrix().diagonal();
  // 1e-3: 3000 s are 7.5 of the longest time constant.
  EXPECT_NEAR(variance(kGpsError.offset), 25.0, 25e-3);
  EXPECT_NEAR(variance(kWind.offset), 49.0, 49e-3);
  EXPECT_NEAR(variance(kHeadingError.offset), 4e-4, 4e-7);
  EXPECT_NEAR(variance(kPitchError.offset), 5e-5, 5e-8);
  EXPECT_NEAR(variance(kRollError.offset), 1e-4, 1e-7);
}

TEST(ErrorFilter, StepsCanBeSplitAnywhere) {
  const CascadeParameters parameters;
  ErrorEstimate whole = start(CovarianceForm::kJoseph);
  whole.x << 50.0, -20.0, 3.0, 1.0, 6.0, 7.0, 0.03, 0.002, -0.005, 0.01, -0.02;
  ErrorEstimate split = whole;
  whole.propagate(parameters, calm(), point_at(0.0), point_at(0.1));
  split.propagate(parameters, calm(), point_at(0.0), point_at(0.03));
  split.propagate(parameters, calm(), point_at(0.03), point_at(0.03));  // nothing
  split.propagate(parameters, calm(), point_at(0.03), point_at(0.1));
  // Second order in the step: what is left is of the third, (0.1 s)^3 of a turn at 0.03 rad/s.
  EXPECT_LT((whole.x - split.x).norm(), 1e-6);
  EXPECT_LT((whole.P.matrix() - split.P.matrix()).norm(), 1e-5 * whole.P.matrix().norm());
}

TEST(ErrorFilter, ExtendedFormKeepsWhatALargeHeadingErrorDoes) {
  // 20 degrees: the chord is 2 V sin(10 deg), turned by 10 degrees; the linear form has the
  // tangent.
  const TrackPoint from = point_at(0.0);
  TrackPoint to = from;
  to.time_us += 100'000;
  ErrorEstimate extended = start(CovarianceForm::kJoseph);
  extended.x(kHeadingError.offset) = 20.0 * kDegree;
  extended.propagate({}, calm(), from, to);
  math::Euler turned = from.attitude;
  turned.heading += 20.0 * kDegree;
  const Eigen::Vector3d expected =
      0.1 * (math::C_NB_from_euler(turned) * from.v_air_B - from.v_air_N);
  // 0.1 %: the heading error decays by that within the step.
  EXPECT_LT((extended.position_error() - expected.head<2>()).norm(), 1e-3 * expected.norm());

  CascadeParameters parameters;
  parameters.linearisation = Linearisation::kLinearised;
  ErrorEstimate linear = start(CovarianceForm::kJoseph);
  linear.x(kHeadingError.offset) = 20.0 * kDegree;
  linear.propagate(parameters, calm(), from, to);
  EXPECT_GT((linear.position_error() - expected.head<2>()).norm(), 0.1 * expected.norm());
}

TEST(ErrorFilter, ARestartOfSahrsForgetsItsAnglesAlone) {
  for (const CovarianceForm form : {CovarianceForm::kJoseph, CovarianceForm::kUd}) {
    CascadeParameters parameters;
    parameters.covariance = form;
    ErrorEstimate estimate = fly(parameters);
    const double heading = estimate.x(kHeadingError.offset);
    ASSERT_NE(heading, 0.0);
    ErrorEstimate kept = estimate;
    StepConditions restarted = calm();
    restarted.sahrs_restarted = true;
    kept.propagate(parameters, calm(), point_at(600.0), point_at(600.1));
    estimate.propagate(parameters, restarted, point_at(600.0), point_at(600.1));
    EXPECT_TRUE(estimate.x.tail<5>().isZero(0.0));
    EXPECT_EQ(estimate.x.head<6>(), kept.x.head<6>());
    const StateMatrix P = estimate.P.matrix();
    EXPECT_LT((P.diagonal().segment<3>(kHeadingError.offset) - calm().angle_variance).norm(),
              1e-15);
    EXPECT_TRUE(P.diagonal().tail<2>().isZero(0.0));
    EXPECT_LT((P.block<6, 5>(0, 6).norm()), 1e-12);
    EXPECT_LT((P.topLeftCorner<6, 6>() - kept.P.matrix().topLeftCorner<6, 6>()).norm(), 1e-9);
  }
}

TEST(ErrorFilter, DoubtAddsToWindAndPositionAndKeepsTheRest) {
  ErrorEstimate estimate = fly({});
  const StateMatrix before = estimate.P.matrix();
  estimate.doubt_wind(3.0);
  EXPECT_NEAR(estimate.P.matrix()(kWind.offset, kWind.offset),
              before(kWind.offset, kWind.offset) + 9.0, 1e-12);
  estimate = fly({});
  estimate.loosen({100.0, 50.0}, 2.0);
  const StateMatrix after = estimate.P.matrix();
  const int east = kPositionError.offset + 1;
  EXPECT_NEAR(after(east, east), before(east, east) + 2500.0, 1e-9);
  EXPECT_NEAR(after(kHeadingError.offset, kHeadingError.offset),
              4.0 * before(kHeadingError.offset, kHeadingError.offset), 1e-15);
  EXPECT_EQ(after(kGpsError.offset, kGpsError.offset), before(kGpsError.offset, kGpsError.offset));
}

TEST(ErrorFilter, LostAirDataAndGapsOfFramesGrowTheUncertainty) {
  const CascadeParameters parameters;
  StepConditions lost = calm();
  lost.air_data_lost = true;
  ErrorEstimate with = start(CovarianceForm::kJoseph);
  ErrorEstimate without = with;
  with.propagate(parameters, calm(), point_at(0.0), point_at(0.1));
  without.propagate(parameters, lost, point_at(0.0), point_at(0.1));
  const double growth =
      without.P.matrix()(kWind.offset, kWind.offset) - with.P.matrix()(kWind.offset, kWind.offset);
  EXPECT_NEAR(growth, 0.1 * std::pow(parameters.air_data_lost_noise, 2), 1e-4);

  ErrorEstimate gap = start(CovarianceForm::kJoseph);
  ErrorEstimate steps = gap;
  gap.propagate(parameters, calm(), point_at(0.0), point_at(2.0));
  for (int i = 0; i < 20; ++i) {
    steps.propagate(parameters, calm(), point_at(0.1 * i), point_at(0.1 * (i + 1)));
  }
  EXPECT_GT(gap.P.matrix()(0, 0), steps.P.matrix()(0, 0) + 50.0);
}

double wind_growth(double gain, double turn_rate) {
  CascadeParameters parameters;
  parameters.wind_turn_gain = gain;
  StepConditions conditions = calm();
  conditions.turn_rate = turn_rate;
  ErrorEstimate estimate = start(CovarianceForm::kJoseph);
  const double before = estimate.P.matrix()(kWind.offset, kWind.offset);
  estimate.propagate(parameters, conditions, point_at(0.0), point_at(0.1));
  return estimate.P.matrix()(kWind.offset, kWind.offset) - before;
}

TEST(ErrorFilter, AStandardRateTurnAddsItsGainToTheProcessNoiseOfTheWind) {
  const double added = 0.1 * CascadeParameters{}.wind.spectral_density();
  const double straight = wind_growth(4.0, 0.0);
  // 1e-4: the noise decays within the step, too.
  EXPECT_NEAR(wind_growth(4.0, 3.0 * kDegree) - straight, 4.0 * added, 4e-4 * added);
  EXPECT_NEAR(wind_growth(4.0, 6.0 * kDegree) - straight, 8.0 * added, 8e-4 * added);
  EXPECT_EQ(wind_growth(0.0, 6.0 * kDegree), straight);
}

TEST(ErrorFilter, AStandardRateTurnAddsItsGainToTheProcessNoiseOfTheHeading) {
  CascadeParameters parameters;
  parameters.heading_turn_gain = 2.0;
  StepConditions conditions = calm();
  const auto variance = [&](double turn_rate) {
    conditions.turn_rate = turn_rate;
    ErrorEstimate estimate = start(CovarianceForm::kJoseph);
    estimate.propagate(parameters, conditions, point_at(0.0), point_at(0.1));
    return StateVector(estimate.P.matrix().diagonal());
  };
  const StateVector added = variance(3.0 * kDegree) - variance(0.0);
  const double expected = 2.0 * 0.1 * 2.0 * 4e-4 / parameters.heading_error.tau;
  EXPECT_NEAR(added(kHeadingError.offset), expected, 2e-3 * expected);
  EXPECT_EQ(added(kPitchError.offset), 0.0);
  EXPECT_EQ(added(kWind.offset), 0.0);
}

TEST(ErrorFilter, WithoutADeviationItsStatesStayZeroToTheBit) {
  for (const CovarianceForm form : {CovarianceForm::kJoseph, CovarianceForm::kUd}) {
    StateMatrix P = start(form).P.matrix();
    P.diagonal().segment<2>(kDeviation.offset).setZero();
    ErrorEstimate estimate{StateVector::Zero(), ErrorCovariance(form, P)};
    for (int i = 0; i < 600; ++i) {
      estimate.propagate({}, calm(), point_at(i), point_at(i + 1));
      const PositionMatrix H = position_measurement();
      const Eigen::Vector2d measured(20.0 * std::sin(0.1 * i), 5.0 * i);
      estimate.x += estimate.P.update(H, 1.0, measured - H * estimate.x);
    }
    EXPECT_NE(estimate.x(kHeadingError.offset), 0.0);
    EXPECT_TRUE(estimate.x.segment<2>(kDeviation.offset).isZero(0.0));
    EXPECT_TRUE(estimate.P.matrix().rightCols<2>().isZero(0.0));
  }
}

Step step_at(int second) {
  Step step;
  step.point = point_at(second);
  return step;
}

TEST(StepHistory, InsertsInOrderAndDropsTheOldest) {
  StepHistory history;
  EXPECT_TRUE(history.empty());
  for (int i = 0; i < StepHistory::kCapacity; ++i) history.push(step_at(2 * i));
  EXPECT_EQ(history.last_until(11'000'000), 5);
  EXPECT_EQ(history.last_until(-1), -1);
  const int at = history.insert(6, step_at(11));
  EXPECT_EQ(history.size(), StepHistory::kCapacity);
  EXPECT_EQ(history[at].point.time_us, 11'000'000);
  EXPECT_EQ(history[0].point.time_us, 2'000'000);
  for (int i = 1; i < history.size(); ++i) {
    EXPECT_GT(history[i].point.time_us, history[i - 1].point.time_us);
  }
  EXPECT_EQ(history.insert(history.size(), step_at(1000)), StepHistory::kCapacity - 1);
  EXPECT_EQ(history.back().point.time_us, 1'000'000'000);
}

}  // namespace
}  // namespace lodestar::fusion
