// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "lodestar/math/scalar.h"
#include "lodestar/strapdown/ground_parameters.h"
#include "lodestar/strapdown/whiteness.h"

namespace lodestar::strapdown {

/// How little the wind may change: the least level of its random walk.
///
/// What the load factor's noise makes of the velocity (0.03 m/s/sqrt(s)) hides from the air data
/// whether the wind changes by less. So the air is taken for still until something speaks against
/// it: gusts, a step of the wind, or fixes whose innovations lean one way for a minute, as they do
/// where wind that changes is held to be constant. Then the least level is that of air of which
/// nothing is known, and only comes down again with time. Without fixes it slowly goes there by
/// itself, as nothing would speak against still air, and comes back when they do.
class StillAir {
 public:
  static constexpr double kCalm = 0.1;  // m/s of gusts, less is none

  /// `unknown_walk` (m/s/sqrt(s)): the least level of air of which nothing is known.
  StillAir(const GroundParameters& parameters, double unknown_walk)
      : parameters_(parameters),
        unknown_walk_(unknown_walk),
        threshold_(-std::log(parameters.still_false_alarm)) {
    parameters_.still_wind_walk = std::min(parameters_.still_wind_walk, unknown_walk);
  }

  /// `gust_sigma` (m/s): of the gusts; `step` (m/s/sqrt(s)): what of the wind's level is a step;
  /// `lost`: there is no GPS; `dt` (s) after the last ones.
  void see_air(double gust_sigma, double step, bool lost, double dt) {
    gust_sigma_ = gust_sigma;
    lost_ = lost;
    changed_ *= std::exp(-dt / parameters_.still_after);
    if (step > 0.0) changed_ = unknown_walk_;
    const double aim = lost ? unknown_walk_ : 0.0;
    const double time = lost ? parameters_.still_lost : kMemory;
    unheard_ = aim + std::exp(-dt / time) * (unheard_ - aim);
  }

  /// Innovations of a fix over their standard deviations, `dt` (s) after the last one. Answers by
  /// how much (m/s, 1 sigma) the wind is less known than a filter for still air holds it to be: 0
  /// unless the fixes have just spoken against still air.
  double see_fix(const std::array<double, 2>& normalised, double dt) {
    if (fixes_.see(normalised, dt) <= threshold_) return 0.0;
    const double before = changed_;
    changed_ = unknown_walk_;
    return std::sqrt(kUnseen * (math::square(unknown_walk_) - math::square(before)));
  }

  /// Whether nothing speaks against it.
  bool still() const {
    return gust_sigma_ < kCalm && std::max(changed_, unheard_) < 0.5 * unknown_walk_;
  }
  /// The least level (m/s/sqrt(s)). Gusts come with a wind that changes, the more without GPS: a
  /// level that is too low then adds up, and among gusts it can hardly be seen.
  double least_walk() const {
    const double gusts = std::sqrt(std::max(math::square(gust_sigma_) - math::square(kCalm), 0.0));
    const double ratio = lost_ ? parameters_.lost_wind_walk : parameters_.gust_wind_walk;
    return std::max({parameters_.still_wind_walk, changed_, unheard_, ratio * gusts});
  }

 private:
  static constexpr double kMemory = 60.0;   // s, of the innovations of fixes
  static constexpr double kUnseen = 200.0;  // s of change that fixes speak of too late

  GroundParameters parameters_;
  double unknown_walk_;
  double threshold_;
  double gust_sigma_ = 0.0;
  bool lost_ = false;
  double changed_ = 0.0;  // m/s/sqrt(s), the least level since the wind changed
  double unheard_ = 0.0;  // m/s/sqrt(s), the least level without fixes
  Whiteness<2> fixes_{kMemory};
};

}  // namespace lodestar::strapdown
