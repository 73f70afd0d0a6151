// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include <cmath>
#include <limits>
#include <string>

#include <octet/core/base/error.h>

namespace octet::python {
namespace {

std::string shapeText(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t k = 0; k < array.ndim(); ++k) {
    text += (k ? ", " : "") + std::to_string(array.shape(k));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void failShape(const py::array& array, const char* name, const std::string& wanted) {
  throw InputError(name, "has shape " + shapeText(array) + ", not " + wanted);
}

/// Any array whose dtype is one of `kinds` (numpy's letters); sequences become arrays.
py::array asArray(const py::object& object, const char* name, const char* kinds, const char* what) {
  const py::array array = py::array::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + " is no array of " + what);
  }
  const char kind = array.dtype().kind();
  // An empty list is an array of float64, whatever it is to hold.
  if (array.size() > 0 && std::string(kinds).find(kind) == std::string::npos) {
    throw py::type_error(std::string(name) + " has dtype " +
                         py::str(array.dtype()).cast<std::string>() + ", which holds no " + what);
  }
  return array;
}

Contiguous<double> doubles(const py::object& object, const char* name) {
  const py::array array = asArray(object, name, "biuf", "real numbers");
  auto result = Contiguous<double>::ensure(array);
  if (!result) throw py::error_already_set();
  return result;
}

void checkFinite(const Contiguous<double>& array, const char* name, py::ssize_t columns) {
  const double* const data = array.data();
  for (py::ssize_t k = 0; k < array.size(); ++k) {
    if (std::isfinite(data[k])) continue;
    throw InputError(name + ("[" + std::to_string(k / columns)) + "]", "is not finite");
  }
}

/// Unsigned 64-bit numbers are not all int64.
Contiguous<std::int64_t> wideIntegers(const py::array& array, const char* name) {
  if (array.dtype().kind() == 'u' && array.itemsize() == 8) {
    const auto wide = Contiguous<std::uint64_t>::ensure(array);
    for (py::ssize_t k = 0; k < wide.size(); ++k) {
      if (wide.data()[k] > static_cast<std::uint64_t>(std::numeric_limits<Index>::max())) {
        throw InputError(name, "index " + std::to_string(wide.data()[k]) + " is out of range");
      }
    }
  }
  auto result = Contiguous<std::int64_t>::ensure(array);
  if (!result) throw py::error_already_set();
  return result;
}

}  // namespace

Contiguous<double> finiteNumbers(const py::object& object, const char* name, py::ssize_t count) {
  auto result = doubles(object, name);
  if (result.ndim() != 1 || (count >= 0 && result.shape(0) != count)) {
    failShape(result, name, count < 0 ? "(n,)" : "(" + std::to_string(count) + ",)");
  }
  checkFinite(result, name, 1);
  return result;
}

Contiguous<double> finitePoints(const py::object& object, const char* name) {
  auto result = doubles(object, name);
  if (result.ndim() == 1 && result.shape(0) == 0) {
    result = Contiguous<double>(std::vector<py::ssize_t>{0, 3});
  }
  if (result.ndim() == 0 || result.shape(result.ndim() - 1) != 3) {
    failShape(result, name, "(..., 3)");
  }
  checkFinite(result, name, 3);
  return result;
}

Contiguous<Index> indexRows(const py::object& object, const char* name, py::ssize_t columns) {
  const py::array array = asArray(object, name, "iu", "integers");
  const py::ssize_t dimensions = columns == 0 ? 1 : 2;
  if (array.size() == 0 && array.ndim() <= dimensions) {
    return columns == 0 ? Contiguous<Index>(0)
                        : Contiguous<Index>(std::vector<py::ssize_t>{0, columns});
  }
  if (array.ndim() != dimensions || (columns > 0 && array.shape(1) != columns)) {
    failShape(array, name, columns == 0 ? "(n,)" : "(n, " + std::to_string(columns) + ")");
  }
  const auto wide = wideIntegers(array, name);
  Contiguous<Index> result(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
  Index* const out = result.mutable_data();
  for (py::ssize_t k = 0; k < wide.size(); ++k) {
    const std::int64_t i = wide.data()[k];
    if (i < 0 || i > std::numeric_limits<Index>::max()) {
      const py::ssize_t row = columns == 0 ? k : k / columns;
      throw InputError(name + ("[" + std::to_string(row)) + "]",
                       "index " + std::to_string(i) + " is out of range");
    }
    out[k] = static_cast<Index>(i);
  }
  return result;
}

Array<Vec3> asPoints(const Contiguous<double>& points) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const auto* const first = reinterpret_cast<const Vec3*>(points.data());
  return Array<Vec3>(first, first + points.size() / 3);
}

std::vector<py::ssize_t> leadingShape(const py::array& array) {
  return std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim() - 1);
}

}  // namespace octet::python
