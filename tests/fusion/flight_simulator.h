// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>

#include "lodestar/earth/wgs84.h"
#include "lodestar/fusion/attitude_error.h"
#include "lodestar/fusion/dead_reckoning.h"
#include "lodestar/math/gauss_markov.h"
#include "lodestar/math/rotation.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"

namespace lodestar::fusion {

/// What the simulated aircraft and its sensors are like.
struct FlightOptions {
  unsigned seed = 1;
  earth::Geodetic start{57.5 * math::kDegree, 16.0 * math::kDegree, 3000.0};
  double rate = 60.0;           // Hz, of SAHRS
  double air_data_rate = 30.0;  // Hz
  double gps_interval = 1.0;    // s
  double gps_latency = 0.2;     // s
  double speed = 200.0;         // m/s, true airspeed
  double leg = 120.0;           // s, straight legs of the racetrack
  double climb = 0.0;           // rad, pitch and flight path of odd legs
  math::GaussMarkov heading_error{1.5 * math::kDegree, 100.0};
  math::GaussMarkov pitch_error{0.4 * math::kDegree, 30.0};
  math::GaussMarkov roll_error{0.6 * math::kDegree, 10.0};
  math::GaussMarkov gps_error{5.0, 150.0};
  double gps_noise = 1.0;                    // m
  double airspeed_noise = 0.5;               // m/s
  double angle_noise = 0.1 * math::kDegree;  // rad, alpha and beta
  double airspeed_bias = 0.0;                // m/s
  double beta_bias = 0.0;                    // rad
  double baro_bias = 0.0;                    // m, true - baro
  double baro_noise = 0.5;                   // m
  double heading_offset = 0.0;               // rad, more heading error (true - SAHRS)
  // Heading error (true - SAHRS) of a compass: slow errors of its levelled components over the
  // horizontal field, forward and right.
  Eigen::Vector2d compass_error = Eigen::Vector2d::Zero();
  bool stated_sigma = true;  // SAHRS states its sigma in P_B
  std::function<Eigen::Vector2d(double)> wind = [](double) { return Eigen::Vector2d(6.0, 7.0); };
  std::function<double(double)> gps_stamp_error = [](double) { return 0.0; };  // s
  // A receiver that stays where it was, with its own noise (m).
  std::function<bool(double)> gps_freeze = [](double) { return false; };
  double gps_freeze_noise = 0.0;
  std::function<bool(double)> gps_on = [](double) { return true; };
  std::function<Eigen::Vector2d(double)> gps_jump = [](double) {
    return Eigen::Vector2d(0.0, 0.0);
  };

  /// Nothing random, nothing wrong.
  static FlightOptions perfect() {
    FlightOptions options;
    options.heading_error.sigma = options.pitch_error.sigma = options.roll_error.sigma = 0.0;
    options.gps_error.sigma = options.gps_noise = options.airspeed_noise = 0.0;
    options.angle_noise = options.baro_noise = 0.0;
    return options;
  }
};

struct Truth {
  double lat = 0.0;
  double lon = 0.0;
  double h = 0.0;
  math::Euler attitude;
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();
  Eigen::Vector2d wind = Eigen::Vector2d::Zero();
  Eigen::Vector2d gps_error = Eigen::Vector2d::Zero();
  earth::Geodetic position() const { return {lat, lon, h}; }
};

/// What reaches the flight computer at one frame, in the order it is to be used.
struct SimulatedFrame {
  std::optional<samples::AirData> air;
  samples::Attitude sahrs;
  std::optional<samples::GpsFix> fix;
  Truth truth;
};

/// A racetrack in wind: straight legs and half turns, alternately right and left.
class FlightSimulator {
 public:
  explicit FlightSimulator(const FlightOptions& options)
      : options_(options), generator_(options.seed) {
    heading_error_ = options.heading_error.sigma * normal();
    pitch_error_ = options.pitch_error.sigma * normal();
    roll_error_ = options.roll_error.sigma * normal();
    truth_.gps_error = options.gps_error.sigma * Eigen::Vector2d(normal(), normal());
    truth_.lat = options.start.lat;
    truth_.lon = options.start.lon;
    truth_.h = options.start.h;
    truth_.attitude.heading = 0.5;
    height_error_ = options.gps_error.sigma * normal();
    update_velocity();
  }

  double time() const { return static_cast<double>(frame_) / options_.rate; }

  /// The next frame; the first is at time 0.
  SimulatedFrame next() {
    if (frame_ > 0) fly(1.0 / options_.rate);
    SimulatedFrame out;
    const auto time_us = static_cast<std::int64_t>(std::llround(1e6 * time()));
    if (due(options_.air_data_rate)) out.air = air_data(time_us);
    out.sahrs = sahrs(time_us);
    if (due(1.0 / options_.gps_interval)) measure_position(time_us);
    if (!fixes_.empty() && time_us >= fixes_.front().measured_us + latency_us()) {
      out.fix = fixes_.front().fix;
      fixes_.pop_front();
    }
    out.truth = truth_;
    ++frame_;
    return out;
  }

 private:
  double normal() { return normal_(generator_); }
  std::int64_t latency_us() const {
    return static_cast<std::int64_t>(std::llround(1e6 * options_.gps_latency));
  }

  // Whether a sensor of `rate` has a sample at this frame.
  bool due(double rate) const {
    const double every = options_.rate / rate;
    const auto n = static_cast<double>(frame_);
    return std::floor(n / every + 1e-9) != std::floor((n - 1.0) / every + 1e-9);
  }

  static double walk(double x, const math::GaussMarkov& model, double dt, double noise) {
    return x * model.decay(dt) + std::sqrt(model.added_variance(dt)) * noise;
  }

  Eigen::Vector3d air_velocity() const {
    samples::AirData air;
    air.true_airspeed = options_.speed;
    air.alpha = kAlpha;
    return air_velocity_B(air);
  }

  void update_velocity() {
    truth_.wind = options_.wind(time());
    truth_.v_N = math::C_NB_from_euler(truth_.attitude) * air_velocity();
    truth_.v_N.head<2>() += truth_.wind;
  }

  void fly(double dt) {
    // Leg, half turn at 45 degrees of bank, leg, half turn the other way.
    const double rate = 9.81 * std::tan(kBank) / options_.speed;
    const double cycle = options_.leg + math::kPi / rate;
    const double phase = std::fmod(time(), 2.0 * cycle);
    const bool turning = std::fmod(phase, cycle) > options_.leg;
    const double sign = phase < cycle ? 1.0 : -1.0;
    const double bank = turning ? sign * kBank : 0.0;
    const double step = 0.5 * dt;  // rad, roll rate 0.5 rad/s
    math::Euler& attitude = truth_.attitude;
    const math::Euler attitude_before = attitude;
    attitude.roll += std::clamp(bank - attitude.roll, -step, step);
    attitude.heading += 9.81 * std::tan(attitude.roll) / options_.speed * dt;
    const double pitch = kAlpha + (sign > 0.0 ? options_.climb : -options_.climb);
    attitude.pitch += std::clamp(pitch - attitude.pitch, -0.1 * dt, 0.1 * dt);

    angle_rates_ << attitude.roll - attitude_before.roll, attitude.pitch - attitude_before.pitch,
        attitude.heading - attitude_before.heading;
    angle_rates_ /= dt;

    const Eigen::Vector3d before = earth::position_rates(truth_.lat, truth_.h, truth_.v_N);
    update_velocity();
    const Eigen::Vector3d after =
        earth::position_rates(truth_.lat + before.x() * dt, truth_.h, truth_.v_N);
    const Eigen::Vector3d moved = 0.5 * dt * (before + after);
    truth_.lat += moved.x();
    truth_.lon += moved.y();
    truth_.h += moved.z();
    heading_error_ = walk(heading_error_, options_.heading_error, dt, normal());
    pitch_error_ = walk(pitch_error_, options_.pitch_error, dt, normal());
    roll_error_ = walk(roll_error_, options_.roll_error, dt, normal());
    for (int axis = 0; axis < 2; ++axis) {
      truth_.gps_error(axis) = walk(truth_.gps_error(axis), options_.gps_error, dt, normal());
    }
    height_error_ = walk(height_error_, options_.gps_error, dt, normal());
  }

  samples::AirData air_data(std::int64_t time_us) {
    samples::AirData air;
    air.time_us = time_us;
    air.true_airspeed =
        options_.speed + options_.airspeed_bias + options_.airspeed_noise * normal();
    air.alpha = kAlpha + options_.angle_noise * normal();
    air.beta = options_.beta_bias + options_.angle_noise * normal();
    air.baro_altitude = truth_.h - options_.baro_bias + options_.baro_noise * normal();
    return air;
  }

  samples::Attitude sahrs(std::int64_t time_us) const {
    const double compass_error = deviation(truth_.attitude.heading).dot(options_.compass_error);
    const math::Euler e{
        truth_.attitude.roll - roll_error_, truth_.attitude.pitch - pitch_error_,
        truth_.attitude.heading - heading_error_ - options_.heading_offset - compass_error};
    samples::Attitude out;
    out.time_us = time_us;
    const Eigen::Matrix3d C_NB = math::C_NB_from_euler(e);
    const math::Euler angles = math::euler_from_C_NB(C_NB);
    out.q_NB = Eigen::Quaterniond(C_NB);
    out.roll = angles.roll;
    out.pitch = angles.pitch;
    out.heading = angles.heading;
    Eigen::Matrix3d rotation_by_angles;  // in B, roll, pitch, heading
    const double sr = std::sin(e.roll), cr = std::cos(e.roll);
    const double sp = std::sin(e.pitch), cp = std::cos(e.pitch);
    rotation_by_angles << 1.0, 0.0, -sp, 0.0, cr, sr * cp, 0.0, -sr, cr * cp;
    out.omega_B = rotation_by_angles * angle_rates_;
    if (options_.stated_sigma) {
      const Eigen::Vector3d sigma(options_.roll_error.sigma, options_.pitch_error.sigma,
                                  options_.heading_error.sigma);
      out.P_B =
          rotation_by_angles * sigma.cwiseAbs2().asDiagonal() * rotation_by_angles.transpose();
    }
    out.mode = samples::AttitudeMode::kRunning;
    out.valid = true;
    return out;
  }

  void measure_position(std::int64_t time_us) {
    const Eigen::Vector2d noise = options_.gps_noise * Eigen::Vector2d(normal(), normal());
    const double height_noise = options_.gps_noise * normal();
    if (!options_.gps_on(time())) return;
    const Eigen::Vector2d error = truth_.gps_error + noise + options_.gps_jump(time());
    const earth::Geodetic measured = earth::displaced(
        truth_.position(), {error.x(), error.y(), -(height_error_ + height_noise)});
    samples::GpsFix fix;
    fix.time_us = time_us + std::llround(1e6 * options_.gps_stamp_error(time()));
    fix.lat = measured.lat;
    fix.lon = measured.lon;
    fix.h = measured.h;
    if (options_.gps_freeze(time())) {
      const double trembling = options_.gps_freeze_noise / 6.4e6;
      fix.lat = frozen_.lat + trembling * normal();
      fix.lon = frozen_.lon;
    } else {
      frozen_ = fix;
    }
    fix.sigma_horizontal = fix.sigma_vertical = std::hypot(5.0, 1.0);
    fixes_.push_back({time_us, fix});
  }

  struct FixUnderWay {
    std::int64_t measured_us;
    samples::GpsFix fix;
  };

  static constexpr double kAlpha = 3.0 * math::kDegree;
  static constexpr double kBank = 45.0 * math::kDegree;

  FlightOptions options_;
  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
  Truth truth_;
  Eigen::Vector3d angle_rates_ = Eigen::Vector3d::Zero();  // rad/s, roll, pitch, heading
  double heading_error_ = 0.0;
  double pitch_error_ = 0.0;
  double roll_error_ = 0.0;
  double height_error_ = 0.0;
  samples::GpsFix frozen_;
  std::int64_t frame_ = 0;
  std::deque<FixUnderWay> fixes_;
};

}  // namespace lodestar::fusion
