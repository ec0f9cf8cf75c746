// Eyes made for tests of projections, and pictures of which single pixels are asked for.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "omma/projection.h"

namespace omma::test {

using Ids = std::vector<std::int32_t>;

enum : std::int32_t { ahead, right, back, left, up, down, none = -1 };
inline const std::vector<Vec3> six = {{0, 0, -1}, {1, 0, 0}, {0, 0, 1},
                                      {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};

inline Eye eye_of(const std::vector<Vec3>& positions, const std::vector<Vec3>& axes,
                  float acceptance_rad = 0.1f) {
  Eye eye;
  eye.position_m = positions;
  eye.axis = axes;
  eye.acceptance_angle_rad.assign(axes.size(), acceptance_rad);
  eye.focal_offset_m.assign(axes.size(), 0.0f);
  eye.eye_id.assign(axes.size(), 0);
  validate_eye(eye);
  return eye;
}

// A picture of which pixels are asked for by their place: x from 0 to 1 from left to right, y from
// 0 to 1 from top to bottom.
struct Map {
  Ids ids;
  int width, height;

  Map(const Eye& eye, Projection projection, int columns, int rows)
      : ids(projection_ids(eye, projection, columns, rows)), width(columns), height(rows) {
    EXPECT_EQ(ids.size(), static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  }

  std::int32_t pixel(int column, int row) const {
    return ids[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(column)];
  }
  std::int32_t at(double x, double y) const {
    return pixel(std::min(static_cast<int>(x * width), width - 1),
                 std::min(static_cast<int>(y * height), height - 1));
  }
  // Share of the pixels that show anything, by ommatidium.
  std::map<std::int32_t, double> shares(int first_column, int last_column) const {
    std::map<std::int32_t, double> share;
    double shown = 0;
    for (int row = 0; row < height; ++row)
      for (int column = first_column; column < last_column; ++column)
        if (const int id = pixel(column, row); id != none) share[id] += 1, shown += 1;
    for (auto& entry : share) entry.second /= shown;
    return share;
  }
};

}  // namespace omma::test
