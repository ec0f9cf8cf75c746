// Embree's part of the hot loop: the closest hits of a packet.
#pragma once

#include "backend/block_functions.h"
#include "backend/embree/embree_api.h"
#include "backend/embree/embree_tracer.h"
#include "physics/lanes/lane_mask.h"
#include "physics/search/traverse.h"

namespace omma {

// Whether a lane is asked for, as Embree wants it: -1 or 0 for each.
template <typename L>
struct EmbreeLanes {
  alignas(64) std::int32_t valid[16];
  OMMA_HD explicit EmbreeLanes(LaneMask<L> lanes) {
    using I = typename L::I;
    const I none_on = lane_numbers<L>() * 0;
    for (int l = 0; l < 16; l += L::width) store(valid + l, lanes.at(l) ? none_on - 1 : none_on);
  }
};

template <typename L>
struct EmbreeSearch {
  static_assert(L::count == 16);
  const EmbreeTracer* tracer;
  IntersectArguments arguments = {};

  OMMA_HD void closest(LaneMask<L> lanes, RayPacket<16>& rays, const PassedSurfaces* passed,
                       Spread spread = Spread::together) {
    const EmbreeLanes<L> asked(lanes);
    arguments.context.passed = passed;
    arguments.expect(spread);
    intersect_16(tracer->scene, asked.valid, rays_of(rays), arguments);
    // t_far_m is the distance found so far, so only nearer hits are looked for.
    if (tracer->moving != nullptr)
      intersect_16(tracer->moving, asked.valid, rays_of(rays), arguments);
  }
  // Lanes whose ray meets an accepted surface between t_near_m and t_far_m; one that lets light
  // through in part counts as any other. Nothing of the rays is kept.
  OMMA_HD LaneMask<L> occluded(LaneMask<L> lanes, const RayPacket<16>& given) {
    const EmbreeLanes<L> asked(lanes);
    RayPacket<16> rays = given;
    arguments.context.passed = nullptr;
    // In coherent mode Embree 3.13.5 with AVX-512 never returns for scattered rays
    // (SearchHits.OccludedIsWhereSomethingIsMet in tests/cpp/render_hits.cpp).
    arguments.expect(Spread::scattered);
    RTCRay16& as_embree = rays_of(rays).ray;
    occluded_16(tracer->scene, asked.valid, as_embree, arguments);
    if (tracer->moving != nullptr) occluded_16(tracer->moving, asked.valid, as_embree, arguments);
    return lanes &
           lanes_where<L>([&](int l) { return load<typename L::F>(rays.t_far_m + l) < 0.0f; });
  }
  OMMA_HD const PlacedMesh* placed() const { return tracer->layout.placed.data(); }
  OMMA_HD Visits<L::count> visits_of_trees() const { return {}; }
};

}  // namespace omma
