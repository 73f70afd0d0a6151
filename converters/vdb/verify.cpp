// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>

#include "certificate.h"
#include "measure_grid.h"

namespace octet {
namespace {

template <typename Grid>
VerifiedGrid verified(const std::string& name, const std::string& type, const Grid& grid,
                      const Context& context) {
  return {name, type, openvdb::GridBase::gridClassToString(grid.getGridClass()),
          grid.voxelSize()[0], measureGrid(grid, context)};
}

/// Grids of one number per voxel that end in x, y, z (or 0, 1, 2): their common beginning.
bool splitComponent(const std::string& name, std::string* common, int* axis) {
  if (name.size() < 2) return false;
  static const std::string ends[3] = {"xX0", "yY1", "zZ2"};
  for (*axis = 0; *axis < 3; ++*axis) {
    if (ends[*axis].find(name.back()) == std::string::npos) continue;
    *common = name.substr(0, name.size() - 1);
    while (common->size() > 1 && std::strchr("._- ", common->back())) common->pop_back();
    return true;
  }
  return false;
}

/// One vector grid from three grids of numbers; active where any of them is.
template <typename VectorGrid, typename ScalarGrid>
typename VectorGrid::Ptr merged(const std::array<openvdb::GridBase::Ptr, 3>& parts) {
  auto result = VectorGrid::create();
  result->setTransform(parts[0]->transformPtr());
  result->setGridClass(parts[0]->getGridClass());
  result->setSaveFloatAsHalf(parts[0]->saveFloatAsHalf());
  std::array<typename ScalarGrid::Ptr, 3> grids;
  for (int axis = 0; axis < 3; ++axis) {
    grids[axis] = openvdb::gridPtrCast<ScalarGrid>(parts[axis])->deepCopy();
    grids[axis]->tree().voxelizeActiveTiles();
    result->tree().topologyUnion(grids[axis]->tree());
  }
  auto in0 = grids[0]->getConstAccessor(), in1 = grids[1]->getConstAccessor(),
       in2 = grids[2]->getConstAccessor();
  for (auto it = result->beginValueOn(); it; ++it) {
    const openvdb::Coord ijk = it.getCoord();
    it.setValue({in0.getValue(ijk), in1.getValue(ijk), in2.getValue(ijk)});
  }
  return result;
}

using Triple = std::array<openvdb::GridBase::Ptr, 3>;

/// Triples of scalar grids on the same voxels.
std::map<std::string, Triple> findTriples(const openvdb::GridPtrVec& grids) {
  std::map<std::string, Triple> triples, complete;
  for (const auto& grid : grids) {
    std::string common;
    int axis = 0;
    const bool scalar = grid->isType<openvdb::FloatGrid>() || grid->isType<openvdb::DoubleGrid>();
    if (scalar && splitComponent(grid->getName(), &common, &axis)) triples[common][axis] = grid;
  }
  for (const auto& [name, parts] : triples) {
    if (!parts[0] || !parts[1] || !parts[2]) continue;
    const bool alike = parts[0]->type() == parts[1]->type() &&
                       parts[0]->type() == parts[2]->type() &&
                       parts[0]->transform() == parts[1]->transform() &&
                       parts[0]->transform() == parts[2]->transform();
    if (alike) complete[name] = parts;
  }
  return complete;
}

std::vector<VerifiedGrid> measureAll(const openvdb::GridPtrVec& grids, const std::string& wanted,
                                     const Context& context) {
  std::vector<VerifiedGrid> result;
  const auto chosen = [&](const std::string& name) { return wanted.empty() || name == wanted; };
  for (const auto& grid : grids) {
    if (!chosen(grid->getName())) continue;
    if (const auto floats = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) {
      result.push_back(verified(grid->getName(), grid->valueType(), *floats, context));
    } else if (const auto doubles = openvdb::gridPtrCast<openvdb::Vec3DGrid>(grid)) {
      result.push_back(verified(grid->getName(), grid->valueType(), *doubles, context));
    }
  }
  for (const auto& [name, parts] : findTriples(grids)) {
    if (!chosen(name)) continue;
    const std::string type = "3 x " + parts[0]->valueType();
    if (parts[0]->isType<openvdb::FloatGrid>()) {
      result.push_back(
          verified(name, type, *merged<openvdb::Vec3SGrid, openvdb::FloatGrid>(parts), context));
    } else {
      result.push_back(
          verified(name, type, *merged<openvdb::Vec3DGrid, openvdb::DoubleGrid>(parts), context));
    }
  }
  return result;
}

}  // namespace

std::vector<VerifiedGrid> verifyVdb(const std::string& path, const std::string& name,
                                    const Context& context) {
  openvdb::initialize();
  if (!std::ifstream(path)) {
    throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  std::vector<VerifiedGrid> result;
  std::vector<std::string> names, types;
  try {
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    const openvdb::GridPtrVecPtr grids = file.getGrids();
    for (const auto& grid : *grids) {
      names.push_back(grid->getName());
      types.push_back(grid->getName() + " (" + grid->valueType() + ")");
    }
    result = measureAll(*grids, name, context);
    file.close();
  } catch (const openvdb::Exception& e) {
    throw InputError(path, "", std::string("is not a readable .vdb: ") + e.what());
  } catch (const std::bad_alloc&) {
    throw InputError(path, "", "is not a readable .vdb: it claims more memory than there is");
  }
  if (result.empty()) {
    throw InputError(path, name,
                     "is no vector grid of this file; it has " +
                         (types.empty() ? "no grids" : listOf(types)) + didYouMean(name, names));
  }
  return result;
}

}  // namespace octet
