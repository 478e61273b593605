// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "lodestar/app/calibration.h"
#include "lodestar/bus/bus.h"
#include "lodestar/bus/log_reader.h"

namespace lodestar::app {
namespace {

std::string read_file(const std::string& path) {
  const bus::File file(std::fopen(path.c_str(), "rb"));
  std::string text;
  std::array<char, 4096> block;
  while (file) {
    const std::size_t count = std::fread(block.data(), 1, block.size(), file.get());
    if (count == 0) break;
    text.append(block.data(), count);
  }
  if (!file || std::ferror(file.get()) != 0) {
    throw std::runtime_error("cannot read " + path + ": " + std::strerror(errno));
  }
  return text;
}

}  // namespace

std::variant<Options, int> parse_options(int argc, const char* const* argv) {
  Options options;
  options.lcm_url = bus::kDefaultUrl;
  bool parameters = false;
  CLI::App app{"Flight computer for synthetic attitude, heading and navigation"};
  app.add_option("--config", options.config, "Configuration; without it the built-in defaults");
  app.add_option("--calibration", options.calibration,
                 "The SMDU's calibration: used, and replaced after a good flight; or a TOML file "
                 "with a section [smdu_calibration], which is only used");
  app.add_option("--lcm-url", options.lcm_url, "Bus of the live inputs and outputs")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  auto* replay = app.add_option("--replay", options.replay, "Read the inputs from this LCM log");
  auto* output = app.add_option("--output", options.output, "Write the outputs to this LCM log");
  auto* realtime = app.add_flag("--realtime", options.realtime,
                                "Lock memory and use SCHED_FIFO, where permitted");
  app.add_flag("--parameters", parameters, "Print the table of all configuration keys and exit");
  app.set_version_flag("--version", std::string("lodestar-fc ") + version());
  replay->needs(output)->excludes(realtime);
  output->needs(replay);
  app.footer(
      "Examples:\n  lodestar-fc --config gripen.toml\n"
      "  lodestar-fc --replay flight.lcm --output answers.lcm");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "lodestar-fc: %s\n", error.what());
    return 2;
  }
  if (parameters) {
    std::fputs(navigator::parameter_table().c_str(), stdout);
    return 0;
  }
  return options;
}

navigator::Config load_config(const Options& options) {
  navigator::Config config;
  if (!options.config.empty()) {
    config = navigator::parse_config(read_file(options.config), options.config);
  }
  use_calibration(config, options.calibration);
  return config;
}

const char* version() { return LODESTAR_VERSION; }

}  // namespace lodestar::app
