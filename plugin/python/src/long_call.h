// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <octet/core/base/context.h>

namespace octet::python {

namespace py = pybind11;

/// The context of one call: memory is what this process may use, and Python is asked whether to go
/// on: signals (Ctrl-C) first, then `callable(stage, done, total, unit)`, which cancels by
/// returning False or by raising. Takes the GIL itself and may be copied and destroyed without it.
/// None asks for signals only.
/// @throws py::type_error when it is neither None nor callable
Context contextOf(const py::object& callable = py::none());

/// Runs `work` without the GIL; returns what it returns, references too.
template <typename Work>
decltype(auto) withoutGil(const Work& work) {
  const py::gil_scoped_release released;
  return work();
}

}  // namespace octet::python
