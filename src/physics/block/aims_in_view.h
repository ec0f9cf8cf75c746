// What ommatidia aim rays at besides the discs of the sky: what is small and bright, the sun's
// mirror image in smooth water, surfaces that shine (LightView::aims). Which of these a replicate
// has in view, and the cone of directions about each.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/block/disc_density.h"
#include "physics/light/far_light.h"

namespace omma {

// Below this part of what a surface gets, as radiance, a thing is left to rays.
inline constexpr double least_aimed_light = 1e-6;
// Of more things than that, where a replicate's own rays meet one of them with a higher probability
// than that, all but the brightest are left to its rays.
inline constexpr int few_aims = 12;
inline constexpr double often_met = 0.25;

// Whether ommatidia of a frame aim rays: where they are lit and not shared.
OMMA_HD bool has_aims(const FrameView& frame) {
  return frame.scene->light != nullptr && frame.scene->light->aim_count > 0 &&
         frame.directions->warps != nullptr && frame.acceptance_sr < 0;
}

// What a cone is to functions that ask about discs: its density is 0 where there is none.
OMMA_HD DiscView make_cone(Vec3 direction, float chord_2) {
  // At least as wide as single precision tells directions apart.
  const float at_least = fmaxf(chord_2, 1e-11f);
  DiscView cone;
  cone.direction = direction;
  cone.chord_2 = at_least;
  cone.density = 1.0f / (static_cast<float>(pi) * at_least);
  return cone;
}

// A place in the traced frame, and about it the radius of what is to be met there.
struct AimPlace {
  Vec3 centre;
  float radius_m;
};

OMMA_HD AimPlace place_of(const SceneView& scene, const AimView& aim) {
  const float* m = scene.frame_from_mesh + 12 * static_cast<std::ptrdiff_t>(aim.instance);
  float largest_2 = 0;
  for (int c = 0; c < 3; ++c)
    largest_2 = fmaxf(largest_2, m[c] * m[c] + m[4 + c] * m[4 + c] + m[8 + c] * m[8 + c]);
  const auto row = [&](int r) {
    return m[4 * r] * aim.centre.x + m[4 * r + 1] * aim.centre.y + m[4 * r + 2] * aim.centre.z +
           m[4 * r + 3];
  };
  return {{row(0), row(1), row(2)}, aim.radius_m * sqrtf(largest_2)};
}

// The cone about a thing as it is seen from a place; none where it is nearly all around.
OMMA_HD DiscView cone_of(const SceneView& scene, const AimView& aim, Vec3 from) {
  if (aim.instance < 0) return make_cone(aim.centre, aim.chord_2);
  const AimPlace place = place_of(scene, aim);
  const Vec3 way = place.centre - from;
  const float distance_2 = dot(way, way), sine_2 = place.radius_m * place.radius_m / distance_2;
  if (!(sine_2 < 0.25f)) return {};
  // chord^2 = 2 - 2 cos.
  return make_cone(way * (1 / sqrtf(distance_2)), 2 * sine_2 / (1 + sqrtf(1 - sine_2)));
}

OMMA_HD bool is_in_cone(const DiscView& cone, Vec3 direction) {
  return chord_2(vector_of(direction), cone.direction) <= cone.chord_2;
}

// Whether a thing is so far from a replicate's axis that nothing of it is seen: with little to
// compute, as most of them are. `cosine`: of the angle from the axis at which the acceptance ends
// and the widest cones, 30 deg, about a place beyond it.
OMMA_HD bool is_out_of_view(const SceneView& scene, const AimView& aim, const Replicate& replicate,
                            float cosine) {
  if (aim.instance < 0) return false;
  const Vec3 way = place_of(scene, aim).centre - vec_of(replicate.origin);
  return dot(way, vec_of(replicate.axis)) < cosine * sqrtf(dot(way, way));
}

// What a replicate is when it looks at a cone; `hash`: that of its rays there.
OMMA_HD DiscTask look_at(const FrameView& frame, const BlockTask& task, const Replicate& replicate,
                         const DiscView& cone) {
  return {&frame, &task, frame.directions->warps + replicate.warp, &cone, &replicate, 0x51ed270bu};
}

// The probability with which a replicate's ray is in a cone, at most.
template <typename L>
OMMA_HD_CALLED double most_met(const FrameView& frame, const BlockTask& task,
                               const Replicate& replicate, const DiscView& cone) {
  return most_unit_pdf(look_at(frame, task, replicate, cone)) / static_cast<double>(cone.density);
}

// What one replicate aims at. It is the same for all scrambles of an ommatidium: what its rays
// leave out is what it aims at.
template <typename L>
OMMA_HD_CALLED void find_in_view(const FrameView& frame, const BlockTask& task,
                                 const Replicate& replicate, AimsInView& found) {
  const SceneView& scene = *frame.scene;
  const LightView& light = *scene.light;
  const Vec3 from = vec_of(replicate.origin);
  const double reach_rad =
      reach_of(frame.directions->warps[replicate.warp], static_cast<double>(replicate.scale)) +
      pi / 6;
  const float cosine = task.motion == nullptr && reach_rad < pi
                           ? cosf(static_cast<float>(reach_rad)) - 1e-5f
                           : -2.0f;
  double least = least_aimed_light, all = 0;
  int room = AimsInView::most;
  do {
    double met = 0;
    all = 0;
    found.count = 0;
    for (int i = 0; i < light.aim_count; ++i) {
      const AimView& aim = light.aims[i];
      if (is_out_of_view(scene, aim, replicate, cosine)) continue;
      const DiscView cone = cone_of(scene, aim, from);
      // A cone that fills an acceptance is found by its rays.
      if (!(cone.density * replicate.acceptance_sr >= 2)) continue;
      const double met_here = most_met<L>(frame, task, replicate, cone);
      const double most = static_cast<double>(aim.brightest) * met_here;
      if (!(most >= least)) continue;
      if (found.count < AimsInView::most) found.aim[found.count] = static_cast<std::uint16_t>(i);
      ++found.count;
      met += met_here;
      all += most;
    }
    // Of too many those that add the most: no more than there is room for add so much of all.
    if (met > often_met) room = few_aims;
    least = all / room;
  } while (found.count > room);
  found.light = static_cast<float>(all);
}

// What all replicates aim at, into `memory`; false where none does.
template <typename L>
OMMA_HD_CALLED bool find_all_in_view(const FrameView& frame, const BlockTask& task,
                                     const Replicates<L>& replicates, int count,
                                     const BlockMemory& memory) {
  bool any = false;
  for (int u = 0; u < count; ++u) {
    find_in_view<L>(frame, task, replicate_at(replicates, u), memory.in_view[u]);
    any = any || memory.in_view[u].count > 0;
  }
  return any;
}

// Of a packet's rays those in a cone of their replicate.
template <typename L>
OMMA_HD_CALLED LaneMask<L> rays_in_cones(const SceneView& scene, const Replicates<L>& replicates,
                                         const Packet<L>& packet, const PacketStart& start,
                                         int samples, const BlockMemory& memory) {
  LaneMask<L> inside;
  for (int l = 0, end = 0; l < start.filled; l = end) {
    const int u = start.replicate + (start.sample + l) / samples;
    end = (u + 1 - start.replicate) * samples - start.sample;
    if (end > start.filled) end = start.filled;
    const AimsInView& seen = memory.in_view[u];
    const Vec3 from = vec_of(load_vector<float>(replicates.origin, u));
    for (int k = 0; k < seen.count; ++k) {
      const DiscView cone = cone_of(scene, scene.light->aims[seen.aim[k]], from);
      for (int lane = l; lane < end; ++lane)
        if (is_in_cone(cone, vec_at(packet.rays.direction, lane))) inside.add(lane);
    }
  }
  return inside;
}

}  // namespace omma
