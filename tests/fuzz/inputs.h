// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

/// @file
/// What a file that nobody vouches for goes through, as functions of its bytes. Anything but an
/// answer - a crash, an exception that is no InputError, a broken promise - ends the process.

namespace octet::fuzz {

/// Reads a control asset; one that is accepted is refined, sampled, written and read again.
/// @return whether it was accepted
bool tryAsset(const std::uint8_t* data, std::size_t size);

/// The formats of meshes, by extension.
inline constexpr const char* kMeshExtensions[] = {".msh", ".mesh", ".vtk"};

/// Checks a mesh as is done before Gmsh sees it.
bool tryMeshCheck(const char* extension, const std::uint8_t* data, std::size_t size);

/// Reads a mesh, Gmsh in its child process included.
bool tryMesh(const char* extension, const std::uint8_t* data, std::size_t size);

}  // namespace octet::fuzz
