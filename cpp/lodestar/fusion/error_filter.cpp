// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/error_filter.h"

#include <algorithm>

#include "lodestar/filter/joseph.h"
#include "lodestar/math/discretise.h"

namespace lodestar::fusion {
namespace {

// What the aircraft may have done unseen in a gap of the frames.
constexpr double kUnseenAcceleration = 5.0;            // m/s^2
constexpr double kStandardTurn = 3.0 * math::kDegree;  // rad/s

NoiseVector noise_densities(const CascadeParameters& p, const StepConditions& conditions,
                            double dt) {
  NoiseVector q;
  const Eigen::Vector3d air_data(p.alpha_noise, p.beta_noise, p.airspeed_noise);
  q.segment<3>(kAirDataNoise.offset) = air_data.cwiseAbs2() / p.air_data_rate;
  const double gap = std::max(0.0, dt - p.step);
  const double unseen = 0.5 * kUnseenAcceleration * gap * gap;
  q.segment<2>(kTrackNoise.offset).setConstant(unseen * unseen / dt + conditions.gust_density);
  q.segment<2>(kGpsNoise.offset).setConstant(p.gps_error.spectral_density());
  const double lost = conditions.air_data_lost ? p.air_data_lost_noise : 0.0;
  const double turn = conditions.turn_rate / kStandardTurn;
  const double wind = p.wind.spectral_density() * (1.0 + p.wind_turn_gain * turn);
  q.segment<2>(kWindNoise.offset).setConstant(wind + lost * lost);
  const Eigen::Vector3d tau(p.heading_error.tau, p.pitch_error.tau, p.roll_error.tau);
  q.segment<3>(kAngleNoise.offset) = 2.0 * conditions.angle_variance.cwiseQuotient(tau);
  q(kAngleNoise.offset) *= 1.0 + p.heading_turn_gain * turn;
  q.segment<2>(kDeviationNoise.offset).setConstant(p.heading_deviation.spectral_density());
  return q;
}

}  // namespace

ErrorCovariance::ErrorCovariance(CovarianceForm form, const StateMatrix& P) : form_(form) {
  assign(P);
}

void ErrorCovariance::assign(const StateMatrix& P) {
  if (form_ == CovarianceForm::kJoseph) {
    P_ = P;
  } else {
    ud_ = filter::UdCovariance<kStates>(P);
  }
}

StateMatrix ErrorCovariance::matrix() const {
  return form_ == CovarianceForm::kJoseph ? P_ : ud_.matrix();
}

Eigen::Matrix2d ErrorCovariance::projected(const PositionMatrix& m) const {
  if (form_ == CovarianceForm::kJoseph) return m * P_ * m.transpose();
  const PositionMatrix mU = m * ud_.U();
  return mU * ud_.D().asDiagonal() * mU.transpose();
}

void ErrorCovariance::propagate(const StateMatrix& F, const NoiseMatrix& G, const NoiseVector& q,
                                double dt) {
  const StateMatrix Phi = math::transition<kStates>(F, dt);
  if (form_ == CovarianceForm::kUd) {
    const NoiseMatrix Gamma = G + (0.5 * dt) * (F * G);
    ud_.propagate<kNoises>(Phi, Gamma, dt * q);
    return;
  }
  const StateMatrix GQGt = G * q.asDiagonal() * G.transpose();
  const StateMatrix P = Phi * P_ * Phi.transpose() + math::process_noise<kStates>(F, GQGt, dt);
  P_ = 0.5 * (P + P.transpose());  // rounding would grow along unstable directions
}

StateVector ErrorCovariance::update(const PositionMatrix& H, double r,
                                    const Eigen::Vector2d& innovation) {
  if (form_ == CovarianceForm::kJoseph) {
    const filter::JosephUpdate<kStates, 2> joseph(P_, H, r * Eigen::Matrix2d::Identity());
    return joseph.apply(P_, innovation);
  }
  StateVector dx = StateVector::Zero();
  for (int i = 0; i < 2; ++i) {
    const StateVector h = H.row(i).transpose();
    const double left = innovation(i) - h.dot(dx);
    dx += ud_.update(h, r) * left;
  }
  return dx;
}

void ErrorEstimate::propagate(const CascadeParameters& parameters, const StepConditions& conditions,
                              const TrackPoint& from, const TrackPoint& to) {
  const double dt = seconds(to.time_us - from.time_us);
  if (dt <= 0.0) return;
  const bool extended = parameters.linearisation == Linearisation::kExtended;
  const StateVector about = extended ? x : StateVector::Zero();
  const ErrorDynamics start = error_dynamics(parameters, from, about);
  const ErrorDynamics finish = error_dynamics(parameters, to, about);
  const StateMatrix F = 0.5 * (start.F + finish.F);
  const NoiseMatrix G = 0.5 * (start.G + finish.G);

  const StateVector before = x;
  x = math::transition<kStates>(F, dt) * before;
  if (extended) {
    const AttitudeError form = parameters.attitude_error;
    const Eigen::Vector2d rate =
        0.5 * (position_error_rate(form, from, before) + position_error_rate(form, to, x));
    x.segment<2>(kPositionError.offset) = before.segment<2>(kPositionError.offset) + dt * rate;
  }
  P.propagate(F, G, noise_densities(parameters, conditions, dt), dt);
  if (conditions.sahrs_restarted) {
    const double deviation = parameters.heading_deviation.sigma;
    restart_angles(
        angle_covariance(parameters.attitude_error, to.attitude.heading, conditions.angle_variance),
        deviation * deviation);
  }
  if (conditions.heading_error) {
    take_heading_error(*conditions.heading_error, parameters.attitude_error, to);
  }
}

void ErrorEstimate::take_heading_error(const KnownAngle& known, AttitudeError form,
                                       const TrackPoint& point) {
  const Eigen::Matrix<double, 1, kStates> H = euler_by_states(form, point, x).row(0);
  StateMatrix covariance = P.matrix();
  const filter::JosephUpdate<kStates, 1> joseph(covariance, H,
                                                Eigen::Matrix<double, 1, 1>(known.variance));
  const Eigen::Matrix<double, 1, 1> innovation(
      math::wrap_pi(known.error - heading_error(form, point, x)));
  x += joseph.apply(covariance, innovation);
  P.assign(covariance);
}

void ErrorEstimate::restart_angles(const Eigen::Matrix3d& angles, double deviation_variance) {
  x.segment<kAngles.size>(kAngles.offset).setZero();
  StateMatrix covariance = P.matrix();
  covariance.middleRows<kAngles.size>(kAngles.offset).setZero();
  covariance.middleCols<kAngles.size>(kAngles.offset).setZero();
  covariance.block<3, 3>(kHeadingError.offset, kHeadingError.offset) = angles;
  covariance.diagonal().segment<2>(kDeviation.offset).setConstant(deviation_variance);
  P.assign(covariance);
}

void ErrorEstimate::doubt_wind(double sigma) {
  StateMatrix covariance = P.matrix();
  covariance.diagonal().segment<2>(kWind.offset).array() += sigma * sigma;
  P.assign(covariance);
}

void ErrorEstimate::loosen(const Eigen::Vector2d& position_sigma, double scale) {
  StateVector factor = StateVector::Ones();
  factor.segment<2>(kWind.offset).setConstant(scale);
  factor.segment<kAngles.size>(kAngles.offset).setConstant(scale);
  StateMatrix covariance = factor.asDiagonal() * P.matrix() * factor.asDiagonal();
  covariance.diagonal().segment<2>(kPositionError.offset) += position_sigma.cwiseAbs2();
  P.assign(covariance);
}

}  // namespace lodestar::fusion
