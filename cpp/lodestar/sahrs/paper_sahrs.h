// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "lodestar/earth/cached_field.h"
#include "lodestar/filter/gate.h"
#include "lodestar/math/rotation.h"
#include "lodestar/sahrs/alignment.h"
#include "lodestar/sahrs/error_model.h"
#include "lodestar/sahrs/parameters.h"
#include "lodestar/sahrs/pose_history.h"
#include "lodestar/sahrs/rate_filter.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"
#include "lodestar/strapdown/field_suspicion.h"
#include "lodestar/strapdown/frozen_flow.h"
#include "lodestar/strapdown/saturated_rates.h"

namespace lodestar::sahrs {

/// Synthetic attitude and heading reference, in the form of the SAHRS paper: nine states, five
/// measurements. Attitude is a quaternion carried by the body rates with the exact exponential; the
/// filter estimates its error and folds it in after each measurement.
///
/// Samples have passed the checks of samples/validity.h and come in the order of their time. A
/// sample may be up to 1 s older than the last body rates, and is applied at its own time. After
/// construction nothing allocates or throws.
class PaperSahrs {
 public:
  /// Measurements, in the order of the bits of Attitude::used and of `innovation`.
  enum Row { kFieldNorth, kFieldEast, kFieldDown, kPitch, kRoll };
  static constexpr int kRows = 5;
  using Rows = std::array<double, kRows>;  // nT x3, rad x2

  PaperSahrs(const Parameters& parameters, const FieldCalibration& calibration,
             earth::GeomagneticKind field_model, double epoch_year);

  /// Where the aircraft is: latitude, longitude (rad), height (m). For the field model, gravity and
  /// the Earth's rotation only; a few kilometres do not matter.
  void set_position(double lat, double lon, double h);

  /// The attitude at `time_us`, known from elsewhere to `sigma_B` (rad, about the body axes), in
  /// place of the alignment by vector measurements.
  void start(const math::Euler& attitude, const Eigen::Vector3d& sigma_B, std::int64_t time_us);

  /// One frame. A gap since the last one is bridged, with the covariance grown, up to 0.5 s; a
  /// longer one is followed by a new alignment.
  void propagate(const samples::BodyRates& sample);

  samples::Use update(const samples::LoadFactor& sample);
  samples::Use update(const samples::MagneticField& sample);
  samples::Use update(const samples::AirData& sample);

  /// Brings `attitude` up to date, after the last update of a frame.
  void finish_frame();
  const samples::Attitude& attitude() const { return attitude_; }

  /// Latest innovations, measured minus predicted, and their standard deviations; 0 before the
  /// first.
  const Rows& innovation() const { return innovation_; }
  const Rows& innovation_sigma() const { return innovation_sigma_; }
  /// How often each assumption kept a measurement out.
  const std::array<std::int64_t, kAssumptions>& assumption_rejects() const {
    return assumption_rejects_;
  }
  const Covariance& covariance() const { return P_; }

 private:
  enum class State { kWaiting, kRunning, kRealigning };

  // A pose in N, at the time of a measurement.
  struct Moment {
    Pose pose;
    Eigen::Matrix3d C_NB;
  };

  static constexpr double kLongestBridge = 0.5;          // s of silence that are bridged
  static constexpr std::int64_t kOldest_us = 1'000'000;  // age up to which a sample comes
  static constexpr std::int64_t kFresh_us = 500'000;     // between samples that are used together

  void integrate(const Eigen::Vector3d& before_B, double dt);
  bool needs_alignment() const { return state_ != State::kRunning || lost_; }
  void try_alignment();
  void set_attitude(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B);
  void count_reset(const Eigen::Vector3d& turn_B);
  samples::AttitudeMode mode(bool certain) const;

  void track_air_data(const samples::AirData& sample);
  samples::Use update_pitch(const Moment& moment);
  samples::Use update_roll(const Moment& moment, const samples::LoadFactor& sample);
  void doubt_heading(double dt);
  bool holds(bool assumption, Assumption which);
  samples::Use reject(Row row);
  double interval(Row row, std::int64_t time_us) const;
  bool moment_at(std::int64_t time_us, Moment& moment) const;
  template <int M>
  samples::Use correct(Measurement<M>& measurement, const Moment& moment, Row first);
  void fold_in(const Eigen::Matrix<double, kEstimated, 1>& correction);

  Parameters parameters_;
  FieldCalibration calibration_;
  double epoch_year_;
  earth::CachedField field_model_;
  double min_cos_pitch_;
  filter::Gate gate_;
  ErrorModel error_model_;

  // Position and what follows from it.
  double lat_ = 0.0;
  double h_ = 0.0;
  double gravity_ = samples::kStandardGravity;
  Eigen::Vector3d b_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d earth_rate_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d transport_rate_N_ = Eigen::Vector3d::Zero();

  // The estimate.
  State state_ = State::kWaiting;
  bool lost_ = false;  // running, but so uncertain that an alignment is better
  Eigen::Quaterniond q_NS_ = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d C_NB_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d gyro_bias_B_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d field_bias_B_ = Eigen::Vector3d::Zero();
  Covariance P_;
  PoseHistory history_;
  Alignment alignment_;
  strapdown::SaturatedRates saturated_rates_;

  // The latest of each channel, and what follows from it.
  bool have_rates_ = false;
  std::int64_t now_us_ = 0;
  double frame_interval_ = 0.0;
  Eigen::Vector3d omega_B_ = Eigen::Vector3d::Zero();
  bool have_load_ = false;
  std::int64_t load_us_ = 0;
  double climb_acceleration_ = 0.0;
  bool have_field_ = false;
  strapdown::FieldSuspicion suspicion_;
  std::int64_t field_us_ = 0;
  Eigen::Vector3d b_B_ = Eigen::Vector3d::Zero();
  bool have_air_ = false;
  samples::AirData air_;
  strapdown::FrozenFlow frozen_flow_;
  bool live_flow_ = true;
  Eigen::Vector3d v_air_B_ = Eigen::Vector3d::Zero();
  double air_climb_integral_ = 0.0;
  RateFilter climb_;
  RateFilter airspeed_;
  RateFilter alpha_;
  RateFilter beta_;

  samples::Attitude attitude_;
  std::array<std::int64_t, kRows> used_us_{};
  std::int64_t last_used_us_ = 0;
  Rows innovation_{};
  Rows innovation_sigma_{};
  std::array<std::int64_t, kAssumptions> assumption_rejects_{};
};

}  // namespace lodestar::sahrs
