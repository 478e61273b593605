// SPDX-License-Identifier: Apache-2.0
// Many flights of the very model that the filter has: its sigma must then be true.
#include <gtest/gtest.h>

#include <cstdio>

#include "cascade_flight.h"

namespace lodestar::fusion {
namespace {

/// Errors of one quantity against their sigma.
class Coverage {
 public:
  void add(double error, double sigma) {
    const double e = error / sigma;
    sum_squares_ += error * error;
    normalised_ += e * e;
    within_1_ += std::abs(e) < 1.0 ? 1 : 0;
    within_2_ += std::abs(e) < 2.0 ? 1 : 0;
    ++count_;
  }

  double rms() const { return std::sqrt(sum_squares_ / count_); }
  double nees() const { return normalised_ / count_; }
  double within_1() const { return within_1_ / count_; }
  double within_2() const { return within_2_ / count_; }

  void check(const char* name, double unit = 1.0) const {
    std::printf("%-14s rms %7.3f  NEES %.2f  within 1 sigma %.3f, 2 sigma %.3f\n", name,
                rms() / unit, nees(), within_1(), within_2());
    EXPECT_NEAR(nees(), 1.0, 0.2) << name;
    EXPECT_NEAR(within_1(), 0.683, 0.05) << name;
    EXPECT_NEAR(within_2(), 0.954, 0.03) << name;
  }

 private:
  double sum_squares_ = 0.0;
  double normalised_ = 0.0;
  double within_1_ = 0.0;
  double within_2_ = 0.0;
  double count_ = 0.0;
};

/// Wind as the filter's model has it.
class GaussMarkovWind {
 public:
  GaussMarkovWind(unsigned seed, const math::GaussMarkov& model)
      : generator_(seed), model_(model), wind_(model.sigma * pair()) {}

  Eigen::Vector2d operator()(double time) {
    const double dt = time - time_;
    time_ = time;
    wind_ = model_.decay(dt) * wind_ + std::sqrt(model_.added_variance(dt)) * pair();
    return wind_;
  }

 private:
  Eigen::Vector2d pair() {
    const double north = normal_(generator_);
    return {north, normal_(generator_)};
  }

  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
  math::GaussMarkov model_;
  double time_ = 0.0;
  Eigen::Vector2d wind_;
};

TEST(CascadeMonteCarlo, SigmaIsTrueWhereTheModelIs) {
  CascadeParameters parameters;
  parameters.airspeed_bias = parameters.beta_bias = 0.0;  // the simulator's are, too
  parameters.wind.tau = 400.0;
  Coverage position, velocity, wind, heading, roll, height;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    FlightOptions options;
    options.seed = seed;
    options.rate = 30.0;
    options.wind = GaussMarkovWind(1000 + seed, parameters.wind);
    options.baro_bias = 15.0;
    CascadeFlight flight(options, parameters);
    flight.fly_until(60.0);
    for (double time = 65.0; time <= 900.0; time += 5.0) {
      flight.fly_until(time);
      const samples::Navigation& n = flight.navigation();
      for (int axis = 0; axis < 2; ++axis) {
        position.add(flight.position_error()(axis), n.sigma_position(axis));
        velocity.add(flight.velocity_error()(axis), n.sigma_velocity(axis));
        wind.add(flight.wind_error()(axis), n.sigma_wind(axis));
      }
      heading.add(flight.heading_error(), n.sigma_attitude.z());
      roll.add(math::wrap_pi(flight.truth().attitude.roll - n.roll), n.sigma_attitude.x());
      height.add(flight.position_error().z(), n.sigma_position.z());
    }
    EXPECT_LE(flight.navigation().reset_count, 1) << seed;
  }
  position.check("position, m");
  velocity.check("velocity, m/s");
  wind.check("wind, m/s");
  heading.check("heading, deg", math::kDegree);
  roll.check("roll, deg", math::kDegree);
  height.check("height, m");
}

/// Heading and wind on flights of the model `parameters`, compass included.
void check_heading_and_wind(CascadeParameters parameters) {
  parameters.airspeed_bias = parameters.beta_bias = 0.0;
  parameters.wind.tau = 400.0;
  Coverage wind, heading;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    FlightOptions options;
    options.seed = seed;
    options.rate = 30.0;
    options.leg = 60.0;
    options.wind = GaussMarkovWind(1000 + seed, parameters.wind);
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    const double forward = parameters.heading_deviation.sigma * normal(generator);
    options.compass_error << forward, parameters.heading_deviation.sigma * normal(generator);
    CascadeFlight flight(options, parameters);
    flight.fly_until(60.0);
    for (double time = 65.0; time <= 700.0; time += 5.0) {
      flight.fly_until(time);
      const samples::Navigation& n = flight.navigation();
      for (int axis = 0; axis < 2; ++axis) wind.add(flight.wind_error()(axis), n.sigma_wind(axis));
      heading.add(flight.heading_error(), n.sigma_attitude.z());
    }
  }
  wind.check("wind, m/s");
  heading.check("heading, deg", math::kDegree);
}

TEST(CascadeMonteCarlo, SigmaIsTrueForACompassOfTheModel) {
  CascadeParameters parameters;
  parameters.heading_deviation = {2.0 * math::kDegree, 1e5};  // the simulator's lasts
  check_heading_and_wind(parameters);
}

TEST(CascadeMonteCarlo, SigmaIsTrueWithSmallAngles) {
  CascadeParameters parameters;
  parameters.attitude_error = AttitudeError::kSmallAngle;
  check_heading_and_wind(parameters);
}

}  // namespace
}  // namespace lodestar::fusion
