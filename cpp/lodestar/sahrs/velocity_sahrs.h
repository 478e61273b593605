// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/sahrs/alignment.h"
#include "lodestar/sahrs/parameters.h"
#include "lodestar/sahrs/rate_filter.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"
#include "lodestar/strapdown/guarded_filter.h"
#include "lodestar/strapdown/parameters.h"

namespace lodestar::sahrs {

/// What of `parameters` a filter of the strapdown family is guarded by.
strapdown::GuardLimits guard_limits(const Parameters& parameters);

/// Synthetic attitude and heading reference in its velocity-aided form: the velocity relative to
/// the air is a state, so that no measurement takes steady flight for granted, and every attitude
/// is alike. Same interface and same conditions on its samples as PaperSahrs.
class VelocitySahrs {
 public:
  /// Measurements, in the order of the bits of Attitude::used and of `innovation`.
  static constexpr int kRows = strapdown::VelocityFilter::kRows;
  using Rows = strapdown::VelocityFilter::Rows;  // nT x3 in B, m/s, rad x2, m

  /// Of `parameters` only the limits count: of airspeed, of alignment (max_imbalance,
  /// max_sideslip), of the field's strength and of validity.
  VelocitySahrs(const Parameters& parameters, const strapdown::Parameters& filter_parameters,
                const FieldCalibration& calibration, earth::GeomagneticKind field_model,
                double epoch_year);

  /// Where the aircraft is: latitude, longitude (rad), height (m). For the field model, gravity and
  /// the Earth's rotation only; a few kilometres do not matter.
  void set_position(double lat, double lon, double h) { guard_.set_position(lat, lon, h); }

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
  const Rows& innovation() const { return filter().innovation(); }
  const Rows& innovation_sigma() const { return filter().innovation_sigma(); }
  /// How often each assumption kept a measurement out: those of airspeed, field strength and live
  /// flow are made, and that of balance by the alignment.
  const std::array<std::int64_t, kAssumptions>& assumption_rejects() const {
    return assumption_rejects_;
  }
  const strapdown::VelocityFilter& filter() const { return guard_.filter(); }

 private:
  enum class State { kWaiting, kRunning, kRealigning };

  bool needs_alignment() const { return state_ != State::kRunning || guard_.lost(); }
  void try_alignment();
  void align_to(const Aligned& aligned);
  void begin(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B, std::int64_t time_us);
  samples::AttitudeMode mode(bool certain) const;

  Parameters parameters_;
  FieldCalibration calibration_;
  strapdown::GuardedFilter<strapdown::kStates> guard_;

  State state_ = State::kWaiting;
  std::int64_t now_us_ = 0;
  std::int64_t alignable_us_ = 0;  // since when a turn has been all there was to align in; 0: none
  Alignment alignment_;
  RateFilter climb_;
  // The latest of each channel.
  Eigen::Vector3d omega_B_ = Eigen::Vector3d::Zero();
  bool have_load_ = false;
  std::int64_t load_us_ = 0;
  bool have_field_ = false;
  std::int64_t field_us_ = 0;
  bool have_air_ = false;
  samples::AirData air_;

  samples::Attitude attitude_;
  std::array<std::int64_t, kAssumptions> assumption_rejects_{};
};

}  // namespace lodestar::sahrs
