// SPDX-License-Identifier: Apache-2.0
#include "read_surface.h"

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <octet/core/base/error.h>

#include "vdb_surface.h"

namespace octet {
namespace {

std::string extensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::string readBytes(const std::string& path) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status)) throw InputError(path, "", "is a folder");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.empty()) throw InputError(path, "", "is empty");
  return bytes;
}

/// The size of a binary .stl follows from its number of triangles; assimp overlooks some cuts. A
/// text file begins with "solid" and goes on with text.
void checkStl(const std::string& bytes, const std::string& path) {
  constexpr std::size_t kHeader = 84, kFacet = 50;
  const std::string start = bytes.substr(0, std::min<std::size_t>(bytes.size(), 512));
  const bool text = start.rfind("solid", 0) == 0 &&
                    std::all_of(start.begin(), start.end(),
                                [](unsigned char c) { return c >= ' ' || std::isspace(c); });
  if (text) {
    if (bytes.find("endsolid") == std::string::npos) {
      throw InputError(path, "", "is cut off: there is no \"endsolid\"");
    }
    return;
  }
  if (bytes.size() < kHeader) throw InputError(path, "", "is no .stl file, or cut off");
  std::uint32_t count = 0;
  for (int b = 3; b >= 0; --b) count = count << 8 | static_cast<unsigned char>(bytes[80 + b]);
  if (bytes.size() < kHeader + kFacet * static_cast<std::size_t>(count)) {
    throw InputError(path, "",
                     "is cut off: it says that it has " + std::to_string(count) +
                         " triangles and has " + std::to_string((bytes.size() - kHeader) / kFacet));
  }
}

/// All triangles of a file's meshes; larger polygons have been split, points and lines are skipped.
TriangleSurface collect(const aiScene& scene) {
  TriangleSurface surface;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    const Index first = static_cast<Index>(surface.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      surface.vertices.emplace_back(p.x, p.y, p.z);
      if (!surface.vertices.back().allFinite()) {
        throw InputError("vertex " + std::to_string(v), "coordinate is not a finite number");
      }
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      std::array<Index, 3> triangle;
      for (int k = 0; k < 3; ++k) triangle[k] = first + static_cast<Index>(face.mIndices[k]);
      surface.triangles.push_back(triangle);
    }
  }
  return surface;
}

/// From memory, so that assimp opens no other file that a .obj names.
TriangleSurface readWithAssimp(const std::string& path, const std::string& extension) {
  const std::string bytes = readBytes(path);
  if (extension == ".stl") checkStl(bytes, path);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(),
                                                     aiProcess_Triangulate, extension.c_str() + 1);
  if (!scene) {
    throw InputError(path, "", std::string("cannot be read: ") + importer.GetErrorString());
  }
  return welded(collect(*scene));
}

}  // namespace

bool isSurfaceFile(const std::string& path) {
  const std::string extension = extensionOf(path);
  return extension == ".obj" || extension == ".stl" || extension == ".vdb";
}

TriangleSurface readSurface(const std::string& path, const SurfaceReadOptions& options) {
  const std::string extension = extensionOf(path);
  if (!isSurfaceFile(path)) {
    throw InputError(path, "", "is no surface: its name ends in none of .obj, .stl and .vdb");
  }
  try {
    TriangleSurface surface =
        extension == ".vdb" ? readVdbSurface(path, options) : readWithAssimp(path, extension);
    if (surface.triangles.empty()) throw InputError("", "has no triangles");
    return surface;
  } catch (const InputError& e) {
    if (!e.file().empty()) throw;
    throw e.inFile(path);
  }
}

}  // namespace octet
