// Studies as Python sees them.
#pragma once

#include <pybind11/pybind11.h>

namespace tetraction::python {

/// Defines the function `study` of the extension module.
void define_study(pybind11::module_& m);

}  // namespace tetraction::python
