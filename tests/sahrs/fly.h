// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <type_traits>

#include "flight_generator.h"
#include "lodestar/sahrs/paper_sahrs.h"
#include "lodestar/sahrs/velocity_sahrs.h"

namespace lodestar::sahrs_test {

/// A form of SAHRS at the place of FlightGenerator.
template <class Form>
Form make_sahrs(const sahrs::Parameters& parameters = {},
                const sahrs::FieldCalibration& calibration = {}) {
  constexpr earth::GeomagneticKind kModel = earth::GeomagneticKind::kIgrf14;
  Form sahrs = [&] {
    if constexpr (std::is_same_v<Form, sahrs::PaperSahrs>) {
      return Form(parameters, calibration, kModel, FlightGenerator::kYear);
    } else {
      return Form(parameters, {}, calibration, kModel, FlightGenerator::kYear);
    }
  }();
  sahrs.set_position(FlightGenerator::kLat, FlightGenerator::kLon, 2000.0);
  return sahrs;
}

/// One frame as the flight computer makes it: rates, then what else is due, in order of channels.
template <class Form>
void frame(FlightGenerator& flight, Form& sahrs) {
  sahrs.propagate(flight.body_rates());
  sahrs.update(flight.load_factor());
  if (flight.slow_sensors_due()) {
    sahrs.update(flight.magnetic_field());
    sahrs.update(flight.air_data());
  }
  sahrs.finish_frame();
}

/// Flies for `duration` (s); `look` sees every frame after it was answered.
template <class Form, class Look>
void fly(FlightGenerator& flight, Form& sahrs, double duration, Look look) {
  const std::int64_t end_us = flight.time_us() + std::llround(1e6 * duration);
  while (flight.time_us() < end_us) {
    flight.step();
    frame(flight, sahrs);
    look();
  }
}

template <class Form>
void fly(FlightGenerator& flight, Form& sahrs, double duration) {
  fly(flight, sahrs, duration, [] {});
}

/// The rotation (rad, in B) from the estimated attitude to the true one.
inline Eigen::Vector3d error_B(const FlightGenerator& flight, const samples::Attitude& attitude) {
  return math::log_quaternion(attitude.q_NB.conjugate() * Eigen::Quaterniond(flight.C_NB()));
}

}  // namespace lodestar::sahrs_test
