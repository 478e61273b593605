// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "lodestar/earth/cached_field.h"
#include "lodestar/samples/samples.h"
#include "lodestar/samples/use.h"
#include "lodestar/strapdown/field_suspicion.h"
#include "lodestar/strapdown/parameters.h"
#include "lodestar/strapdown/saturated_rates.h"
#include "lodestar/strapdown/velocity_filter.h"

namespace lodestar::strapdown {

/// What the filter may be given, from where the parameters of the whole estimator are.
struct GuardLimits {
  double min_airspeed = 60.0;             // m/s
  double gyro_gap_noise = 0.0;            // rad/s/sqrt(s), of the rate within a gap
  double max_field_strength_error = 0.1;  // of the model's strength
};

/// The filter, and what stands between it and sensors that fail: gaps in the rates, gyros at the
/// end of their range, fields of something near the detector. A start from an attitude that is only
/// roughly known is refined: see begin().
template <int N>
class GuardedFilter {
 public:
  GuardedFilter(const Parameters& parameters, const GuardLimits& limits,
                earth::GeomagneticKind field_model, double epoch_year,
                const GroundParameters& ground = {});

  /// Where the aircraft is: latitude, longitude (rad), height (m). For the field model, gravity and
  /// the Earth's rotation only; a few kilometres do not matter.
  void set_position(double lat, double lon, double h);

  /// Starts from an attitude known to `sigma_B` (rad, about the body axes). If that is degrees, the
  /// equations are linearised about it as the gyros carry it on, until heading is known to 1 degree
  /// or for 150 s; then the filter starts again from the attitude it has by then.
  void begin(const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& sigma_B, std::int64_t time_us);

  /// One frame. False where the gap since the last one was too long to bridge, 0.5 s: the filter
  /// has stopped, and is to begin anew.
  bool propagate(const samples::BodyRates& sample);

  samples::Use update(const samples::LoadFactor& sample);
  /// Whether a field (calibrated) is as strong as the model's. To be asked before every update.
  bool vet(const samples::MagneticField& sample);
  samples::Use update(const samples::MagneticField& sample);
  samples::Use update(const samples::AirData& sample);

  /// To be called after the last update of a frame.
  void finish_frame();

  bool running() const { return running_; }
  /// Running, but so uncertain that an alignment is better than a linear correction: of heading or
  /// tilt.
  bool lost() const { return lost_; }
  /// Whether a field of strange strength was met of late, so that none is to align by.
  bool suspects_field() const { return suspicion_.lasts(now_us_); }
  /// The latest time of a measurement that was used.
  std::int64_t last_used_us() const { return last_used_us_; }
  /// Bits of measurements that this frame kept out, before the gates or by them.
  int rejected() const;
  const Eigen::Vector3d& field_N() const { return b_N_; }  // nT, the model's
  double gravity() const { return gravity_; }              // m/s^2

  StrapdownFilter<N>& filter() { return filter_; }
  const StrapdownFilter<N>& filter() const { return filter_; }

 private:
  void refine_start();
  void doubt_heading(std::int64_t before_us);
  void note(samples::Use use, std::int64_t time_us);

  GuardLimits limits_;
  double epoch_year_;
  earth::CachedField field_model_;
  StrapdownFilter<N> filter_;
  Eigen::Vector3d b_N_ = Eigen::Vector3d::Zero();
  double gravity_ = samples::kStandardGravity;

  bool running_ = false;
  bool coarse_ = false;  // the start is still being refined
  bool lost_ = false;
  bool lost_tilt_ = false;  // the air data wait, too
  std::int64_t now_us_ = 0;
  bool have_rates_ = false;
  std::int64_t begun_us_ = 0;
  std::int64_t last_used_us_ = 0;
  std::int64_t field_us_ = 0;
  std::int64_t field_used_us_ = 0;
  bool field_refused_ = false;  // in this frame
  FieldSuspicion suspicion_;
  SaturatedRates saturated_rates_;
};

extern template class GuardedFilter<kStates>;
extern template class GuardedFilter<kGroundStates>;

}  // namespace lodestar::strapdown
