// How surfaces reflect that have a table of it, by band and angle of incidence: stacks of thin
// films and metals (omma::BoundaryTable), each a Mueller matrix by the half vector of a facet. The
// tables are made by backend/scatter_data, and linear in the cosine between their nodes: of bare
// metals within 2e-3 (tests/python/test_layers.py).
#pragma once

#include "physics/surface/fresnel.h"

namespace omma {

inline constexpr int boundary_nodes = 129;  // of cosines, even from 0 to 1
// A band of a table: [a, b, c][node][value, how much more it is at the next node], and then the
// mean of a over cosines, 2 integral a(c) c dc, and 0. Bands lie one behind the other.
inline constexpr int boundary_pairs = 3 * boundary_nodes + 1;

template <typename F>
struct BoundaryPlace {
  decltype(to_int(F{})) table;  // its number, -1 of lanes that have none
  decltype(to_int(F{})) base;   // first pair of the table; of lanes that have none, of the first
  decltype(to_int(F{})) node;   // below the cosine
  F part;                       // of the way to the next
};

template <typename F, typename I>
OMMA_HD BoundaryPlace<F> find_boundary(int bands, I table, F cosine) {
  const F place = clamp_unit_lanes(cosine) * static_cast<float>(boundary_nodes - 1);
  const I floor = to_int(place);
  const I node = floor < boundary_nodes - 2 ? floor : floor * 0 + (boundary_nodes - 2);
  return {table, keep(table >= 0, table) * (bands * boundary_pairs), node, place - to_float(node)};
}

// Of lanes that have a table.
template <typename F>
OMMA_HD Mueller<F> eval_boundary(const float* tables, const BoundaryPlace<F>& at, int band) {
  const auto first = at.base + at.node + band * boundary_pairs;
  const auto element = [&](int k) {
    const Pair<F> pair = gather_pair(tables, first + k * boundary_nodes);
    return pair.first + at.part * pair.second;
  };
  return {element(0), element(1), element(2)};
}

template <typename F>
OMMA_HD F boundary_mean(const float* tables, const BoundaryPlace<F>& at, int band) {
  const Pair<F> pair = gather_pair(tables, at.base + (band * boundary_pairs + 3 * boundary_nodes));
  return pair.first;
}

}  // namespace omma
