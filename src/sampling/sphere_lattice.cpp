// Finds patches by halving the sphere until a part is either out of reach or small.
#include "sampling/sphere_lattice.h"

#include <algorithm>
#include <cmath>

#include "threads/cancel.h"

namespace omma {
namespace {

constexpr double points_per_patch = 256;
// The golden angle in 2^-64 of a full turn: 2^64 (1 - 1/golden ratio).
constexpr std::uint64_t golden_turn = 0x61C8864680B583EBull;

double turns(std::uint64_t azimuth) {
  return std::ldexp(static_cast<double>(azimuth), -64);
}

Vec3d place(const SphereLattice& lattice, double index, double azimuth_turns) {
  const double share = index / static_cast<double>(lattice.points);
  const double z = 1 - 2 * share, across = 2 * std::sqrt(share * (1 - share));
  const double azimuth = 2 * pi * azimuth_turns;
  return transform_vector(lattice.turn,
                          {across * std::cos(azimuth), across * std::sin(azimuth), z});
}

// Angle from the pole where the lattice begins.
double polar_angle(const SphereLattice& lattice, double index) {
  return 2 * std::asin(std::sqrt(std::min(1.0, index / static_cast<double>(lattice.points))));
}

}  // namespace

Vec3d lattice_point(const SphereLattice& lattice, std::uint64_t index) {
  return place(lattice, static_cast<double>(index) + 0.5, turns(index * golden_turn));
}

std::vector<LatticePatch> lattice_patches(const SphereLattice& lattice,
                                          const std::function<bool(Vec3d, double)>& wanted) {
  std::vector<LatticePatch> found, open;
  constexpr std::uint64_t quarter = std::uint64_t(1) << 62;
  for (std::uint64_t k = 4; k-- > 0;) open.push_back({0, lattice.points, k * quarter, quarter});
  while (!open.empty()) {
    check_cancelled();
    const LatticePatch patch = open.back();
    open.pop_back();
    const double upper = polar_angle(lattice, static_cast<double>(patch.first));
    const double lower = polar_angle(lattice, static_cast<double>(patch.end));
    const double widest =
        upper < pi / 2 && lower > pi / 2 ? 1 : std::max(std::sin(upper), std::sin(lower));
    const double height = lower - upper, width = 2 * pi * turns(patch.width) * widest;
    const std::uint64_t rows = patch.end - patch.first;
    const double half = std::sin(0.25 * (upper + lower));
    const Vec3d centre = place(lattice, static_cast<double>(lattice.points) * half * half,
                               turns(patch.azimuth + patch.width / 2));
    // Along the meridian, then along a circle of latitude.
    if (!wanted(centre, 0.5 * (height + width))) continue;
    if (rows < 2 || static_cast<double>(rows) * turns(patch.width) <= points_per_patch) {
      found.push_back(patch);
      continue;
    }
    LatticePatch one = patch, other = patch;
    if (height > width)
      one.end = other.first = patch.first + rows / 2;
    else
      one.width = other.width = patch.width / 2, other.azimuth = patch.azimuth + one.width;
    open.push_back(other);
    open.push_back(one);
  }
  return found;
}

// From one point of the patch to the next there are three distances at most (the three-distance
// theorem: Slater 1967, Math. Proc. Camb. Phil. Soc. 63, 1115): the fewest indices that step right
// by less than the width, the fewest that step left, or both together.
std::vector<std::uint64_t> points_of(const LatticePatch& patch) {
  const auto azimuth_in_patch = [&](std::uint64_t i) { return i * golden_turn - patch.azimuth; };
  std::vector<std::uint64_t> points;
  std::uint64_t i = patch.first;
  while (i < patch.end && azimuth_in_patch(i) >= patch.width) ++i;
  if (i >= patch.end) return points;
  std::uint64_t right = 1, left = 1;
  while (right * golden_turn > patch.width) ++right;
  while (0 - left * golden_turn > patch.width) ++left;
  const std::uint64_t shorter = std::min(right, left), longer = std::max(right, left);
  while (i < patch.end) {
    points.push_back(i);
    if (azimuth_in_patch(i + shorter) < patch.width)
      i += shorter;
    else if (azimuth_in_patch(i + longer) < patch.width)
      i += longer;
    else
      i += right + left;
  }
  return points;
}

}  // namespace omma
