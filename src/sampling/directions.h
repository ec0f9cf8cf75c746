// Sample directions of all ommatidia of an eye, as tables, so that no ray needs a random number or
// a sine: a number of independently scrambled patterns of unit directions around the axis for each
// distinct acceptance angle. An estimate takes one pattern, chosen and turned about the axis by its
// scramble hash. Where tables would be too large, the same directions are made on the fly; random
// directions always are (kernel/random_direction.h).
#pragma once

#include <cstdint>
#include <vector>

#include "omma/render.h"
#include "sampling/acceptance_warp.h"

namespace omma {

// Turns about the axis that a scramble can have; a power of two.
inline constexpr std::uint64_t turn_count = 1024;

// Floats per warp in DirectionTables::polar.
inline constexpr int polar_stride = 2 * (AcceptanceWarpView::intervals + 1);

struct DirectionTables {
  int samples = 0;
  Sampling sampling = Sampling::low_discrepancy;
  std::uint64_t seed = 0;
  std::vector<AcceptanceWarp> warps;   // [distinct acceptance angle]
  std::vector<std::uint32_t> warp_of;  // [ommatidium], index into warps
  std::vector<float> footprint_rad;    // [warp], width of each ray (kernel/footprint.h)
  int patterns = 0;                    // per distinct acceptance angle; 0: made on the fly
  // [warp][pattern][x, y, z][samples], unit, in a frame with z along the axis.
  std::vector<float> local;
  std::vector<Vec2> turns;  // cosine and sine of the turns about the axis
  // With random sampling: [warp][AcceptanceWarpView::intervals + 1][theta, dtheta], rad.
  std::vector<float> polar;
};

// For estimates of settings.samples rays. Warps for the same kernel and acceptance angle are taken
// from `known`, where there are some.
DirectionTables make_direction_tables(const Eye& eye, const RenderSettings& settings,
                                      const DirectionTables* known = nullptr);

// Low-discrepancy direction `index` of a scramble, where no tables exist; into x, y, z.
void make_direction(const DirectionTables& tables, int warp, std::uint32_t scramble_hash, int index,
                    float& x, float& y, float& z);

}  // namespace omma
