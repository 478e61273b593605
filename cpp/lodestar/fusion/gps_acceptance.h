// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "lodestar/math/parameter.h"

namespace lodestar::fusion {

/// When a fix is believed: keys of both filters. And what is known of the position at the first
/// frame, which the navigator sets from [initial].
struct GpsAcceptance {
  double gps_false_rejection = 1e-5;  // -
  double gps_timeout = 5.0;           // s
  double reacquisition_time = 3.0;    // s

  std::optional<double> initial_lat;     // rad
  std::optional<double> initial_lon;     // rad
  double initial_position_sigma = 10.0;  // m

 protected:
  template <class Self, class Visitor>
  static void describe_acceptance(Self& self, Visitor&& visit) {
    visit(self.gps_false_rejection,
          {"gps_false_rejection", "-", 1e-12, 0.1, "Probability that the gate refuses a good fix"});
    visit(self.gps_timeout,
          {"gps_timeout_s", "s", 0.5, 60.0, "Time without a used fix that makes GPS lost"});
    visit(self.reacquisition_time,
          {"reacquisition_time_s", "s", 0.0, 8.0,
           "Time over which fixes must agree among themselves to be believed again"});
  }
};

}  // namespace lodestar::fusion
