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

#include "omma/eye.h"
#include "sampling/directions.h"

namespace omma {

// Rows of weights are padded with zeros to whole groups of so many.
inline constexpr int weight_group = 16;

struct SharedRays {
  Eye rays;  // each an ommatidium of its own, its axis the direction
  // response[i] = sum of weight[k] * radiance[ray[k]], k from first[i] to first[i + 1].
  std::vector<std::int64_t> first;  // [ommatidium + 1]
  std::vector<std::int32_t> ray;    // [entry]
  std::vector<float> weight;        // [entry], 1 in sum over each row
};

// About tables.samples rays per ommatidium in all, another set for each `pattern`.
SharedRays make_shared_rays(const Eye& eye, const DirectionTables& tables, int pattern);

// Tables for tracing each of the rays along its axis, once.
DirectionTables make_ray_tables(const Eye& rays, const RenderSettings& settings);

}  // namespace omma
