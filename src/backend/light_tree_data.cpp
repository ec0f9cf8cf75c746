// Binary trees over lights: divided at the middle of their longest axis, or into strong ones and
// weak ones, down to single lights.
#include "backend/light_tree_data.h"

#include <algorithm>
#include <numeric>

#include "backend/sky_data.h"
#include "model/scene_place.h"

namespace omma {
namespace {

// Of more lights several share a leaf, so that a tree of a million triangles stays small.
constexpr std::size_t most_leaves = 1 << 14;

// Ranks of the tree for each light, where there are few: more than half of a node's lights may be
// on one side then, so that what lies far from all others stands alone.
constexpr std::size_t ranks_each = 16;

std::size_t ranks_for(std::size_t lights) {
  const std::size_t wanted = std::max(2 * lights, std::min(ranks_each * lights, most_leaves));
  std::size_t ranks = 1;
  while (ranks < wanted && lights > 1) ranks *= 2;
  return ranks;
}

double along(Vec3d place, int axis) {
  return axis == 0 ? place.x : axis == 1 ? place.y : place.z;
}

int longest_axis(const std::vector<TreeLight>& lights, const std::int32_t* first,
                 const std::int32_t* last) {
  int longest = 0;
  double most = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax_element(first, last, [&](std::int32_t a, std::int32_t b) {
      return along(lights[static_cast<std::size_t>(a)].centre_m, axis) <
             along(lights[static_cast<std::size_t>(b)].centre_m, axis);
    });
    const double size = along(lights[static_cast<std::size_t>(*high)].centre_m, axis) -
                        along(lights[static_cast<std::size_t>(*low)].centre_m, axis);
    if (size > most) most = size, longest = axis;
  }
  return longest;
}

// How far off a group of lights may be that is judged as one: its weight times its squared size, of
// each part of a division. Without cones as in Conty Estevez and Kulla (2018).
double vagueness(const std::vector<TreeLight>& lights, const std::int32_t* first,
                 const std::int32_t* last) {
  Bounds box;
  double weight = 0;
  for (const std::int32_t* light = first; light != last; ++light) {
    box = box_around(box, lights[static_cast<std::size_t>(*light)].box);
    weight += lights[static_cast<std::size_t>(*light)].weight;
  }
  const Vec3d size = box.upper - box.lower;
  return weight > 0 ? weight * dot(size, size) : 0;
}

// Puts lights of at least half the strongest one's weight last: of a node's two the first has the
// more exact probability, also where it is small. Returns how many others there are.
std::size_t strong_last(const std::vector<TreeLight>& lights, std::int32_t* first,
                        std::int32_t* last) {
  const auto weight = [&](std::int32_t light) {
    return lights[static_cast<std::size_t>(light)].weight;
  };
  double strongest = 0;
  for (const std::int32_t* light = first; light != last; ++light)
    strongest = std::max(strongest, weight(*light));
  std::int32_t* const strong = std::stable_partition(
      first, last, [&](std::int32_t light) { return weight(light) < 0.5 * strongest; });
  return static_cast<std::size_t>(strong - first);
}

// Whether one is far stronger than the others are in the mean; it is put last.
bool is_one_far_stronger(const std::vector<TreeLight>& lights, std::int32_t* first,
                         std::int32_t* last) {
  constexpr double far_stronger = 8;
  const auto weight = [&](std::int32_t light) {
    return lights[static_cast<std::size_t>(light)].weight;
  };
  std::int32_t* const strongest = std::max_element(
      first, last, [&](std::int32_t a, std::int32_t b) { return weight(a) < weight(b); });
  double others = -weight(*strongest);
  for (const std::int32_t* light = first; light != last; ++light) others += weight(*light);
  std::iter_swap(last - 1, strongest);
  return weight(last[-1]) * static_cast<double>(last - first - 1) > far_stronger * others;
}

// Divides lights at the middle of the longest axis of the box around them, so that neither side has
// more than `most`. Returns how many are on the first side.
std::size_t divide_at_middle(const std::vector<TreeLight>& lights, std::int32_t* first,
                             std::int32_t* last, std::size_t most) {
  const auto number = static_cast<std::size_t>(last - first);
  const int axis = longest_axis(lights, first, last);
  const auto at = [&](std::int32_t light) {
    return along(lights[static_cast<std::size_t>(light)].centre_m, axis);
  };
  const auto [low, high] = std::minmax_element(
      first, last, [&](std::int32_t a, std::int32_t b) { return at(a) < at(b); });
  const double middle = at(*low) + 0.5 * (at(*high) - at(*low));
  const auto below = static_cast<std::size_t>(
      std::count_if(first, last, [&](std::int32_t light) { return at(light) < middle; }));
  const std::size_t split =
      below == 0 ? std::min(number / 2 + number % 2, most)
                 : std::clamp(below, number > most ? number - most : std::size_t{0}, most);
  if (split < number)
    std::nth_element(first, first + split, last, [&](std::int32_t a, std::int32_t b) {
      return at(a) != at(b) ? at(a) < at(b) : a < b;
    });
  return split;
}

// Gives lights `count` ranks of the tree, a power of two, whose lights begin at `ranked`. One that
// is far stronger stands alone, since of it alone is known exactly where it sends nothing: in a
// group its neighbours would be taken for strong there. Else strong lights part from weak ones
// where that tells more of both than halves of the box around them do.
void give_ranks(const std::vector<TreeLight>& lights, std::int32_t* first, std::int32_t* last,
                std::int32_t* ranked, std::size_t count, std::size_t per_leaf) {
  const auto number = static_cast<std::size_t>(last - first);
  if (count <= per_leaf) {
    std::copy(first, last, ranked);
    return;
  }
  if (number == 0) return;
  const std::size_t half = count / 2;
  const auto vague = [&](const std::int32_t* from, std::size_t split) {
    return vagueness(lights, from, from + split) + vagueness(lights, from + split, from + number);
  };
  std::size_t split = divide_at_middle(lights, first, last, half);
  std::vector<std::int32_t> other(first, last);
  std::int32_t* const begin = other.data();
  // Two ranks for each light, so that what is below can still be divided where that tells most.
  const auto has_room = [&](std::size_t side) { return 2 * side <= half; };
  const bool stands_alone =
      has_room(number - 1) && is_one_far_stronger(lights, begin, begin + number);
  const std::size_t weak = stands_alone ? number - 1 : strong_last(lights, begin, begin + number);
  const bool fits = has_room(std::max(weak, number - weak));
  if (stands_alone || (fits && vague(begin, weak) < vague(first, split))) {
    std::copy(other.begin(), other.end(), first);
    split = weak;
  }
  give_ranks(lights, first, first + split, ranked, half, per_leaf);
  give_ranks(lights, first + split, last, ranked + half, half, per_leaf);
}

// The cone around two.
void join_cones(const TreeLight& a, const TreeLight& b, TreeLight& both) {
  const Vec3d sum = a.axis + b.axis;
  both.axis = dot(sum, sum) > 1e-12 ? normalize(sum) : Vec3d{0, 0, 1};
  const auto edge = [&](const TreeLight& light) {
    return light.reach_rad + std::acos(std::clamp(dot(both.axis, light.axis), -1.0, 1.0));
  };
  both.reach_rad = std::min(std::max(edge(a), edge(b)), pi);
}

// Lights as one: their centroid by weight, and their variance about it.
TreeLight join(const TreeLight& a, const TreeLight& b) {
  if (!(a.weight > 0) || !(b.weight > 0)) return a.weight > 0 ? a : b;
  TreeLight both;
  both.box = box_around(a.box, b.box);
  both.weight = a.weight + b.weight;
  both.range_m = std::max(a.range_m, b.range_m);
  join_cones(a, b, both);
  const double share = b.weight / both.weight;
  const Vec3d between = b.centre_m - a.centre_m;
  both.centre_m = a.centre_m + between * share;
  both.variance_m2 = (1 - share) * a.variance_m2 + share * b.variance_m2 +
                     share * (1 - share) * dot(between, between);
  return both;
}

// What falls with distance, as one, and the weight of what does not.
struct Cluster {
  TreeLight falling;
  double steady = 0;
};

class Placing {
 public:
  Placing(LightTree& tree, const std::vector<TreeLight>& lights) : tree_(tree), lights_(lights) {
    for (const TreeLight& light : lights) total_ += light.weight;
  }

  // Writes what is below a node of lights of these ranks.
  Cluster place(std::size_t node, std::size_t first, std::size_t last) {
    const std::size_t leaves = (tree_.nodes.size() + 1) / 2, middle = (first + last) / 2;
    Cluster all;
    if (node + 1 >= leaves) {
      for (std::size_t rank = first; rank < last; ++rank) add(rank, all);
    } else {
      const Cluster low = place(2 * node + 1, first, middle),
                    high = place(2 * node + 2, middle, last);
      all = {join(low.falling, high.falling), low.steady + high.steady};
    }
    const TreeLight& falling = all.falling;
    // Single precision keeps ranges and cones by making them a little larger.
    constexpr double larger = 1 + 1e-6;
    const double cos_reach = falling.reach_rad < pi ? std::cos(falling.reach_rad) - 1e-6 : -1.0;
    tree_.nodes[node] = {to_float(falling.box.lower),
                         to_float(falling.box.upper),
                         static_cast<float>(falling.variance_m2),
                         static_cast<float>(falling.weight),
                         static_cast<float>(all.steady / (tree_.distance_m * tree_.distance_m)),
                         static_cast<float>(falling.range_m * larger),
                         to_float(falling.axis),
                         static_cast<float>(std::max(cos_reach, -1.0))};
    return all;
  }

 private:
  void add(std::size_t rank, Cluster& all) const {
    if (tree_.light_of_rank[rank] < 0) return;
    TreeLight light = lights_[static_cast<std::size_t>(tree_.light_of_rank[rank])];
    light.weight /= total_;
    if (light.is_steady)
      all.steady += light.weight;
    else
      all.falling = join(all.falling, light);
  }

  LightTree& tree_;
  const std::vector<TreeLight>& lights_;
  double total_ = 0;  // of weights
};

}  // namespace

TreeLight tree_light(Vec3d place_m, double weight, bool is_steady) {
  return {{place_m, place_m, false}, place_m, 0, weight, is_steady};
}

LightTreeView LightTree::view() const {
  return {nodes.data(),
          light_of_rank.data(),
          rank_of_light.data(),
          sum.data(),
          static_cast<std::int32_t>((nodes.size() + 1) / 2),
          static_cast<std::int32_t>(light_of_rank.size()),
          static_cast<std::int32_t>(lights)};
}

LightTree make_light_tree(const std::vector<TreeLight>& lights, double distance_m) {
  LightTree tree;
  tree.distance_m = distance_m;
  tree.lights = lights.size();
  const std::size_t ranks = ranks_for(lights.size());
  tree.nodes.resize(2 * std::min(ranks, most_leaves) - 1);
  tree.light_of_rank.resize(ranks);
  tree.rank_of_light.resize(ranks);
  tree.sum.resize(ranks + 1);
  place_lights(tree, lights);
  return tree;
}

void place_lights(LightTree& tree, const std::vector<TreeLight>& lights) {
  const std::size_t ranks = tree.light_of_rank.size();
  std::vector<std::int32_t> order(lights.size());
  std::iota(order.begin(), order.end(), 0);
  std::fill(tree.light_of_rank.begin(), tree.light_of_rank.end(), -1);
  give_ranks(lights, order.data(), order.data() + order.size(), tree.light_of_rank.data(), ranks,
             std::max(ranks / most_leaves, std::size_t{1}));
  std::vector<double> weights(ranks, 0.0);
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    if (tree.light_of_rank[rank] < 0) continue;
    const auto light = static_cast<std::size_t>(tree.light_of_rank[rank]);
    tree.rank_of_light[light] = static_cast<std::int32_t>(rank);
    weights[rank] = lights[light].weight;
  }
  const std::vector<float> sum = running_sum(weights);
  std::copy(sum.begin(), sum.end(), tree.sum.begin());  // where it is: views know the address
  tree.all = Placing(tree, lights).place(0, 0, ranks).falling;
}

}  // namespace omma
