// Points on the unit sphere, sorted into the cells of a cube, so that all those within reach of a
// direction are found without a tree.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "omma/vec.h"

namespace omma {

class SphereCells {
 public:
  // Unit vectors, looked up within `reach` (a chord, at most 2) at most.
  SphereCells(std::span<const Vec3d> points, double reach) : reach_(reach) {
    // No finer than the points are, and a table that fits a second-level cache.
    const int most = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(points.size()))));
    side_ = std::clamp(static_cast<int>(2 / std::max(reach, 1e-3)), 1, std::clamp(most, 1, 64));
    std::vector<std::uint32_t> cell;
    cell.reserve(points.size());
    for (const Vec3d p : points)
      cell.push_back(
          static_cast<std::uint32_t>((place(p.z) * side_ + place(p.y)) * side_ + place(p.x)));
    first_.assign(static_cast<std::size_t>(side_) * side_ * side_ + 1, 0);
    for (const std::uint32_t c : cell) ++first_[c + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    std::vector<std::uint32_t> next = first_;
    point_.resize(points.size());
    index_.resize(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const std::uint32_t k = next[cell[i]]++;
      point_[k] = points[i];
      index_[k] = i;
    }
  }

  // Calls found(index, chord squared) for each point within reach, always in the same order.
  template <typename Found>
  void for_each_near(Vec3d direction, const Found& found) const {
    const double most = reach_ * reach_;
    // A hair more, as distances are rounded.
    const double reach = reach_ * (1 + 1e-9);
    const int x0 = place(direction.x - reach), x1 = place(direction.x + reach);
    const int y0 = place(direction.y - reach), y1 = place(direction.y + reach);
    const int z0 = place(direction.z - reach), z1 = place(direction.z + reach);
    for (int z = z0; z <= z1; ++z)
      for (int y = y0; y <= y1; ++y) {
        const std::size_t row = static_cast<std::size_t>((z * side_ + y) * side_);
        const std::uint32_t end = first_[row + static_cast<std::size_t>(x1) + 1];
        for (std::uint32_t k = first_[row + static_cast<std::size_t>(x0)]; k < end; ++k) {
          const Vec3d apart = point_[k] - direction;
          const double chord2 = dot(apart, apart);
          if (chord2 <= most) found(index_[k], chord2);
        }
      }
  }

 private:
  int place(double coordinate) const {
    return std::clamp(static_cast<int>((coordinate + 1) * 0.5 * side_), 0, side_ - 1);
  }

  double reach_;
  int side_ = 1;
  std::vector<std::uint32_t> first_;  // [cell + 1], cells along x, then y, then z
  std::vector<Vec3d> point_;
  std::vector<std::uint32_t> index_;  // of each point as given
};

}  // namespace omma
