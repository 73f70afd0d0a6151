// SPDX-License-Identifier: Apache-2.0
#include "messages.h"

#include <cstring>
#include <type_traits>

#include <octet/core/base/error.h>

namespace octet::gmsh_import {
namespace {

/// "OGMS" where the least byte comes first.
constexpr std::uint32_t kMark = 0x534d474f;
constexpr std::size_t kHeadBytes = 3 * sizeof(std::uint32_t) + sizeof(std::uint64_t);

[[noreturn]] void refuse(const std::string& why) { throw InputError("message", why); }

/// Values that are sent as they lie in memory. (Eigen's vectors are, but do not say so.)
template <typename T>
constexpr bool kPlain =
    std::is_arithmetic_v<T> || std::is_same_v<T, Vec3> || std::is_same_v<T, std::array<Index, 2>> ||
    std::is_same_v<T, std::array<Index, 3>>;
static_assert(sizeof(Vec3) == 3 * sizeof(double));

/// Appends values; the fields of a struct in the order in which `fields` visits them.
class Packer {
 public:
  template <typename T>
  void operator()(T& value) {
    if constexpr (kPlain<T>) {
      plain(&value, 1);
    } else {
      fields(*this, value);
    }
  }
  template <typename List>
  void list(List& values) {
    std::uint64_t n = values.size();
    (*this)(n);
    if constexpr (kPlain<typename List::value_type>) {
      plain(values.data(), values.size());
    } else {
      for (auto& value : values) (*this)(value);
    }
  }
  std::string bytes;

 private:
  template <typename T>
  void plain(const T* values, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
};

class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  void operator()(T& value) {
    if constexpr (kPlain<T>) {
      plain(&value, 1);
    } else {
      fields(*this, value);
    }
  }
  template <typename List>
  void list(List& values) {
    using Value = typename List::value_type;
    std::uint64_t n = 0;
    (*this)(n);
    // An entry that is a struct takes a byte at least.
    if (n > bytes_.size() / (kPlain<Value> ? sizeof(Value) : 1)) refuse("is cut off");
    values.resize(n);
    if constexpr (kPlain<Value>) {
      plain(values.data(), values.size());
    } else {
      for (auto& value : values) (*this)(value);
    }
  }
  bool atEnd() const { return bytes_.empty(); }

 private:
  template <typename T>
  void plain(T* values, std::size_t count) {
    const std::size_t size = count * sizeof(T);
    if (bytes_.size() < size) refuse("is cut off");
    if (size > 0) std::memcpy(static_cast<void*>(values), bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
};

template <typename Archive>
void fields(Archive& archive, std::string& text) {
  archive.list(text);
}

template <typename Archive, typename T, typename Allocator>
void fields(Archive& archive, std::vector<T, Allocator>& values) {
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
  archive(m.messages), archive(m.nodeTags), archive(m.coordinates);
  archive(m.blocks), archive(m.views), archive(m.groups);
}

template <typename Archive>
void fields(Archive& archive, GmshShells& s) {
  archive(s.coordinates), archive(s.shells), archive(s.volumes), archive(s.edgeLength);
}

template <typename Archive>
void fields(Archive& archive, TriangleSurface& s) {
  archive(s.vertices), archive(s.triangles);
}

template <typename Archive>
void fields(Archive& archive, RemeshedSurface& s) {
  archive(s.surface), archive(s.creases), archive(s.corners);
}

template <typename Archive>
void fields(Archive& archive, MeshRequest& r) {
  archive(r.path), archive(r.memory);
}

template <typename Archive>
void fields(Archive& archive, FillRequest& r) {
  archive(r.shells), archive(r.memory);
}

template <typename Archive>
void fields(Archive& archive, SurfaceRequest& r) {
  archive(r.surface), archive(r.edgeLength), archive(r.sharpAngle);
}

template <typename Archive>
void fields(Archive& archive, WorkDone& w) {
  archive(w.done), archive(w.total);
}

template <typename Archive>
void fields(Archive& archive, WorkFailure& f) {
  archive(f.ofInput), archive(f.place), archive(f.reason);
}

}  // namespace

template <typename T>
std::string pack(const T& content) {
  Packer packer;
  packer(const_cast<T&>(content));  // one list of fields serves both ways; this one only reads
  return std::move(packer.bytes);
}

template <typename T>
T unpack(std::string_view bytes) {
  T content;
  Unpacker unpacker(bytes);
  unpacker(content);
  if (!unpacker.atEnd()) refuse("goes on after its end");
  return content;
}

#define OCTET_CONTENT(Type)               \
  template std::string pack(const Type&); \
  template Type unpack(std::string_view);
OCTET_CONTENT(GmshMesh)
OCTET_CONTENT(TriangleSurface)
OCTET_CONTENT(RemeshedSurface)
OCTET_CONTENT(MeshRequest)
OCTET_CONTENT(FillRequest)
OCTET_CONTENT(SurfaceRequest)
OCTET_CONTENT(WorkDone)
OCTET_CONTENT(WorkFailure)
#undef OCTET_CONTENT

std::string message(MessageKind kind, std::string_view content) {
  Packer packer;
  packer.bytes.reserve(kHeadBytes + content.size());
  std::uint32_t mark = kMark, version = kMessageVersion, number = static_cast<std::uint32_t>(kind);
  std::uint64_t size = content.size();
  packer(mark), packer(version), packer(number), packer(size);
  return std::move(packer.bytes.append(content));
}

std::optional<Message> MessageReader::next() {
  if (bytes_.size() < kHeadBytes) return std::nullopt;
  std::uint32_t mark = 0, version = 0, number = 0;
  std::uint64_t size = 0;
  Unpacker head(bytes_);
  head(mark), head(version), head(number), head(size);
  if (mark != kMark) refuse("is none");
  if (version != kMessageVersion) {
    refuse("is of version " + std::to_string(version) + " instead of " +
           std::to_string(kMessageVersion));
  }
  if (number > static_cast<std::uint32_t>(MessageKind::Failure)) refuse("is of an unknown kind");
  if (size > mostBytes_) refuse("is too large");
  if (bytes_.size() - kHeadBytes < size) return std::nullopt;
  Message result{static_cast<MessageKind>(number), bytes_.substr(kHeadBytes, size)};
  bytes_.erase(0, kHeadBytes + size);
  return result;
}

}  // namespace octet::gmsh_import
