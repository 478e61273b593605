// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "lodestar/filter/gate.h"
#include "lodestar/math/gauss_markov.h"
#include "lodestar/sahrs/reference_error.h"
#include "lodestar/sahrs/smdu_calibration.h"

namespace lodestar::sahrs::smdu {

/// [smdu_ground_swing].
struct SwingParameters {
  static constexpr double kDegree = math::kDegree;

  double scale_sigma = 0.05;        // -
  double element_sigma = 0.003;     // -
  double max_tilt = 5.0 * kDegree;  // rad
  int min_sectors = 8;
  double max_gated = 0.02;        // -
  double max_residual = 1.5;      // -
  double max_bias_sigma = 300.0;  // nT
  double max_scale_sigma = 0.01;  // -

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.scale_sigma,
          {"scale_sigma", "-", 1e-5, 0.5, "Common scale error before the swing, 1 sigma"});
    visit(self.element_sigma, {"element_sigma", "-", 0.0, 0.2,
                               "What a matrix element is off besides: a swing cannot see it"});
    visit(self.max_tilt, {"max_tilt_deg", "deg", 0.1, 45.0,
                          "Roll and pitch up to which the aircraft counts as level", kDegree});
    visit(self.min_sectors,
          {"min_sectors", "-", 3.0, 12.0, "Of the twelve 30 deg sectors of heading, seen"});
    visit(self.max_gated, {"max_gated", "-", 0.0, 1.0, "Largest share of gated samples"});
    visit(self.max_residual,
          {"max_residual", "-", 1.0, 100.0, "Largest mean square of the normalised innovation"});
    visit(self.max_bias_sigma,
          {"max_bias_sigma_nT", "nT", 1.0, 1e5, "Largest sigma of the horizontal bias"});
    visit(self.max_scale_sigma,
          {"max_scale_sigma", "-", 1e-5, 0.5, "Largest sigma of the common scale"});
  }
};

enum class SwingVerdict : std::uint8_t {
  kGood,
  kNoSamples,  // none of them level
  kHeadings,   // too few headings
  kGated,      // too many samples contradict the rest
  kResidual,   // what is left is larger than its sigma
  kUncertain,  // bias or scale are not known well enough
};
inline constexpr const char* kSwingVerdictNames[] = {
    "good",           "no level samples",   "too few headings",
    "too many gated", "residual too large", "bias or scale too uncertain"};

inline const char* name(SwingVerdict verdict) {
  return kSwingVerdictNames[static_cast<std::size_t>(verdict)];
}

/// Calibration before the first flight: the aircraft stands level and is swung through the
/// headings, which tells four numbers, the bias and one scale common to the axes (SAHRS paper §5).
///
/// Recursive least squares of these four and of the detector's slow error. The elements of D beyond
/// the common scale (9) and the errors of the reference (6) are considered: their share in the
/// sigma, and its correlation with the bias, is right, their estimate stays zero.
class GroundSwing {
 public:
  /// Errors of detector and reference are those of `errors`.
  GroundSwing(const SwingParameters& parameters, const FilterParameters& errors);

  /// One raw field `b_raw` (nT) at the attitude C_NB in the field `b_N` (nT), in order of time.
  void add(std::int64_t time_us, const Eigen::Matrix3d& C_NB, const Eigen::Vector3d& b_raw,
           const Eigen::Vector3d& b_N);

  /// Scale is common, misalignment zero.
  Calibration calibration() const;
  SwingVerdict verdict() const;
  int sectors() const;
  double residual() const;  // mean square of the normalised innovation
  double gated() const;     // share

 private:
  static constexpr math::Block kSwingBias{0, 3};
  static constexpr math::Block kCommonScale = math::after(kSwingBias, 1);
  static constexpr math::Block kSlowError = math::after(kCommonScale, 3);
  static constexpr math::Block kElements = math::after(kSlowError, 9);  // of D, row by row
  static constexpr math::Block kReference = math::after(kElements, kReferenceErrors);
  static constexpr int kEstimated = math::end(kSlowError);
  static constexpr int kAll = math::end(kReference);
  static_assert(kAll == 22);
  static constexpr int kSectors = 12;

  SwingParameters parameters_;
  double noise_;  // nT
  math::GaussMarkov drift_;
  std::int64_t interval_us_;
  filter::Gate gate_;

  Eigen::Matrix<double, kEstimated, 1> x_ = Eigen::Matrix<double, kEstimated, 1>::Zero();
  Eigen::Matrix<double, kAll, kAll> P_ = Eigen::Matrix<double, kAll, kAll>::Zero();
  std::int64_t last_us_ = 0;
  std::int64_t used_ = 0;
  std::int64_t gated_ = 0;
  double square_sum_ = 0.0;
  std::array<bool, kSectors> seen_{};
};

}  // namespace lodestar::sahrs::smdu
