// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <variant>

#include "lodestar/fusion/cascade.h"
#include "lodestar/fusion/integrated.h"

namespace lodestar::fusion {

/// What gives NAV: one of the two filters. In a frame, in this order: body rates, samples, the
/// attitude of SAHRS, fixes.
class Fusion {
 public:
  explicit Fusion(const Cascade& cascade) : filter_(cascade) {}
  explicit Fusion(const Integrated& integrated) : filter_(integrated) {}

  samples::FusionFilter filter() const {
    return integrated() != nullptr ? samples::FusionFilter::kIntegrated
                                   : samples::FusionFilter::kCascade;
  }

  /// Where the aircraft is, roughly.
  void set_position(double lat, double lon, double h) {
    if (Integrated* one = integrated()) one->set_position(lat, lon, h);
  }
  void propagate(const samples::BodyRates& rates) {
    if (Integrated* one = integrated()) one->propagate(rates);
  }
  void update(const samples::LoadFactor& sample) {
    if (Integrated* one = integrated()) one->update(sample);
  }
  void update(const samples::MagneticField& calibrated) {
    if (Integrated* one = integrated()) one->update(calibrated);
  }
  void update(const samples::AirData& sample) {
    std::visit([&](auto& one) { one.update(sample); }, filter_);
  }
  void follow(const samples::Attitude& sahrs) {
    if (Integrated* one = integrated()) return one->follow(sahrs);
    std::get<Cascade>(filter_).propagate(sahrs);
  }
  /// A frame without rates, at the time of the attitude that is held.
  void coast(const samples::Attitude& held) {
    if (Integrated* one = integrated()) return one->coast(held.time_us);
    std::get<Cascade>(filter_).propagate(held);
  }
  samples::Use update(const samples::GpsFix& fix) {
    return std::visit([&](auto& one) { return one.update(fix); }, filter_);
  }
  /// What another reference, now lost, said of the heading of SAHRS: at `time_us` it was wrong by
  /// `error` (rad, true - SAHRS) to `sigma` (rad).
  void know_heading_error(double error, double sigma, std::int64_t time_us) {
    if (Integrated* one = integrated()) return one->know_heading_error(error, sigma, time_us);
    std::get<Cascade>(filter_).know_heading_error(error, sigma, time_us);
  }

  const samples::Navigation& navigation() const {
    return std::visit(
        [](const auto& one) -> const samples::Navigation& { return one.navigation(); }, filter_);
  }
  /// Latest GPS position innovation and its sigma (m, north, east).
  Eigen::Vector2d innovation() const {
    return std::visit([](const auto& one) { return one.innovation(); }, filter_);
  }
  Eigen::Vector2d innovation_sigma() const {
    return std::visit([](const auto& one) { return one.innovation_sigma(); }, filter_);
  }

 private:
  Integrated* integrated() { return std::get_if<Integrated>(&filter_); }
  const Integrated* integrated() const { return std::get_if<Integrated>(&filter_); }

  std::variant<Cascade, Integrated> filter_;
};

}  // namespace lodestar::fusion
