// One of many lights, chosen by what it sends to a place: down a binary tree over them, to either
// side with a probability by the power of its lights over the square of their distance (Conty
// Estevez and Kulla 2018, Importance sampling of many lights with adaptive tree splitting,
// doi:10.1145/3233305, without their cones).
#pragma once

#include "physics/light/emissive.h"

namespace omma {

// A place in the frame that a matrix [3][4] leads from, m; the origin where it leads to a plane.
OMMA_HD Vec3 place_before(const float* m, Vec3 place) {
  const Vec3 column[3] = {{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}};
  const Vec3 from = place - Vec3{m[3], m[7], m[11]};
  const auto across = [&](int a, int b) { return cross_of(column[a], column[b]); };
  const float det = dot(column[0], across(1, 2));
  if (det == 0.0f) return {};
  return Vec3{dot(from, across(1, 2)), dot(from, across(2, 0)), dot(from, across(0, 1))} *
         (1.0f / det);
}

// How near many lights about a place seem, as a part of the variance of their places: of 100 to
// 1,600 lamps on a grid, the less it is the more even is what single samples bring (1: a variance
// of 2 to 10, 0.1: 0.5 to 1.4, 0.03: 0.4 to 0.7), but what surrounds a place at a distance, as a
// ring of light does, is taken for as much nearer.
inline constexpr float nearness = 0.1f;

// What the lights of a node send to a place, about: as from the nearest place of their box.
OMMA_HD float eval_light_node(const LightNode& node, Vec3 place) {
  const auto outside = [](float lower, float upper, float at) {
    return fmaxf(fmaxf(lower - at, at - upper), 0.0f);
  };
  const float x = outside(node.lower.x, node.upper.x, place.x),
              y = outside(node.lower.y, node.upper.y, place.y),
              z = outside(node.lower.z, node.upper.z, place.z);
  const float distance_2 = fmaxf(x * x + y * y + z * z + nearness * node.variance_m2, 1e-12f);
  return node.steady + node.power / fminf(distance_2, 1e30f);
}

// Lights of a tree by their rank: from `first` to before `last`.
struct LightRange {
  std::int32_t first, last;
  float probability;
};

// Down to a leaf; goes_first(share, middle): whether to the lights before rank `middle`, which
// have that share.
template <typename GoesFirst>
OMMA_HD LightRange find_light_leaf(const LightTreeView& tree, Vec3 place,
                                   const GoesFirst& goes_first) {
  LightRange range{0, tree.count, 1.0f};
  for (std::int32_t node = 0; node + 1 < tree.leaves;) {
    const std::int32_t child = 2 * node + 1, middle = (range.first + range.last) / 2;
    const float first = eval_light_node(tree.nodes[child], place);
    const float both = first + eval_light_node(tree.nodes[child + 1], place);
    const float share = both > 0.0f ? first / both : 1.0f;
    const bool is_first = goes_first(share, middle);
    (is_first ? range.last : range.first) = middle;
    range.probability *= is_first ? share : 1.0f - share;
    node = is_first ? child : child + 1;
  }
  return range;
}

// Of a leaf of several lights they are chosen by their strength.
OMMA_HD float probability_in_leaf(const LightTreeView& tree, const LightRange& leaf,
                                  std::int32_t rank) {
  if (leaf.last - leaf.first <= 1) return 1.0f;
  const float all = tree.sum[leaf.last] - tree.sum[leaf.first];
  return all > 0.0f ? (tree.sum[rank + 1] - tree.sum[rank]) / all : 0.0f;
}

struct ChosenLight {
  std::int32_t index = -1;  // of the lights of the tree
  float probability = 0;
  float left = 0;  // of the random number, in [0, 1)
};

OMMA_HD ChosenLight sample_light_tree(const LightTreeView& tree, Vec3 place, float u) {
  constexpr float below_1 = 0x1.fffffep-1f;
  const LightRange leaf = find_light_leaf(tree, place, [&](float share, std::int32_t) {
    const bool is_first = u < share;
    u = is_first ? u / share : (u - share) / (1.0f - share);
    u = fminf(u, below_1);
    return is_first;
  });
  std::int32_t rank = leaf.first;
  if (leaf.last - leaf.first > 1) {
    const float first = tree.sum[leaf.first], last = tree.sum[leaf.last];
    const float at = fminf(first + u * (last - first), last * below_1);
    rank += find_in_sum(tree.sum + leaf.first, leaf.last - leaf.first, at);
    u = within_part(tree.sum, rank, at);
  }
  return {tree.light_of_rank[rank], leaf.probability * probability_in_leaf(tree, leaf, rank), u};
}

// With which sample_light_tree chooses a light.
OMMA_HD float light_tree_probability(const LightTreeView& tree, Vec3 place,
                                     std::int32_t light) {
  const std::int32_t rank = tree.rank_of_light[light];
  const LightRange leaf = find_light_leaf(
      tree, place, [&](float, std::int32_t middle) { return rank < middle; });
  return leaf.probability * probability_in_leaf(tree, leaf, rank);
}

}  // namespace omma
