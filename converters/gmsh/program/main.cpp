// SPDX-License-Identifier: Apache-2.0
// octetvdb-gmsh: what Gmsh and CGAL, both under the GPL, do for octetvdb, as a program of its own.
// It does one request and ends (messages.h). Whatever Gmsh does to a process, it does to this one.
#include <cstdio>
#include <cstring>
#include <new>

#include <octet/core/base/error.h>
#include <octet/core/base/system.h>
#include <octet/version.h>

#include "../messages.h"
#include "cgal_remesh.h"
#include "gmsh_reader.h"
#include "gmsh_volumes.h"

namespace octet::gmsh_import {
namespace {

constexpr const char* kAbout =
    "octetvdb-gmsh %s reads and makes meshes for octetvdb, which starts it.\n"
    "It uses Gmsh (GPL 2 or later) and CGAL (GPL 3 or later), and is under the GPL 3 or later.\n";

/// Requests come from octetvdb, which has what they hold in memory.
constexpr std::uint64_t kAnySize = UINT64_MAX;

class Parent {
 public:
  Parent() : out_(system::takeStandardOutput()) { send(MessageKind::Hello, ""); }

  void send(MessageKind kind, const std::string& content) {
    const std::string bytes = message(kind, content);
    if (std::fwrite(bytes.data(), 1, bytes.size(), out_) != bytes.size() ||
        std::fflush(out_) != 0) {
      throw IoError("", "nobody takes the answer");
    }
  }

  Message request() {
    MessageReader reader(kAnySize);
    std::string buffer(1 << 16, '\0');
    while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), stdin)) {
      reader.take(std::string_view(buffer.data(), n));
      if (auto request = reader.next()) return std::move(*request);
    }
    throw InputError("message", "is cut off");
  }

 private:
  std::FILE* out_;
};

std::string remeshed(const SurfaceRequest& request, Parent* parent) {
  RemeshOptions options;
  options.edgeLength = request.edgeLength;
  options.sharpAngle = request.sharpAngle;
  const Context context([&](const ProgressReport& report) {
    parent->send(MessageKind::Progress, pack(WorkDone{report.done, report.total}));
    return true;  // it ends this process to cancel
  });
  return pack(remeshByCgal(request.surface, options, context));
}

std::string answer(const Message& message, Parent* parent) {
  switch (message.kind) {
    case MessageKind::ReadMesh: {
      const auto request = unpack<MeshRequest>(message.content);
      system::limitMemory(request.memory);
      return pack(readWithGmsh(request.path));
    }
    case MessageKind::FillMesh: {
      const auto request = unpack<FillRequest>(message.content);
      system::limitMemory(request.memory);
      return pack(meshVolumes(request.shells));
    }
    case MessageKind::Remesh:
      return remeshed(unpack<SurfaceRequest>(message.content), parent);
    case MessageKind::Orient:
      return pack(orientedByCgal(unpack<SurfaceRequest>(message.content).surface));
    case MessageKind::Clean:
      return pack(withoutSliversByCgal(unpack<SurfaceRequest>(message.content).surface));
    default:
      throw InputError("message", "is no request");
  }
}

/// Answers one request. @return whether the answer is what was asked for
bool serve(Parent* parent) {
  WorkFailure failure;
  try {
    parent->send(MessageKind::Answer, answer(parent->request(), parent));
    return true;
  } catch (const InputError& e) {
    failure = {1, e.place(), e.reason()};
  } catch (const Error& e) {
    failure = {0, e.file(), e.reason()};
  } catch (const std::bad_alloc&) {
    failure = {0, "", "there is not enough memory"};
  }
  parent->send(MessageKind::Failure, pack(failure));
  return false;
}

}  // namespace
}  // namespace octet::gmsh_import

int main(int argc, char** argv) {
  using namespace octet;
  if (argc != 2 || std::strcmp(argv[1], "serve") != 0) {
    const bool asked = argc == 2 && std::strcmp(argv[1], "--version") == 0;
    std::fprintf(asked ? stdout : stderr, gmsh_import::kAbout, kVersion);
    return asked ? 0 : 2;
  }
  try {
    system::becomeChild();
    gmsh_import::Parent parent;
    const bool done = gmsh_import::serve(&parent);
    // No destructors, no exit handlers: Gmsh's model may be damaged.
    std::_Exit(done ? 0 : 1);
  } catch (const std::exception&) {
    return 1;  // nobody is there to be told
  }
}
