// SPDX-License-Identifier: Apache-2.0
#include "errors.h"

#include <octet/core/base/memory_budget.h>

namespace octet::python {
namespace {

namespace py = pybind11;

/// Live as long as the interpreter: the translator has no state of its own.
PyObject *errorType = nullptr, *inputErrorType = nullptr, *ioErrorType = nullptr,
         *memoryErrorType = nullptr, *cancelledType = nullptr;

PyObject* makeType(py::module_& module, const char* name, const char* doc, const py::tuple& bases) {
  py::dict members;
  for (const char* part : {"file", "place", "reason"}) members[part] = py::str("");
  const std::string qualified = std::string("octetvdb.") + name;
  PyObject* const type =
      PyErr_NewExceptionWithDoc(qualified.c_str(), doc, bases.ptr(), members.ptr());
  if (!type) throw py::error_already_set();
  module.add_object(name, type);
  return type;
}

void raise(PyObject* type, const Error& e) {
  try {
    const py::object exception = py::handle(type)(py::str(e.what()));
    exception.attr("file") = py::str(e.file());
    exception.attr("place") = py::str(e.place());
    exception.attr("reason") = py::str(e.reason());
    PyErr_SetObject(type, exception.ptr());
  } catch (const py::error_already_set&) {
    // A name that is not UTF-8: the message still gets through.
    PyErr_SetString(type, "the error's message cannot be shown as text");
  }
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const InputError& e) {
    raise(inputErrorType, e);
  } catch (const IoError& e) {
    raise(ioErrorType, e);
  } catch (const MemoryError& e) {
    raise(memoryErrorType, e);
  } catch (const Cancelled& e) {
    raise(cancelledType, e);
  } catch (const Error& e) {
    raise(errorType, e);
  }
}

}  // namespace

void bindErrors(py::module_& module) {
  errorType = makeType(module, "Error",
                       "What the library throws. `file`, `place` and `reason` are the parts of "
                       "the message; those unknown are empty.",
                       py::make_tuple(py::handle(PyExc_Exception)));
  const py::handle error(errorType);
  inputErrorType =
      makeType(module, "InputError", "The caller's data or request cannot be used, and why.",
               py::make_tuple(error, py::handle(PyExc_ValueError)));
  ioErrorType = makeType(module, "IoError", "A file cannot be written: permissions, full disk.",
                         py::make_tuple(error, py::handle(PyExc_OSError)));
  memoryErrorType =
      makeType(module, "MemoryError", "Work needs more memory than there is, and how much.",
               py::make_tuple(error, py::handle(PyExc_MemoryError)));
  cancelledType =
      makeType(module, "Cancelled", "A progress callback returned False.", py::make_tuple(error));
  py::register_local_exception_translator(&translate);
}

void useErrors(const py::module_& module) {
  errorType = module.attr("Error").ptr();
  inputErrorType = module.attr("InputError").ptr();
  ioErrorType = module.attr("IoError").ptr();
  memoryErrorType = module.attr("MemoryError").ptr();
  cancelledType = module.attr("Cancelled").ptr();
  for (PyObject* type : {errorType, inputErrorType, ioErrorType, memoryErrorType, cancelledType})
    Py_INCREF(type);
  py::register_local_exception_translator(&translate);
}

}  // namespace octet::python
