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

// Local frame of a direction: z along the axis, unit length.
struct DirectionPattern {
  const float* x = nullptr;  // [samples]
  const float* y = nullptr;
  const float* z = nullptr;
};

struct DirectionTables {
  int samples = 0;
  Sampling sampling = Sampling::low_discrepancy;
  std::uint64_t seed = 0;
  std::vector<AcceptanceWarp> warps;   // [distinct acceptance angle]
  std::vector<std::uint32_t> warp_of;  // [ommatidium], index into warps
  int patterns = 0;                    // per distinct acceptance angle; 0: made on the fly
  std::vector<float> local;            // [warp][pattern][x, y, z][samples]
  std::vector<Vec2> turns;             // cosine and sine of the turns about the axis
  // With random sampling: [warp][AcceptanceWarpView::intervals + 1][theta, dtheta], rad.
  std::vector<float> polar;
};

// Warps for the same kernel and acceptance angle are taken from `known`, where there are some.
DirectionTables make_direction_tables(const Eye& eye, const RenderSettings& settings,
                                      const DirectionTables* known = nullptr);

// The pattern that an estimate reads, where tables exist.
inline DirectionPattern find_pattern(const DirectionTables& tables, std::uint32_t warp,
                                     std::uint64_t hash, int scramble) {
  // Scrambles of one ommatidium follow one another, so that no two share a pattern.
  const auto pattern = (static_cast<std::uint32_t>(hash) + static_cast<std::uint32_t>(scramble)) &
                       static_cast<std::uint32_t>(tables.patterns - 1);
  const std::size_t n = static_cast<std::size_t>(tables.samples);
  const float* p = tables.local.data() + (warp * std::size_t(tables.patterns) + pattern) * 3 * n;
  return {p, p + n, p + 2 * n};
}

// Its turn about the axis, from other bits of the hash than the pattern; scrambles of one
// ommatidium turn differently.
inline Vec2 find_turn(const DirectionTables& tables, std::uint64_t hash, int scramble) {
  const std::uint64_t turn = (hash >> 40) + static_cast<std::uint64_t>(scramble) * 389;
  return tables.turns.data()[turn & (turn_count - 1)];
}

// What sample_random_direction reads of a warp.
inline const float* find_polar(const DirectionTables& tables, std::uint32_t warp) {
  return tables.polar.data() + warp * std::size_t(2 * (AcceptanceWarpView::intervals + 1));
}

// Low-discrepancy directions `first` to `first + count` of an estimate, where no tables exist; into
// x, y, z.
void make_directions(const DirectionTables& tables, std::uint32_t warp, std::uint64_t hash,
                     int scramble, int first, int count, float* x, float* y, float* z);

}  // namespace omma
