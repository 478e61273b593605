// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "lodestar/filter/gate.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"
#include "lodestar/strapdown/delayed.h"
#include "lodestar/strapdown/gust.h"
#include "lodestar/strapdown/history.h"
#include "lodestar/strapdown/parameters.h"
#include "lodestar/strapdown/propagation.h"
#include "lodestar/strapdown/state.h"

namespace lodestar::strapdown {

/// Attitude, and velocity relative to the air, from gyros, load factor, magnetic field and air data:
/// an error-state filter whose states are those of state.h. It has no Euler angle anywhere.
///
/// Samples come in the order of their time, at most 1 s older than the last body rates; each is
/// applied at its own time. After construction nothing allocates or throws.
class VelocityFilter {
 public:
  /// Measurements, in the order of `innovation`.
  enum Row { kFieldX, kFieldY, kFieldZ, kAirspeed, kAlpha, kBeta, kBaro };
  static constexpr int kRows = 7;
  using Rows = std::array<double, kRows>;  // nT x3 in B, m/s, rad x2, m

  explicit VelocityFilter(const Parameters& parameters);

  /// Latitude (rad), height (m) and the model's magnetic field there (nT, in N).
  void set_place(double lat, double h, const Eigen::Vector3d& b_N);

  /// Starts, or starts again, from an attitude known to `sigma_B` (rad, about the body axes). The
  /// air velocity and the height follow from the next air data. What is known of the sensors stays.
  void start(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B, std::int64_t time_us);

  /// One frame from the last `time_us` to this, at the trapezoidal rate. `extra_angle` (rad^2, per
  /// axis): variance of what a gap in the rates hides.
  void propagate(const samples::BodyRates& sample, double extra_angle_variance = 0.0);

  samples::Use update(const samples::LoadFactor& sample);
  samples::Use update(const samples::MagneticField& sample);  // calibrated
  samples::Use update(const samples::AirData& sample);

  const Estimate& estimate() const { return x_; }
  /// Lower triangle only; see sparse_update.h.
  const Covariance& covariance() const { return P_; }
  /// Covariance of the small rotation about the body axes (rad^2).
  Eigen::Matrix3d attitude_covariance_B() const;
  /// Rate of B relative to the inertial frame, corrected (rad/s).
  Eigen::Vector3d omega_B() const;
  double gust_sigma() const { return gust_level_.sigma(); }
  bool has_velocity() const { return has_velocity_; }

  /// Latest innovations, measured minus predicted, and their standard deviations; 0 before the first.
  const Rows& innovation() const { return innovation_; }
  const Rows& innovation_sigma() const { return innovation_sigma_; }
  /// Bits of `Row`: what this frame's measurements did.
  int used() const { return used_; }
  int rejected() const { return rejected_; }

 private:
  ProcessNoise process_noise(double dt) const;
  Eigen::Vector3d force_to_use(double& density) const;
  void start_velocity(const samples::AirData& sample);
  void remember(const Eigen::Vector3d& force_B, double dt);
  bool locate(std::int64_t time_us, Moment& moment) const;
  Estimate estimate_at(const Moment& moment) const;
  Delay delay_of(const Moment& moment) const;
  template <class Measurement>
  samples::Use correct(const Measurement& m, const Moment& moment, Row first, bool together);
  template <class Measurement>
  samples::Use correct_now(const Measurement& m, Row first, bool together);

  Parameters parameters_;
  filter::Gate gate_;
  Place place_;
  double lat_ = 0.0;
  double h_ = 0.0;
  Eigen::Vector3d b_N_ = Eigen::Vector3d::Zero();

  Estimate x_;
  Covariance P_;
  GustLevel gust_level_;
  History history_;
  Corrections corrections_;
  bool has_velocity_ = false;

  std::int64_t now_us_ = 0;
  bool have_rates_ = false;
  Eigen::Vector3d measured_omega_B_ = Eigen::Vector3d::Zero();
  bool have_load_ = false;
  std::int64_t load_us_ = 0;
  Eigen::Vector3d force_B_ = Eigen::Vector3d::Zero();    // m/s^2, latest measured
  Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();    // the same in N, at its time
  Eigen::Vector3d impulse_at_load_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d impulse_N_ = Eigen::Vector3d::Zero();
  std::int64_t air_us_ = 0;

  Rows innovation_{};
  Rows innovation_sigma_{};
  int used_ = 0;
  int rejected_ = 0;
};

}  // namespace lodestar::strapdown
