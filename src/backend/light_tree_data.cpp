// Binary trees over lights: divided at the median of their longest axis, down to single lights.
#include "backend/light_tree_data.h"

#include <algorithm>
#include <numeric>

#include "backend/sky_data.h"
#include "model/scene_place.h"

namespace omma {
namespace {

// Of more lights several share a leaf, so that a tree of a million triangles stays small.
constexpr std::size_t most_leaves = 1 << 14;

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

// Sorts lights from `first` on into `leaves` leaves, a power of two.
void sort_into_leaves(const std::vector<TreeLight>& lights, std::int32_t* first, std::int32_t* last,
                      std::size_t leaves) {
  if (leaves == 1 || last - first < 2) return;
  const int axis = longest_axis(lights, first, last);
  std::int32_t* const middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [&](std::int32_t a, std::int32_t b) {
    const double at_a = along(lights[static_cast<std::size_t>(a)].centre_m, axis);
    const double at_b = along(lights[static_cast<std::size_t>(b)].centre_m, axis);
    return at_a != at_b ? at_a < at_b : a < b;
  });
  sort_into_leaves(lights, first, middle, leaves / 2);
  sort_into_leaves(lights, middle, last, leaves / 2);
}

// Lights as one: their centroid by weight, and their variance about it.
TreeLight join(const TreeLight& a, const TreeLight& b) {
  if (!(a.weight > 0) || !(b.weight > 0)) return a.weight > 0 ? a : b;
  TreeLight both;
  both.box = box_around(a.box, b.box);
  both.weight = a.weight + b.weight;
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
  Placing(LightTree& tree, const std::vector<TreeLight>& lights) : tree_(tree), lights_(lights) {}

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
    tree_.nodes[node] = {to_float(falling.box.lower), to_float(falling.box.upper),
                         static_cast<float>(falling.variance_m2),
                         static_cast<float>(falling.weight),
                         static_cast<float>(all.steady / (tree_.distance_m * tree_.distance_m))};
    return all;
  }

 private:
  void add(std::size_t rank, Cluster& all) const {
    TreeLight light = lights_[static_cast<std::size_t>(tree_.light_of_rank[rank])];
    light.weight /= tree_.total;
    if (light.is_steady)
      all.steady += light.weight;
    else
      all.falling = join(all.falling, light);
  }

  LightTree& tree_;
  const std::vector<TreeLight>& lights_;
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
          static_cast<std::int32_t>(light_of_rank.size())};
}

LightTree make_light_tree(const std::vector<TreeLight>& lights, double distance_m) {
  LightTree tree;
  tree.distance_m = distance_m;
  std::size_t leaves = 1;
  while (leaves < lights.size() && leaves < most_leaves) leaves *= 2;
  tree.nodes.resize(2 * leaves - 1);
  tree.light_of_rank.resize(lights.size());
  std::iota(tree.light_of_rank.begin(), tree.light_of_rank.end(), 0);
  sort_into_leaves(lights, tree.light_of_rank.data(), tree.light_of_rank.data() + lights.size(),
                   leaves);
  tree.rank_of_light.resize(lights.size());
  std::vector<double> weights;
  for (std::size_t rank = 0; rank < lights.size(); ++rank) {
    const auto light = static_cast<std::size_t>(tree.light_of_rank[rank]);
    tree.rank_of_light[light] = static_cast<std::int32_t>(rank);
    weights.push_back(lights[light].weight);
  }
  tree.sum = running_sum(weights);
  tree.total = std::accumulate(weights.begin(), weights.end(), 0.0);
  place_lights(tree, lights);
  return tree;
}

void place_lights(LightTree& tree, const std::vector<TreeLight>& lights) {
  tree.all = Placing(tree, lights).place(0, 0, lights.size()).falling;
}

}  // namespace omma
