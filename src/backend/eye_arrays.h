// An Eye in the layout of the hot loops: structure of arrays, sorted along a space-filling curve.
#pragma once

#include <cstdint>
#include <vector>

#include "model/new_version.h"
#include "omma/eye.h"
#include "physics/views/frame_view.h"
#include "sampling/directions.h"

namespace omma {

// The eye as the hot loop reads it, in an order along which neighbours in memory are neighbours in
// direction. Frames: head. All arrays [ommatidium + zeros_behind].
struct EyeArrays {
  std::vector<float> origin_x, origin_y, origin_z;  // m, position - axis * focal offset
  std::vector<float> axis_x, axis_y, axis_z;        // unit
  std::vector<float> up_x, up_y, up_z;              // unit, across the axis
  std::vector<float> focal_offset_m;
  std::vector<float> aperture_radius_m;
  std::vector<float> scale;              // of its warp, as DirectionTables::scale_of
  std::vector<std::int32_t> warp;        // index into DirectionTables::warps
  std::vector<std::int32_t> ommatidium;  // index in the Eye
  std::vector<std::int32_t> number;      // the same, or in its own eye of a population
  bool has_apertures = false;            // whether any radius is above 0
  bool has_scales = false;               // whether any scale is not 1
  // Bounds of all, for checking poses: the largest origin_x, _y, _z, and focal offset or radius.
  double most_origin_m[3] = {};
  double most_offset_m = 0;
  Version version = new_version();

  std::size_t size() const { return ommatidium.empty() ? 0 : ommatidium.size() - zeros_behind; }
};

// `eye_sizes`: RenderSettings::eye_sizes; the arrays then have one eye behind the other, each with
// numbers of its own.
EyeArrays make_eye_arrays(const Eye& eye, const DirectionTables& directions,
                          const std::vector<std::int32_t>& eye_sizes = {});

// Points into the arrays.
EyeView view(const EyeArrays& arrays);

// How many ommatidia in a row make a block whose members hear each other: so many, half of
// most_per_block or more, that the last block of an eye has as many as can be.
int ommatidia_that_hear(std::size_t ommatidia);

// [ommatidium][listened_to]: those nearest to it in direction among its block, which are as many in
// a row as `block` says; by their place in the block, itself where there are too few.
std::vector<std::uint8_t> nearest_in_blocks(const EyeArrays& eye, int block);

}  // namespace omma
