// What moves from pose to pose, as Python gives it to the engine (rendering/moves.py).
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <span>
#include <tuple>
#include <vector>

#include "omma/render.h"

namespace omma::python {

namespace nb = nanobind;

using Poses = nb::ndarray<nb::numpy, const double, nb::shape<-1, 4, 4>, nb::c_contig>;
using Indices = nb::ndarray<nb::numpy, const std::int32_t, nb::shape<-1>, nb::c_contig>;
using Times = nb::ndarray<nb::numpy, const double, nb::shape<-1>, nb::c_contig>;
// Things, their transforms, times, animations; poses before the first, with their times, and
// transforms of things then; groups of things that are not seen, the group of each pose, and whether
// light does not see them either.
using MovesTuple = std::tuple<Indices, Poses, Times, Indices, Poses, Times, Poses,
                              std::vector<std::vector<int>>, Indices, bool>;

// The memory of a C-ordered (4, 4) float64 array is that of a Mat4.
inline std::span<const Mat4> matrices_of(const Poses& poses) {
  return {reinterpret_cast<const Mat4*>(poses.data()), poses.shape(0)};
}

// The call points into the arrays of `moves`, which must outlive it.
inline void take_moves(const MovesTuple& moves, RenderCall& call) {
  const auto& [instances, transforms, times, animations, past, past_times, past_transforms, unseen,
               unseen_at, unseen_by_light] = moves;
  call.instances = {instances.data(), instances.size()};
  call.world_from_node = matrices_of(transforms);
  call.times_s = {times.data(), times.size()};
  call.animations = {animations.data(), animations.size()};
  call.past_world_from_head = matrices_of(past);
  call.past_times_s = {past_times.data(), past_times.size()};
  call.past_world_from_node = matrices_of(past_transforms);
  call.unseen = unseen;
  call.unseen_at = {unseen_at.data(), unseen_at.size()};
  call.unseen_by_light = unseen_by_light;
}

}  // namespace omma::python
