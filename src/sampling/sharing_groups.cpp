// Clusters of nodal points: ommatidia are joined to those of their nearest that are near enough.
#include "sampling/sharing_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/nearest_axis.h"
#include "threads/parallel.h"

namespace omma {

std::vector<std::vector<std::uint32_t>> sharing_groups(const Eye& eye) {
  const std::size_t n = eye.size();
  std::vector<Vec3d> positions(n);
  for (std::size_t i = 0; i < n; ++i) positions[i] = to_double(eye.position_m[i]);
  const AxisTree tree(positions);
  std::vector<NearestAxes> near(n);
  parallel_for(std::size_t{0}, n,
               [&](std::size_t i) { near[i] = tree.nearest(positions[i], NearestAxes::most); });
  std::vector<double> spacing(n);  // squared distance to the farthest of the near ones
  for (std::size_t i = 0; i < n; ++i)
    spacing[i] = near[i].chord_squared[static_cast<std::size_t>(near[i].count - 1)];
  std::vector<double> sorted = spacing;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2),
                   sorted.end());
  const double most = 9 * sorted[n / 2];

  std::vector<std::uint32_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::uint32_t i = 0; i < n; ++i)
    for (int k = 0; k < near[i].count; ++k) {
      const auto j = static_cast<std::uint32_t>(near[i].index[static_cast<std::size_t>(k)]);
      if (eye.eye_id[i] == eye.eye_id[j] &&
          near[i].chord_squared[static_cast<std::size_t>(k)] <= most)
        parent[std::max(root(i), root(j))] = std::min(root(i), root(j));
    }
  std::vector<std::vector<std::uint32_t>> groups;
  std::vector<std::int64_t> group_of(n, -1);
  for (std::uint32_t i = 0; i < n; ++i) {
    std::int64_t& group = group_of[root(i)];
    if (group < 0) {
      group = static_cast<std::int64_t>(groups.size());
      groups.emplace_back();
    }
    groups[static_cast<std::size_t>(group)].push_back(i);
  }
  return groups;
}

std::vector<std::vector<std::uint32_t>> width_classes(std::span<const std::uint32_t> member,
                                                      std::span<const double> width) {
  double narrowest = 0, widest = 0;
  for (const std::uint32_t i : member) {
    if (width[i] > 0 && (narrowest == 0 || width[i] < narrowest)) narrowest = width[i];
    widest = std::max(widest, width[i]);
  }
  if (widest == 0) return {};
  const double span = std::log(widest / narrowest);
  // A hair less, as the widest may be just so many times as wide.
  const double count = std::max(1.0, std::ceil(span / std::log(most_width_ratio) * (1 - 1e-9)));
  std::vector<std::vector<std::uint32_t>> classes(static_cast<std::size_t>(count));
  for (const std::uint32_t i : member) {
    if (width[i] == 0) continue;
    const double place = span > 0 ? std::log(width[i] / narrowest) / span * count : 0;
    classes[static_cast<std::size_t>(std::min(place, count - 1))].push_back(i);
  }
  std::erase_if(classes, [](const auto& one) { return one.empty(); });
  return classes;
}

}  // namespace omma
