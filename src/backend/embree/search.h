// Embree's part of the hot loop: the closest hits of a packet.
#pragma once

#include "backend/block_functions.h"
#include "backend/embree/embree_api.h"
#include "backend/embree/tracer.h"

namespace omma {

struct EmbreeSearch {
  const EmbreeTracer* tracer;
  IntersectArguments arguments;

  OMMA_HD void closest(const std::int32_t* valid, RayPacket<16>& rays,
                       const PassedSurfaces<16>* passed) {
    arguments.context.passed = passed;
    intersect_16(tracer->scene, valid, rays_of(rays), arguments);
    // Only what is nearer than what was found is looked for.
    if (tracer->moving != nullptr) intersect_16(tracer->moving, valid, rays_of(rays), arguments);
  }
  OMMA_HD const PlacedMesh* placed() const {
    return tracer->placed.data();
  }
};

}  // namespace omma
