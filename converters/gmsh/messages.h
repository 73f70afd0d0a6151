// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "gmsh_mesh.h"
#include "remesh.h"

/// @file
/// What octetvdb and the program octetvdb-gmsh say to each other, over pipes on one machine.
///
/// The program greets, reads one request, answers with any number of Progress and one of the other
/// messages, and ends. A message is a mark, the version of all this, its kind and its size, then as
/// many bytes, all numbers as the machine has them: the mark also tells another byte order.

namespace octet::gmsh_import {

/// Is raised with every change of a message.
inline constexpr std::uint32_t kMessageVersion = 1;

enum class MessageKind : std::uint32_t {
  Hello,     ///< without content
  ReadMesh,  ///< MeshRequest, answered by GmshMesh
  FillMesh,  ///< FillRequest, answered by GmshMesh
  Remesh,    ///< SurfaceRequest, answered by RemeshedSurface
  Orient,    ///< SurfaceRequest, answered by TriangleSurface
  Clean,     ///< SurfaceRequest, answered by TriangleSurface: withoutSlivers
  Progress,  ///< WorkDone
  Answer,    ///< what the request asks for
  Failure    ///< WorkFailure
};

struct MeshRequest {
  std::string path;
  std::uint64_t memory = 0;  ///< bytes that the work may take
};

struct FillRequest {
  GmshShells shells;
  std::uint64_t memory = 0;  ///< bytes that the work may take
};

struct SurfaceRequest {
  TriangleSurface surface;
  double edgeLength = 0, sharpAngle = 0;  ///< of RemeshOptions; 0 where they are not asked for
};

struct WorkDone {
  std::uint64_t done = 0, total = 0;
};

/// An error of octet's family, as data.
struct WorkFailure {
  std::uint8_t ofInput = 0;  ///< an InputError, else an IoError
  std::string place, reason;
};

/// Returns the content of a message as bytes. For all the structs above, GmshMesh,
/// RemeshedSurface and TriangleSurface.
template <typename T>
std::string pack(const T& content);

/// Reads content back. @throws InputError unless the bytes are one such content, whole.
template <typename T>
T unpack(std::string_view bytes);

/// Returns a message as it is sent.
std::string message(MessageKind kind, std::string_view content);

struct Message {
  MessageKind kind = MessageKind::Hello;
  std::string content;
};

/// @brief Takes the bytes of messages in pieces of any size and gives the messages.
class MessageReader {
 public:
  /// @param mostBytes of one message's content
  explicit MessageReader(std::uint64_t mostBytes) : mostBytes_(mostBytes) {}

  void take(std::string_view bytes) { bytes_.append(bytes); }

  /// Returns the next message, when all of it is there.
  /// @throws InputError for what is no message, of another version, or larger than allowed
  std::optional<Message> next();

 private:
  std::uint64_t mostBytes_;
  std::string bytes_;
};

}  // namespace octet::gmsh_import
