// An even lattice of points on the sphere, and how to come by those of a small part of it only.
//
// Fibonacci points (Swinbank and Purser 2006, QJRMS 132, 1769): point i of n has the height
// z = 1 - (2i + 1)/n and the azimuth of i golden angles.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "omma/vec.h"

namespace omma {

struct SphereLattice {
  std::uint64_t points = 0;
  Mat4 turn;  // rotates it to where it is wanted
};

// More than this, and doubles would not place them evenly.
inline constexpr double most_lattice_points = 0x1p36;

// Points first to end whose azimuth is in [azimuth, azimuth + width); azimuths are in 2^-64 of a
// full turn, so that each point is in one patch exactly.
struct LatticePatch {
  std::uint64_t first = 0, end = 0;
  std::uint64_t azimuth = 0, width = 0;
};

Vec3d lattice_point(const SphereLattice& lattice, std::uint64_t index);

// Patches of some hundred points that do not overlap and together hold all points that are wanted;
// wanted(centre, radius_rad) says whether any direction within this angle of the centre may be.
std::vector<LatticePatch> lattice_patches(const SphereLattice& lattice,
                                          const std::function<bool(Vec3d, double)>& wanted);

// The points of a patch, in rising order.
std::vector<std::uint64_t> points_of(const LatticePatch& patch);

}  // namespace omma
