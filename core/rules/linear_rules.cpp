// SPDX-License-Identifier: Apache-2.0
#include "linear_rules.h"

namespace octet {

LinearRules::LinearRules(double zeta) : octSpoke{}, octFacet{}, tetFacet{} {
  const double p = parallelWeight(zeta);
  const double q = (1.0 / 3 - p) / 2;
  const double r = q - 1.0 / 12;
  const auto& between = kCellTables<Octahedron>.edgeBetween;
  const auto& opposite = Octahedron::opposite;

  for (int k = 0; k < 12; ++k) {
    const int x = Octahedron::edges[k][0], y = Octahedron::edges[k][1];
    const int X = opposite[x], Y = opposite[y];
    const auto add = [&](int from, int to, double w) {
      octSpoke[k][between[from][to]] += from < to ? w : -w;
    };
    add(Y, x, p);
    add(X, y, p);
    for (int z = 0; z < 6; ++z) {
      if (z == x || z == y || z == X || z == Y) continue;
      add(z, x, q);
      add(z, y, q);
      add(X, z, r);
      add(Y, z, r);
    }
  }

  int n = 0;
  for (int x = 0; x < 6; ++x) {
    for (int first = 0; first < 6; ++first) {
      for (int second = first + 1; second < 6; ++second) {
        if (between[x][first] < 0 || between[x][second] < 0 || between[first][second] < 0) continue;
        // The rule is stated for (x,y,z) outward; the other way round the sign changes.
        const int sign = facetAndSign<Octahedron>(x, first, second)[1];
        const int y = sign > 0 ? first : second, z = sign > 0 ? second : first;
        const int X = opposite[x], Y = opposite[y], Z = opposite[z];
        const auto add = [&](int a, int b, int c, double w) {
          octFacet[n][facetAndSign<Octahedron>(a, b, c)[0]] += sign * w;
        };
        add(x, y, z, -7.0 / 96);
        add(x, y, Z, 17.0 / 96 - q);
        add(x, Y, z, 17.0 / 96 - q);
        add(X, y, z, -31.0 / 96 + 2 * q);
        add(x, Y, Z, -15.0 / 96 + 2 * q);
        add(X, y, Z, 9.0 / 96 - q);
        add(X, Y, z, 9.0 / 96 - q);
        add(X, Y, Z, 1.0 / 96);
        ++n;
      }
    }
  }

  for (int a = 0; a < 4; ++a) {
    int other[3], m = 0;
    for (int j = 0; j < 4; ++j) {
      if (j != a) other[m++] = j;
    }
    const auto [x, y, z] = other;
    const int triples[4][3] = {{x, y, z}, {a, x, y}, {a, y, z}, {a, z, x}};
    for (const auto& t : triples) {
      const auto [facet, sign] = facetAndSign<Tetrahedron>(t[0], t[1], t[2]);
      tetFacet[a][facet] += sign / 8.0;
    }
  }
}

}  // namespace octet
