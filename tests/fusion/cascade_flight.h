// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "flight_simulator.h"
#include "lodestar/fusion/cascade.h"

namespace lodestar::fusion {

/// A cascade aboard a simulated flight.
class CascadeFlight {
 public:
  explicit CascadeFlight(const FlightOptions& options, const CascadeParameters& parameters = {})
      : simulator_(options), cascade_(std::make_unique<Cascade>(parameters)) {}

  /// One frame; what the cascade did with its fix, if there was one.
  std::optional<samples::Use> step() {
    const SimulatedFrame frame = simulator_.next();
    truth_ = frame.truth;
    sahrs_ = frame.sahrs;
    if (frame.air) cascade_->update(*frame.air);
    cascade_->propagate(frame.sahrs);
    if (!frame.fix) return std::nullopt;
    return cascade_->update(*frame.fix);
  }

  void fly_until(double time) {
    while (simulator_.time() < time) step();
  }

  /// Flies until `done` or `time`; the time.
  template <class Condition>
  double fly_until(double time, Condition&& done) {
    while (simulator_.time() < time && !done()) step();
    return simulator_.time();
  }

  double time() const { return simulator_.time(); }
  const Truth& truth() const { return truth_; }
  const samples::Attitude& sahrs() const { return sahrs_; }
  const samples::Navigation& navigation() const { return cascade_->navigation(); }
  Cascade& cascade() { return *cascade_; }

  /// True minus estimated (m, m/s, rad).
  Eigen::Vector3d position_error() const {
    const samples::Navigation& n = navigation();
    return earth::displacement_N({n.lat, n.lon, n.h}, truth_.position());
  }
  Eigen::Vector3d velocity_error() const { return truth_.v_N - navigation().v_N; }
  Eigen::Vector2d wind_error() const { return truth_.wind - navigation().wind_N.head<2>(); }
  double heading_error() const {
    return math::wrap_pi(truth_.attitude.heading - navigation().heading);
  }

 private:
  FlightSimulator simulator_;
  std::unique_ptr<Cascade> cascade_;
  Truth truth_;
  samples::Attitude sahrs_;
};

}  // namespace lodestar::fusion
