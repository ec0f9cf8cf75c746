// Point sets of the standard normal in the plane, moved so that each integrates edges better while
// all together keep exactly the normal's radii: a set taken at random and turned at random about
// the origin has no bias.
#pragma once

#include <cstdint>
#include <vector>

#include "omma/vec.h"

namespace omma {

// Above this many points to a pattern nothing is moved: it would cost their square.
inline constexpr int most_moved_points = 512;

// `patterns` [pattern][point], all of one size, independent standard normals in x and y (z unused).
// What comes out depends on nothing but them and the seed. Runs in parallel.
void move_apart(std::vector<std::vector<Vec3d>>& patterns, std::uint64_t seed);

}  // namespace omma
