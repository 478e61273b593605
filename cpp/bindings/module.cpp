// SPDX-License-Identifier: Apache-2.0
#include "bindings.h"

PYBIND11_MODULE(_core, module) {
  module.doc() = "The C++ core of Lodestar. Signatures and docstrings: _core.pyi.";
  lodestar::bindings::bind_calibration(module);
  lodestar::bindings::bind_earth(module);
  lodestar::bindings::bind_navigator(module);
}
