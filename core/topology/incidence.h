// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/types.h"
#include "../rules/cell_tables.h"

/// @file
/// References to simplices together with how they are seen. A coefficient read through a reference
/// takes its sign; both are 4 bytes, so that incidence stays small.

namespace octet {

/// An edge, seen along its stored direction or against it.
class EdgeRef {
 public:
  EdgeRef() = default;
  EdgeRef(Index edge, bool reversed) : code_(static_cast<std::uint32_t>(edge) << 1 | reversed) {}

  Index index() const { return static_cast<Index>(code_ >> 1); }
  bool reversed() const { return code_ & 1u; }
  double sign() const { return reversed() ? -1.0 : 1.0; }
  EdgeRef flippedIf(bool flip) const { return EdgeRef(code_ ^ static_cast<std::uint32_t>(flip)); }

  static constexpr std::int64_t kMaxEdges = std::int64_t{1} << 31;

 private:
  explicit EdgeRef(std::uint32_t code) : code_(code) {}
  std::uint32_t code_ = 0;
};

/// A facet, seen as an ordered triple: place k of the triple is place `place(k)` of the stored one.
class FacetRef {
 public:
  FacetRef() = default;
  FacetRef(Index facet, std::uint8_t permutation)
      : code_(static_cast<std::uint32_t>(facet) << 3 | permutation) {}

  Index index() const { return static_cast<Index>(code_ >> 3); }
  std::uint8_t permutation() const { return code_ & 7u; }
  int place(int k) const { return kPermutations[permutation()][k]; }
  /// +1 when the triple and the stored facet have the same orientation.
  double sign() const { return permutation() < 3 ? 1.0 : -1.0; }

  static constexpr std::int64_t kMaxFacets = std::int64_t{1} << 29;

 private:
  std::uint32_t code_ = 0;
};

/// A cell seen from one of its local facets.
class CellSide {
 public:
  CellSide() = default;
  CellSide(Index cell, int facet)
      : code_(static_cast<std::uint32_t>(cell) << 3 | static_cast<std::uint32_t>(facet)) {}

  bool exists() const { return code_ != kNoCell; }
  Index cell() const { return static_cast<Index>(code_ >> 3); }
  int facet() const { return static_cast<int>(code_ & 7u); }

 private:
  static constexpr std::uint32_t kNoCell = 0xffffffffu;
  std::uint32_t code_ = kNoCell;
};

/// A cell in the star of a vertex, and the vertex' place in it.
struct CellAtVertex {
  Index cell;
  int place;
};

/// A cell in the star of an edge, and the places of the edge's stored start and end in it.
struct CellAtEdge {
  Index cell;
  int start, end;
};

}  // namespace octet
