// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "lodestar/earth/cached_field.h"
#include "lodestar/filter/gate.h"
#include "lodestar/math/gauss_markov.h"
#include "lodestar/sahrs/ins_history.h"
#include "lodestar/sahrs/reference_error.h"
#include "lodestar/sahrs/smdu_calibration.h"
#include "lodestar/samples/outputs.h"
#include "lodestar/samples/samples.h"

namespace lodestar::sahrs::smdu {

/// Calibrates the magnetic detector over a whole flight, with the INS as attitude reference (SAHRS
/// paper §5): a Kalman filter of the twelve states x.
///
/// With b_B = C_NB' b_N of the INS and the field model, the innovation is b_B - b_cal(x), in B,
/// where the detector's errors are at home. To tell the truth about its sigma the filter carries
/// nine more states: the detector's slow error (3, nT), which a sample by itself cannot tell from
/// x, is estimated; the lasting errors of INS and field model (6) are considered
/// (reference_error.h).
///
/// Samples have passed the checks of samples/validity.h, each kind in order of time. After
/// construction nothing allocates or throws.
class CalibrationFilter {
 public:
  CalibrationFilter(const FilterParameters& parameters, earth::GeomagneticKind field_model,
                    double epoch_year);

  void update(const samples::InsSolution& sample);
  void update(const samples::MagneticField& sample);

  /// The INS is known to be wrong. Once it has been used, this flight is good for nothing more.
  void fail_ins();

  Calibration calibration() const;
  Checks checks() const;
  Verdict verdict() const;
  /// SMDU.CALIBRATION at `time_us`.
  samples::SmduCalibration status(std::int64_t time_us) const;
  /// Time of the last sample that was used.
  std::int64_t time_us() const { return used_us_; }

 private:
  static constexpr math::Block kStates{0, kCalibrationStates};
  static constexpr math::Block kSlowError = math::after(kStates, 3);  // nT, in B
  static constexpr math::Block kReference = math::after(kSlowError, kReferenceErrors);
  static constexpr int kEstimated = math::end(kSlowError);
  static constexpr int kAll = math::end(kReference);
  static_assert(kAll == 21);
  using Covariance = Eigen::Matrix<double, kAll, kAll>;

  void correct(const samples::MagneticField& sample, const Eigen::Matrix3d& C_NB);
  void propagate(double dt);
  void note(const Eigen::Vector3d& normalised, double normalised_square);

  FilterParameters parameters_;
  math::GaussMarkov drift_;
  std::int64_t interval_us_;
  double epoch_year_;
  earth::CachedField field_model_;
  filter::Gate gate_;

  Calibration estimate_;                                    // x; its P is the corner of P_
  Eigen::Vector3d slow_error_B_ = Eigen::Vector3d::Zero();  // nT
  Covariance P_ = Covariance::Zero();

  InsHistory ins_;
  samples::MagneticField waiting_;  // for the INS to get to its time
  bool is_waiting_ = false;
  bool running_ = false;
  bool ins_failed_ = false;
  std::int64_t taken_us_ = 0;  // time of the last sample that was due
  std::int64_t used_us_ = 0;   // ... that corrected the states, or was gated

  double duration_ = 0.0;  // s
  std::int64_t used_ = 0;
  std::int64_t gated_ = 0;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();  // normalised innovation
  bool last_passed_ = false;
  double square_sum_ = 0.0;
  double products_ = 0.0;         // of neighbours
  double product_squares_ = 0.0;  // of their lengths
};

}  // namespace lodestar::sahrs::smdu
