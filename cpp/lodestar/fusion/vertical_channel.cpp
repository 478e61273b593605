// SPDX-License-Identifier: Apache-2.0
#include "lodestar/fusion/vertical_channel.h"

#include <algorithm>
#include <cmath>

#include "lodestar/filter/joseph.h"

namespace lodestar::fusion {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;
using Update = filter::JosephUpdate<2, 1>;

}  // namespace

VerticalChannel::VerticalChannel(const CascadeParameters& parameters)
    : parameters_(parameters), gate_(parameters.gps_false_rejection) {
  const double bias_sigma = parameters.baro_bias.sigma;
  const double gps_sigma = parameters.gps_error.sigma;
  P_bias_.diagonal() << bias_sigma * bias_sigma, gps_sigma * gps_sigma;
}

void VerticalChannel::propagate(double dt, double v_air_d) {
  if (!started_ || dt <= 0.0) return;
  v_air_d_ = v_air_d;
  const double keep = parameters_.vertical_rate_error.decay(dt);
  Eigen::Matrix2d Phi;
  Phi << 1.0, dt, 0.0, keep;
  climb_ = Phi * climb_ - Eigen::Vector2d(v_air_d * dt, 0.0);
  P_climb_ = Phi * P_climb_ * Phi.transpose();
  P_climb_(1, 1) += parameters_.vertical_rate_error.added_variance(dt);

  const Eigen::Vector2d decay(parameters_.baro_bias.decay(dt), parameters_.gps_error.decay(dt));
  bias_ = bias_.cwiseProduct(decay);
  P_bias_ = decay.asDiagonal() * P_bias_ * decay.asDiagonal();
  P_bias_.diagonal() += Eigen::Vector2d(parameters_.baro_bias.added_variance(dt),
                                        parameters_.gps_error.added_variance(dt));
}

void VerticalChannel::update_baro(double baro_altitude, double age) {
  const double r = parameters_.baro_noise * parameters_.baro_noise;
  if (!started_) {
    started_ = true;
    climb_ << baro_altitude, 0.0;
    P_climb_.diagonal() << r, std::pow(parameters_.vertical_rate_error.sigma, 2);
    return;
  }
  const double delay = age + parameters_.baro_lag;
  const double climb_rate = climb_(1) - v_air_d_;
  const Scalar innovation(baro_altitude - (climb_(0) - delay * climb_rate));
  climb_ += Update(P_climb_, {1.0, -delay}, Scalar(r)).apply(P_climb_, innovation);
}

void VerticalChannel::update_gps(double above_baro, double sigma) {
  // The slow part of what the receiver states is a state; the rest is noise.
  const double slow = parameters_.gps_error.sigma;
  const double r =
      std::max(parameters_.gps_noise * parameters_.gps_noise, sigma * sigma - slow * slow);
  const Scalar innovation(above_baro - bias_.sum());
  const Update update(P_bias_, {1.0, 1.0}, Scalar(r));
  if (!gate_.passes(update.normalised_square(innovation), 1) && ++refused_ < kPatience) return;
  if (refused_ >= kPatience) P_bias_(0, 0) += innovation(0) * innovation(0);
  refused_ = 0;
  bias_ += Update(P_bias_, {1.0, 1.0}, Scalar(r)).apply(P_bias_, innovation);
}

double VerticalChannel::sigma_height() const { return std::sqrt(P_climb_(0, 0) + P_bias_(0, 0)); }

}  // namespace lodestar::fusion
