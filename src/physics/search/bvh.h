// The hierarchy of boxes around what is placed in a scene, as the search sees it: flat arrays
// behind pointers, the same on host and device. Made by backend/build_tree; searched by
// physics/search/traverse.h.
//
// Two levels: a tree over what is placed, each of which is a tree over triangles in its own frame.
// Every tree is eight wide and its boxes are compressed (Ylitie, Karras, Laine 2017,
// doi:10.1145/3105762.3105773): a node keeps those of its children as multiples of a power of two
// from its own corner.
#pragma once

#include <cstdint>

#include "omma/vec.h"
#include "physics/views/ray_packet.h"
#include "physics/views/version.h"

namespace omma {

inline constexpr int node_width = 8;  // most children of a node
inline constexpr int quad_width = 4;  // triangles kept side by side

// Nodes from the root of a tree to a leaf at most, of triangles (2^38 in a full one) and of what is
// placed (2^24). Trees are split by surface as long as that leaves no more below than have room.
inline constexpr int most_tree_depth = 12, most_top_depth = 8;
// What is still to be visited of a tree: a node leaves up to seven children for later.
OMMA_HD constexpr int stack_capacity(int tree_depth) {
  return (node_width - 1) * tree_depth + 1;
}

// Children that are nodes come first, then leaves. Child c spans origin + lower * 2^(exponent -
// 127) to origin + upper * 2^(exponent - 127), rounded outwards.
struct WideNode {
  float origin[3];                // m
  std::uint8_t exponent[3];       // per axis, as in a float's bits
  std::uint8_t counts;            // children, times 16; plus those of them that are nodes
  std::uint32_t first_child;      // index of the first child that is a node; the others follow it
  std::uint32_t first_leaf;       // index of the first quad (top level: placed tree)
  std::uint8_t leaf[node_width];  // quads behind first_leaf, times 16; plus how many triangles
  std::uint8_t lower[3][node_width], upper[3][node_width];
};
static_assert(sizeof(WideNode) == 80);

// Triangles of a leaf, four side by side; a leaf's last quad may be filled in part, its other
// places then hold no number.
struct TriangleQuad {
  float corner[3][3][quad_width];      // [vertex][axis], m
  std::uint32_t triangle[quad_width];  // index in its mesh
  // Index into the table of placed meshes; where the search must ask whether a hit counts,
  // `ask_flag` is added. Triangles of a tree that is placed several times have 0 here.
  std::uint32_t placed[quad_width];
};
inline constexpr std::uint32_t ask_flag = 0x80000000u;

// A tree of triangles, placed.
struct PlacedTree {
  float tree_from_frame[3][4];  // row major, from the traced frame
  std::uint32_t root;           // index into BvhView::nodes
  std::uint32_t placed;         // index into the table of placed meshes; `none` where the tree's
                                // triangles say, and its frame is the traced one
  std::uint32_t seen_by;        // as of the placed mesh (ray_packet.h)
};

// Where a placed mesh is, without rounding: what frame_from_mesh takes are its positions less
// `about_m`.
struct PlacedFrame {
  Mat4 frame_from_mesh;
  Vec3d about_m;
};

struct BvhView {
  const WideNode* top_nodes = nullptr;  // the first is the root; null where nothing is placed
  const PlacedTree* trees = nullptr;    // in the order of the top level's leaves
  const WideNode* nodes = nullptr;      // of all trees of triangles
  const TriangleQuad* quads = nullptr;
  const PlacedMesh* placed = nullptr;   // the table of placed meshes
  const PlacedFrame* frames = nullptr;  // of the same
  std::int64_t top_node_count = 0, tree_count = 0, node_count = 0, quad_count = 0;
  std::int64_t placed_count = 0;  // at least 1, which rays look up that met nothing
  std::int64_t frame_count = 0;
  Version triangles_version = 0;  // of nodes and quads
  Version placed_version = 0;     // of all else
};

}  // namespace omma
