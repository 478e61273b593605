// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "lodestar/fusion/error_filter.h"
#include "lodestar/samples/outputs.h"

namespace lodestar::fusion {

/// Stationary variances of the three angle states along their axes (rad^2): what SAHRS says of
/// itself, and no less than configured.
Eigen::Vector3d angle_variance(const CascadeParameters& parameters, const samples::Attitude& sahrs);

/// 1 sigma of roll, pitch and heading (rad) of a small rotation of covariance `P_B` (rad^2, in B).
Eigen::Vector3d angle_sigma(const math::Euler& attitude, const Eigen::Matrix3d& P_B);

/// Fills the horizontal standard deviations of position, velocity and wind, and those of the
/// attitude: the filter's, and of what its states leave out: sample noise, gusts of
/// `gust_variance` ((m/s)^2), constant errors of airspeed and sideslip.
void state_sigma(const CascadeParameters& parameters, const TrackPoint& point,
                 const ErrorEstimate& estimate, const StepConditions& conditions,
                 double gust_variance, samples::Navigation& navigation);

}  // namespace lodestar::fusion
