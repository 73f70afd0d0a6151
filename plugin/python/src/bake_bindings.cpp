// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include <pybind11/stl.h>

#include <octet/converters/io/frames.h>
#include <octet/converters/vdb/merge_vdb.h>
#include <octet/converters/vdb/wording.h>
#include <octet/core/base/error.h>

#include "../../choices.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// A list as farms write it, or numbers.
using Frames = std::variant<std::monostate, std::string, std::vector<int>>;

std::optional<std::vector<int>> framesOf(const Frames& frames) {
  if (const auto* text = std::get_if<std::string>(&frames)) return parseFrames(*text);
  if (const auto* numbers = std::get_if<std::vector<int>>(&frames)) return *numbers;
  return std::nullopt;
}

BakeReport bakeAsset(const ControlAsset& asset, const std::string& path,
                     std::vector<std::string> forms, bool derivative, double voxelSize,
                     int resolution, std::optional<int> levels, const std::string& boundary,
                     const std::string& wallSurface, const std::string& grid,
                     const std::string& reconstruction, const std::string& target, bool half,
                     bool project, const std::string& method, const Frames& frames,
                     bool skipExisting, const std::optional<std::array<double, 6>>& region,
                     std::optional<std::pair<int, int>> shard, double zeta,
                     const py::object& progress) {
  BakeOptions options;
  options.forms = std::move(forms);
  options.derivative = derivative;
  options.voxelSize = voxelSize;
  options.resolution = resolution;
  options.levels = levels;
  options.boundary = boundaryChoice(boundary, true);
  options.wallSurface = wallSurfaceChoice(wallSurface);
  options.sampling = choose("grid", grid, samplingChoices());
  options.reconstruction = reconstructionChoice(reconstruction);
  options.target = target;
  options.half = half;
  options.project = project;
  options.method = choose("method", method, methodChoices());
  options.frames = framesOf(frames);
  options.skipExisting = skipExisting;
  if (region) {
    options.region.emplace();
    for (int k = 0; k < 3; ++k) {
      options.region->min[k] = (*region)[static_cast<std::size_t>(k)];
      options.region->max[k] = (*region)[static_cast<std::size_t>(k) + 3];
    }
  }
  if (shard) options.shard = Shard{shard->first, shard->second};
  options.zeta = zeta;
  const Context context = contextOf(progress);
  return withoutGil([&] { return bake(asset, options, path, context); });
}

py::dict metadataOf(const VdbGridInfo& info) {
  py::dict result;
  for (const VdbMetadata& entry : info.metadata) {
    result[py::str(entry.name)] =
        std::visit([](const auto& value) -> py::object { return py::cast(value); }, entry.value);
  }
  return result;
}

void bindGridInfo(py::module_& module) {
  py::class_<VdbGridInfo>(module, "GridInfo", py::module_local(),
                          "What was put into a grid, or found in one.")
      .def_readonly("name", &VdbGridInfo::name, "Name of the grid.")
      .def_readonly("type", &VdbGridInfo::type, "OpenVDB's value type, such as \"vec3s\".")
      .def_readonly("grid_class", &VdbGridInfo::gridClass, "OpenVDB's grid class.")
      .def_readonly("vector_type", &VdbGridInfo::vectorType,
                    "OpenVDB's vector type; empty for scalars.")
      .def_readonly("voxel_size", &VdbGridInfo::voxelSize, "Voxel size, world units.")
      .def_readonly("active_voxels", &VdbGridInfo::activeVoxels, "Number of active voxels.")
      .def_readonly("leaves", &VdbGridInfo::leaves, "Number of leaf nodes.")
      .def_readonly("min", &VdbGridInfo::min, "Least active value (length, for vectors).")
      .def_readonly("max", &VdbGridInfo::max, "Largest active value (length, for vectors).")
      .def_readonly("index_min", &VdbGridInfo::indexMin, "Lowest active index, three integers.")
      .def_readonly("index_max", &VdbGridInfo::indexMax, "Highest active index, three integers.")
      .def_readonly("half", &VdbGridInfo::half, "Stored as 16-bit floats?")
      .def_property_readonly("metadata", &metadataOf, "The grid's metadata as a dict.")
      .def_property_readonly(
          "method", [](const VdbGridInfo& g) { return methodName(g.method); },
          "How a vector grid was baked: \"circulations\", \"differences\" or "
          "\"samples\".")
      .def_readonly("sampled_voxels", &VdbGridInfo::sampledVoxels,
                    "Active voxels of a vector grid that hold samples whatever the method.")
      .def_property_readonly(
          "note", [](const VdbGridInfo& g) { return words(g.reasons); },
          "What there is to say about that.")
      .def_readonly("certificate", &VdbGridInfo::certificate,
                    "A Certificate, of a vector grid that was just baked; else None.")
      .def("__repr__", [](const VdbGridInfo& g) {
        return "<octetvdb.GridInfo \"" + g.name + "\" " + g.type + ", " +
               std::to_string(g.activeVoxels) + " active voxels>";
      });
}

void bindReport(py::module_& module) {
  py::class_<BakedFile>(module, "BakedFile", py::module_local(), "One file of a bake.")
      .def_readonly("path", &BakedFile::path, "Where it is.")
      .def_readonly("frame", &BakedFile::frame, "Its frame number; None when not animated.")
      .def_readonly("grids", &BakedFile::grids,
                    "A GridInfo for each grid; none of a file that was skipped.")
      .def_readonly("skipped", &BakedFile::skipped,
                    "Was it there already, complete and from the same asset and options?");
  py::class_<BakeReport>(module, "BakeReport", py::module_local(), "What a bake did.")
      .def_readonly("levels", &BakeReport::levels, "Number of subdivisions.")
      .def_readonly("cells", &BakeReport::cells, "Number of cells at the finest level.")
      .def_readonly("voxel_size", &BakeReport::voxelSize, "Voxel size, world units.")
      .def_readonly("mean_edge", &BakeReport::meanEdge, "Mean fine edge, world units.")
      .def_readonly("note", &BakeReport::note, "What the target's importer has to do.")
      .def_readonly("part", &BakeReport::part, "\"shard 2 of 7\" or \"region\"; empty: the whole.")
      .def_readonly("files", &BakeReport::files, "A BakedFile for each file.");
}

}  // namespace

void bindBake(py::module_& module) {
  module.attr("targets") = py::tuple(py::cast(namesOf(targetChoices())));
  bindGridInfo(module);
  bindReport(module);
  module.def("bake", &bakeAsset, py::arg("asset"), py::arg("path"), py::kw_only(),
             py::arg("forms") = std::vector<std::string>(), py::arg("derivative") = false,
             py::arg("voxel_size") = 0.0, py::arg("resolution") = 0, py::arg("levels") = py::none(),
             py::arg("boundary") = "auto", py::arg("wall_surface") = "smooth",
             py::arg("grid") = "collocated", py::arg("reconstruction") = "limit",
             py::arg("target") = "openvdb", py::arg("half") = false, py::arg("project") = false,
             py::arg("method") = "auto", py::arg("frames") = py::none(),
             py::arg("skip_existing") = false, py::arg("region") = py::none(),
             py::arg("shard") = py::none(), py::arg("zeta") = kDefaultZeta,
             py::arg("progress") = py::none(),
             R"(Bakes an asset's forms into OpenVDB grids, one per form.

path:           the .vdb to write; of an animated asset "name.####.vdb", where "@@@@", "%04d", "$F4"
                and "<frame>" mean the frame, too; without any ".####" goes before the ending
forms:          names of forms; all by default
derivative:     bake the forms' exterior derivatives: the velocity of a vector potential
voxel_size:     world units; or
resolution:     voxels along the domain's longest side
levels:         subdivisions; None: until the mean edge is at most 2 voxels
boundary:       "auto", "walls" or "open"; for comparison, the thesis' methods: "simple",
                "projection" or "expansion"
wall_surface:   "smooth", or "loop": exactly Loop's surface
grid:           "collocated" or "staggered"
reconstruction: "limit" or "whitney"
target:         the program that reads the grids: one of octetvdb.targets
half:           store 16-bit floats
project:        replace forms that are not closed by the nearest closed ones
method:         "auto", "conservative" (vectors without discrete divergence or curl, or an error)
                or "samples"
frames:         of an animated asset: a list such as "1-10x2" or "1,3,7-9", or numbers; all by
                default
skip_existing:  leave files that are complete and from the same asset and options
region:         bake only the leaves that this box meets, world units of the asset: (x0, y0, z0,
                x1, y1, z1)
shard:          (i, n): bake only part i of n, of about equal work, from 1 to n; merge() joins them
zeta:           free weight of the octahedron's linear rule
progress:       called as progress(stage, done, total, unit); returning False raises Cancelled

Files appear complete or not at all. Releases the GIL. Raises InputError, IoError, MemoryError,
Cancelled.)");
  module.def(
      "merge",
      [](const std::vector<std::string>& parts, const std::string& path,
         const py::object& progress) {
        const Context context = contextOf(progress);
        return withoutGil([&] { return mergeVdb(parts, path, context); });
      },
      py::arg("parts"), py::arg("path"), py::kw_only(), py::arg("progress") = py::none(),
      R"(Joins the shards of a bake to the .vdb that it would have been without them; a BakedFile.

parts: the .vdb of each shard, in any order; of an animation, those of one frame
Releases the GIL. Raises InputError, IoError, MemoryError, Cancelled.)");
  module.def(
      "read_grid_info",
      [](const std::string& path) {
        const Context context = contextOf();
        return withoutGil([&] { return readVdbInfo(path, nullptr, context); });
      },
      py::arg("path"), "What a .vdb holds, a GridInfo for each grid. Raises InputError.");
}

}  // namespace octet::python
