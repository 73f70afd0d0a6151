// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include <octet/core/field/field.h>

namespace octet::python {

/// A field of one or of three components.
struct FieldHandle {
  std::variant<ScalarField, VectorField> field;

  explicit FieldHandle(ScalarField f) : field(std::move(f)) {}
  explicit FieldHandle(VectorField f) : field(std::move(f)) {}
};

}  // namespace octet::python
