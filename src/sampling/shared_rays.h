// Rays that neighbouring ommatidia share. Their fields of view overlap, so a ray traced for one
// tells its neighbours something too. The rays of an eye are an even lattice over its field of
// view, as dense as the ommatidia there ask for, fixed to the head; a response is a weighted mean
// of the rays within reach of the ommatidium. About seven times as many samples come of the same
// rays, and lattice points are spread more evenly than those of separate ommatidia.
//
// The price: a ray starts at the ommatidium nearest to its direction, so a response sees through
// the nodal points of its neighbours. On an eye of radius R that widens the acceptance angle for
// things at a distance d by the factor 1 + R/d (tests/cpp/render_shared_rays.cpp).
#pragma once

#include <cstdint>
#include <vector>

#include "model/new_version.h"
#include "omma/eye.h"
#include "physics/block/weigh.h"
#include "sampling/directions.h"

namespace omma {

// Least gain in effective samples for which an ommatidium shares rays; below, it traces its own,
// which are spread better for it than a lattice cut off at the border of its field. Measured
// (docs/sampling.md): below, errors grow with samples up to 2.5 times; above, they fall.
inline constexpr double least_sharing_gain = 2;

// Most rays, and most weights of those that are shared: a set then takes up to about 2 GB.
inline constexpr std::int64_t most_shared_rays = std::int64_t(1) << 23;
inline constexpr std::int64_t most_shared_weights = std::int64_t(1) << 27;

struct SharedRays {
  Eye rays;                         // each an ommatidium of its own, its axis the direction
  std::vector<std::uint32_t> warp;  // [ray], of the eye's tables: the narrowest that it counts for
  std::vector<char> is_shared;      // [ommatidium], whether its rays count for others too
  // response[i] = sum of weight[k] * radiance[ray[k]], k from first[i] to first[i + 1].
  std::vector<std::int64_t> first;     // [ommatidium + 1]
  std::vector<std::int32_t> ray;       // [entry]
  std::vector<float> weight;           // [entry], 1 in sum over each row
  Version version = new_version();     // of first, ray and weight
  std::uint64_t directions_tried = 0;  // of lattice points; what making them has cost
};

// About tables.samples rays per ommatidium in all, different ones in each `set`. Throws omma::Error
// where rays or weights would be more than the most.
SharedRays make_shared_rays(const Eye& eye, const DirectionTables& tables, int set);

// Points into the rays.
SharedWeights view(const SharedRays& shared);

// Tables for tracing each of the rays along its axis, once, as wide as the eye's.
DirectionTables make_ray_tables(const DirectionTables& of_eye, const SharedRays& shared);

}  // namespace omma
