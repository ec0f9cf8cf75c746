// Which of many directions lies nearest another one: a k-d tree over unit vectors, for pictures and
// for neighbours on the eye. The one place that uses nanoflann.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "omma/vec.h"

namespace omma {

// The nearest directions found, nearest first; equal distances are in order of index.
struct NearestAxes {
  static constexpr int most = 8;
  int count = 0;
  std::array<std::int32_t, most> index{};
  std::array<double, most> chord_squared{};  // squared distance of the tips of the unit vectors
};

class AxisTree {
 public:
  // Unit vectors; at most 2^31 - 1 of them.
  explicit AxisTree(std::vector<Vec3d> axes);
  AxisTree(AxisTree&&) noexcept;
  AxisTree& operator=(AxisTree&&) noexcept;
  ~AxisTree();

  // The `count` (1 to NearestAxes::most) axes nearest a unit vector, or all where there are fewer.
  NearestAxes nearest(Vec3d direction, int count) const;

  // Index of the nearest axis, ties to the lower index. `guess` is the index of an axis expected to
  // be near; it changes the time this takes, never the answer. The tree must not be empty.
  std::int32_t nearest(Vec3d direction, std::int32_t guess, double& chord_squared) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The angle between two unit vectors from the distance of their tips; exact for small angles too.
double angle_from_chord_squared(double chord_squared);

}  // namespace omma
