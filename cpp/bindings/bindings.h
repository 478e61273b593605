// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

namespace lodestar::bindings {

// One function per folder of the core that Python sees; each adds its names to lodestar._core.
void bind_calibration(pybind11::module_& module);
void bind_earth(pybind11::module_& module);
void bind_navigator(pybind11::module_& module);

}  // namespace lodestar::bindings
