// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "lodestar/math/rotation.h"

namespace lodestar::math {
namespace {

// A coning motion: roll and pitch rate a quarter of a period apart, 0.2 rad of half angle, about a
// turn of its own. Its attitude is known in closed form.
constexpr double kConeAngle = 0.2;  // rad
constexpr double kConeRate = 2.0;   // rad/s

Eigen::Matrix3d coning_attitude(double t) {
  const Eigen::Vector3d axis(std::cos(kConeRate * t), std::sin(kConeRate * t), 0.0);
  return exp_so3(kConeAngle * axis);
}

Eigen::Vector3d coning_rate_B(double t) {
  // omega_B = C' C', with C = exp([a u(t) x]): sin(a) along u' and (cos(a) - 1) about the cone
  // axis.
  const double c = std::cos(kConeRate * t), s = std::sin(kConeRate * t);
  return kConeRate * Eigen::Vector3d(-std::sin(kConeAngle) * s, std::sin(kConeAngle) * c,
                                     std::cos(kConeAngle) - 1.0);
}

Eigen::Matrix3d derivative(const Eigen::Matrix3d& C, const Eigen::Vector3d& omega_B) {
  return C * skew(omega_B);
}

/// Largest error of attitude (rad) and orthonormality over `duration`, of `step(C, omega_0,
/// omega_1, dt)`.
struct Errors {
  double angle = 0.0;
  double orthonormality = 0.0;
};

template <class Step>
Errors integrate(double dt, double duration, Step step) {
  Errors errors;
  Eigen::Matrix3d C = coning_attitude(0.0);
  const int steps = static_cast<int>(std::lround(duration / dt));
  for (int k = 0; k < steps; ++k) {
    const double t = k * dt;
    C = step(C, coning_rate_B(t), coning_rate_B(t + dt), dt);
    const Eigen::Matrix3d difference = coning_attitude(t + dt).transpose() * C;
    const Eigen::Vector3d angle(difference(2, 1) - difference(1, 2),
                                difference(0, 2) - difference(2, 0),
                                difference(1, 0) - difference(0, 1));
    errors.angle = std::max(errors.angle, 0.5 * angle.norm());
    errors.orthonormality =
        std::max(errors.orthonormality, (C.transpose() * C - Eigen::Matrix3d::Identity()).norm());
  }
  return errors;
}

Eigen::Matrix3d exponential_step(const Eigen::Matrix3d& C, const Eigen::Vector3d& omega_0,
                                 const Eigen::Vector3d& omega_1, double dt) {
  return (Eigen::Quaterniond(C) * exp_quaternion(rotation_vector(omega_0, omega_1, dt)))
      .normalized()
      .toRotationMatrix();
}

Eigen::Matrix3d trapezoidal_step(const Eigen::Matrix3d& C, const Eigen::Vector3d& omega_0,
                                 const Eigen::Vector3d& omega_1, double dt) {
  return (Eigen::Quaterniond(C) * exp_quaternion(0.5 * dt * (omega_0 + omega_1)))
      .normalized()
      .toRotationMatrix();
}

/// Second-order Runge-Kutta on the matrix, as the SAHRS paper has it (§3.1).
Eigen::Matrix3d runge_kutta_step(const Eigen::Matrix3d& C, const Eigen::Vector3d& omega_0,
                                 const Eigen::Vector3d& omega_1, double dt) {
  const Eigen::Matrix3d k1 = derivative(C, omega_0);
  const Eigen::Matrix3d k2 = derivative(C + dt * k1, omega_1);
  return C + 0.5 * dt * (k1 + k2);
}

TEST(AttitudeIntegration, TheExponentialIsOfSecondOrderInAConingMotion) {
  // What is left is the curvature of the rate between two samples, dt^2 / 12 of its change.
  const double coarse = integrate(0.02, 10.0, exponential_step).angle;
  const double fine = integrate(0.01, 10.0, exponential_step).angle;
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);
  EXPECT_LT(integrate(1e-4, 1.0, exponential_step).angle, 1e-8);
}

TEST(AttitudeIntegration, TheSecondTermOfMagnusHalvesTheDriftOfAConingMotion) {
  const double with = integrate(1.0 / 30.0, 60.0, exponential_step).angle;
  const double without = integrate(1.0 / 30.0, 60.0, trapezoidal_step).angle;
  EXPECT_NEAR(without / with, 2.0, 0.1);
}

TEST(AttitudeIntegration, TheExponentialIsNoWorseThanRungeKuttaInAConingMotion) {
  const Errors exponential = integrate(1.0 / 30.0, 60.0, exponential_step);
  const Errors runge_kutta = integrate(1.0 / 30.0, 60.0, runge_kutta_step);
  EXPECT_LT(exponential.angle, runge_kutta.angle);
  EXPECT_LT(exponential.orthonormality, 1e-14);
  EXPECT_GT(runge_kutta.orthonormality, 1e-6);
}

TEST(AttitudeIntegration, TheExponentialBeatsRungeKuttaInASteadyRollAtThePapersRate) {
  const Eigen::Vector3d omega_B(120.0 * kDegree, 0.0, 5.0 * kDegree);
  const double dt = 1.0 / 30.0;
  Eigen::Matrix3d exponential = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d runge_kutta = Eigen::Matrix3d::Identity();
  for (int k = 0; k < 30 * 10; ++k) {
    exponential = exponential_step(exponential, omega_B, omega_B, dt);
    runge_kutta = runge_kutta_step(runge_kutta, omega_B, omega_B, dt);
  }
  const Eigen::Matrix3d truth = exp_so3(10.0 * omega_B);
  EXPECT_LT((exponential - truth).norm(), 1e-12);
  EXPECT_GT((runge_kutta - truth).norm(), 1e-3);
}

}  // namespace
}  // namespace lodestar::math
