// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include <octet/core/fit/guides.h>
#include <octet/core/topology/control_mesh.h>

namespace octet {

/// @brief Reads guides for a fit (core/fit/guides.h), by the file's extension:
///
/// - `.obj`: polylines, as `l` elements over `v` vertices; the curve's name is the latest `o` or
///   `g`. Their speed is `speed`. Other elements are ignored.
/// - `.csv`: a header line, then a point per line; columns x, y, z and curve (points of one name
///   that follow each other are a polyline), optionally speed and weight. Lines whose curve is
///   empty are point vectors and need columns vx, vy, vz; name is optional. Separated by commas,
///   semicolons or tabs; # starts a comment.
/// - `.json`: {"curves": [{"name", "points": [[x,y,z],..], "speed" or "speeds", "weight"}],
///   "vectors": [{"name", "point", "value", "weight"}]}.
///
/// World units of the cage, and per second.
/// @param speed  of curves that state none
/// @throws InputError with file, line (in JSON also the place, "curves[0].points[2]") and reason
Guides readGuides(const std::string& path, double speed = 1);

/// @brief Reads given fluxes through boundary facets: {"simplices": [[a,b,c],..], "values": [..]},
/// vertices of the control mesh; the flux runs along the listed order, as in a control asset.
/// @return outward flux by facet
/// @throws InputError
std::map<Index, double> readGivenFlux(const std::string& path, const ControlMesh& mesh);

}  // namespace octet
