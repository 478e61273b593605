// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <variant>

#include "lodestar/sahrs/paper_sahrs.h"
#include "lodestar/sahrs/velocity_sahrs.h"

namespace lodestar::sahrs {

/// SAHRS in the form that its parameters ask for. What a member does is said in PaperSahrs.
class Sahrs {
 public:
  /// The more of both forms; rows that a form does not have are 0.
  static constexpr int kRows = std::max<int>(PaperSahrs::kRows, VelocitySahrs::kRows);
  using Rows = std::array<double, kRows>;

  Sahrs(const Parameters& parameters, const strapdown::Parameters& filter_parameters,
        const FieldCalibration& calibration, earth::GeomagneticKind field_model, double epoch_year)
      : form_(make(parameters, filter_parameters, calibration, field_model, epoch_year)) {}

  void set_position(double lat, double lon, double h) {
    std::visit([&](auto& form) { form.set_position(lat, lon, h); }, form_);
  }
  void start(const math::Euler& attitude, const Eigen::Vector3d& sigma_B, std::int64_t time_us) {
    std::visit([&](auto& form) { form.start(attitude, sigma_B, time_us); }, form_);
  }
  void propagate(const samples::BodyRates& sample) {
    std::visit([&](auto& form) { form.propagate(sample); }, form_);
  }
  template <class Sample>
  samples::Use update(const Sample& sample) {
    return std::visit([&](auto& form) { return form.update(sample); }, form_);
  }
  void finish_frame() {
    std::visit([](auto& form) { form.finish_frame(); }, form_);
  }

  samples::SahrsForm form() const { return static_cast<samples::SahrsForm>(form_.index()); }
  const samples::Attitude& attitude() const {
    return std::visit([](const auto& form) -> const auto& { return form.attitude(); }, form_);
  }
  Rows innovation() const {
    return std::visit([](const auto& form) { return widened(form.innovation()); }, form_);
  }
  Rows innovation_sigma() const {
    return std::visit([](const auto& form) { return widened(form.innovation_sigma()); }, form_);
  }
  const std::array<std::int64_t, kAssumptions>& assumption_rejects() const {
    return std::visit([](const auto& form) -> const auto& { return form.assumption_rejects(); },
                      form_);
  }

 private:
  using Forms = std::variant<VelocitySahrs, PaperSahrs>;  // in the order of SahrsForm

  static Forms make(const Parameters& parameters, const strapdown::Parameters& filter_parameters,
                    const FieldCalibration& calibration, earth::GeomagneticKind field_model,
                    double epoch_year) {
    if (parameters.form == samples::SahrsForm::kPaper) {
      return Forms(std::in_place_type<PaperSahrs>, parameters, calibration, field_model,
                   epoch_year);
    }
    return Forms(std::in_place_type<VelocitySahrs>, parameters, filter_parameters, calibration,
                 field_model, epoch_year);
  }

  template <std::size_t Size>
  static Rows widened(const std::array<double, Size>& rows) {
    Rows wide{};
    std::copy(rows.begin(), rows.end(), wide.begin());
    return wide;
  }

  Forms form_;
};

}  // namespace lodestar::sahrs
