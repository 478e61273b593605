// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lodestar/math/parameter.h"
#include "lodestar/math/rotation.h"

namespace lodestar::monitor {

/// [monitor.ins]: INS against SAHRS.
struct InsMonitorParameters {
  double level_sigma = 0.1 * math::kDegree;    // rad, of the INS: roll and pitch
  double heading_sigma = 0.2 * math::kDegree;  // rad, of the INS

  double sigmas = 6.0;
  double level_least = 2.5 * math::kDegree;    // rad
  double heading_least = 5.0 * math::kDegree;  // rad
  double change_sigmas = 2.5;
  double level_change = 3.0 * math::kDegree;       // rad
  double heading_change = 6.5 * math::kDegree;     // rad
  double usual_tau = 60.0;                         // s
  double level_departure = 3.0 * math::kDegree;    // rad
  double heading_departure = 3.5 * math::kDegree;  // rad
  double departure_tau = 30.0;                     // s
  double turn_error = 0.01;
  double frozen_turn = 1.0 * math::kDegree;  // rad

  double confirmation_time = 0.1;  // s
  double release = 0.7;
  double release_time = 10.0;  // s
  double doubt_time = 20.0;    // s

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    using math::kDegree;
    visit(self.level_sigma, {"level_sigma_deg", "deg", 0.001, 10.0,
                             "Error of the INS in roll and pitch, 1 sigma", kDegree});
    visit(self.heading_sigma, {"heading_sigma_deg", "deg", 0.001, 10.0,
                               "Error of the INS in heading, 1 sigma", kDegree});
    describe_thresholds(self, visit);
    describe_times(self, visit);
  }

 private:
  template <class Self, class Visitor>
  static void describe_thresholds(Self& self, Visitor&& visit) {
    using math::kDegree;
    visit(self.sigmas,
          {"threshold_sigmas", "-", 1.0, 20.0, "Threshold in sigmas of INS and SAHRS together"});
    visit(self.level_least,
          {"level_threshold_deg", "deg", 0.1, 45.0, "Least threshold in roll and pitch", kDegree});
    visit(self.heading_least,
          {"heading_threshold_deg", "deg", 0.1, 90.0, "Least threshold in heading", kDegree});
    visit(self.change_sigmas, {"change_sigmas", "-", 1.0, 20.0,
                               "Allowed departure from the usual difference, in the same sigmas"});
    visit(self.level_change, {"level_change_deg", "deg", 0.1, 45.0,
                              "Least allowed departure in roll and pitch", kDegree});
    visit(self.heading_change,
          {"heading_change_deg", "deg", 0.1, 90.0, "Least allowed departure in heading", kDegree});
    visit(self.usual_tau,
          {"usual_tau_s", "s", 1.0, 1e4, "Time constant of the mean that is the usual difference"});
    visit(self.level_departure, {"level_departure_deg", "deg", 0.1, 45.0,
                                 "Allowed departure from the gyros in roll and pitch, besides half "
                                 "a sigma of SAHRS",
                                 kDegree});
    visit(self.heading_departure, {"heading_departure_deg", "deg", 0.1, 90.0,
                                   "Allowed departure from the gyros in heading, besides half a "
                                   "sigma of SAHRS",
                                   kDegree});
    visit(self.departure_tau,
          {"departure_tau_s", "s", 1.0, 1e4, "Time over which the INS is compared with the gyros"});
    visit(self.turn_error, {"turn_error", "-", 0.0, 1.0,
                            "What the gyros may err by, as part of the angle turned in that time"});
    visit(
        self.frozen_turn,
        {"frozen_turn_deg", "deg", 0.01, 45.0,
         "Turn of SAHRS, while the INS repeats itself bit by bit, that makes it frozen", kDegree});
  }

  template <class Self, class Visitor>
  static void describe_times(Self& self, Visitor&& visit) {
    visit(self.confirmation_time, {"confirmation_time_s", "s", 0.0, 60.0,
                                   "Time over the threshold that makes a miscompare"});
    visit(self.release,
          {"release", "-", 0.01, 1.0, "Part of the threshold below which an axis agrees again"});
    visit(self.release_time,
          {"release_time_s", "s", 0.0, 600.0, "Time in agreement after which the INS is trusted"});
    visit(self.doubt_time,
          {"doubt_time_s", "s", 0.0, 600.0,
           "Time before a miscompare for which the heading of the INS is not trusted either"});
  }
};

}  // namespace lodestar::monitor
