// SPDX-License-Identifier: Apache-2.0
#include "long_call.h"

namespace octet::python {

Context contextOf(const py::object& callable) {
  if (!callable.is_none() && !PyCallable_Check(callable.ptr())) {
    throw py::type_error("progress is not callable");
  }
  const std::shared_ptr<py::object> kept(new py::object(callable), [](py::object* object) {
    const py::gil_scoped_acquire gil;
    delete object;
  });
  ContextParts parts;
  parts.memoryLimit = memoryLimit();
  parts.progress = [kept](const ProgressReport& report) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (kept->is_none() || report.stage.empty()) return true;
    const py::object answer = (*kept)(report.stage, report.done, report.total, report.unit);
    return answer.ptr() != Py_False;
  };
  return Context(std::move(parts));
}

}  // namespace octet::python
