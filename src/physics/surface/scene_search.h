// The search that a block is rendered with (physics/block/block.h), by our own hierarchy of boxes:
// which surfaces of a scene rays meet, cut-outs and surfaces that were passed left out. Over flat
// arrays alone, so that it is the same on host and device.
#pragma once

#include "physics/rays/passed.h"
#include "physics/search/traverse.h"
#include "physics/surface/surface.h"

namespace omma {

template <typename L>
struct SceneSearch {
  const SceneView* scene;
  const BvhView* bvh;
  Visits<L::count> visits = {};  // in one lane

  OMMA_HD_LARGE void closest(LaneMask<L> lanes, RayPacket<L::count>& rays, const PassedSurfaces* passed,
                       Spread = Spread::together) const {
    const auto accept = [&](int lane, float t_m, float u, float v, std::uint32_t triangle,
                            std::uint32_t placed, bool from_behind) {
      if (!accepts(placed, triangle, u, v, from_behind)) return false;
      if (passed == nullptr || passed->count[lane] == 0) return true;
      return !has_passed(*passed, lane, {none, placed, triangle, t_m, u, v},
                         vec_at(rays.direction, lane),
                         [&](std::uint32_t, std::uint32_t geometry, std::uint32_t index) {
                           return corners(geometry, index);
                         });
    };
    omma::closest<L>(*bvh, visits, lanes, rays, accept);
  }

  // Lanes whose ray meets an accepted surface between its t_near_m and t_far_m; one that lets light
  // through in part counts as any other.
  OMMA_HD_LARGE LaneMask<L> occluded(LaneMask<L> lanes, const RayPacket<L::count>& rays) const {
    return omma::occluded<L>(
        *bvh, visits, lanes, rays,
        [&](int, float, float u, float v, std::uint32_t triangle, std::uint32_t placed,
            bool from_behind) { return accepts(placed, triangle, u, v, from_behind); });
  }

  OMMA_HD const PlacedMesh* placed() const { return bvh->placed; }
  // Where a search of splats keeps what is still to be visited.
  OMMA_HD const Visits<L::count>& visits_of_trees() const { return visits; }

  // A triangle of a placed mesh, in the traced frame.
  OMMA_HD Triangle corners(std::uint32_t placed, std::uint32_t triangle) const {
    const PlacedFrame& frame = bvh->frames[placed];
    const MeshView& mesh = scene->meshes[bvh->placed[placed].mesh];
    const std::int32_t* vertices = mesh.triangles + 3 * static_cast<std::ptrdiff_t>(triangle);
    Triangle t;
    for (int k = 0; k < 3; ++k) {
      const float* at = mesh.positions + 3 * static_cast<std::ptrdiff_t>(vertices[k]);
      t.corner[k] = transform_point(frame.frame_from_mesh,
                                    to_double(Vec3{at[0], at[1], at[2]}) - frame.about_m);
    }
    return t;
  }

 private:
  OMMA_HD bool accepts(std::uint32_t placed, std::uint32_t triangle, float u, float v,
                       bool from_behind) const {
    return accept_hit(*scene, {bvh->placed[placed].mesh, triangle, u, v}, from_behind);
  }
};

}  // namespace omma
