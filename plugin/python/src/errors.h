// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

namespace octet::python {

/// Adds the exceptions Error, InputError (also a ValueError), IoError (also an OSError),
/// MemoryError (also Python's) and Cancelled to the module, with attributes `file`, `place` and
/// `reason`, and translates the library's to them.
void bindErrors(pybind11::module_& module);

/// Translates the library's exceptions to those of a module that has them.
void useErrors(const pybind11::module_& module);

}  // namespace octet::python
