// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <map>

#include <octet/core/base/error.h>
#include <octet/core/base/reported_loop.h>
#include <octet/core/base/suggestion.h>

#include "block_walk.h"
#include "certificate.h"
#include "measure_grid.h"
#include "vdb_input.h"

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
typename VectorGrid::Ptr merged(const std::array<openvdb::GridBase::Ptr, 3>& parts,
                                const Context& context) {
  using Tree = typename VectorGrid::TreeType;
  using Scalars = Block<typename ScalarGrid::TreeType>;
  using ScalarAccessor = typename ScalarGrid::ConstUnsafeAccessor;
  std::array<typename ScalarGrid::Ptr, 3> grids;
  for (int axis = 0; axis < 3; ++axis) {
    grids[axis] = openvdb::gridPtrCast<ScalarGrid>(parts[axis]);
  }
  auto result =
      VectorGrid::create({grids[0]->background(), grids[1]->background(), grids[2]->background()});
  result->setTransform(parts[0]->transformPtr());
  result->setGridClass(parts[0]->getGridClass());
  result->setSaveFloatAsHalf(parts[0]->saveFloatAsHalf());
  Tree& tree = result->tree();
  for (const auto& grid : grids) tree.topologyUnion(grid->tree());
  const auto at = [&](const openvdb::Coord& origin) {
    std::array<Scalars, 3> blocks;
    for (int axis = 0; axis < 3; ++axis) {
      blocks[axis] = Scalars::at(ScalarAccessor(grids[axis]->tree()), origin);
    }
    return blocks;
  };
  // Where one of the three has a leaf or a smaller tile, the union has one, too.
  auto tile = tree.beginValueOn();
  tile.setMaxDepth(Tree::ValueOnIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    context.poll();
    const auto blocks = at(tile.getCoord());
    tile.setValue({blocks[0].value, blocks[1].value, blocks[2].value});
  }
  std::vector<typename Tree::LeafNodeType*> leaves;
  tree.getNodes(leaves);
  parallelFor<std::size_t>(
      leaves.size(),
      [&](std::size_t k) {
        const auto blocks = at(leaves[k]->origin());
        auto* const values = leaves[k]->buffer().data();
        for (int n = 0; n < kVoxelsOfBlock; ++n) {
          values[n] = {blocks[0][n], blocks[1][n], blocks[2][n]};
        }
      },
      context, 16);
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
      result.push_back(verified(
          name, type, *merged<openvdb::Vec3SGrid, openvdb::FloatGrid>(parts, context), context));
    } else {
      result.push_back(verified(
          name, type, *merged<openvdb::Vec3DGrid, openvdb::DoubleGrid>(parts, context), context));
    }
  }
  return result;
}

}  // namespace

std::vector<VerifiedGrid> verifyVdb(const std::string& path, const std::string& name,
                                    const Context& context) {
  const VdbContents contents = readVdb(path, context);
  std::vector<std::string> names, types;
  for (const auto& grid : *contents.grids) {
    names.push_back(grid->getName());
    types.push_back(grid->getName() + " (" + grid->valueType() + ")");
  }
  std::vector<VerifiedGrid> result;
  try {
    result = measureAll(*contents.grids, name, context);
  } catch (const openvdb::Exception& e) {
    throw InputError(path, "", std::string("cannot be measured: ") + e.what());
  } catch (const InputError& e) {
    throw e.inFile(path);
  }
  if (result.empty()) {
    throw InputError(path, name,
                     "is no vector grid of this file; it has " +
                         (types.empty() ? "no grids" : listOf(types)) + didYouMean(name, names));
  }
  return result;
}

}  // namespace octet
