// SPDX-License-Identifier: Apache-2.0
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <variant>

#include "lodestar/app/calibration.h"
#include "lodestar/app/live.h"
#include "lodestar/app/options.h"
#include "lodestar/app/replay.h"
#include "lodestar/app/stop_signals.h"

namespace {

using namespace lodestar;  // NOLINT: the program itself

void run_replay(const app::Options& options, const app::StopSignals& stop) {
  const auto start = std::chrono::steady_clock::now();
  const navigator::Config config = app::load_config(options);
  const app::Replayed count = app::replay(config, options.replay, options.output, stop);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  spdlog::info("{} messages, {} frames in {:.2f} s -> {}", count.messages, count.frames,
               taken.count(), options.output);
  app::keep_calibration(count.calibration, options.calibration);
}

void run_live(const app::Options& options, const app::StopSignals& stop) {
  app::Live live(app::load_config(options), options.lcm_url, options.realtime);
  spdlog::info("lodestar-fc {} on {}", app::version(), options.lcm_url);
  live.run(stop);
  spdlog::info("stopped after {} frames", live.frames());
  app::keep_calibration(live.calibration_result(), options.calibration);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto options = app::parse_options(argc, argv);
    if (const int* status = std::get_if<int>(&options)) return *status;
    spdlog::set_default_logger(spdlog::stderr_logger_mt("lodestar-fc"));
    spdlog::set_pattern("%H:%M:%S.%e %l %v");
    const app::StopSignals stop;
    const auto& given = std::get<app::Options>(options);
    if (given.replay.empty()) {
      run_live(given, stop);
    } else {
      run_replay(given, stop);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lodestar-fc: %s\n", error.what());
    return 2;
  }
  return 0;
}
