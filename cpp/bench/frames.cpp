// SPDX-License-Identifier: Apache-2.0
// Time of one frame, over the frames of a recorded flight: LODESTAR_BENCH_LOG names the LCM log.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "lodestar/bus/channels.h"
#include "lodestar/bus/codec.h"
#include "lodestar/bus/log_reader.h"
#include "lodestar/navigator/navigator.h"

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

/// Feeds one decoded message to whatever takes samples.
template <class Estimator>
void feed(Estimator& estimator, const bus::Decoded& message) {
  std::visit([&estimator](const auto& sample) { estimator.take(sample); }, message);
}

struct WholeNavigator {
  navigator::Navigator navigator{navigator::Config{}};
  void take(samples::Reason) {}
  void take(const samples::BodyRates& s) { benchmark::DoNotOptimize(navigator.step(s)); }
  template <class Sample>
  void take(const Sample& s) {
    navigator.offer(s);
  }
};

/// Runs `Estimator` over the flight, again and again from the start; one iteration is one frame.
template <class Estimator>
void one_frame(benchmark::State& state) {
  const auto& frames = flight().frames;
  auto estimator = std::make_unique<Estimator>();
  std::size_t i = 0;
  for (auto _ : state) {
    for (const bus::Decoded& message : frames[i]) feed(*estimator, message);
    if (++i < frames.size()) continue;
    state.PauseTiming();
    estimator = std::make_unique<Estimator>();
    i = 0;
    state.ResumeTiming();
  }
}

BENCHMARK(one_frame<WholeNavigator>)->Name("navigator_frame")->Unit(benchmark::kMicrosecond);

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
