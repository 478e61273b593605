// SPDX-License-Identifier: Apache-2.0
#include "lodestar/navigator/navigator.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <string>
#include <variant>

#include "columns.h"
#include "lodestar/storage/calibration_file.h"

namespace lodestar::bindings {
namespace {

using navigator::Navigator;

using Indices = py::array_t<std::int64_t, py::array::c_style>;

/// How one input channel of a recording reaches the navigator, by row number.
using Feed = std::function<void(std::size_t)>;

struct Collected {
  SampleCollector<samples::Attitude> sahrs;
  SampleCollector<samples::Navigation> nav;
  SampleCollector<samples::InsMonitor> ins_monitor;
  SampleCollector<samples::SmduCalibration> smdu_calibration;
  SampleCollector<samples::Health> health;
};

template <class Sample>
Feed offer_feed(Navigator& navigator, const std::string& channel, const py::dict& arrays) {
  return [&navigator, rows = SampleRows<Sample>(channel, arrays)](std::size_t row) {
    navigator.offer(rows.at(row));
  };
}

Feed step_feed(Navigator& navigator, Collected& collected, const std::string& channel,
               const py::dict& arrays) {
  return [&, rows = SampleRows<samples::BodyRates>(channel, arrays)](std::size_t row) {
    const navigator::Outputs* outputs = navigator.step(rows.at(row));
    if (outputs == nullptr) return;
    collected.sahrs.add(outputs->sahrs);
    collected.nav.add(outputs->nav);
    if (outputs->ins_monitor_due) collected.ins_monitor.add(outputs->ins_monitor);
    if (!outputs->health_due) return;
    collected.smdu_calibration.add(outputs->smdu_calibration);
    collected.health.add(navigator.health());
  };
}

Feed feed(Navigator& navigator, Collected& collected, const std::string& name,
          const py::dict& arrays) {
  if (name == "EFCS.RATES") return step_feed(navigator, collected, name, arrays);
  if (name == "EFCS.LOAD_FACTOR") return offer_feed<samples::LoadFactor>(navigator, name, arrays);
  if (name == "SMDU") return offer_feed<samples::MagneticField>(navigator, name, arrays);
  if (name == "ADC") return offer_feed<samples::AirData>(navigator, name, arrays);
  if (name == "GPS") return offer_feed<samples::GpsFix>(navigator, name, arrays);
  if (name == "INS") return offer_feed<samples::InsSolution>(navigator, name, arrays);
  throw std::invalid_argument("channel " + name + ": not an input of an in-process run");
}

/// The bytes of a stored calibration, or a text (TOML); neither if empty.
void use_calibration(navigator::Config& config, const std::string& bytes) {
  if (bytes.empty()) return;
  if (!storage::looks_like_calibration(bytes)) {
    navigator::apply_calibration(config, bytes, "calibration");
    return;
  }
  const auto decoded = sahrs::smdu::decode(bytes, config.airframe.id);
  if (const auto* refusal = std::get_if<sahrs::smdu::Refusal>(&decoded)) {
    throw navigator::ConfigError(std::string("calibration: ") + name(*refusal));
  }
  navigator::apply_calibration(config, std::get<sahrs::smdu::Record>(decoded));
}

/// Runs a whole recording through a fresh navigator, message by message in the given order.
py::dict run(const std::string& config_text, const std::string& calibration,
             const py::dict& channels, const std::vector<std::string>& names,
             const Indices& channel, const Indices& row) {
  if (channel.size() != row.size()) throw std::invalid_argument("channel, row: lengths differ");
  const auto which = channel.unchecked<1>();
  const auto where = row.unchecked<1>();
  navigator::Config config = navigator::parse_config(config_text, "config");
  use_calibration(config, calibration);
  Navigator navigator(config);
  Collected collected;
  std::vector<Feed> feeds;
  std::vector<std::size_t> rows;
  for (const std::string& name : names) {
    const py::dict arrays = channels[py::str(name)];
    feeds.push_back(feed(navigator, collected, name, arrays));
    rows.push_back(static_cast<std::size_t>(py::len(arrays["time_us"])));
  }
  for (py::ssize_t i = 0; i < which.shape(0); ++i) {
    const auto c = static_cast<std::size_t>(which(i));
    const auto r = static_cast<std::size_t>(where(i));
    if (c >= feeds.size() || r >= rows[c]) {
      throw std::out_of_range("event " + std::to_string(i) + ": no such channel or row");
    }
    feeds[c](r);
  }
  py::dict result;
  result["SAHRS"] = collected.sahrs.arrays();
  result["NAV"] = collected.nav.arrays();
  result["INS.MONITOR"] = collected.ins_monitor.arrays();
  result["SMDU.CALIBRATION"] = collected.smdu_calibration.arrays();
  result["HEALTH"] = collected.health.arrays();
  return result;
}

}  // namespace

void bind_navigator(py::module_& module) {
  py::register_exception<navigator::ConfigError>(module, "ConfigError", PyExc_ValueError);
  module.def("run", &run, py::arg("config_text"), py::arg("calibration"), py::arg("channels"),
             py::arg("names"), py::arg("channel"), py::arg("row"),
             "Run a recording through a fresh Navigator; see lodestar.navigator.run.");
  module.def("parameter_table", &navigator::parameter_table,
             "Table of all configuration keys, in Markdown.");
  module.def(
      "check_config",
      [](const std::string& text, const std::string& source) {
        navigator::parse_config(text, source);
      },
      py::arg("text"), py::arg("source"),
      "Raise ConfigError, one line, if `text` is not a valid configuration.");
}

}  // namespace lodestar::bindings
