// SPDX-License-Identifier: Apache-2.0
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "bindings.h"
#include "columns.h"
#include "lodestar/navigator/config.h"
#include "lodestar/sahrs/ground_swing.h"
#include "lodestar/sahrs/ins_history.h"
#include "lodestar/sahrs/smdu_calibration_filter.h"
#include "lodestar/samples/validity.h"
#include "lodestar/storage/calibration_file.h"

namespace lodestar::bindings {
namespace {

using namespace sahrs::smdu;  // NOLINT: this file is about nothing else

/// All samples of INS and SMDU in order of time, the INS last where they are equal, as in flight.
template <class OnIns, class OnSmdu>
void merge(const py::dict& ins, const py::dict& smdu, OnIns on_ins, OnSmdu on_smdu) {
  const SampleRows<samples::InsSolution> solutions("INS", ins);
  const SampleRows<samples::MagneticField> fields("SMDU", smdu);
  const auto rows = [](const auto& all) { return static_cast<std::size_t>(all.rows()); };
  std::size_t next = 0;
  for (std::size_t i = 0; i < rows(fields); ++i) {
    const samples::MagneticField field = fields.at(i);
    for (; next < rows(solutions) && solutions.at(next).time_us < field.time_us; ++next) {
      on_ins(solutions.at(next));
    }
    if (!samples::refusal(field)) on_smdu(field);
  }
  for (; next < rows(solutions); ++next) on_ins(solutions.at(next));
}

py::dict described(const Calibration& calibration, const char* verdict, std::int64_t time_us,
                   const navigator::Config& config) {
  py::dict result;
  result["x"] = calibration.x;
  result["P"] = calibration.P;
  result["verdict"] = verdict;
  result["time_us"] = time_us;
  result["epoch_year"] = config.earth.epoch_year;
  result["airframe"] = config.airframe.id;
  return result;
}

py::dict calibrate_flight(const std::string& config_text, const py::dict& ins,
                          const py::dict& smdu) {
  const navigator::Config config = navigator::parse_config(config_text, "config");
  CalibrationFilter filter(config.smdu_calibration_filter, config.earth.geomagnetic_model,
                           config.earth.epoch_year);
  merge(
      ins, smdu,
      [&](const samples::InsSolution& solution) {
        if (!solution.valid) filter.fail_ins();
        if (!samples::refusal(solution)) filter.update(solution);
      },
      [&](const samples::MagneticField& field) { filter.update(field); });
  const Checks c = filter.checks();
  const FilterParameters& p = config.smdu_calibration_filter;
  py::dict result =
      described(filter.calibration(), name(filter.verdict()), filter.time_us(), config);
  py::dict checks;  // value and limit
  checks["duration_s"] = py::make_tuple(c.duration, p.min_duration);
  checks["gated"] = py::make_tuple(c.gated, p.max_gated);
  checks["residual"] = py::make_tuple(c.residual, p.max_residual);
  checks["correlation"] = py::make_tuple(c.correlation, p.max_correlation);
  checks["observability"] = py::make_tuple(c.observability, p.min_observability);
  result["checks"] = checks;
  return result;
}

py::dict calibrate_ground(const std::string& config_text, const py::dict& ins,
                          const py::dict& smdu) {
  const navigator::Config config = navigator::parse_config(config_text, "config");
  GroundSwing swing(config.smdu_ground_swing, config.smdu_calibration_filter);
  earth::GeomagneticModel model(config.earth.geomagnetic_model);
  InsHistory history;
  std::optional<samples::MagneticField> waiting;  // for the INS to get to its time
  std::int64_t time_us = 0;
  merge(
      ins, smdu,
      [&](const samples::InsSolution& at) {
        if (samples::refusal(at)) return;
        history.push(at);
        Eigen::Matrix3d C_NB;
        if (!waiting || waiting->time_us > at.time_us) return;
        if (history.attitude_at(waiting->time_us, C_NB)) {
          time_us = waiting->time_us;
          swing.add(time_us, C_NB, waiting->b_B,
                    model.field_N(at.lat, at.lon, at.h, config.earth.epoch_year));
        }
        waiting.reset();
      },
      [&](const samples::MagneticField& field) {
        if (!waiting) waiting = field;
      });
  const SwingParameters& p = config.smdu_ground_swing;
  py::dict result = described(swing.calibration(), name(swing.verdict()), time_us, config);
  py::dict checks;
  checks["sectors"] = py::make_tuple(swing.sectors(), p.min_sectors);
  checks["gated"] = py::make_tuple(swing.gated(), p.max_gated);
  checks["residual"] = py::make_tuple(swing.residual(), p.max_residual);
  result["checks"] = checks;
  return result;
}

void store(const std::string& path, const std::string& airframe, std::int64_t time_us,
           double epoch_year, bool ground, const StateVector& x, const StateMatrix& P) {
  if (airframe.size() > kLongestAirframe) throw std::invalid_argument("airframe: too long");
  const Source source = ground ? Source::kGroundSwing : Source::kFlight;
  storage::store_calibration(path, {airframe, time_us, epoch_year, source, {x, P}});
}

py::object load(const std::string& path, const std::string& airframe) {
  const storage::LoadedCalibration loaded = storage::load_calibration(path, airframe);
  if (!loaded.record) return py::none();
  const Record& record = *loaded.record;
  py::dict result;
  result["x"] = record.calibration.x;
  result["P"] = record.calibration.P;
  result["airframe"] = record.airframe;
  result["time_us"] = record.time_us;
  result["epoch_year"] = record.epoch_year;
  result["source"] = kSourceNames[static_cast<std::size_t>(record.source)];
  result["note"] = loaded.note;
  return result;
}

}  // namespace

void bind_calibration(py::module_& module) {
  using namespace py::literals;
  py::register_exception<storage::StorageError>(module, "StorageError", PyExc_OSError);
  module.def("calibrate_flight", &calibrate_flight, "config_text"_a, "ins"_a, "smdu"_a);
  module.def("calibrate_ground", &calibrate_ground, "config_text"_a, "ins"_a, "smdu"_a);
  module.def("store_calibration", &store, "path"_a, "airframe"_a, "time_us"_a, "epoch_year"_a,
             "ground"_a, "x"_a, "P"_a);
  module.def("load_calibration", &load, "path"_a, "airframe"_a);
}

}  // namespace lodestar::bindings
