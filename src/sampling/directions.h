// Sample directions of all ommatidia of an eye, as tables, so that no ray needs a random number or
// a sine: a number of independently scrambled patterns of unit directions around the axis for each
// distinct acceptance. An estimate takes one pattern, chosen by its scramble hash, and where the
// sensitivity is round turned about the axis by it too; of any other each pattern's points are
// turned before they are warped. Where tables would be too large, directions are made on the fly;
// random directions always are (physics/sampling/random_direction.h).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "model/new_version.h"
#include "omma/render.h"
#include "optics/acceptance_warp.h"
#include "physics/views/frame_view.h"
#include "sampling/polar_tables.h"
#include "sampling/unset_vector.h"
#include "sampling/warp_cache.h"

namespace omma {

// Not to be copied: the views are addresses.
struct DirectionTables {
  DirectionTables() = default;
  DirectionTables(DirectionTables&&) = default;
  DirectionTables& operator=(DirectionTables&&) = default;

  int samples = 0;
  Points points = Points::low_discrepancy;
  std::uint64_t seed = 0;
  std::vector<AcceptanceWarp> warps;           // [distinct acceptance]
  std::shared_ptr<WarpCache> warp_cache;       // shared by all tables that `known` led to
  std::vector<AcceptanceWarpView> warp_views;  // of them
  std::vector<std::uint32_t> warp_of;          // [ommatidium], index into warps
  // [ommatidium], times as wide as its warp: sines of the polar angles are multiplied by it. Empty:
  // all are 1.
  std::vector<float> scale_of;
  std::vector<float> footprint_rad;  // [warp], width of each ray (physics/surface/footprint.h)
  // [warp]: the turn about the axis that all have whose sensitivity is not round, else -1.
  std::vector<std::int32_t> fixed_turn;
  int patterns = 0;  // per warp; 0: made on the fly
  // [warp][pattern][x, y, z][samples], unit, in a frame with x up, y right and z along the axis.
  // Where only some are ever asked for, the others are not written.
  UnsetVector<float> local;
  // [pattern][sample], the points that they are made of, the same for all acceptances.
  std::shared_ptr<const std::vector<std::vector<Vec3d>>> normals;
  std::vector<Vec2> turns;  // [turn_count + 1], cosine and sine; the last is no turn
  PolarTables polar;        // with random points
  Version version = new_version();
};

// [ommatidium], its number in its own eye of a population (RenderSettings::eye_sizes), which random
// numbers are hashed from; without sizes that in the eye.
std::vector<std::int32_t> numbers_in_eyes(std::size_t ommatidia,
                                          const std::vector<std::int32_t>& eye_sizes);

// The acceptance that an ommatidium is rendered with: its own, or the settings' kernel at its
// acceptance angle.
Acceptance rendered_acceptance(const Eye& eye, const RenderSettings& settings, std::size_t i);

// For estimates of `samples` rays, whatever the settings say of their number. Warps for the same
// acceptance are taken from `known` or its cache, where there are some, and so are points. With
// `of_frame_0` only the patterns are made that ommatidia have in frame 0, which with frozen noise
// and a fixed number of rays is all that are asked for: an eye whose acceptances change is ready in
// less than its frame.
DirectionTables make_direction_tables(const Eye& eye, const RenderSettings& settings, int samples,
                                      const DirectionTables* known = nullptr,
                                      bool of_frame_0 = false);

// Points into the tables.
DirectionsView view(const DirectionTables& tables);

}  // namespace omma
