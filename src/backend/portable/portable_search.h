// The portable backend's part of the hot loop: the closest hits of a packet, and whether anything
// is in its way.
#pragma once

#include "backend/portable/portable_tracer.h"
#include "physics/rays/passed.h"
#include "physics/search/traverse.h"
#include "physics/surface/surface.h"

namespace omma {

template <typename L>
struct PortableSearch {
  const PortableTracer* tracer;

  OMMA_HD void closest(LaneMask<L> lanes, RayPacket<L::count>& rays,
                       const PassedSurfaces<L::count>* passed, Spread = Spread::together) const {
    const auto accept = [&](int lane, float t_m, float u, float v, std::uint32_t triangle,
                            std::uint32_t placed, bool from_behind) {
      if (!accepts(placed, triangle, u, v, from_behind)) return false;
      if (passed == nullptr || passed->count[lane] == 0) return true;
      const Vec3 direction{rays.direction[0][lane], rays.direction[1][lane],
                           rays.direction[2][lane]};
      return !has_passed(*passed, lane, {none, placed, triangle, t_m, u, v}, direction,
                         [&](std::uint32_t, std::uint32_t geometry, std::uint32_t index) {
                           return tracer->corners(geometry, index);
                         });
    };
    omma::closest<L>(tracer->view, lanes, rays, accept);
  }

  // Lanes whose ray meets an accepted surface between its t_near_m and t_far_m; one that lets light
  // through in part counts as any other.
  OMMA_HD LaneMask<L> occluded(LaneMask<L> lanes, const RayPacket<L::count>& rays) const {
    return omma::occluded<L>(
        tracer->view, lanes, rays,
        [&](int, float, float u, float v, std::uint32_t triangle, std::uint32_t placed,
            bool from_behind) { return accepts(placed, triangle, u, v, from_behind); });
  }

  OMMA_HD const PlacedMesh* placed() const { return tracer->layout.placed.data(); }

 private:
  OMMA_HD bool accepts(std::uint32_t placed, std::uint32_t triangle, float u, float v,
                       bool from_behind) const {
    const std::int32_t mesh = tracer->layout.placed.data()[placed].mesh;
    return accept_hit(*tracer->scene_view, {mesh, triangle, u, v}, from_behind);
  }
};

}  // namespace omma
