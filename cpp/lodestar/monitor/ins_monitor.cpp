// SPDX-License-Identifier: Apache-2.0
#include "lodestar/monitor/ins_monitor.h"

#include <algorithm>
#include <cmath>

#include "lodestar/math/scalar.h"

namespace lodestar::monitor {
namespace {

using math::seconds;
using samples::InsState;

// Beyond this pitch the difference of two Euler headings says little of the heading.
constexpr double kSteepest = 60.0 * math::kDegree;  // rad

// Part of sigma by which gyros may lead astray within half a minute: where attitude is poorly known
// so is their bias.
constexpr double kUnknownGyros = 0.5;

/// Takes vectors from N to axes along the heading of `C_NB`, to its right, and down.
Eigen::Matrix3d level_axes(const Eigen::Matrix3d& C_NB) {
  const double heading = std::atan2(C_NB(1, 0), C_NB(0, 0));
  const double c = std::cos(heading), s = std::sin(heading);
  Eigen::Matrix3d C_LN;
  C_LN << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
  return C_LN;
}

Eigen::Quaterniond attitude_of(const samples::InsSolution& ins) {
  return Eigen::Quaterniond(math::C_NB_from_euler({ins.roll, ins.pitch, ins.heading}));
}

bool repeats(const samples::InsSolution& a, const samples::InsSolution& b) {
  return a.roll == b.roll && a.pitch == b.pitch && a.heading == b.heading;
}

}  // namespace

InsMonitor::InsMonitor(const InsMonitorParameters& parameters, double timeout)
    : parameters_(parameters), timeout_(timeout) {}

void InsMonitor::propagate(const samples::Attitude& sahrs) {
  now_us_ = sahrs.time_us;
  if (sahrs.reset_count != sahrs_resets_) {  // another attitude: what was usual is so no more
    sahrs_resets_ = sahrs.reset_count;
    history_.clear();
    restart();
  }
  gyros_.propagate(sahrs, parameters_.departure_tau);
  if (sahrs.valid) {
    history_.push(sahrs, gyros_.q_GB());
  } else {
    history_.clear();
  }
  if (state_.state == InsState::kNone) return;
  if (seconds(now_us_ - heard_us_) > timeout_) {
    if (state_.state != InsState::kMiscompare) fail(trusted_);
    stop();
  } else if (seconds(now_us_ - compared_us_) > timeout_) {
    stop();
  }
}

void InsMonitor::compare(const samples::InsSolution& ins) {
  heard_us_ = now_us_;
  const std::optional<StatedAttitude> sahrs = history_.at(ins.time_us);
  if (!sahrs) return;
  compared_us_ = now_us_;
  set_difference(ins, *sahrs);
  const double dt = compared_before_ ? seconds(ins.time_us - last_ins_.time_us) : 0.0;
  time_axes(dt);
  judge(frozen(ins, *sahrs), dt);
  follow(ins, *sahrs, dt);
  remember(ins, *sahrs);
  last_ins_ = ins;
  compared_before_ = true;
}

std::optional<TrustedHeading> InsMonitor::take_failure() {
  const std::optional<TrustedHeading> failure = failure_;
  failure_.reset();
  return failure;
}

void InsMonitor::restart() {
  compared_before_ = false;
  reference_.restart();
  state_.time_over.setZero();
  distrust();
}

void InsMonitor::stop() {
  state_ = {};
  restart();
}

void InsMonitor::set_difference(const samples::InsSolution& ins, const StatedAttitude& sahrs) {
  const Eigen::Quaterniond q_ins = attitude_of(ins);
  const Eigen::Matrix3d C_NB = sahrs.q_NB.toRotationMatrix();
  const Eigen::Matrix3d C_LN = level_axes(C_NB);
  const Eigen::Matrix3d C_LB = C_LN * C_NB;
  state_.difference = C_LN * math::log_quaternion(q_ins * sahrs.q_NB.conjugate());
  const Eigen::Vector3d ins_sigma(parameters_.level_sigma, parameters_.level_sigma,
                                  parameters_.heading_sigma);
  const Eigen::Vector3d variance =
      (C_LB * sahrs.P_B * C_LB.transpose()).diagonal() + ins_sigma.cwiseAbs2();
  if (!compared_before_) usual_ = state_.difference;
  set_threshold(variance.cwiseSqrt(), C_LN * reference_.departure(q_ins, sahrs.q_GB));
}

/// Bounds on either side, each the nearest that any of the three comparisons sets. The difference
/// has the threshold of the side it is on: none if it is beyond the bound of the other side.
void InsMonitor::set_threshold(const Eigen::Vector3d& sigma, const Eigen::Vector3d& departure) {
  const InsMonitorParameters& p = parameters_;
  const Eigen::Vector3d least(p.level_least, p.level_least, p.heading_least);
  const Eigen::Vector3d least_change(p.level_change, p.level_change, p.heading_change);
  const Eigen::Vector3d stated = (p.sigmas * sigma).cwiseMax(least);
  const Eigen::Vector3d change = (p.change_sigmas * sigma).cwiseMax(least_change);
  const Eigen::Vector3d least_brief(p.level_departure, p.level_departure, p.heading_departure);
  const Eigen::Vector3d brief =
      (least_brief + kUnknownGyros * sigma).array() + p.turn_error * gyros_.turned();
  for (int i = 0; i < 3; ++i) {
    const double now = state_.difference(i);
    const double late = now - departure(i);
    const double high = std::min({stated(i), usual_(i) + change(i), late + brief(i)});
    const double low = std::max({-stated(i), usual_(i) - change(i), late - brief(i)});
    const bool beyond = now >= 0.0 ? now < low : now > high;
    state_.threshold(i) = beyond ? 0.0 : std::max(0.0, now >= 0.0 ? high : -low);
  }
}

/// While the INS is not believed the reference goes back to SAHRS, as the two usually differ: of a
/// false alarm nothing remains, of a fault everything.
void InsMonitor::follow(const samples::InsSolution& ins, const StatedAttitude& sahrs, double dt) {
  const double share = -std::expm1(-dt / parameters_.departure_tau);
  const bool believed = state_.state == InsState::kAgree;
  const Eigen::Matrix3d C_LN = level_axes(sahrs.q_NB.toRotationMatrix());
  const Eigen::Quaterniond expected = math::exp_quaternion(C_LN.transpose() * usual_) * sahrs.q_NB;
  reference_.follow(believed ? attitude_of(ins) : expected, sahrs.q_GB, share);
}

/// What was usual is forgotten while the INS is not believed: it may have been learnt from a wrong
/// one, and would then keep a right one out.
void InsMonitor::time_axes(double dt) {
  const double share = -std::expm1(-dt / parameters_.usual_tau);
  const bool believed = state_.state != InsState::kMiscompare;
  for (int i = 0; i < 3; ++i) {
    const double size = std::abs(state_.difference(i));
    double& time_over = state_.time_over(i);
    if (size > state_.threshold(i)) {
      time_over += dt;
    } else if (size <= parameters_.release * state_.threshold(i)) {
      time_over = 0.0;
    }
    if (!believed) {
      usual_(i) -= share * usual_(i);
    } else if (time_over == 0.0) {
      usual_(i) += share * (state_.difference(i) - usual_(i));
    }
  }
}

bool InsMonitor::frozen(const samples::InsSolution& ins, const StatedAttitude& sahrs) {
  if (!compared_before_ || !repeats(ins, last_ins_)) {
    q_NB_of_change_ = sahrs.q_NB;
    return false;
  }
  const Eigen::Vector3d turn = math::log_quaternion(q_NB_of_change_.conjugate() * sahrs.q_NB);
  return turn.norm() > parameters_.frozen_turn;
}

void InsMonitor::judge(bool frozen, double dt) {
  const bool over = state_.time_over.maxCoeff() > 0.0;
  agreed_for_ = over || frozen ? 0.0 : agreed_for_ + dt;
  const bool confirmed = over && state_.time_over.maxCoeff() >= parameters_.confirmation_time;
  if (frozen || confirmed) {
    if (state_.state != InsState::kMiscompare) fail(frozen ? trusted_ : trusted_before_);
    state_.state = InsState::kMiscompare;
  } else if (state_.state != InsState::kMiscompare || agreed_for_ >= parameters_.release_time) {
    state_.state = over ? InsState::kSuspect : InsState::kAgree;
  }
}

void InsMonitor::fail(const std::optional<TrustedHeading>& last) {
  failure_ = last;
  distrust();
}

/// What the heading of the INS says of that of SAHRS, in case there is no INS soon.
void InsMonitor::remember(const samples::InsSolution& ins, const StatedAttitude& sahrs) {
  const math::Euler attitude = math::euler_from_C_NB(sahrs.q_NB.toRotationMatrix());
  if (state_.state != InsState::kAgree || agreed_for_ < parameters_.release_time ||
      std::abs(attitude.pitch) > kSteepest || repeats(ins, last_ins_)) {
    return;
  }
  trusted_ = TrustedHeading{ins.time_us, math::wrap_pi(ins.heading - attitude.heading),
                            parameters_.heading_sigma};
  if (!trusted_next_) {
    trusted_next_ = trusted_;
  } else if (seconds(ins.time_us - trusted_next_->time_us) >= parameters_.doubt_time) {
    trusted_before_ = trusted_next_;
    trusted_next_ = trusted_;
  }
}

void InsMonitor::distrust() {
  trusted_.reset();
  trusted_before_.reset();
  trusted_next_.reset();
  agreed_for_ = 0.0;
}

}  // namespace lodestar::monitor
