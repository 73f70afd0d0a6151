// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <octet/core/base/types.h>

/// @file
/// numpy arrays in and out. In: any numeric dtype, byte order and strides; contiguous doubles are
/// used in place. Out: the library's own memory, read-only, kept alive by its owner; or memory that
/// is handed over. All of this needs the GIL.

namespace octet::python {

namespace py = pybind11;

/// Contiguous, aligned, native-endian numbers.
template <typename T>
using Contiguous = py::array_t<T, py::array::c_style | py::array::forcecast |
                                      py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

/// @name Arguments
/// `name` is what messages call the argument.
/// @throws InputError for a shape or value, py::type_error for a dtype that holds no such numbers.
/// @{
/// Finite doubles of shape (count,), or (any,) if `count` is negative.
Contiguous<double> finiteNumbers(const py::object& object, const char* name,
                                 py::ssize_t count = -1);
/// Finite points of shape (..., 3), leading dimensions as they are.
Contiguous<double> finitePoints(const py::object& object, const char* name);
/// Indices of shape (any, columns), or (any,) if `columns` is 0. An empty sequence has no rows.
Contiguous<Index> indexRows(const py::object& object, const char* name, py::ssize_t columns);
/// The points of such an array.
Array<Vec3> asPoints(const Contiguous<double>& points);
/// @}

/// Shape of an array without its last dimension.
std::vector<py::ssize_t> leadingShape(const py::array& array);

/// A read-only view of memory that `owner` keeps.
template <typename T>
py::array view(const T* data, std::vector<py::ssize_t> shape, py::handle owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), {}, data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// Views of a container of numbers, points or fixed-size rows.
template <typename Rows>
py::array viewRows(const Rows& rows, py::ssize_t columns, py::handle owner) {
  using Row = typename Rows::value_type;
  using T = std::remove_cv_t<std::remove_reference_t<decltype(std::declval<const Row&>()[0])>>;
  static_assert(std::is_trivially_copyable_v<T>);
  const auto count = static_cast<py::ssize_t>(rows.size());
  return view(reinterpret_cast<const T*>(rows.data()), {count, columns}, owner);
}

/// Hands a container of numbers over to numpy, without a copy.
template <typename Numbers>
py::array handOver(Numbers numbers, std::vector<py::ssize_t> shape) {
  auto* const kept = new Numbers(std::move(numbers));
  const py::capsule owner(kept, [](void* p) { delete static_cast<Numbers*>(p); });
  using T = typename Numbers::value_type;
  if constexpr (std::is_arithmetic_v<T>) {
    return py::array(py::dtype::of<T>(), std::move(shape), {}, kept->data(), owner);
  } else {
    using Scalar = std::remove_cv_t<std::remove_reference_t<decltype((*kept)[0][0])>>;
    return py::array(py::dtype::of<Scalar>(), std::move(shape), {},
                     reinterpret_cast<const Scalar*>(kept->data()), owner);
  }
}
template <typename Numbers>
py::array handOver(Numbers numbers) {
  const auto count = static_cast<py::ssize_t>(numbers.size());
  return handOver(std::move(numbers), {count});
}

}  // namespace octet::python
