// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/navigator.h"

#include <algorithm>

namespace lodestar::navigator {

using samples::Channel;
using samples::Reason;
using samples::Use;

namespace {

constexpr std::int64_t kMonitorStep = kSecond / 10;  // between two INS.MONITOR

/// With what the calibration of the detector leaves.
strapdown::Parameters strapdown_parameters(const Config& config) {
  strapdown::Parameters parameters = config.strapdown;
  const sahrs::FieldCalibration& calibration = config.smdu_calibration;
  if (calibration.bias_sigma) parameters.field_bias_sigma = *calibration.bias_sigma;
  if (calibration.matrix_sigma) parameters.field_matrix_sigma = *calibration.matrix_sigma;
  return parameters;
}

sahrs::Sahrs make_sahrs(const Config& config) {
  sahrs::Parameters paper = config.sahrs;
  const sahrs::FieldCalibration& calibration = config.smdu_calibration;
  if (calibration.bias_sigma) paper.field_bias.sigma = *calibration.bias_sigma;
  if (calibration.matrix_sigma) paper.field_matrix_sigma = *calibration.matrix_sigma;
  sahrs::Sahrs sahrs(paper, strapdown_parameters(config), calibration,
                     config.earth.geomagnetic_model, config.earth.epoch_year);
  const InitialParameters& initial = config.initial;
  sahrs.set_position(initial.lat, initial.lon, initial.h);
  return sahrs;
}

sahrs::smdu::CalibrationFilter make_calibration(const Config& config) {
  return sahrs::smdu::CalibrationFilter(config.smdu_calibration_filter,
                                        config.earth.geomagnetic_model, config.earth.epoch_year);
}

void set_initial_position(fusion::GpsAcceptance& parameters, const InitialParameters& initial) {
  if (!initial.position_sigma) return;
  parameters.initial_lat = initial.lat;
  parameters.initial_lon = initial.lon;
  parameters.initial_position_sigma = *initial.position_sigma;
}

fusion::Fusion make_fusion(const Config& config) {
  const InitialParameters& initial = config.initial;
  if (config.fusion.filter == samples::FusionFilter::kCascade) {
    fusion::CascadeParameters parameters = config.cascade;
    parameters.initial_heading = initial.heading;
    parameters.initial_heading_sigma = initial.heading_sigma;
    set_initial_position(parameters, initial);
    return fusion::Fusion(fusion::Cascade(parameters));
  }
  fusion::IntegratedParameters parameters = config.integrated;
  set_initial_position(parameters, initial);
  fusion::Integrated integrated(parameters, strapdown_parameters(config),
                                sahrs::guard_limits(config.sahrs), config.earth.geomagnetic_model,
                                config.earth.epoch_year);
  integrated.set_position(initial.lat, initial.lon, initial.h);
  return fusion::Fusion(integrated);
}

}  // namespace

Navigator::Navigator(const Config& config)
    : config_(config),
      field_model_(config.earth.geomagnetic_model),
      sahrs_(make_sahrs(config)),
      fusion_(make_fusion(config)),
      calibration_(make_calibration(config)),
      ins_monitor_(config.ins_monitor, config.timeout.ins),
      body_rates_(config.timeout.body_rates),
      inputs_({Channel::kLoadFactor, config.timeout.load_factor},
              {Channel::kMagneticField, config.timeout.magnetic_field},
              {Channel::kAirData, config.timeout.air_data}, {Channel::kGps, config.timeout.gps},
              {Channel::kIns, config.timeout.ins}),
      specific_force_(config.timeout.other),
      gps_observables_(config.timeout.other),
      sar_(config.timeout.other),
      radar_altitude_(config.timeout.other) {}

template <class Sample>
bool Navigator::accept(SensorWatch<Sample>& watch, Channel channel, const Sample& sample) {
  samples::ChannelCounters& counters = of(counters_, channel);
  ++counters.received;
  const auto reason = watch.judge(sample);
  if (reason) counters.reject(*reason);
  return !reason;
}

template <class Sample, std::size_t Capacity>
void Navigator::hold(Input<Sample, Capacity>& input, const Sample& sample) {
  if (!accept(input.watch, input.channel, sample)) return;
  if (input.pending.full()) {  // the oldest goes: it is the least use to the frame that comes
    of(counters_, input.channel).reject(Reason::kQueueFull);
    input.pending.pop();
  }
  input.pending.push(sample);
}

void Navigator::offer(const samples::LoadFactor& s) { hold(std::get<0>(inputs_), s); }
void Navigator::offer(const samples::MagneticField& s) { hold(std::get<1>(inputs_), s); }
void Navigator::offer(const samples::AirData& s) { hold(std::get<2>(inputs_), s); }
void Navigator::offer(const samples::GpsFix& s) { hold(std::get<3>(inputs_), s); }

void Navigator::offer(const samples::InsSolution& s) {
  auto& input = std::get<4>(inputs_);
  hold(input, s);
  if (!s.valid || input.watch.state(clock_.now()) == samples::SensorState::kStuck) {
    calibration_.fail_ins();
  }
}

void Navigator::offer(const samples::SpecificForce& s) {
  accept(specific_force_, Channel::kSpecificForce, s);
}
void Navigator::offer(const samples::GpsObservables& s) {
  accept(gps_observables_, Channel::kGpsObservables, s);
}
void Navigator::offer(const samples::SarMeasurement& s) { accept(sar_, Channel::kSar, s); }
void Navigator::offer(const samples::RadarAltitude& s) {
  accept(radar_altitude_, Channel::kRadarAltitude, s);
}

void Navigator::count_rejection(Channel channel, Reason reason) {
  samples::ChannelCounters& counters = of(counters_, channel);
  ++counters.received;
  counters.reject(reason);
}

const Outputs* Navigator::step(const samples::BodyRates& rates) {
  const bool first = !clock_.started();
  switch (clock_.judge(rates.time_us)) {
    case FrameClock::Verdict::kBackwards:
      count_rejection(Channel::kBodyRates, Reason::kTimeBackwards);
      return nullptr;
    case FrameClock::Verdict::kAhead:
      count_rejection(Channel::kBodyRates, Reason::kFuture);
      return nullptr;
    case FrameClock::Verdict::kJump:
      start_over();
      break;
    case FrameClock::Verdict::kFrame:
      break;
  }
  if (first) start(rates.time_us);
  if (accept(body_rates_, Channel::kBodyRates, rates)) {
    ++of(counters_, Channel::kBodyRates).used;
    rates_us_ = rates.time_us;
    estimate(rates);
  } else {
    coast(rates.time_us);
  }
  publish(rates.time_us, first);
  return &outputs_;
}

void Navigator::start(std::int64_t time_us) {
  const InitialParameters& initial = config_.initial;
  if (!initial.roll || !initial.pitch || !initial.heading) return;
  sahrs_.start({*initial.roll, *initial.pitch, *initial.heading},
               {initial.attitude_sigma, initial.attitude_sigma, initial.heading_sigma}, time_us);
}

void Navigator::start_over() {
  restarts_ = static_cast<std::int16_t>(outputs_.sahrs.reset_count + 1);
  sahrs_ = make_sahrs(config_);
  fusion_ = make_fusion(config_);
  calibration_ = make_calibration(config_);
  ins_monitor_ = monitor::InsMonitor(config_.ins_monitor, config_.timeout.ins);
  body_rates_.restart();
  const auto restart = [](auto& input) {
    input.watch.restart();
    input.pending.clear();
    input.applied_us = kNever;
  };
  std::apply([&](auto&... input) { (restart(input), ...); }, inputs_);
  next_health_us_ = 0;
  next_monitor_us_ = 0;
}

void Navigator::estimate(const samples::BodyRates& rates) {
  sahrs_.propagate(rates);
  fusion_.propagate(rates);
  apply_in_order(std::get<0>(inputs_), std::get<1>(inputs_), std::get<2>(inputs_));
  sahrs_.finish_frame();
  fusion_.follow(sahrs_.attitude());
  apply_in_order(std::get<3>(inputs_));
  ins_monitor_.propagate(sahrs_.attitude());
  apply_in_order(std::get<4>(inputs_));
  if (const auto heading = ins_monitor_.take_failure()) {
    fusion_.know_heading_error(heading->error, heading->sigma, heading->time_us);
  }
  std::apply([this](auto&... input) { (drop_future(input), ...); }, inputs_);
  const samples::Navigation& nav = fusion_.navigation();
  if (!nav.valid) return;
  sahrs_.set_position(nav.lat, nav.lon, nav.h);
  fusion_.set_position(nav.lat, nav.lon, nav.h);
}

// Without rates the attitude is held, and no measurement can be compared with it: those wait for
// the next good rates, for as long as they may.
void Navigator::coast(std::int64_t time_us) {
  samples::Attitude held = sahrs_.attitude();
  held.time_us = time_us;
  fusion_.coast(held);
}

template <class... Inputs>
void Navigator::apply_in_order(Inputs&... inputs) {
  for (;;) {
    std::int64_t earliest = clock_.now() + 1;
    const auto look = [&earliest](const auto& input) {
      if (!input.pending.empty()) earliest = std::min(earliest, input.pending.front().time_us);
    };
    (look(inputs), ...);
    if (earliest > clock_.now()) return;
    // The first input that holds a sample of that time: order among equals is that of the inputs.
    bool done = false;
    const auto apply_if_earliest = [&](auto& input) {
      if (done || input.pending.empty() || input.pending.front().time_us != earliest) return;
      apply_front(input);
      done = true;
    };
    (apply_if_earliest(inputs), ...);
  }
}

template <class AnyInput>
void Navigator::apply_front(AnyInput& input) {
  samples::ChannelCounters& counters = of(counters_, input.channel);
  input.applied_us = input.pending.front().time_us;
  if (clock_.now() - input.pending.front().time_us > kOldest) {
    counters.reject(Reason::kLate);
  } else {
    switch (apply(input.pending.front())) {
      case Use::kUsed:
      case Use::kHeld:
        ++counters.used;
        break;
      case Use::kGated:
        counters.reject(Reason::kGate);
        break;
      case Use::kAssumption:  // counted by the estimator, check by check
        break;
    }
  }
  input.pending.pop();
}

Use Navigator::apply(const samples::LoadFactor& sample) {
  fusion_.update(sample);
  return sahrs_.update(sample);
}

Use Navigator::apply(const samples::MagneticField& sample) {
  calibration_.update(sample);
  samples::MagneticField calibrated = sample;
  calibrated.b_B = config_.smdu_calibration.apply(sample.b_B);
  fusion_.update(calibrated);
  return sahrs_.update(sample);
}

Use Navigator::apply(const samples::AirData& sample) {
  fusion_.update(sample);
  return sahrs_.update(sample);
}

// Never an input of SAHRS: who watches the INS, or learns from it for the next flight, takes it
// here.
Use Navigator::apply(const samples::InsSolution& sample) {
  calibration_.update(sample);
  ins_monitor_.compare(sample);
  return Use::kHeld;
}

template <class AnyInput>
void Navigator::drop_future(AnyInput& input) {
  bool dropped = false;
  while (!input.pending.empty() && input.pending.back().time_us > clock_.now() + kAhead) {
    of(counters_, input.channel).reject(Reason::kFuture);
    input.pending.pop_back();
    dropped = true;
  }
  // A wild time stamp must not make what follows look late.
  if (!dropped) return;
  input.watch.rewind(input.pending.empty() ? input.applied_us : input.pending.back().time_us);
}

void Navigator::publish(std::int64_t time_us, bool first) {
  outputs_.sahrs = sahrs_.attitude();
  outputs_.nav = fusion_.navigation();
  outputs_.sahrs.time_us = time_us;
  outputs_.nav.time_us = time_us;
  outputs_.sahrs.reset_count = static_cast<std::int16_t>(outputs_.sahrs.reset_count + restarts_);
  const bool bridged = time_us - rates_us_ <= kLongestCoast;
  outputs_.sahrs.valid = outputs_.sahrs.valid && bridged;
  outputs_.nav.valid = outputs_.nav.valid && bridged;
  const samples::InsState before = outputs_.ins_monitor.state;
  outputs_.ins_monitor = ins_monitor_.state();
  outputs_.ins_monitor.time_us = time_us;
  const bool news = outputs_.ins_monitor.state != before;
  outputs_.ins_monitor_due = first || news || time_us >= next_monitor_us_;
  if (outputs_.ins_monitor_due) next_monitor_us_ = (time_us / kMonitorStep + 1) * kMonitorStep;
  outputs_.health_due = first || time_us >= next_health_us_;
  if (outputs_.ins_monitor.state == samples::InsState::kMiscompare) calibration_.fail_ins();
  if (!outputs_.health_due) return;
  next_health_us_ = (time_us / kSecond + 1) * kSecond;
  outputs_.smdu_calibration = calibration_.status(time_us);
}

CalibrationResult Navigator::calibration_result() const {
  return {calibration_.verdict(),
          calibration_.checks(),
          {config_.airframe.id, calibration_.time_us(), config_.earth.epoch_year,
           sahrs::smdu::Source::kFlight, calibration_.calibration()}};
}

samples::Health Navigator::health() const {
  samples::Health health;
  const std::int64_t now = clock_.now();
  health.time_us = now;
  health.counters = counters_;
  const auto set_state = [&](Channel channel, const auto& watch) {
    health.sensor_state[static_cast<std::size_t>(channel)] = watch.state(now);
  };
  set_state(Channel::kBodyRates, body_rates_);
  std::apply([&](const auto&... input) { (set_state(input.channel, input.watch), ...); }, inputs_);
  set_state(Channel::kSpecificForce, specific_force_);
  set_state(Channel::kGpsObservables, gps_observables_);
  set_state(Channel::kSar, sar_);
  set_state(Channel::kRadarAltitude, radar_altitude_);
  health.sahrs_form = sahrs_.form();
  health.fusion_filter = fusion_.filter();
  health.sahrs_mode = outputs_.sahrs.mode;
  health.fusion_mode = outputs_.nav.mode;
  health.calibration_id = calibration_id(config_.smdu_calibration);
  health.config_hash = config_.hash;
  const sahrs::Sahrs::Rows innovation = sahrs_.innovation();
  const sahrs::Sahrs::Rows innovation_sigma = sahrs_.innovation_sigma();
  std::copy(innovation.begin(), innovation.end(), health.innovation.begin());
  std::copy(innovation_sigma.begin(), innovation_sigma.end(), health.innovation_sigma.begin());
  for (int axis = 0; axis < 2; ++axis) {
    const std::size_t row = innovation.size() + static_cast<std::size_t>(axis);
    health.innovation[row] = fusion_.innovation()(axis);
    health.innovation_sigma[row] = fusion_.innovation_sigma()(axis);
  }
  health.assumption_rejects = sahrs_.assumption_rejects();
  const double h = outputs_.nav.valid ? outputs_.nav.h : config_.initial.h;
  if (!field_model_.validity(config_.earth.epoch_year, h).valid()) {
    health.warning = samples::kWarningFieldModel;
  }
  return health;
}

}  // namespace lodestar::navigator
