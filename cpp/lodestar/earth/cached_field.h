// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/earth/geomagnetic_model.h"

namespace lodestar::earth {

/// The geomagnetic field for a real-time loop: held while the aircraft has not moved far enough for
/// it to have changed by `tolerance` (nT), evaluated anew when it has.
///
/// The change is bounded, not measured, by the steepest gradients of either model anywhere on the
/// Earth from -1 km up and at any epoch since 1900: 0.0164 nT/m horizontally, 0.0356 nT/m
/// vertically and 303 nT a year, taken a little larger; and by the turn of north itself on the way
/// east, which grows without limit towards the poles. 1 nT is about 55 m horizontally or 26 m
/// vertically, and thus one evaluation in 0.2 s at 250 m/s.
class CachedField {
 public:
  explicit CachedField(GeomagneticKind kind, double tolerance = 1.0);

  /// Field (nT) in N, within `tolerance` of GeomagneticModel::field_N at the same arguments.
  const Eigen::Vector3d& field_N(double lat, double lon, double h, double decimal_year);

  ModelValidity validity(double decimal_year, double h) const {
    return model_.validity(decimal_year, h);
  }

 private:
  double change_bound(double lat, double lon, double h, double decimal_year) const;

  GeomagneticModel model_;
  double tolerance_;
  // Where field_N_ was evaluated; not a number before the first time.
  double lat_;
  double lon_;
  double h_;
  double decimal_year_;
  double sin_lat_;
  double cos_lat_;
  double horizontal_field_;  // nT
  Eigen::Vector3d field_N_;
};

}  // namespace lodestar::earth
