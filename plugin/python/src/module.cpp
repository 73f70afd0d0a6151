// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <pybind11/pybind11.h>
#include <tbb/global_control.h>

#include <octet/version.h>

#include "../../choices.h"
#include "bindings.h"
#include "errors.h"

namespace octet::python {

BoundaryChoice boundaryChoice(const std::string& name, bool methods) {
  return choose("boundary", name, boundaryChoices(methods));
}

BoundaryRows wallSurfaceChoice(const std::string& name) {
  return choose("wall_surface", name, wallSurfaceChoices());
}

Reconstruction reconstructionChoice(const std::string& name) {
  return choose("reconstruction", name, reconstructionChoices());
}

namespace {

/// A limit on threads from `enter` to `exit`.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads) : threads_(threads) {
    if (threads < 1) throw InputError("threads", "is less than 1");
  }
  void enter() {
    control_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                     static_cast<std::size_t>(threads_));
  }
  void exit() { control_.reset(); }

 private:
  int threads_;
  std::unique_ptr<tbb::global_control> control_;
};

void bindThreadLimit(py::module_& module) {
  py::class_<ThreadLimit>(
      module, "ThreadLimit", py::module_local(),
      R"(Limits the library to some threads: `with octetvdb.ThreadLimit(4): ...`.

Holds for the whole process. Results do not depend on it.)")
      .def(py::init<int>(), py::arg("threads"))
      .def("__enter__",
           [](ThreadLimit& limit) -> ThreadLimit& {
             limit.enter();
             return limit;
           })
      .def("__exit__", [](ThreadLimit& limit, const py::args&) { limit.exit(); });
}

}  // namespace
}  // namespace octet::python

PYBIND11_MODULE(_octetvdb, module) {
  module.doc() = "The compiled part of octetvdb.";
  module.attr("__version__") = octet::kVersion;
  octet::python::bindErrors(module);
  octet::python::bindMesh(module);
  octet::python::bindAsset(module);
  octet::python::bindField(module);
  octet::python::bindRefiner(module);
  octet::python::bindCertificate(module);
  octet::python::bindBake(module);
  octet::python::bindCages(module);
  octet::python::bindFit(module);
  octet::python::bindPrimitives(module);
  octet::python::bindSampling(module);
  octet::python::bindStreamlines(module);
  octet::python::bindThreadLimit(module);
}
