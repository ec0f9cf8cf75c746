// One of many lights, chosen by what it sends to a place: down a binary tree over them, to either
// side with a probability by the power of its lights over the square of their distance (Conty
// Estevez and Kulla 2018, Importance sampling of many lights with adaptive tree splitting,
// doi:10.1145/3233305; cones, ranges and horizons decide only whether that is nothing).
#pragma once

#include "physics/light/emissive.h"
#include "physics/sampling/cumulative.h"

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

// A point that lights shine on. Its normal is that of a surface that takes light from the normal's
// side alone; zeros: from all around.
struct LitPoint {
  Vec3 position, normal;
  float rise_m = 0;  // of rays that leave the surface: lights below where they begin are not above
};

// How far along a direction from a position a node's box reaches, m.
OMMA_HD float farthest_along(const LightNode& node, Vec3 position, Vec3 direction) {
  const auto farthest = [](float along, float lower, float upper) {
    return fmaxf(along * lower, along * upper);
  };
  const Vec3 lower = node.lower - position, upper = node.upper - position;
  return farthest(direction.x, lower.x, upper.x) + farthest(direction.y, lower.y, upper.y) +
         farthest(direction.z, lower.z, upper.z);
}

// Whether a node's box is, in part at least, where a point takes light from.
OMMA_HD bool is_above(const LightNode& node, const LitPoint& at) {
  return !(farthest_along(node, at.position, at.normal) < at.rise_m);
}

// Whether a position may be in the cones of a node's lights: as seen from the middle of the box it
// is off their axis by less than their reach and what half the box seems wide from there. What
// reaches no farther than a right angle (1e-5: cosines in single precision) sends nothing to a
// position that the whole box is ahead of along the axis.
OMMA_HD bool is_in_cones(const LightNode& node, Vec3 position) {
  if (!(node.cos_reach > -1.0f)) return true;
  if (node.cos_reach > -1e-5f && farthest_along(node, position, node.axis * -1.0f) < 0.0f)
    return false;
  const Vec3 half = (node.upper - node.lower) * 0.5f, from = position - (node.lower + half);
  const float radius_2 = dot(half, half), distance_2 = dot(from, from);
  if (!(distance_2 > radius_2)) return true;
  const float sin_2 = radius_2 / distance_2, cosine = sqrtf(1.0f - sin_2);
  if (node.cos_reach <= -cosine) return true;
  const float sin_reach_2 = fmaxf(1.0f - node.cos_reach * node.cos_reach, 0.0f);
  const float least = node.cos_reach * cosine - sqrtf(sin_reach_2 * sin_2);
  return dot(from, node.axis) >= (least - 1e-5f) * sqrtf(distance_2);
}

// What the lights of a node send to a point, about: as from the nearest place of their box. 0: they
// send it nothing.
OMMA_HD float eval_light_node(const LightNode& node, const LitPoint& at) {
  const Vec3 place = at.position;
  const auto outside = [](float lower, float upper, float x) {
    return fmaxf(fmaxf(lower - x, x - upper), 0.0f);
  };
  const float x = outside(node.lower.x, node.upper.x, place.x),
              y = outside(node.lower.y, node.upper.y, place.y),
              z = outside(node.lower.z, node.upper.z, place.z);
  const float to_box_2 = x * x + y * y + z * z;
  if (to_box_2 > node.range_m * node.range_m || !is_above(node, at) || !is_in_cones(node, place))
    return node.steady;
  const float distance_2 = fmaxf(to_box_2 + nearness * node.variance_m2, 1e-12f);
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
OMMA_HD LightRange find_light_leaf(const LightTreeView& tree, const LitPoint& at,
                                   const GoesFirst& goes_first) {
  LightRange range{0, tree.count, 1.0f};
  for (std::int32_t node = 0; node + 1 < tree.leaves;) {
    const std::int32_t child = 2 * node + 1, middle = (range.first + range.last) / 2;
    const float first = eval_light_node(tree.nodes[child], at);
    const float both = first + eval_light_node(tree.nodes[child + 1], at);
    // A node may seem to send something of which both sides turn out to send nothing.
    if (!(both > 0.0f)) return {range.first, range.last, 0.0f};
    const float share = first / both;
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
  std::int32_t index = -1;  // of the lights of the tree; -1: none sends anything
  float probability = 0;
  float left = 0;  // of the random number, in [0, 1)
};

OMMA_HD ChosenLight sample_light_tree(const LightTreeView& tree, const LitPoint& at, float u) {
  constexpr float below_1 = 0x1.fffffep-1f;
  const LightRange leaf = find_light_leaf(tree, at, [&](float share, std::int32_t) {
    const bool is_first = u < share;
    u = is_first ? u / share : (u - share) / (1.0f - share);
    u = fminf(u, below_1);
    return is_first;
  });
  if (!(leaf.probability > 0.0f)) return {};
  std::int32_t rank = leaf.first;
  if (leaf.last - leaf.first > 1) {
    const float first = tree.sum[leaf.first], last = tree.sum[leaf.last];
    const float within = fminf(first + u * (last - first), last * below_1);
    rank += find_in_sum(tree.sum + leaf.first, leaf.last - leaf.first, within);
    u = within_part(tree.sum, rank, within);
  }
  return {tree.light_of_rank[rank], leaf.probability * probability_in_leaf(tree, leaf, rank), u};
}

// With which sample_light_tree chooses a light.
OMMA_HD float light_tree_probability(const LightTreeView& tree, const LitPoint& at,
                                     std::int32_t light) {
  const std::int32_t rank = tree.rank_of_light[light];
  const LightRange leaf =
      find_light_leaf(tree, at, [&](float, std::int32_t middle) { return rank < middle; });
  return leaf.probability * probability_in_leaf(tree, leaf, rank);
}

// Of lights that may be hidden from a place a part is chosen evenly, or what a strong one behind a
// wall outshines would not be found (defensive sampling, Hesterberg 1995, Weighted average
// importance sampling and defensive mixture distributions, doi:10.1080/00401706.1995.10484303).
// Of many lights that would find few, and is paid for by all others.
OMMA_HD float even_part(std::int32_t lights) {
  return 0.2f * fminf(16.0f / static_cast<float>(lights), 1.0f);
}

OMMA_HD float in_part_evenly(float probability, std::int32_t lights) {
  const float evenly = even_part(lights);
  return evenly / static_cast<float>(lights) + (1.0f - evenly) * probability;
}

// One of so many lights by a random number below even_part.
OMMA_HD ChosenLight choose_evenly(std::int32_t lights, float u) {
  const auto all = static_cast<float>(lights);
  const float which = fminf(u / even_part(lights) * all, all * 0x1.fffffep-1f);
  const auto index = static_cast<std::int32_t>(which);
  return {index, 0.0f, fminf(which - static_cast<float>(index), 0x1.fffffep-1f)};
}

// As sample_light_tree, but for the part that is chosen evenly.
OMMA_HD ChosenLight choose_light(const LightTreeView& tree, const LitPoint& at, float u) {
  if (tree.lights <= 1) return sample_light_tree(tree, at, u);
  const float evenly = even_part(tree.lights);
  ChosenLight chosen;
  if (u < evenly) {
    chosen = choose_evenly(tree.lights, u);
    chosen.probability = light_tree_probability(tree, at, chosen.index);
  } else {
    chosen = sample_light_tree(tree, at, fminf((u - evenly) / (1.0f - evenly), 0x1.fffffep-1f));
    if (chosen.index < 0) return {};
  }
  chosen.probability = in_part_evenly(chosen.probability, tree.lights);
  return chosen;
}

// With which choose_light chooses a light.
OMMA_HD float choose_light_probability(const LightTreeView& tree, const LitPoint& at,
                                       std::int32_t light) {
  const float probability = light_tree_probability(tree, at, light);
  return tree.lights <= 1 ? probability : in_part_evenly(probability, tree.lights);
}

}  // namespace omma
