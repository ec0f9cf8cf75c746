// Builds the hierarchy that physics/search/traverse.h searches: eight children a node, split where
// the surface area heuristic says (binned: Wald 2007, doi:10.1109/RT.2007.4342588), boxes
// compressed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/search/bvh.h"

namespace omma {

struct BuildBox {
  float lower[3], upper[3];  // m
  std::uint32_t index;       // of what it is around
};

// A tree whose leaves name the boxes they hold.
struct BuiltTree {
  std::vector<WideNode> nodes;       // the first is the root; none without boxes
  std::vector<std::uint32_t> order;  // [block of a leaf][place]: index of a box, or `none`
};

// What a tree is to be like.
struct TreeShape {
  int most_in_leaf;  // boxes
  int block;         // of boxes, which leaves are made of
  int most_depth;    // nodes from its root to a leaf
};

// Moves the boxes about. The same boxes give the same tree whatever the number of threads. Throws
// omma::Cancelled, and omma::Error where the boxes are too many.
BuiltTree build_tree(std::vector<BuildBox>& boxes, const TreeShape& shape);

// Fits the boxes of a tree of triangles to blocks whose corners have moved; `nodes` are those of
// the tree, which begins with node `first` of all. Returns the box around it, without an index.
BuildBox refit_tree(std::span<WideNode> nodes, std::uint32_t first, const TriangleQuad* blocks);

}  // namespace omma
