// Builds the hierarchy that physics/traverse.h searches: eight children a node, split where the
// surface area heuristic says (binned: Wald 2007, doi:10.1109/RT.2007.4342588), boxes compressed.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/bvh.h"

namespace omma {

struct BuildTriangle {
  float corner[3][3];  // [vertex][axis], m
  std::uint32_t triangle, placed;  // as in TriangleBlock
};

struct BuildBox {
  float lower[3];
  std::uint32_t index;
  float upper[3];
  std::uint32_t spare;
};

// A tree over boxes before what is in its leaves is written: first the nodes, of which the first is
// the root, then the boxes' indices in the order of the leaves.
struct BuiltTree {
  std::vector<WideNode> nodes;
  std::vector<std::uint32_t> order;     // [item] index of a box; leaves are filled up with `none`
};

// Leaves hold up to `most_in_leaf` boxes in blocks of `block`. Boxes are moved about. Empty without
// boxes. Throws omma::Cancelled.
BuiltTree build_tree(std::vector<BuildBox>& boxes, int most_in_leaf, int block);

}  // namespace omma
