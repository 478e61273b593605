// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>

#include "lodestar/navigator/config.h"

namespace lodestar::app {

/// The command line of lodestar-fc.
struct Options {
  std::string config;       // path; empty: built-in defaults
  std::string calibration;  // path; empty: as the configuration has it
  std::string lcm_url;
  std::string replay;  // path; empty: live
  std::string output;  // path
  bool realtime = false;
};

/// The options, or the exit status where nothing is left to do: 0 after --help, --version and
/// --parameters, 2 after one line on standard error.
std::variant<Options, int> parse_options(int argc, const char* const* argv);

/// Reads the files that the options name. Throws std::runtime_error (navigator::ConfigError among
/// them) in one line.
navigator::Config load_config(const Options& options);

/// Version of this build.
const char* version();

}  // namespace lodestar::app
