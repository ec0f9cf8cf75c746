// Points on the unit sphere, sorted into rows along x, so that all those within reach of a
// direction are found without a tree.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "omma/vec.h"
#include "threads/parallel.h"

namespace omma {

class SphereCells {
 public:
  // Unit vectors, looked up within about `reach` (a chord, at most 2). Rows are as wide as that, in
  // the box that holds the points; a row's points are in the order of their x.
  SphereCells(std::span<const Vec3d> points, double reach) {
    double end[2] = {-1, -1};
    for (const Vec3d& p : points) {
      begin_[0] = std::min(begin_[0], p.y);
      begin_[1] = std::min(begin_[1], p.z);
      end[0] = std::max(end[0], p.y);
      end[1] = std::max(end[1], p.z);
    }
    const double extent = std::max({end[0] - begin_[0], end[1] - begin_[1], 1e-9});
    width_ = std::max(reach, extent / most_rows);
    for (int i = 0; i < 2; ++i)
      rows_[i] = 1 + static_cast<int>(std::max(0.0, end[i] - begin_[i]) / width_);
    std::vector<std::uint32_t> row;
    row.reserve(points.size());
    for (const Vec3d& p : points)
      row.push_back(static_cast<std::uint32_t>(place(p.z, 1) * rows_[0] + place(p.y, 0)));
    first_.assign(static_cast<std::size_t>(rows_[0]) * static_cast<std::size_t>(rows_[1]) + 1, 0);
    for (const std::uint32_t r : row) ++first_[r + 1];
    for (std::size_t r = 1; r < first_.size(); ++r) first_[r] += first_[r - 1];
    std::vector<std::uint32_t> next = first_;
    index_.resize(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) index_[next[row[i]]++] = i;
    point_.resize(points.size());
    parallel_for(std::size_t{0}, first_.size() - 1, [&](std::size_t r) {
      const auto at = [&](std::uint32_t k) { return index_.begin() + k; };
      std::sort(at(first_[r]), at(first_[r + 1]), [&](std::uint32_t a, std::uint32_t b) {
        return points[a].x != points[b].x ? points[a].x < points[b].x : a < b;
      });
      for (std::uint32_t k = first_[r]; k < first_[r + 1]; ++k) point_[k] = points[index_[k]];
    });
  }

  // Calls found(index, chord squared) for each point within reach, always in the same order.
  template <typename Found>
  void for_each_near(Vec3d direction, double reach, const Found& found) const {
    const double most = reach * reach;
    // A hair more, as distances are rounded.
    const double wide = reach * (1 + 1e-9) + 1e-15;
    const int y0 = place(direction.y - wide, 0), y1 = place(direction.y + wide, 0);
    const int z0 = place(direction.z - wide, 1), z1 = place(direction.z + wide, 1);
    for (int z = z0; z <= z1; ++z)
      for (int y = y0; y <= y1; ++y) {
        const auto row = static_cast<std::size_t>(z * rows_[0] + y);
        const Vec3d* const end = point_.data() + first_[row + 1];
        const Vec3d* p = std::lower_bound(point_.data() + first_[row], end, direction.x - wide,
                                          [](const Vec3d& a, double x) { return a.x < x; });
        for (; p != end && p->x <= direction.x + wide; ++p) {
          const Vec3d apart = *p - direction;
          const double chord2 = dot(apart, apart);
          if (chord2 <= most) found(index_[static_cast<std::size_t>(p - point_.data())], chord2);
        }
      }
  }

 private:
  static constexpr int most_rows = 1023;  // a table of some megabytes at most

  int place(double coordinate, int which) const {
    return static_cast<int>(
        std::clamp((coordinate - begin_[which]) / width_, 0.0, rows_[which] - 1.0));
  }

  double begin_[2] = {1, 1};  // of y and z
  double width_ = 2;
  int rows_[2] = {1, 1};
  std::vector<std::uint32_t> first_;  // [row + 1]
  std::vector<Vec3d> point_;
  std::vector<std::uint32_t> index_;  // of each point as given
};

}  // namespace omma
