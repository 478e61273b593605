// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "lodestar/filter/ud.h"
#include "lodestar/fusion/cascade_model.h"

namespace lodestar::fusion {

/// Covariance of the error states, plain or in UD factors.
class ErrorCovariance {
 public:
  ErrorCovariance() = default;
  ErrorCovariance(CovarianceForm form, const StateMatrix& P);

  StateMatrix matrix() const;
  /// Covariance of `m` x.
  Eigen::Matrix2d projected(const PositionMatrix& m) const;
  /// Over `dt` (s) of x' = F x + G w, w of spectral densities `q`.
  void propagate(const StateMatrix& F, const NoiseMatrix& G, const NoiseVector& q, double dt);
  /// Takes in y = H x + noise of variance `r` per component; answers the correction of x.
  StateVector update(const PositionMatrix& H, double r, const Eigen::Vector2d& innovation);
  void assign(const StateMatrix& P);

 private:
  CovarianceForm form_ = CovarianceForm::kJoseph;
  StateMatrix P_ = StateMatrix::Zero();
  filter::UdCovariance<kStates> ud_;
};

/// An angle error (rad) and its variance (rad^2), as another reference gives them.
struct KnownAngle {
  double error = 0.0;
  double variance = 0.0;
};

/// What the model of one step takes from outside.
struct StepConditions {
  Eigen::Vector3d angle_variance = Eigen::Vector3d::Zero();  // rad^2, along angle_axes()
  double gust_density = 0.0;                                 // (m/s)^2 s, per axis
  double turn_rate = 0.0;                                    // rad/s, about the vertical, >= 0
  bool air_data_lost = false;
  bool sahrs_restarted = false;             // its errors are new ones at the end of the step
  std::optional<KnownAngle> heading_error;  // known from elsewhere at the end of the step
};

/// The estimated errors and their covariance at one time.
struct ErrorEstimate {
  StateVector x = StateVector::Zero();
  ErrorCovariance P;

  /// From `from` to `to`, trapezoidal in the two linearisations.
  void propagate(const CascadeParameters& parameters, const StepConditions& conditions,
                 const TrackPoint& from, const TrackPoint& to);

  Eigen::Vector2d position_error() const { return x.segment<2>(kPositionError.offset); }
  Eigen::Vector2d wind() const { return x.segment<2>(kWind.offset); }

  /// Makes the wind unknown by `sigma` (m/s, per axis) more than it was.
  void doubt_wind(double sigma);

  /// Makes the position unknown by `position_sigma` (m, per axis) more than it was, and scales what
  /// is unknown of wind and angles by `scale` in sigma.
  void loosen(const Eigen::Vector2d& position_sigma, double scale);

 private:
  void restart_angles(const Eigen::Matrix3d& angles, double deviation_variance);
  void take_heading_error(const KnownAngle& known, AttitudeError form, const TrackPoint& point);
};

}  // namespace lodestar::fusion
