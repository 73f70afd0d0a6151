// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <octet/core/base/progress.h>

namespace octet::python {

namespace py = pybind11;

/// A progress callback that asks Python whether to go on: signals (Ctrl-C) first, then
/// `callable(stage, done, total, unit)`, which cancels by returning False or by raising. Takes the
/// GIL itself and may be copied and destroyed without it. None asks for signals only.
/// @throws py::type_error when it is neither None nor callable
ProgressCallback progressCallback(const py::object& callable);

/// Runs `work` without the GIL; returns what it returns, references too.
template <typename Work>
decltype(auto) withoutGil(const Work& work) {
  const py::gil_scoped_release released;
  return work();
}

}  // namespace octet::python
