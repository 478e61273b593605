// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "lodestar/filter/gate.h"
#include "lodestar/math/scalar.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"
#include "lodestar/strapdown/delayed.h"
#include "lodestar/strapdown/frozen_flow.h"
#include "lodestar/strapdown/gps_aid.h"
#include "lodestar/strapdown/ground_parameters.h"
#include "lodestar/strapdown/gust.h"
#include "lodestar/strapdown/history.h"
#include "lodestar/strapdown/parameters.h"
#include "lodestar/strapdown/propagation.h"
#include "lodestar/strapdown/scaled_flow.h"
#include "lodestar/strapdown/sparse_update.h"
#include "lodestar/strapdown/state.h"
#include "lodestar/strapdown/still_air.h"
#include "lodestar/strapdown/wind_level.h"

namespace lodestar::strapdown {

/// Attitude, and velocity relative to the air, from gyros, load factor, magnetic field and air
/// data: an error-state filter whose states are those of state.h. It has no Euler angle anywhere.
///
/// Samples come in the order of their time, at most 1 s older than the last body rates; each is
/// applied at its own time. After construction nothing allocates or throws.
///
/// With N = kGroundStates it also holds position and wind, and takes GPS.
template <int N>
class StrapdownFilter {
 public:
  using Vector = StateVectorOf<N>;
  using Matrix = CovarianceOf<N>;

  /// Measurements, in the order of `innovation`.
  enum Row { kFieldX, kFieldY, kFieldZ, kAirspeed, kAlpha, kBeta, kBaro };
  static constexpr int kRows = 7;
  using Rows = std::array<double, kRows>;  // nT x3 in B, m/s, rad x2, m

  explicit StrapdownFilter(const Parameters& parameters, const GroundParameters& ground = {});

  /// Latitude (rad), height (m) and the model's magnetic field there (nT, in N).
  void set_place(double lat, double h, const Eigen::Vector3d& b_N);

  /// Starts, or starts again, from an attitude known to `sigma_B` (rad, about the body axes). The
  /// air velocity and the height follow from the next air data. What is known of the sensors stays.
  void start(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B, std::int64_t time_us);

  /// From here on all equations are linearised about the present attitude as the gyros carry it on,
  /// and not about the estimate, which goes its own way. While heading is known to some degrees
  /// only the estimate moves by degrees, and what was learnt at one heading is wrong at the next:
  /// the filter would take its own moves for turns of the aircraft and the hard iron for observed.
  void hold_linearisation();
  /// Starts again from the estimated motion, as if the attitude were known to `sigma_B` (rad, about
  /// the body axes) and nothing of the sensors, with all equations linearised about the estimate.
  void start_again(const Eigen::Vector3d& sigma_B);

  /// Adds to the gyro bias that is taken off (rad/s), as an alignment has found it.
  void correct_gyro_bias(const Eigen::Vector3d& more_B) { x_.gyro_bias_B += more_B; }
  /// Adds to the variance of heading (rad^2).
  void doubt_heading(double variance) {
    P_(kAttitude.offset + 2, kAttitude.offset + 2) += variance;
  }

  /// One frame from the last `time_us` to this, at the trapezoidal rate. `extra_angle` (rad^2, per
  /// axis): variance of what a gap in the rates hides.
  void propagate(const samples::BodyRates& sample, double extra_angle_variance = 0.0);

  samples::Use update(const samples::LoadFactor& sample);
  samples::Use update(const samples::MagneticField& sample);  // calibrated
  samples::Use update(const samples::AirData& sample);

  /// Over the ground: the position (rad) is known anew, to `sigma` (m, per axis).
  void set_ground_position(double lat, double lon, double sigma);
  /// Where there are no air data: air velocity and height begin with the ground velocity `v_N`
  /// (m/s) and `height` (m) that two fixes make, and with the wind as it is estimated. They are
  /// next to unknown then; fixes tell them.
  void start_over_ground(const Eigen::Vector3d& v_N, double height);
  /// Moves it by `offset` (m, north, east).
  void displace(const Eigen::Vector2d& offset) { x_.displace(offset); }
  /// What was estimated at `time_us`, as far as it is known now; none before the last second.
  std::optional<GroundPoint> ground_at(std::int64_t time_us) const;
  /// Sum of all that was corrected of the position since the start (m, north, east).
  const Eigen::Vector2d& position_corrections() const { return corrections_.position; }
  /// The same of the heading (rad).
  double heading_corrections() const { return corrections_.heading; }
  /// 1 sigma of the gyro bias about the vertical (rad/s).
  double yaw_bias_sigma() const {
    const Eigen::RowVector3d down_B = x_.C_NB.row(2);
    const Eigen::Matrix3d P_B = P_.template block<3, 3>(kGyroBias.offset, kGyroBias.offset)
                                    .template selfadjointView<Eigen::Lower>();
    return std::sqrt(down_B * P_B * down_B.transpose());
  }
  /// Takes in a measurement of gps_aid.h whose innovation was formed with the best estimate.
  template <class Measurement>
  void apply(const SparseUpdate<N, Measurement>& update) {
    take(update.apply(P_));
  }
  /// Makes position (m) and wind (m/s) unknown by so much more than they were, 1 sigma per axis.
  void doubt_ground(const Eigen::Vector2d& position, const Eigen::Vector2d& wind) {
    auto diagonal = P_.diagonal();
    part<2>(diagonal, kPosition) += position.cwiseAbs2();
    for (int axis = 0; axis < 2; ++axis) {
      const double variance = wind(axis) * wind(axis);
      P_(kWind.offset + axis, kWind.offset + axis) += variance;
      P_(kMeanWind.offset + axis, kWind.offset + axis) += variance;
      P_(kMeanWind.offset + axis, kMeanWind.offset + axis) += variance;
    }
  }
  /// Starts with the levels of calm air; they are learnt from there as from any others.
  void presume_calm_air() {
    gust_level_.set(StillAir::kCalm);
    wind_level_.settle();
  }
  /// Whether the air still is as presumed: gusts would have raised one level or the other.
  bool in_calm_air() const {
    constexpr double kMargin = 1.5;
    return gust_sigma() < kMargin * StillAir::kCalm && wind_level_.step() == 0.0;
  }
  /// Innovations of a fix over their standard deviations (north, east), `dt` (s) after the last
  /// one: whether they speak against still air.
  void hear_fix(const Eigen::Vector2d& normalised, double dt) {
    const double doubt = still_air_.see_fix({normalised.x(), normalised.y()}, dt);
    if (doubt > 0.0) doubt_ground(Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(doubt));
  }
  /// Whether GPS is lost: see still_air.h.
  void set_gps_lost(bool lost) { gps_lost_ = lost; }

  Estimate estimate() const;
  /// Lower triangle only; see sparse_update.h.
  const Matrix& covariance() const { return P_; }
  /// Covariance of the small rotation about the body axes (rad^2).
  Eigen::Matrix3d attitude_covariance_B() const;
  /// Variances of the small rotation about north, east and down (rad^2).
  Eigen::Vector3d attitude_variance_N() const {
    return P_.diagonal().template segment<kAttitude.size>(kAttitude.offset);
  }
  /// Rate of B relative to the inertial frame (rad/s), of what the gyros measure.
  Eigen::Vector3d corrected(const Eigen::Vector3d& measured_omega_B) const {
    return measured_omega_B - x_.gyro_matrix * measured_omega_B - x_.gyro_bias_B;
  }
  const Parameters& parameters() const { return parameters_; }
  double gust_sigma() const { return gust_level_.sigma(); }
  double wind_walk() const { return wind_level_.walk(); }
  bool has_velocity() const { return has_velocity_; }
  /// What of the latest air data is frozen: bits of FrozenFlow.
  int frozen_flow() const { return frozen_; }

  /// Latest innovations, measured minus predicted, and their standard deviations; 0 before the
  /// first.
  const Rows& innovation() const { return innovation_; }
  const Rows& innovation_sigma() const { return innovation_sigma_; }
  /// Bits of `Row`: what this frame's measurements did.
  int used() const { return used_; }
  int rejected() const { return rejected_; }

 private:
  // Silence after which no load factor holds.
  static constexpr std::int64_t kFresh_us = 200'000;

  ProcessNoise process_noise(double dt) const;
  Eigen::Vector3d best_velocity(const Eigen::Vector3d& air_velocity_N) const;
  // Where there is a ground: ground_filter.cpp.
  void fly_over_ground(const Step& step, const ProcessNoise& noise);
  void restart_ground(const Estimate& best, const Matrix& before);
  void take(const Vector& correction);
  Eigen::Vector3d force_to_use(double& density) const;
  void settle();
  void fold_in(const Vector& correction);
  void forget_history();
  void start_velocity(const samples::AirData& sample);
  void follow_transport();
  void follow_baro(const samples::AirData& sample);
  void remember(const Eigen::Vector3d& force_B, double dt);
  bool locate(std::int64_t time_us, Moment& moment) const;
  Delay delay(const Moment& moment) const {
    return delay_since(moment, x_, math::seconds(now_us_ - moment.time_us), place_.gravity);
  }
  void learn_air(double dt);
  template <class Measurement>
  samples::Use correct(const Measurement& m, Row first, bool together, int left_out = 0);

  Parameters parameters_;
  GroundParameters ground_;
  filter::Gate gate_;
  Place place_;
  double h_ = 0.0;
  Eigen::Vector3d b_N_ = Eigen::Vector3d::Zero();

  Estimate x_;
  Matrix P_;
  GustLevel gust_level_;
  WindLevel wind_level_;
  StillAir still_air_;
  FrozenFlow frozen_flow_;
  ScaledFlow scaled_flow_;
  int frozen_ = 0;
  History history_;
  Eigen::Vector2d travelled_ = Eigen::Vector2d::Zero();  // m, over the ground since the start
  Corrections corrections_;
  bool has_velocity_ = false;
  bool gps_lost_ = false;

  std::int64_t now_us_ = 0;
  bool have_rates_ = false;
  Eigen::Vector3d measured_omega_B_ = Eigen::Vector3d::Zero();
  bool have_load_ = false;
  std::int64_t load_us_ = 0;                           // its time
  std::int64_t load_heard_us_ = 0;                     // when it came
  Eigen::Vector3d force_B_ = Eigen::Vector3d::Zero();  // m/s^2, latest measured
  Eigen::Vector3d force_N_ = Eigen::Vector3d::Zero();  // the same in N, at its time
  Eigen::Vector3d impulse_at_load_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d impulse_N_ = Eigen::Vector3d::Zero();
  std::int64_t air_us_ = 0;
  std::int64_t baro_used_us_ = 0;

  // Corrections of the attitude (rad, in N) that P_ has not been turned by yet.
  Eigen::Vector3d unturned_N_ = Eigen::Vector3d::Zero();
  bool held_ = false;               // x_ keeps the attitude to linearise about
  Vector offset_ = Vector::Zero();  // the estimate less x_ while held; attitude only

  Rows innovation_{};
  Rows innovation_sigma_{};
  int used_ = 0;
  int rejected_ = 0;
};

/// Attitude from the air alone, and with GPS.
using VelocityFilter = StrapdownFilter<kStates>;
using GroundFilter = StrapdownFilter<kGroundStates>;

// Only a filter with a ground has these.
template <>
void GroundFilter::fly_over_ground(const Step& step, const ProcessNoise& noise);
template <>
void GroundFilter::restart_ground(const Estimate& best, const Matrix& before);
template <>
void GroundFilter::set_ground_position(double lat, double lon, double sigma);
template <>
void GroundFilter::start_over_ground(const Eigen::Vector3d& v_N, double height);
template <>
std::optional<GroundPoint> GroundFilter::ground_at(std::int64_t time_us) const;

extern template class StrapdownFilter<kStates>;
extern template class StrapdownFilter<kGroundStates>;

}  // namespace lodestar::strapdown
