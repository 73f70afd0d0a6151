// SPDX-License-Identifier: Apache-2.0
#include "move_damping.h"

#include "../base/parallel.h"
#include "../topology/control_mesh.h"

namespace octet {
namespace {

/// A move is halved so many times before it is dropped.
constexpr int kHalvings = 3;

/// The moves of a level, and the share of each that is made.
class DampedMoves {
 public:
  DampedMoves(const Complex& fine, const Array<Vec3>& before, const LocalRows& moves,
              const Array<Vec3>& after)
      : f_(fine), places_(static_cast<std::size_t>(fine.vertexCount()), kNone), positions_(after) {
    const Complex& coarse = *fine.coarse;
    for (const Index v : moves.fine()) {
      places_[v] = static_cast<Index>(moves_.size());
      Vec3 move = Vec3::Zero();
      moves.row(v, 1, [&](Index e, double weight) {
        move -= weight * (before[coarse.edges[e][1]] - before[coarse.edges[e][0]]);
      });
      vertices_.push_back(v);
      moves_.push_back(move);
      unmoved_.push_back(after[v] - move);
    }
    shares_.assign(moves_.size(), 1.0);
    for (Index cell = 0; cell < f_.cellCount(); ++cell) {
      for (int k = 0; k < f_.cellVertexCount(cell); ++k) {
        if (places_[f_.cellVertex(cell, k)] == kNone) continue;
        cells_.push_back(cell);
        break;
      }
    }
  }

  /// Halves what turns cells over, or at last drops it. @return is there any?
  bool damp(bool drop) {
    Array<char> touched;
    touched.assign(moves_.size(), 0);
    bool any = false;
    for (const Index cell : cells_) {
      if (volume(cell) > 0) continue;
      std::array<double, 6> shares;
      const int count = f_.cellVertexCount(cell);
      for (int k = 0; k < count; ++k) {
        const Index at = places_[f_.cellVertex(cell, k)];
        if (at == kNone) continue;
        shares[k] = shares_[at];
        positions_[vertices_[at]] = unmoved_[at];
      }
      const bool moveTurnsIt = volume(cell) > 0;
      for (int k = 0; k < count; ++k) {
        const Index at = places_[f_.cellVertex(cell, k)];
        if (at == kNone) continue;
        place(at);
        if (moveTurnsIt && shares[k] > 0) touched[at] = 1, any = true;
      }
    }
    for (std::size_t at = 0; at < touched.size(); ++at) {
      if (!touched[at]) continue;
      shares_[at] = drop ? 0 : shares_[at] / 2;
      place(static_cast<Index>(at));
    }
    return any;
  }

  const std::vector<double>& shares() const { return shares_; }
  const Array<Vec3>& positions() const { return positions_; }

 private:
  double volume(Index cell) const { return f_.cellSigns[cell] * cellVolume6(f_, positions_, cell); }
  void place(Index at) { positions_[vertices_[at]] = unmoved_[at] + shares_[at] * moves_[at]; }

  const Complex& f_;
  Array<Index> places_;  // per vertex: in the lists below
  Array<Vec3> positions_;
  std::vector<Index> vertices_, cells_;
  std::vector<Vec3> moves_, unmoved_;
  std::vector<double> shares_;
};

}  // namespace

void dampMoves(const Complex& fine, const Array<Vec3>& before, LocalRows* moves,
               Array<Vec3>* after) {
  if (moves->empty()) return;
  DampedMoves damped(fine, before, *moves, *after);
  bool any = false;
  for (int k = 0; k <= kHalvings && damped.damp(k == kHalvings); ++k) any = true;
  if (!any) return;
  moves->scale(damped.shares());
  *after = damped.positions();
}

}  // namespace octet
