// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <openvdb/openvdb.h>

#include <octet/core/base/context.h>
#include <octet/core/raster/tile.h>

/// @file
/// For the sources of this folder alone: it brings OpenVDB's headers.

namespace octet {

/// Voxels of a leaf that something holds for: bit y * 8 + z of word x.
using LeafMask = std::array<std::uint64_t, 8>;
inline constexpr int kVoxelsOfBlock = 512;

/// `ijk` moved along an axis; beyond the range of indices it comes back at the other end.
inline openvdb::Coord moved(openvdb::Coord ijk, int axis, int by) {
  ijk[axis] = static_cast<std::int32_t>(static_cast<std::uint32_t>(ijk[axis]) +
                                        static_cast<std::uint32_t>(by));
  return ijk;
}

/// 8^3 voxels of a tree: a leaf, or a piece of a tile or of the background.
template <typename Tree>
struct Block {
  using Value = typename Tree::ValueType;

  const typename Tree::LeafNodeType* leaf = nullptr;
  const Value* values = nullptr;  ///< of the leaf
  Value value{};                  ///< of all voxels, where there is no leaf
  bool on = false;                ///< the same

  /// @param accessor  of the tree
  template <typename Accessor>
  static Block at(const Accessor& accessor, const openvdb::Coord& origin) {
    Block block;
    block.leaf = accessor.probeConstLeaf(origin);
    if (block.leaf) {
      block.values = block.leaf->buffer().data();
    } else {
      block.on = accessor.probeValue(origin, block.value);
    }
    return block;
  }

  const Value& operator[](int n) const { return leaf ? values[n] : value; }
  std::uint64_t word(int x) const {
    if (leaf) {
      return leaf->getValueMask().template getWord<openvdb::Index64>(static_cast<unsigned>(x));
    }
    return on ? ~std::uint64_t{0} : 0;
  }
};

/// A block and the six beside it.
template <typename Tree>
struct BlockStar {
  openvdb::Coord origin;
  Block<Tree> own;
  Block<Tree> sides[3][2];  ///< by axis; before, after
  bool known[3][2];         ///< false where a side is no part of what was baked

  /// The voxels whose neighbour along an axis is active.
  LeafMask besideActive(int axis, int side) const {
    constexpr std::uint64_t kFirstZ = 0x0101010101010101u;
    const Block<Tree>& other = sides[axis][side];
    LeafMask mask;
    for (int x = 0; x < 8; ++x) {
      const std::uint64_t here = own.word(x);
      if (axis == 0) {
        const int next = side ? x + 1 : x - 1;
        mask[x] = next < 0 || next > 7 ? other.word(next & 7) : own.word(next);
      } else if (axis == 1) {
        mask[x] = side ? here >> 8 | other.word(x) << 56 : here << 8 | other.word(x) >> 56;
      } else if (side) {
        mask[x] = (here >> 1 & ~(kFirstZ << 7)) | (other.word(x) & kFirstZ) << 7;
      } else {
        mask[x] = (here << 1 & ~kFirstZ) | (other.word(x) >> 7 & kFirstZ);
      }
    }
    return mask;
  }
  LeafMask active() const {
    LeafMask mask;
    for (int x = 0; x < 8; ++x) mask[x] = own.word(x);
    return mask;
  }
  /// The voxels whose next ones on all axes are active.
  LeafMask allBesideActive(int side) const {
    LeafMask mask = besideActive(0, side);
    for (const int axis : {1, 2}) {
      const LeafMask along = besideActive(axis, side);
      for (int x = 0; x < 8; ++x) mask[x] &= along[x];
    }
    return mask;
  }
};

/// Active voxels of one value in a cube, with one value beyond each of its facets.
template <typename Tree>
struct ConstantBox {
  using Value = typename Tree::ValueType;

  openvdb::Coord origin;
  int size;
  Value value;
  Value sides[3][2];
  bool on[3][2];     ///< are the voxels beyond a facet active?
  bool known[3][2];  ///< as in a BlockStar
};

/// Calls visit(number of a voxel) for the voxels of a mask, in order.
template <typename Visit>
void visitBits(const LeafMask& mask, const Visit& visit) {
  for (int x = 0; x < 8; ++x) {
    for (std::uint64_t rest = mask[x]; rest; rest &= rest - 1) {
      visit(x * 64 + __builtin_ctzll(rest));
    }
  }
}

/// @brief Goes through the active voxels of a tree by blocks with what is around them: leaves one
/// by one, and tiles as few cubes as their surroundings allow, in fixed lots, so that sums over
/// lots do not depend on threads.
template <typename Tree>
class BlockWalk {
 public:
  using Leaf = typename Tree::LeafNodeType;

  /// @param window  of tiles that the tree knows; others are unknown, not empty
  /// @param alike   hand out only such cubes whose surroundings have their own value
  BlockWalk(const Tree& tree, const IndexBox& window, bool alike, const Context& context)
      : tree_(tree), window_(window), alike_(alike), context_(context) {
    tree.getNodes(leaves_);
    auto it = tree.cbeginValueOn();
    it.setMaxDepth(Tree::ValueOnCIter::LEAF_DEPTH - 1);
    for (std::size_t n = 0; it; ++it) {
      if (++n % kTilesPerPoll == 0) context.poll();
      openvdb::CoordBBox box;
      it.getBoundingBox(box);
      tiles_.push_back({box.min(), box.dim()[0]});
    }
  }

  std::size_t lotCount() const { return (leaves_.size() + tiles_.size() + kLot - 1) / kLot; }

  /// Calls visitor->add(BlockStar) and visitor->add(ConstantBox) for what a lot holds.
  template <typename Visitor>
  void visit(std::size_t lot, Visitor* visitor) const {
    const openvdb::tree::ValueAccessor<const Tree> accessor(tree_);
    const std::size_t end = std::min((lot + 1) * kLot, leaves_.size() + tiles_.size());
    for (std::size_t k = lot * kLot; k < end; ++k) {
      if (k < leaves_.size()) {
        visitor->add(starAt(accessor, leaves_[k]->origin()));
      } else {
        visitCube(accessor, tiles_[k - leaves_.size()], visitor);
      }
    }
  }

 private:
  static constexpr std::size_t kLot = 16, kTilesPerPoll = 4096;
  static constexpr int kWidth = static_cast<int>(Leaf::DIM);

  struct Cube {
    openvdb::Coord origin;
    int size;
  };

  bool isKnown(const openvdb::Coord& ijk) const {
    return window_.contains({ijk[0] >> 3, ijk[1] >> 3, ijk[2] >> 3});
  }

  template <typename Accessor>
  BlockStar<Tree> starAt(const Accessor& accessor, const openvdb::Coord& origin) const {
    BlockStar<Tree> star;
    star.origin = origin;
    star.own = Block<Tree>::at(accessor, origin);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        const openvdb::Coord beside = moved(origin, axis, side ? kWidth : -kWidth);
        star.sides[axis][side] = Block<Tree>::at(accessor, beside);
        star.known[axis][side] = isKnown(beside);
      }
    }
    return star;
  }

  /// Width of the largest cube at a place that a tree says one thing about.
  template <typename Accessor>
  static int widthAt(const Accessor& accessor, const openvdb::Coord& ijk) {
    using Upper = typename Tree::RootNodeType::ChildNodeType;
    const int depth = accessor.getValueDepth(ijk);
    if (depth <= 0) return static_cast<int>(Upper::DIM);
    if (depth == 1) return static_cast<int>(Upper::ChildNodeType::DIM);
    return depth == 2 ? kWidth : 1;
  }

  template <typename Accessor, typename Visitor>
  void visitCube(const Accessor& accessor, const Cube& cube, Visitor* visitor) const {
    context_.poll();
    ConstantBox<Tree> box;
    box.origin = cube.origin;
    box.size = cube.size;
    accessor.probeValue(cube.origin, box.value);
    if (describe(accessor, &box)) return visitor->add(box);
    if (cube.size == kWidth) return visitor->add(starAt(accessor, cube.origin));
    const int half = cube.size / 2;
    for (int octant = 0; octant < 8; ++octant) {
      openvdb::Coord origin = cube.origin;
      for (int k = 0; k < 3; ++k) origin[k] += (octant >> (2 - k) & 1) * half;
      visitCube(accessor, {origin, half}, visitor);
    }
  }

  /// Looks beyond a box' facets; false when there is more than one thing beyond one.
  template <typename Accessor>
  bool describe(const Accessor& accessor, ConstantBox<Tree>* box) const {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        const openvdb::Coord beside = moved(box->origin, axis, side ? box->size : -box->size);
        if (widthAt(accessor, beside) < box->size) return false;
        auto& value = box->sides[axis][side];
        bool& on = box->on[axis][side];
        on = accessor.probeValue(beside, value);
        if (alike_ && !(on && value == box->value)) return false;
        box->known[axis][side] = isKnown(beside);
      }
    }
    return true;
  }

  const Tree& tree_;
  const IndexBox window_;
  const bool alike_;
  const Context& context_;
  std::vector<const Leaf*> leaves_;
  std::vector<Cube> tiles_;
};

}  // namespace octet
