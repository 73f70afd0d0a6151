// SPDX-License-Identifier: Apache-2.0
#include "star_fluxes.h"

#include <algorithm>
#include <map>
#include <string>

#include "../base/sort_unique.h"
#include "star_flux_tables.h"

namespace octet {
namespace {

/// A name of the tables, taken apart: a letter and a number.
struct Name {
  char kind;
  int index;
};

std::vector<Name> namesIn(const char* text) {
  std::vector<Name> names;
  for (const char* c = text; *c; ++c) {
    if (*c >= 'a' && *c <= 'z') {
      names.push_back({*c, 0});
    } else if (*c >= '0' && *c <= '9') {
      names.back().index = names.back().index * 10 + (*c - '0');
    }
  }
  return names;
}

/// Is the order of the labels an even permutation of their ascending order?
template <std::size_t N>
bool even(const std::array<std::uint8_t, N>& labels) {
  bool result = true;
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = i + 1; j < N; ++j) result ^= labels[i] > labels[j];
  }
  return result;
}

/// @brief Collects images of rows; an image that comes twice counts once.
class PatternBuilder {
 public:
  void beginRow() { seen_.clear(); }

  void add(std::array<std::uint8_t, 2> edge, std::array<std::uint8_t, 3> facet, double weight) {
    // Both are kept in ascending order, and the orders' signs go to the weight.
    const double sign = even(edge) == even(facet) ? 1 : -1;
    std::sort(edge.begin(), edge.end());
    std::sort(facet.begin(), facet.end());
    if (seen_.emplace(std::pair{edge, facet}, sign).second) rows_[edge][facet] += sign * weight;
  }

  FluxPattern take() const {
    FluxPattern pattern;
    for (const auto& [edge, row] : rows_) {
      for (const auto& [facet, weight] : row) pattern.facets.push_back(facet);
    }
    sortUnique(&pattern.facets);
    for (const auto& [edge, row] : rows_) {
      for (const auto& [facet, weight] : row) {
        const auto number = std::lower_bound(pattern.facets.begin(), pattern.facets.end(), facet) -
                            pattern.facets.begin();
        pattern.terms.push_back({static_cast<std::uint16_t>(pattern.edges.size()),
                                 static_cast<std::uint16_t>(number), weight});
      }
      pattern.edges.push_back(edge);
    }
    return pattern;
  }

 private:
  std::map<std::pair<std::array<std::uint8_t, 2>, std::array<std::uint8_t, 3>>, double> seen_;
  std::map<std::array<std::uint8_t, 2>, std::map<std::array<std::uint8_t, 3>, double>> rows_;
};

/// Adds all images of a row; `image(name)` is the label of a name under one symmetry.
template <typename Image>
void addImage(const char* edge, const char* facet, double weight, const Image& image,
              PatternBuilder* builder) {
  std::array<std::uint8_t, 2> e;
  std::array<std::uint8_t, 3> f;
  const std::vector<Name> ofEdge = namesIn(edge), ofFacet = namesIn(facet);
  for (std::size_t k = 0; k < 2; ++k) e[k] = static_cast<std::uint8_t>(image(ofEdge[k]));
  for (std::size_t k = 0; k < 3; ++k) f[k] = static_cast<std::uint8_t>(image(ofFacet[k]));
  builder->add(e, f, weight);
}

FluxPattern buildLine(int n) {
  PatternBuilder builder;
  for (const LineFluxRow& row : kLineFluxRows) {
    builder.beginRow();
    const double weight = row.millionths[static_cast<std::size_t>(n - kFirstLineTable)] * 1e-6;
    for (int turn = 0; turn < n; ++turn) {
      for (const bool back : {false, true}) {
        for (const bool down : {false, true}) {
          const auto image = [&](Name name) {
            if (name.kind == 'm') return 0;
            if (name.kind == 'a' || name.kind == 'b') return (name.kind == 'b') != down ? 2 : 1;
            const int j = back ? -name.index - (name.kind == 'o' ? 1 : 0) : name.index;
            const int index = ((turn + j) % n + n) % n;
            if (name.kind == 'o') return 3 + 2 * n + index;
            return ((name.kind == 's') != down ? 3 + n : 3) + index;
          };
          addImage(row.edge, row.facet, weight, image, &builder);
        }
      }
    }
  }
  return builder.take();
}

FluxPattern buildTwin() {
  PatternBuilder builder;
  for (const TwinFluxRow& row : kTwinFluxRows) {
    builder.beginRow();
    for (int turn = 0; turn < 3; ++turn) {
      for (const bool mirror : {false, true}) {
        for (const bool flip : {false, true}) {
          const auto image = [&](Name name) {
            if (name.kind == 'm') return 0;
            int j = name.index;
            if (name.kind == 'r') {
              j = ((mirror ? 1 - j : j) + 2 * turn + 6) % 6;
              return 1 + j;
            }
            const bool beyond = name.kind == 'p' || name.kind == 'q';
            j = ((mirror ? (beyond ? -j - 1 : -j) : j) + turn + 6) % 3;
            const bool below = (name.kind == 'w' || name.kind == 'q') != flip;
            return (beyond ? (below ? 16 : 13) : (below ? 10 : 7)) + j;
          };
          addImage(row.edge, row.facet, row.millionths * 1e-6, image, &builder);
        }
      }
    }
  }
  return builder.take();
}

}  // namespace

const FluxPattern& lineFluxes(int n) {
  static const std::vector<FluxPattern> patterns = [] {
    std::vector<FluxPattern> all(1);  // the first is empty
    for (int k = kFirstLineTable; k <= kLastLineTable; ++k) all.push_back(buildLine(k));
    return all;
  }();
  const bool known = n >= kFirstLineTable && n <= kLastLineTable;
  return patterns[known ? static_cast<std::size_t>(n - kFirstLineTable + 1) : 0];
}

const FluxPattern& twinFluxes() {
  static const FluxPattern pattern = buildTwin();
  return pattern;
}

}  // namespace octet
