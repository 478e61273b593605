// SPDX-License-Identifier: Apache-2.0
// Time of one frame, over the frames of a recorded flight: LODESTAR_BENCH_LOG names the LCM log.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

#include "lodestar/bus/channels.h"
#include "lodestar/bus/codec.h"
#include "lodestar/bus/log_reader.h"
#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/fusion/cascade.h"
#include "lodestar/fusion/integrated.h"
#include "lodestar/navigator/navigator.h"
#include "lodestar/sahrs/paper_sahrs.h"
#include "lodestar/sahrs/velocity_sahrs.h"

namespace {

using namespace lodestar;

/// A flight cut into frames: the messages up to and with one EFCS.RATES.
struct Flight {
  std::vector<std::vector<bus::Decoded>> frames;
};

Flight load(const char* path) {
  Flight flight;
  std::vector<bus::Decoded> frame;
  bus::LogReader reader(path);
  bus::LogEvent event;
  while (reader.next(event)) {
    const auto channel = bus::input_channel(event.channel);
    if (!channel) continue;
    frame.push_back(bus::decode(*channel, event.data, event.size));
    if (*channel != samples::Channel::kBodyRates) continue;
    flight.frames.push_back(frame);
    frame.clear();
  }
  return flight;
}

const Flight& flight() {
  static const Flight loaded = load(std::getenv("LODESTAR_BENCH_LOG"));
  return loaded;
}

template <samples::FusionFilter filter>
struct WholeNavigator {
  navigator::Navigator navigator{config()};

  static navigator::Config config() {
    navigator::Config config;
    config.fusion.filter = filter;
    return config;
  }

  void take(samples::Reason) {}
  void take(const samples::BodyRates& s) { benchmark::DoNotOptimize(navigator.step(s)); }
  template <class Sample>
  void take(const Sample& s) {
    navigator.offer(s);
  }
  void fly(std::size_t frame) {
    for (const bus::Decoded& message : flight().frames[frame]) {
      std::visit([this](const auto& sample) { take(sample); }, message);
    }
  }
};

/// What has come with one EFCS.RATES, small and in one piece, so that the time of an estimator is
/// not that of fetching messages.
struct SensorFrame {
  samples::BodyRates rates;
  std::optional<samples::LoadFactor> load;
  std::optional<samples::MagneticField> field;
  std::optional<samples::AirData> air;
  std::optional<samples::GpsFix> fix;

  void take(const samples::BodyRates& s) { rates = s; }
  void take(const samples::LoadFactor& s) { load = s; }
  void take(const samples::MagneticField& s) { field = s; }
  void take(const samples::AirData& s) { air = s; }
  void take(const samples::GpsFix& s) { fix = s; }
  template <class Other>
  void take(const Other&) {}
};

const std::vector<SensorFrame>& sensor_frames() {
  static const std::vector<SensorFrame> made = [] {
    std::vector<SensorFrame> frames(flight().frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      for (const bus::Decoded& message : flight().frames[i]) {
        std::visit([&frame = frames[i]](const auto& sample) { frame.take(sample); }, message);
      }
    }
    return frames;
  }();
  return made;
}

/// SAHRS of either form alone: predict, and what has come with the frame.
template <class Sahrs>
struct SahrsAlone {
  const std::vector<SensorFrame>& frames = sensor_frames();
  Sahrs sahrs = made();

  static Sahrs made() {
    const navigator::Config c;
    if constexpr (std::is_same_v<Sahrs, sahrs::PaperSahrs>) {
      return Sahrs(c.sahrs, c.smdu_calibration, c.earth.geomagnetic_model, c.earth.epoch_year);
    } else {
      return Sahrs(c.sahrs, c.strapdown, c.smdu_calibration, c.earth.geomagnetic_model,
                   c.earth.epoch_year);
    }
  }
  SahrsAlone() {
    const navigator::InitialParameters initial;
    sahrs.set_position(initial.lat, initial.lon, initial.h);
  }
  void fly(std::size_t i) {
    const SensorFrame& frame = frames[i];
    sahrs.propagate(frame.rates);
    if (frame.load) sahrs.update(*frame.load);
    if (frame.field) sahrs.update(*frame.field);
    if (frame.air) sahrs.update(*frame.air);
    sahrs.finish_frame();
    benchmark::DoNotOptimize(sahrs.attitude());
  }
};

/// The answers of SAHRS over the flight, made once.
const std::vector<samples::Attitude>& attitudes() {
  static const std::vector<samples::Attitude> made = [] {
    std::vector<samples::Attitude> answers;
    const auto sahrs = std::make_unique<SahrsAlone<sahrs::PaperSahrs>>();
    for (std::size_t i = 0; i < sensor_frames().size(); ++i) {
      sahrs->fly(i);
      answers.push_back(sahrs->sahrs.attitude());
    }
    return answers;
  }();
  return made;
}

/// The cascade alone, behind a SAHRS that costs nothing.
struct CascadeAlone {
  const std::vector<SensorFrame>& frames = sensor_frames();
  const std::vector<samples::Attitude>& sahrs = attitudes();
  fusion::Cascade cascade{fusion::CascadeParameters{}};

  void fly(std::size_t i) {
    const SensorFrame& frame = frames[i];
    if (frame.air) cascade.update(*frame.air);
    cascade.propagate(sahrs[i]);
    if (frame.fix) cascade.update(*frame.fix);
    benchmark::DoNotOptimize(cascade.navigation());
  }
};

/// The integrated filter alone: predict, and what has come with the frame.
struct IntegratedAlone {
  const std::vector<SensorFrame>& frames = sensor_frames();
  const std::vector<samples::Attitude>& sahrs = attitudes();
  fusion::Integrated integrated = made();

  static fusion::Integrated made() {
    const navigator::Config c;
    fusion::Integrated one(c.integrated, c.strapdown, sahrs::guard_limits(c.sahrs),
                           c.earth.geomagnetic_model, c.earth.epoch_year);
    one.set_position(c.initial.lat, c.initial.lon, c.initial.h);
    return one;
  }
  void fly(std::size_t i) {
    const SensorFrame& frame = frames[i];
    integrated.propagate(frame.rates);
    if (frame.load) integrated.update(*frame.load);
    if (frame.field) integrated.update(*frame.field);
    if (frame.air) integrated.update(*frame.air);
    integrated.follow(sahrs[i]);
    if (frame.fix) integrated.update(*frame.fix);
    benchmark::DoNotOptimize(integrated.navigation());
  }
};

/// Runs `Estimator` over the flight, again and again from the start; one iteration is one frame.
template <class Estimator>
void one_frame(benchmark::State& state) {
  const std::size_t frames = flight().frames.size();
  auto estimator = std::make_unique<Estimator>();
  std::size_t i = 0;
  for (auto _ : state) {
    estimator->fly(i);
    if (++i < frames) continue;
    state.PauseTiming();
    estimator = std::make_unique<Estimator>();
    i = 0;
    state.ResumeTiming();
  }
}

/// A whole evaluation: every place is another one.
void geomagnetic_evaluation(benchmark::State& state) {
  earth::GeomagneticModel model(earth::GeomagneticKind::kIgrf14);
  double place = 0.0;
  for (auto _ : state) {
    place += 0.001;
    const double lat = 1.5 * std::sin(place);
    benchmark::DoNotOptimize(model.field_N(lat, place, 5000.0, 2026.5));
  }
}

BENCHMARK(one_frame<WholeNavigator<samples::FusionFilter::kIntegrated>>)
    ->Name("navigator_frame")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(one_frame<WholeNavigator<samples::FusionFilter::kCascade>>)
    ->Name("navigator_cascade_frame")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(one_frame<SahrsAlone<sahrs::PaperSahrs>>)
    ->Name("sahrs_paper_step")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(one_frame<SahrsAlone<sahrs::VelocitySahrs>>)
    ->Name("sahrs_step")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(one_frame<IntegratedAlone>)->Name("integrated_step")->Unit(benchmark::kMicrosecond);
BENCHMARK(one_frame<CascadeAlone>)->Name("cascade_step")->Unit(benchmark::kMicrosecond);
BENCHMARK(geomagnetic_evaluation)->Name("geomagnetic_evaluation")->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  if (std::getenv("LODESTAR_BENCH_LOG") == nullptr) {
    std::fprintf(stderr, "bench_frames: LODESTAR_BENCH_LOG must name an LCM log of a flight\n");
    return 2;
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
