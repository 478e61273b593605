// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lodestar/earth/wgs84.h"
#include "lodestar/math/rotation.h"
#include "lodestar/samples/samples.h"

namespace lodestar::strapdown {

/// What is wrong with the sensors of a simulated flight; nothing by default.
struct SensorErrors {
  double gyro_noise = 0.0;  // rad/s per sample
  Eigen::Vector3d gyro_bias_B = Eigen::Vector3d::Zero();
  double load_noise = 0.0;  // g0 per sample
  Eigen::Vector3d load_bias_B = Eigen::Vector3d::Zero();
  double field_noise = 0.0;  // nT
  Eigen::Vector3d field_bias_B = Eigen::Vector3d::Zero();
  double airspeed_noise = 0.0;  // m/s
  double airspeed_bias = 0.0;
  double flow_noise = 0.0;  // rad
  Eigen::Vector2d flow_bias = Eigen::Vector2d::Zero();
  double baro_noise = 0.0;  // m
  double gust_sigma = 0.0;  // m/s, Gauss-Markov of 2.8 s per body axis
  double baro_lag = 0.3;    // s
  double gps_noise = 0.0;   // m

  /// A fighter's, as drawn for one flight.
  static SensorErrors fighter(std::mt19937& generator) {
    std::normal_distribution<double> normal;
    const auto vector = [&](double sigma) {
      return Eigen::Vector3d(sigma * normal(generator), sigma * normal(generator),
                             sigma * normal(generator));
    };
    SensorErrors e;
    e.gyro_noise = 0.05 * math::kDegree;
    e.gyro_bias_B = vector(0.2 * math::kDegree);
    e.load_noise = 0.02;
    e.load_bias_B = vector(0.01);
    e.field_noise = 80.0;
    e.field_bias_B = vector(500.0);
    e.airspeed_noise = 0.5;
    e.airspeed_bias = 0.5 * normal(generator);
    e.flow_noise = 0.1 * math::kDegree;
    e.flow_bias = vector(0.3 * math::kDegree).head<2>();
    e.baro_noise = 0.5;
    e.gps_noise = 1.0;
    return e;
  }
};

/// Flight at constant speed and height over a rotating Earth, at 60 Hz, the attitude prescribed:
/// roll swings between `roll` +- `swing` with period 120 s, the track turns as a coordinated turn
/// of that roll does, and heading keeps to it. Rates and forces follow from the motion alone.
class SimulatedFlight {
 public:
  static constexpr double kInterval = 1.0 / 60.0;

  SimulatedFlight(double roll, double swing, double heading, const SensorErrors& errors,
                  std::uint32_t seed, const Eigen::Vector2d& wind = Eigen::Vector2d::Zero())
      : roll_(roll),
        swing_(swing),
        track_(heading),
        errors_(errors),
        generator_(seed),
        wind_N_(wind.x(), wind.y(), 0.0) {
    C_NB_ = attitude(0.0, track_);
    baro_ = kHeight;
  }

  static constexpr double kLat = 57.5 * math::kDegree;
  static constexpr double kHeight = 2500.0;
  static constexpr double kAirspeed = 190.0;
  static Eigen::Vector3d field_N() { return Eigen::Vector3d(15300.0, 1700.0, 48800.0); }

  const Eigen::Matrix3d& C_NB() const { return C_NB_; }
  std::int64_t time_us() const { return time_us(step_); }

  samples::BodyRates rates() {
    samples::BodyRates s;
    s.time_us = time_us();
    s.omega_B = omega_at(now()) + errors_.gyro_bias_B + noise(errors_.gyro_noise);
    return s;
  }
  samples::LoadFactor load_factor() {
    samples::LoadFactor s;
    s.time_us = time_us();
    s.n_B =
        -force_B() / samples::kStandardGravity + errors_.load_bias_B + noise(errors_.load_noise);
    return s;
  }
  samples::MagneticField field() {
    samples::MagneticField s;
    s.time_us = time_us();
    s.b_B = C_NB_.transpose() * field_N() + errors_.field_bias_B + noise(errors_.field_noise);
    return s;
  }
  samples::AirData air_data() {
    const Eigen::Vector3d w = C_NB_.transpose() * v_N(track_) + gust_B_;
    samples::AirData s;
    s.time_us = time_us();
    s.true_airspeed = w.norm() + errors_.airspeed_bias + noise(errors_.airspeed_noise).x();
    s.alpha = std::atan2(w.z(), w.x()) + errors_.flow_bias.x() + noise(errors_.flow_noise).x();
    s.beta = std::asin(w.y() / w.norm()) + errors_.flow_bias.y() + noise(errors_.flow_noise).x();
    s.baro_altitude = baro_ + noise(errors_.baro_noise).x();
    return s;
  }

  /// Where it is; height above the ellipsoid.
  const earth::Geodetic& position() const { return position_; }
  Eigen::Vector3d v_N() const { return v_N(track_) + wind_N_; }
  const Eigen::Vector3d& wind_N() const { return wind_N_; }
  Eigen::Vector3d wind_change_N = Eigen::Vector3d::Zero();  // m/s^2, from now on
  samples::GpsFix fix() {
    const earth::Geodetic seen = earth::displaced(position_, noise(errors_.gps_noise));
    samples::GpsFix s;
    s.time_us = time_us();
    s.lat = seen.lat;
    s.lon = seen.lon;
    s.h = seen.h;
    return s;
  }

  void advance() {
    const Eigen::Vector3d v_before = v_N();
    ++step_;
    const double before = now() - kInterval;
    track_ += kInterval * turn_rate(before + 0.5 * kInterval);
    C_NB_ = attitude(now(), track_);
    wind_N_ += kInterval * wind_change_N;
    position_ = earth::displaced(position_, 0.5 * kInterval * (v_before + v_N()));
    const double decay = std::exp(-kInterval / 2.8);
    gust_B_ = decay * gust_B_ + noise(errors_.gust_sigma * std::sqrt(1.0 - decay * decay));
  }

 private:
  static std::int64_t time_us(std::int64_t step) { return step * 1'000'000 / 60; }
  double now() const { return 1e-6 * static_cast<double>(time_us()); }
  double roll_at(double t) const { return roll_ + swing_ * std::sin(2.0 * math::kPi * t / 120.0); }
  double turn_rate(double t) const {
    return earth::gravity(kLat, kHeight) * std::tan(roll_at(t)) / kAirspeed;
  }
  double turn_acceleration(double t) const {
    return (turn_rate(t + 1e-4) - turn_rate(t - 1e-4)) / 2e-4;
  }
  Eigen::Matrix3d attitude(double t, double track) const {
    return math::C_NB_from_euler({roll_at(t), 3.0 * math::kDegree, track});
  }
  static Eigen::Vector3d v_N(double track) {
    return kAirspeed * Eigen::Vector3d(std::cos(track), std::sin(track), 0.0);
  }
  static Eigen::Vector3d earth_rate() { return earth::earth_rate_N(kLat); }
  Eigen::Vector3d transport_rate() const { return earth::transport_rate_N(kLat, kHeight, v_N()); }

  /// omega_NB from the attitude a moment later and earlier, and the turn of N itself.
  Eigen::Vector3d omega_at(double t) const {
    constexpr double kStep = 1e-4;
    const double rate = turn_rate(t);
    const double bend = 0.5 * turn_acceleration(t) * kStep * kStep;
    const Eigen::Matrix3d later = attitude(t + kStep, track_ + rate * kStep + bend);
    const Eigen::Matrix3d earlier = attitude(t - kStep, track_ - rate * kStep + bend);
    const Eigen::Vector3d omega_NB_B =
        math::log_quaternion(Eigen::Quaterniond(earlier.transpose() * later)) / (2.0 * kStep);
    return omega_NB_B + C_NB_.transpose() * (earth_rate() + transport_rate());
  }
  Eigen::Vector3d force_B() const {
    const Eigen::Vector3d v = v_N(track_);
    const Eigen::Vector3d acceleration =
        turn_rate(now()) * Eigen::Vector3d(-v.y(), v.x(), 0.0) + wind_change_N;
    const Eigen::Vector3d gravity(0.0, 0.0, earth::gravity(kLat, kHeight));
    return C_NB_.transpose() *
           (acceleration + (2.0 * earth_rate() + transport_rate()).cross(v_N()) - gravity);
  }
  Eigen::Vector3d noise(double sigma) {
    if (sigma == 0.0) return Eigen::Vector3d::Zero();
    std::normal_distribution<double> normal(0.0, sigma);
    return Eigen::Vector3d(normal(generator_), normal(generator_), normal(generator_));
  }

  double roll_;
  double swing_;
  double track_;
  SensorErrors errors_;
  std::mt19937 generator_;
  std::int64_t step_ = 0;
  Eigen::Matrix3d C_NB_;
  Eigen::Vector3d gust_B_ = Eigen::Vector3d::Zero();
  double baro_ = 0.0;
  Eigen::Vector3d wind_N_;
  earth::Geodetic position_{kLat, 0.3, kHeight};
};

}  // namespace lodestar::strapdown
