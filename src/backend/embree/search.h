// Embree's part of the hot loop: the closest hits of a packet.
#pragma once

#include "backend/block_functions.h"
#include "backend/embree/embree_api.h"
#include "backend/embree/tracer.h"

namespace omma {

struct EmbreeSearch {
  const EmbreeTracer* tracer;
  IntersectArguments arguments = {};

  OMMA_HD void closest(const std::int32_t* valid, RayPacket<16>& rays,
                       const PassedSurfaces<16>* passed, Spread spread = Spread::together) {
    arguments.context.passed = passed;
    arguments.expect(spread);
    intersect_16(tracer->scene, valid, rays_of(rays), arguments);
    // t_far_m is the distance found so far, so only nearer hits are looked for.
    if (tracer->moving != nullptr) intersect_16(tracer->moving, valid, rays_of(rays), arguments);
  }
  // A bit for each valid ray that meets an accepted surface between t_near_m and t_far_m; one that
  // lets light through in part counts as any other. Nothing of the rays is kept.
  OMMA_HD unsigned occluded(const std::int32_t* valid, const RayPacket<16>& given) {
    RayPacket<16> rays = given;
    arguments.context.passed = nullptr;
    // In coherent mode Embree 3.13.5 with AVX-512 never returns for scattered rays
    // (SearchHits.OccludedIsWhereSomethingIsMet in tests/cpp/render_hits.cpp).
    arguments.expect(Spread::scattered);
    RTCRay16& as_embree = rays_of(rays).ray;
    occluded_16(tracer->scene, valid, as_embree, arguments);
    if (tracer->moving != nullptr) occluded_16(tracer->moving, valid, as_embree, arguments);
    unsigned bits = 0;
    for (int l = 0; l < 16; ++l) bits |= (valid[l] != 0 && rays.t_far_m[l] < 0 ? 1u : 0u) << l;
    return bits;
  }
  OMMA_HD const PlacedMesh* placed() const {
    return tracer->layout.placed.data();
  }
};

}  // namespace omma
