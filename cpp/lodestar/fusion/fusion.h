// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <variant>

#include "lodestar/fusion/cascade.h"
#include "lodestar/fusion/integrated.h"
#include "lodestar/math/scalar.h"

namespace lodestar::fusion {

/// What gives NAV: one of the two filters. In a frame, in this order: body rates, samples, the
/// attitude of SAHRS, fixes.
///
/// `integrated` starts twice: for the gusts of its parameters, and for calm air. What a filter for
/// gusts does not learn in its first seconds in calm air it misses for minutes, and one for calm
/// air that starts in gusts is lost. The first one is the output; if it finds no gusts, the other
/// one goes on in its place.
class Fusion {
 public:
  explicit Fusion(const Cascade& cascade) : filter_(cascade) {}
  explicit Fusion(const Integrated& integrated) : filter_(integrated), calm_(integrated) {
    calm_->presume_calm_air();
  }

  samples::FusionFilter filter() const {
    return integrated() != nullptr ? samples::FusionFilter::kIntegrated
                                   : samples::FusionFilter::kCascade;
  }

  /// Where the aircraft is, roughly.
  void set_position(double lat, double lon, double h) {
    each([&](Integrated& one) { one.set_position(lat, lon, h); });
  }
  void propagate(const samples::BodyRates& rates) {
    each([&](Integrated& one) { one.propagate(rates); });
  }
  void update(const samples::LoadFactor& sample) {
    each([&](Integrated& one) { one.update(sample); });
  }
  void update(const samples::MagneticField& calibrated) {
    each([&](Integrated& one) { one.update(calibrated); });
  }
  void update(const samples::AirData& sample) {
    ++heard_;
    each([&](Integrated& one) { one.update(sample); });
    if (Cascade* one = cascade()) one->update(sample);
  }
  void follow(const samples::Attitude& sahrs) {
    each([&](Integrated& one) { one.follow(sahrs); });
    if (Cascade* one = cascade()) one->propagate(sahrs);
    if (calm_) choose_start();
  }
  /// A frame without rates, at the time of the attitude that is held.
  void coast(const samples::Attitude& held) {
    each([&](Integrated& one) { one.coast(held.time_us); });
    if (Cascade* one = cascade()) one->propagate(held);
  }
  samples::Use update(const samples::GpsFix& fix) {
    if (calm_) calm_->update(fix);
    return std::visit([&](auto& one) { return one.update(fix); }, filter_);
  }
  /// What another reference, now lost, said of the heading of SAHRS: at `time_us` it was wrong by
  /// `error` (rad, true - SAHRS) to `sigma` (rad).
  void know_heading_error(double error, double sigma, std::int64_t time_us) {
    if (calm_) calm_->know_heading_error(error, sigma, time_us);
    std::visit([&](auto& one) { one.know_heading_error(error, sigma, time_us); }, filter_);
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
  /// `call` with every `integrated` there is.
  template <class Call>
  void each(const Call& call) {
    if (Integrated* one = std::get_if<Integrated>(&filter_)) call(*one);
    if (calm_) call(*calm_);
  }
  Cascade* cascade() { return std::get_if<Cascade>(&filter_); }
  const Integrated* integrated() const { return std::get_if<Integrated>(&filter_); }

  /// Ends the second start after a while: it goes on if its air data have told of no gusts.
  void choose_start() {
    constexpr double kListen = 20.0;  // s
    constexpr int kEnough = 100;      // air data
    const Integrated& calm = *calm_;
    const std::int64_t now = calm.navigation().time_us;
    if (!calm.filter().has_velocity()) {
      started_us_ = now;
      heard_ = 0;
    }
    if (math::seconds(now - started_us_) < kListen || !calm.navigation().valid) return;
    if (heard_ >= kEnough && calm.filter().in_calm_air()) {
      calm_->replace(navigation());
      filter_ = *calm_;
    }
    calm_.reset();
  }

  std::variant<Cascade, Integrated> filter_;
  std::optional<Integrated> calm_;  // the second start, until it is decided
  std::int64_t started_us_ = 0;     // when it had no air velocity yet
  int heard_ = 0;                   // air data since
};

}  // namespace lodestar::fusion
