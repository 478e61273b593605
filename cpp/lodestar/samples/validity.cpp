// SPDX-License-Identifier: Apache-2.0
#include "lodestar/samples/validity.h"

#include <cmath>
#include <initializer_list>

namespace lodestar::samples {
namespace {

constexpr double kHalfTurn = 3.1415926535897936;     // rad, pi rounded up
constexpr double kQuarterTurn = 1.5707963267948968;  // rad, pi/2 rounded up
constexpr double kFullTurn = 6.2831853071795872;     // rad, 2 pi rounded up

/// One value with the range it must lie in.
struct Bound {
  double value;
  double low;
  double high;
};

std::optional<Reason> judge(std::initializer_list<Bound> bounds, bool valid) {
  for (const Bound& b : bounds) {
    if (!std::isfinite(b.value)) return Reason::kNotFinite;
  }
  for (const Bound& b : bounds) {
    if (b.value < b.low || b.value > b.high) return Reason::kOutOfRange;
  }
  if (!valid) return Reason::kInvalid;
  return std::nullopt;
}

std::optional<Reason> judge_vector(const Eigen::Vector3d& v, double limit, bool valid) {
  return judge({{v.x(), -limit, limit}, {v.y(), -limit, limit}, {v.z(), -limit, limit}}, valid);
}

}  // namespace

std::optional<Reason> refusal(const BodyRates& s) { return judge_vector(s.omega_B, 20.0, s.valid); }

std::optional<Reason> refusal(const LoadFactor& s) { return judge_vector(s.n_B, 30.0, s.valid); }

std::optional<Reason> refusal(const MagneticField& s) {
  return judge_vector(s.b_B, 200e3, s.valid);
}

std::optional<Reason> refusal(const AirData& s) {
  return judge({{s.true_airspeed, 0.0, 1500.0},
                {s.alpha, -kHalfTurn, kHalfTurn},
                {s.beta, -kQuarterTurn, kQuarterTurn},
                {s.baro_altitude, -1000.0, 40e3},
                {s.static_temperature, 100.0, 400.0}},
               s.valid);
}

std::optional<Reason> refusal(const SpecificForce& s) {
  const auto reason = judge_vector(s.f_B, 700.0, s.valid);
  return reason ? reason : judge({{s.temperature, 100.0, 500.0}}, true);
}

std::optional<Reason> refusal(const GpsFix& s) {
  const double speed = s.has_velocity ? 2000.0 : INFINITY;  // m/s; unused fields only stay finite
  return judge({{s.lat, -kQuarterTurn, kQuarterTurn},
                {s.lon, -kHalfTurn, kFullTurn},
                {s.h, -1000.0, 100e3},
                {s.v_N.x(), -speed, speed},
                {s.v_N.y(), -speed, speed},
                {s.v_N.z(), -speed, speed},
                {s.sigma_horizontal, 1e-4, 1e5},
                {s.sigma_vertical, 1e-4, 1e5},
                {s.sigma_velocity, s.has_velocity ? 1e-5 : 0.0, 1e4},
                {s.hdop, 0.0, 1000.0}},
               s.fix_type >= 2 && s.satellites >= 3);
}

std::optional<Reason> refusal(const GpsObservables& s) {
  if (s.count < 0 || s.count > GpsObservables::kMaximum) return Reason::kOutOfRange;
  for (int i = 0; i < s.count; ++i) {
    const auto reason = judge({{s.pseudorange[i], 1e6, 1e8},
                               {s.carrier_phase[i], -1e9, 1e9},
                               {s.sigma[i], 1e-4, 1e5},
                               {s.sv_p_E[i][0], -1e8, 1e8},
                               {s.sv_p_E[i][1], -1e8, 1e8},
                               {s.sv_p_E[i][2], -1e8, 1e8}},
                              true);
    if (reason) return reason;
  }
  return std::nullopt;
}

std::optional<Reason> refusal(const InsSolution& s) {
  return judge({{s.roll, -kHalfTurn, kHalfTurn},
                {s.pitch, -kQuarterTurn, kQuarterTurn},
                {s.heading, -kHalfTurn, kFullTurn},
                {s.lat, -kQuarterTurn, kQuarterTurn},
                {s.lon, -kHalfTurn, kFullTurn},
                {s.h, -1000.0, 100e3},
                {s.v_N.x(), -2000.0, 2000.0},
                {s.v_N.y(), -2000.0, 2000.0},
                {s.v_N.z(), -2000.0, 2000.0}},
               s.valid);
}

std::optional<Reason> refusal(const SarMeasurement& s) {
  const auto reason = judge({{s.range, 0.0, 1e6}, {s.range_rate, -5000.0, 5000.0}}, true);
  return reason ? reason : judge_vector(s.nominal_target_p_E, 1e7, true);
}

std::optional<Reason> refusal(const RadarAltitude& s) {
  return judge({{s.height, -100.0, 20e3}}, s.valid);
}

}  // namespace lodestar::samples
