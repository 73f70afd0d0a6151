// SPDX-License-Identifier: Apache-2.0
#include "gmsh_mesh.h"

#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace octet::gmsh_import {
namespace {

/// Appends values; the fields of a struct in the order in which `fields` visits them.
class Packer {
 public:
  template <typename T>
  void operator()(T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    } else {
      fields(*this, value);
    }
  }
  template <typename T>
  void list(T& values) {
    std::uint64_t n = values.size();
    (*this)(n);
    for (auto& value : values) (*this)(value);
  }
  std::string bytes;
};

class Unpacker {
 public:
  explicit Unpacker(const std::string& bytes) : at_(bytes.data()), end_(at_ + bytes.size()) {}

  template <typename T>
  void operator()(T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      if (static_cast<std::size_t>(end_ - at_) < sizeof value) throw std::runtime_error("cut off");
      std::memcpy(&value, at_, sizeof value);
      at_ += sizeof value;
    } else {
      fields(*this, value);
    }
  }
  template <typename T>
  void list(T& values) {
    std::uint64_t n = 0;
    (*this)(n);
    // Every entry takes a byte at least.
    if (n > static_cast<std::uint64_t>(end_ - at_)) throw std::runtime_error("cut off");
    values.resize(n);
    for (auto& value : values) (*this)(value);
  }
  bool atEnd() const { return at_ == end_; }

 private:
  const char* at_;
  const char* end_;
};

template <typename Archive>
void fields(Archive& archive, std::string& text) {
  archive.list(text);
}

template <typename Archive, typename T>
void fields(Archive& archive, std::vector<T>& values) {
  archive.list(values);
}

template <typename Archive>
void fields(Archive& archive, ElementBlock& b) {
  archive(b.type), archive(b.dimension), archive(b.nodesPerElement), archive(b.typeName);
  archive(b.tags), archive(b.nodes);
}

template <typename Archive>
void fields(Archive& archive, ViewStep& s) {
  archive(s.step), archive(s.components), archive(s.tags), archive(s.values);
}

template <typename Archive>
void fields(Archive& archive, View& v) {
  archive(v.name), archive(v.dataType), archive(v.steps);
}

template <typename Archive>
void fields(Archive& archive, PhysicalGroup& g) {
  archive(g.dimension), archive(g.name), archive(g.blocks);
}

template <typename Archive>
void fields(Archive& archive, GmshMesh& m) {
  archive(m.error), archive(m.messages), archive(m.nodeTags), archive(m.coordinates);
  archive(m.blocks), archive(m.views), archive(m.groups);
}

}  // namespace

std::string pack(const GmshMesh& mesh) {
  Packer packer;
  packer(const_cast<GmshMesh&>(mesh));  // one list of fields serves both ways; this one only reads
  return std::move(packer.bytes);
}

GmshMesh unpack(const std::string& bytes) {
  GmshMesh mesh;
  Unpacker unpacker(bytes);
  unpacker(mesh);
  if (!unpacker.atEnd()) throw std::runtime_error("more than a mesh");
  return mesh;
}

}  // namespace octet::gmsh_import
