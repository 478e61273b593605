// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>

#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"
#include "lodestar/samples/samples.h"
#include "sensor_errors.h"

namespace lodestar::sahrs_test {

/// A coordinated flight of random turns, climbs and changes of speed, and what its sensors say.
class FlightGenerator {
 public:
  /// All errors are multiplied by `error_scale`.
  explicit FlightGenerator(unsigned seed, double error_scale = 1.0, double rate_hz = 60.0,
                           const SensorErrors& errors = {})
      : errors_(errors),
        error_scale_(error_scale),
        random_(seed),
        dt_(1.0 / (rate_hz * kSubsteps)) {
    earth::GeomagneticModel model(earth::GeomagneticKind::kIgrf14);
    b_N_ = model.field_N(kLat, kLon, 2000.0, kYear) + normal3(errors.field_model);
    gyro_matrix_ = matrix(errors.gyro_misalignment);
    gyro_matrix_.diagonal() = normal3(errors.gyro_scale);
    field_matrix_ = matrix(errors.field_matrix);
    gyro_bias_ = normal3(errors.gyro_bias);
    gyro_drift_ = normal3(errors.gyro_drift.sigma);
    load_bias_ = normal3(errors.load_bias);
    field_bias_ = normal3(errors.field_bias);
    field_drift_ = normal3(errors.field_drift.sigma);
    airspeed_scale_ = normal(errors.airspeed_scale);
    airspeed_bias_ = normal(errors.airspeed_bias);
    alpha_bias_ = normal(errors.flow_bias);
    beta_bias_ = normal(errors.flow_bias);
    alpha_scale_ = normal(errors.alpha_scale);
    baro_bias_ = normal(errors.baro_bias);
    chi_ = uniform(0.0, 2.0 * math::kPi);
    evaluate();
  }

  /// One frame on; then the fields and samples below speak of its time.
  void step() {
    for (int i = 0; i < kSubsteps; ++i) substep();
    const double dt = kSubsteps * dt_;
    walk(gyro_drift_, errors_.gyro_drift, dt);
    walk(field_drift_, errors_.field_drift, dt);
    walk(gust_, errors_.vertical_gust, dt);
    ++frame_;
  }

  std::int64_t time_us() const { return std::llround(1e6 * time_); }
  math::Euler truth() const { return math::euler_from_C_NB(C_NB_); }
  const Eigen::Matrix3d& C_NB() const { return C_NB_; }
  bool slow_sensors_due() const { return frame_ % 2 == 0; }
  void fly_straight() { straight_ = true; }

  samples::BodyRates body_rates() {
    const Eigen::Vector3d omega =
        omega_IB_B_ + gyro_matrix_ * omega_IB_B_ + gyro_bias_ + gyro_drift_;
    return {time_us(), omega + normal3(errors_.gyro_noise), true};
  }
  samples::LoadFactor load_factor() {
    return {time_us(), n_B_ + load_bias_ + normal3(errors_.load_noise), true};
  }
  samples::MagneticField magnetic_field() {
    const Eigen::Vector3d b_B = C_NB_.transpose() * b_N_;
    return {time_us(),
            b_B + field_matrix_ * b_B + field_bias_ + field_drift_ + normal3(errors_.field_noise),
            true};
  }
  samples::AirData air_data() {
    const double alpha = alpha_ + gust_.x() / V_;
    return {time_us(),
            V_ * (1.0 + airspeed_scale_) + airspeed_bias_ + normal(errors_.airspeed_noise),
            alpha * (1.0 + alpha_scale_) + alpha_bias_ + normal(errors_.flow_noise),
            beta_bias_ + normal(errors_.flow_noise),
            lagged_h_ + baro_bias_ + normal(errors_.baro_noise),
            280.0,
            true};
  }

  static constexpr double kLat = 58.0 * math::kDegree;
  static constexpr double kLon = 16.0 * math::kDegree;
  static constexpr double kYear = 2026.5;

 private:
  static constexpr int kSubsteps = 4;
  static constexpr double kMaxBank = 60.0 * math::kDegree;

  // A value on its way to its command: second order, so that value and rate are continuous.
  struct Follower {
    double value, rate, bandwidth, max_rate;
    void step(double command, double dt) {
      const double wanted =
          std::fmin(max_rate, std::fmax(-max_rate, bandwidth * (command - value)));
      const double acceleration = 2.0 * bandwidth * (wanted - rate);
      value += rate * dt + 0.5 * acceleration * dt * dt;
      rate += acceleration * dt;
    }
  };

  void choose_leg() {
    const double kind = uniform(0.0, 1.0);
    const double side = uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    bank_command_ = !straight_ && kind < 0.5 ? side * uniform(0.3, 1.0) * kMaxBank : 0.0;
    gamma_command_ = kind > 0.3 && kind < 0.7 ? uniform(-0.1, 0.1) : 0.0;
    if (h_ > 4000.0) gamma_command_ = -std::abs(gamma_command_);
    if (h_ < 1500.0) gamma_command_ = std::abs(gamma_command_);
    if (kind > 0.8) speed_command_ = uniform(150.0, 220.0);
    leg_end_ = time_ + uniform(20.0, bank_command_ != 0.0 ? 60.0 : 150.0);
  }

  void substep() {
    if (time_ >= leg_end_) choose_leg();
    bank_.step(bank_command_, dt_);
    gamma_.step(gamma_command_, dt_);
    speed_.step(speed_command_, dt_);
    const double before = alpha_;
    const double chi_rate = chi_rate_;
    h_ += dt_ * V_ * std::sin(gamma_.value);
    lagged_h_ += (h_ - lagged_h_) * -std::expm1(-dt_ / errors_.baro_lag);
    time_ += dt_;
    evaluate();
    chi_ += 0.5 * dt_ * (chi_rate + chi_rate_);
    alpha_rate_ = (alpha_ - before) / dt_;
    evaluate();
  }

  // Attitude, rates and load factor of the moment. Lateral force is nought: that fixes chi_rate.
  void evaluate() {
    const double mu = bank_.value, gamma = gamma_.value;
    V_ = speed_.value;
    const double g = earth::gravity(kLat, h_);
    chi_rate_ = std::tan(mu) * (g / V_ + gamma_.rate / std::cos(gamma));
    const double lift =
        g * std::cos(gamma) * std::cos(mu) +
        V_ * (chi_rate_ * std::cos(gamma) * std::sin(mu) + gamma_.rate * std::cos(mu));  // m/s^2
    alpha_ = 0.07 * lift / g * (180.0 / V_) * (180.0 / V_);
    const Eigen::Matrix3d C_NW = math::C_NB_from_euler({mu, gamma, chi_});
    const Eigen::Matrix3d C_WB = math::exp_so3({0.0, alpha_, 0.0});  // z_W ahead of z_B by alpha
    C_NB_ = C_NW * C_WB;
    const Eigen::Vector3d omega_NW_W(
        bank_.rate - chi_rate_ * std::sin(gamma),
        gamma_.rate * std::cos(mu) + chi_rate_ * std::sin(mu) * std::cos(gamma),
        -gamma_.rate * std::sin(mu) + chi_rate_ * std::cos(mu) * std::cos(gamma));
    const Eigen::Vector3d v_N = C_NW * Eigen::Vector3d(V_, 0.0, 0.0);
    const Eigen::Vector3d omega_IE_N = earth::earth_rate_N(kLat);
    const Eigen::Vector3d omega_EN_N = earth::transport_rate_N(kLat, h_, v_N);
    omega_IB_B_ = C_WB.transpose() * omega_NW_W + Eigen::Vector3d(0.0, alpha_rate_, 0.0) +
                  C_NB_.transpose() * (omega_IE_N + omega_EN_N);
    const Eigen::Vector3d a_N =
        C_NW * Eigen::Vector3d(speed_.rate, omega_NW_W.z() * V_, -omega_NW_W.y() * V_);
    const Eigen::Vector3d f_N =
        a_N + (2.0 * omega_IE_N + omega_EN_N).cross(v_N) - Eigen::Vector3d(0.0, 0.0, g);
    n_B_ = -(C_NB_.transpose() * f_N) / samples::kStandardGravity;
  }

  double normal(double sigma) { return error_scale_ * sigma * gaussian_(random_); }
  Eigen::Vector3d normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  }
  Eigen::Matrix3d matrix(double sigma) {
    Eigen::Matrix3d m;
    for (int i = 0; i < 3; ++i) m.row(i) = normal3(sigma);
    return m;
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  void walk(Eigen::Vector3d& value, const math::GaussMarkov& process, double dt) {
    value = process.decay(dt) * value + normal3(std::sqrt(process.added_variance(dt)));
  }

  SensorErrors errors_;
  double error_scale_;
  std::mt19937_64 random_;
  std::normal_distribution<double> gaussian_;
  double dt_, time_ = 0.0, leg_end_ = 20.0;
  std::int64_t frame_ = 0;
  bool straight_ = false;
  double bank_command_ = 0.0, gamma_command_ = 0.0, speed_command_ = 180.0;
  Follower bank_{0.0, 0.0, 1.0, 15.0 * math::kDegree};
  Follower gamma_{0.0, 0.0, 0.5, 2.0 * math::kDegree};
  Follower speed_{180.0, 0.0, 0.1, 1.0};
  double chi_ = 0.0, chi_rate_ = 0.0, alpha_ = 0.0, alpha_rate_ = 0.0, V_ = 180.0;
  double h_ = 2000.0, lagged_h_ = 2000.0;
  Eigen::Vector3d gust_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d C_NB_, gyro_matrix_, field_matrix_;
  Eigen::Vector3d omega_IB_B_, n_B_, b_N_, gyro_bias_, gyro_drift_, load_bias_, field_bias_,
      field_drift_;
  double airspeed_scale_, airspeed_bias_, alpha_bias_, beta_bias_, alpha_scale_, baro_bias_;
};

}  // namespace lodestar::sahrs_test
