// SPDX-License-Identifier: Apache-2.0
#include <pybind11/numpy.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "bindings.h"
#include "lodestar/earth/geomagnetic_model.h"
#include "lodestar/earth/wgs84.h"

namespace py = pybind11;

namespace lodestar::bindings {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Arrays of one shape, as NumPy broadcasts them; throws its ValueError where they do not fit.
template <class... Arrays>
std::array<Array, sizeof...(Arrays)> broadcast(const Arrays&... arrays) {
  const py::tuple result = py::module_::import("numpy").attr("broadcast_arrays")(arrays...);
  std::array<Array, sizeof...(Arrays)> same_shape;
  for (std::size_t i = 0; i < same_shape.size(); ++i) same_shape[i] = result[i].cast<Array>();
  return same_shape;
}

// An array of `shape` vectors.
Array vectors_like(const Array& shape) {
  std::vector<py::ssize_t> sizes(shape.shape(), shape.shape() + shape.ndim());
  sizes.push_back(3);
  return Array(sizes);
}

earth::GeomagneticKind kind_of(const std::string& name) {
  std::string allowed;
  for (std::size_t i = 0; i < std::size(earth::kGeomagneticNames); ++i) {
    if (name == earth::kGeomagneticNames[i]) return static_cast<earth::GeomagneticKind>(i);
    allowed += (i == 0 ? "" : ", ") + std::string(earth::kGeomagneticNames[i]);
  }
  throw py::value_error("model: unknown geomagnetic model '" + name + "' (allowed: " + allowed +
                        ")");
}

void warn(const std::string& message) {
  if (PyErr_WarnEx(PyExc_RuntimeWarning, message.c_str(), 1) < 0) throw py::error_already_set();
}

void warn_unless_valid(bool years, bool heights, const earth::GeomagneticModel& model,
                       const std::string& name) {
  const auto whole = [](double value) { return std::to_string(std::lround(value)); };
  if (!years) {
    warn("decimal_year: outside " + whole(model.first_year()) + " to " + whole(model.last_year()) +
         " of " + name + "; the nearest epoch is used");
  }
  if (!heights) {
    warn("h: outside " + whole(model.min_height()) + " to " + whole(model.max_height()) + " m of " +
         name + "; the field is extrapolated");
  }
}

Array geomagnetic_field(const Array& lat, const Array& lon, const Array& h,
                        const Array& decimal_year, const std::string& name) {
  earth::GeomagneticModel model(kind_of(name));
  const auto [lats, lons, hs, years] = broadcast(lat, lon, h, decimal_year);
  Array fields = vectors_like(lats);
  double* out = fields.mutable_data();
  bool years_valid = true;
  bool heights_valid = true;
  for (py::ssize_t i = 0; i < lats.size(); ++i) {
    const double year = years.data()[i];
    const earth::ModelValidity here = model.validity(year, hs.data()[i]);
    years_valid &= here.year;
    heights_valid &= here.height;
    Eigen::Map<Eigen::Vector3d>(out + 3 * i) =
        model.field_N(lats.data()[i], lons.data()[i], hs.data()[i], year);
  }
  warn_unless_valid(years_valid, heights_valid, model, name);
  return fields;
}

Array geodetic_to_ecef(const Array& lat, const Array& lon, const Array& h) {
  const auto [lats, lons, hs] = broadcast(lat, lon, h);
  Array positions = vectors_like(lats);
  double* out = positions.mutable_data();
  for (py::ssize_t i = 0; i < lats.size(); ++i) {
    Eigen::Map<Eigen::Vector3d>(out + 3 * i) =
        earth::geodetic_to_ecef({lats.data()[i], lons.data()[i], hs.data()[i]});
  }
  return positions;
}

py::tuple ecef_to_geodetic(const Array& p_E) {
  if (p_E.ndim() == 0 || p_E.shape(p_E.ndim() - 1) != 3) {
    throw py::value_error("p_E: the last axis must have size 3 (x, y, z)");
  }
  const std::vector<py::ssize_t> sizes(p_E.shape(), p_E.shape() + p_E.ndim() - 1);
  Array lat(sizes);
  Array lon(sizes);
  Array h(sizes);
  for (py::ssize_t i = 0; i < lat.size(); ++i) {
    const earth::Geodetic position =
        earth::ecef_to_geodetic(Eigen::Map<const Eigen::Vector3d>(p_E.data() + 3 * i));
    lat.mutable_data()[i] = position.lat;
    lon.mutable_data()[i] = position.lon;
    h.mutable_data()[i] = position.h;
  }
  return py::make_tuple(lat, lon, h);
}

}  // namespace

void bind_earth(py::module_& module) {
  using namespace py::literals;
  module.def("geomagnetic_field", &geomagnetic_field, "lat"_a, "lon"_a, "h"_a, "decimal_year"_a,
             "model"_a = earth::kGeomagneticNames[0]);
  module.def("gravity", py::vectorize(earth::gravity), "lat"_a, "h"_a);
  module.def("meridian_radius", py::vectorize(earth::meridian_radius), "lat"_a);
  module.def("transverse_radius", py::vectorize(earth::transverse_radius), "lat"_a);
  module.def("geodetic_to_ecef", &geodetic_to_ecef, "lat"_a, "lon"_a, "h"_a);
  module.def("ecef_to_geodetic", &ecef_to_geodetic, "p_E"_a);
}

}  // namespace lodestar::bindings
