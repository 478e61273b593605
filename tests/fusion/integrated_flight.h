// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <utility>

#include "../strapdown/simulated_flight.h"
#include "lodestar/fusion/integrated.h"

namespace lodestar::fusion {

/// The filter on a flight: field and air data with every second frame, a fix a second.
class IntegratedFlight {
 public:
  static Eigen::Vector2d wind() { return {8.0, -5.0}; }  // m/s, north, east

  IntegratedFlight(const strapdown::SensorErrors& errors, std::uint32_t seed,
                   double heading_error = 0.0, double heading_sigma = 0.1 * math::kDegree,
                   const strapdown::Parameters& sensors = {},
                   const IntegratedParameters& parameters = {}, double swing = 35.0 * math::kDegree)
      : flight_(0.0, swing, 0.4 * seed, errors, seed + 1000, wind()),
        filter_(std::make_unique<Integrated>(parameters, sensors,
                                             strapdown::GuardLimits{60.0, 0.01, 0.1},
                                             earth::GeomagneticKind::kIgrf14, 2026.5)) {
    error_ = math::exp_so3(Eigen::Vector3d(0.0, 0.0, heading_error));
    sahrs_.P_B = Eigen::Vector3d(0.1 * math::kDegree, 0.1 * math::kDegree, heading_sigma)
                     .cwiseAbs2()
                     .asDiagonal();
    sahrs_.mode = samples::AttitudeMode::kRunning;
    sahrs_.valid = true;
    place();
  }

  void fly(double seconds) {
    const int frames = static_cast<int>(std::lround(60.0 * seconds));
    for (int i = 0; i < frames; ++i, ++frame_) {
      if (!silent) fly_frame();
      flight_.advance();
    }
  }

  const samples::Navigation& nav() const { return filter_->navigation(); }
  Integrated& filter() { return *filter_; }
  Eigen::Vector2d position_error() const {
    const earth::Geodetic estimated{nav().lat, nav().lon, flight_.position().h};
    return earth::displacement_N(flight_before_, estimated).head<2>();
  }
  Eigen::Vector2d velocity_error() const { return (nav().v_N - v_N_before_).head<2>(); }
  double heading_error() const {
    return math::wrap_pi(nav().heading - math::euler_from_C_NB(C_NB_before_).heading);
  }
  double sahrs_heading() const {
    return math::euler_from_C_NB(sahrs_.q_NB.toRotationMatrix()).heading;
  }
  Eigen::Vector2d wind_error() const { return (nav().wind_N - wind_N_before_).head<2>(); }
  /// From now on the wind changes by `change` (m/s^2, north, east).
  void change_wind(const Eigen::Vector2d& change) { flight_.wind_change_N.head<2>() = change; }

  bool silent = false;  // no body rates
  bool with_gps = true;
  bool with_air = true;
  bool with_field = true;
  double airspeed_error = 0.0;  // m/s
  std::size_t latency_frames = 0;
  std::function<void(samples::GpsFix&)> spoil = [](samples::GpsFix&) {};
  samples::Use last_use = samples::Use::kHeld;
  int used = 0;
  int airspeed_refused = 0;

 private:
  void place() {
    const earth::Geodetic& at = flight_.position();
    filter_->set_position(at.lat, at.lon, at.h);
  }

  void fly_frame() {
    filter_->propagate(flight_.rates());
    filter_->update(flight_.load_factor());
    if (frame_ % 2 == 0) {
      samples::MagneticField field = flight_.field();
      field.b_B +=
          flight_.C_NB().transpose() * (filter_field() - strapdown::SimulatedFlight::field_N());
      if (with_field) filter_->update(field);
      samples::AirData air = flight_.air_data();
      air.true_airspeed += airspeed_error;
      if (with_air) {
        filter_->update(air);
        const strapdown::GroundFilter& inside = std::as_const(*filter_).filter();
        airspeed_refused += inside.rejected() >> strapdown::GroundFilter::kAirspeed & 1;
      }
    }
    sahrs_.q_NB = Eigen::Quaterniond(error_ * flight_.C_NB());
    sahrs_.heading = sahrs_heading();
    filter_->follow(sahrs_);
    if (frame_ % 60 == 30 && with_gps) fixes_.push_back({flight_.fix(), frame_ + latency_frames});
    if (!fixes_.empty() && fixes_.front().second <= frame_) {
      samples::GpsFix fix = fixes_.front().first;
      fixes_.pop_front();
      spoil(fix);
      last_use = filter_->update(fix);
      if (last_use == samples::Use::kUsed) ++used;
    }
    flight_before_ = flight_.position();
    C_NB_before_ = flight_.C_NB();
    v_N_before_ = flight_.v_N();
    wind_N_before_ = flight_.wind_N();
  }

  /// The model's field where the filter was placed: the flight's is another.
  static Eigen::Vector3d filter_field() {
    static const Eigen::Vector3d b_N = [] {
      earth::GeomagneticModel model(earth::GeomagneticKind::kIgrf14);
      return Eigen::Vector3d(model.field_N(strapdown::SimulatedFlight::kLat, 0.3,
                                           strapdown::SimulatedFlight::kHeight, 2026.5));
    }();
    return b_N;
  }

  strapdown::SimulatedFlight flight_;
  std::unique_ptr<Integrated> filter_;
  samples::Attitude sahrs_;
  Eigen::Matrix3d error_;  // of SAHRS, in N
  std::deque<std::pair<samples::GpsFix, std::size_t>> fixes_;
  std::size_t frame_ = 0;
  earth::Geodetic flight_before_;
  Eigen::Matrix3d C_NB_before_;
  Eigen::Vector3d v_N_before_;
  Eigen::Vector3d wind_N_before_;
};

}  // namespace lodestar::fusion
