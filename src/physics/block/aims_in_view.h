// What ommatidia aim rays at besides the discs of the sky: what is small and bright, such as the
// sun's mirror image in smooth water and surfaces that shine (LightView::aims). Which of these aims
// a replicate has in view, and the cone of directions about each.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/block/disc_density.h"
#include "physics/light/emissive.h"
#include "physics/light/far_light.h"

namespace omma {

// What adds less than this part of all that is aimed at is left to rays.
inline constexpr double least_share = 1e-6;
// Of more aims than that, where a replicate's own rays meet one of them with a higher probability
// than that, all but the brightest are left to its rays.
inline constexpr int few_aims = 12;
inline constexpr double often_met = 0.25;
// Cones are as large as an acceptance at most, in which rays find the rest; those of images, most
// of whose light is in their middle, this many times as large.
inline constexpr float largest_image = 4;

// Whether ommatidia of a frame aim rays: where they are lit and not shared.
OMMA_HD bool has_aims(const FrameView& frame) {
  return frame.scene->light != nullptr && frame.scene->light->aim_count > 0 &&
         frame.directions->warps != nullptr && frame.acceptance_sr < 0;
}

// Calls `each(number)` for what is in view, in order, up to number `end`.
template <typename Each>
OMMA_HD void for_each_in_view(const AimsInView& seen, int end, const Each& each) {
  for (int word = 0; 32 * word < end; ++word)
    for (std::uint32_t bits = seen.bits[word]; bits != 0; bits &= bits - 1) {
      const int i = 32 * word + lowest_bit(bits);
      if (i >= end) return;
      each(i);
    }
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

// A vector of an instance's mesh in the traced frame.
OMMA_HD Vec3 turn_with_instance(const float* frame_from_mesh, Vec3 v) {
  const float* m = frame_from_mesh;
  const auto row = [&](int r) { return m[4 * r] * v.x + m[4 * r + 1] * v.y + m[4 * r + 2] * v.z; };
  return {row(0), row(1), row(2)};
}

OMMA_HD const float* frame_of(const SceneView& scene, const AimView& aim) {
  return scene.frame_from_mesh + 12 * static_cast<std::ptrdiff_t>(aim.instance);
}

OMMA_HD Vec3 place_of(const SceneView& scene, const AimView& aim) {
  const float* m = frame_of(scene, aim);
  return turn_with_instance(m, aim.centre) + Vec3{m[3], m[7], m[11]};
}

// The image of a disc in a plane mirror, or the disc itself.
OMMA_HD Vec3 image_direction(const SceneView& scene, const AimView& aim) {
  const Vec3 from = scene.light->discs[aim.disc].direction;
  if (aim.instance < 0) return from;
  const float* m = frame_of(scene, aim);
  const Vec3 normal =
      cross_of(turn_with_instance(m, aim.centre), turn_with_instance(m, aim.across));
  return from - normal * (2 * dot(from, normal) / fmaxf(dot(normal, normal), 1e-30f));
}

// The cone about an aim as it is seen from a place; none where it is nearly all around.
OMMA_HD DiscView cone_of(const SceneView& scene, const AimView& aim, Vec3 from) {
  if (aim.disc >= 0) return make_cone(image_direction(scene, aim), aim.chord_2);
  const float* m = frame_of(scene, aim);
  float scale_2 = 0;
  for (int c = 0; c < 3; ++c)
    scale_2 = fmaxf(scale_2, m[c] * m[c] + m[4 + c] * m[4 + c] + m[8 + c] * m[8 + c]);
  const Vec3 way = place_of(scene, aim) - from;
  const float distance_2 = dot(way, way),
              sine_2 = aim.radius_m * aim.radius_m * scale_2 / distance_2;
  if (!(sine_2 < 0.25f)) return {};
  // chord^2 = 2 - 2 cos.
  return make_cone(way * (1 / sqrtf(distance_2)), 2 * sine_2 / (1 + sqrtf(1 - sine_2)));
}

OMMA_HD bool is_in_cone(const DiscView& cone, Vec3 direction) {
  return chord_2(vector_of(direction), cone.direction) <= cone.chord_2;
}

// Whether an aim is so far from a replicate's axis that nothing of it is seen: with little to
// compute, as most of them are. `cosine`: of the angle from the axis at which the acceptance ends
// and the widest cones, 30 deg, about a place beyond it.
OMMA_HD bool is_out_of_view(const SceneView& scene, const AimView& aim, const Replicate& replicate,
                            float cosine) {
  if (aim.disc >= 0) return false;
  const Vec3 way = place_of(scene, aim) - vec_of(replicate.origin);
  return dot(way, vec_of(replicate.axis)) < cosine * sqrtf(dot(way, way));
}

// Whether another mirror shows the same image.
OMMA_HD bool is_seen_already(const SceneView& scene, const AimsInView& seen, int i,
                             const DiscView& cone) {
  bool is_seen = false;
  for_each_in_view(
      seen, i, [&](int j) __attribute__((always_inline)) {
        const AimView& other = scene.light->aims[j];
        is_seen = is_seen || (other.disc == scene.light->aims[i].disc &&
                              chord_2(vector_of(image_direction(scene, other)), cone.direction) <
                                  0.01f * cone.chord_2);
      });
  return is_seen;
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

// Takes what is in view and adds `least` at least; returns with what probability a ray meets one.
template <typename L>
OMMA_HD_CALLED double take_in_view(const FrameView& frame, const BlockTask& task,
                                   const Replicate& replicate, double least, AimsInView& found) {
  const SceneView& scene = *frame.scene;
  const LightView& light = *scene.light;
  const double reach_rad =
      reach_of(frame.directions->warps[replicate.warp], static_cast<double>(replicate.scale)) +
      pi / 6;
  const float cosine = task.motion == nullptr && reach_rad < pi
                           ? cosf(static_cast<float>(reach_rad)) - 1e-5f
                           : -2.0f;
  for (std::uint32_t& bits : found.bits) bits = 0;
  found.count = 0;
  double met = 0, all = 0;
  for (int i = 0; i < light.aim_count; ++i) {
    const AimView& aim = light.aims[i];
    if (is_out_of_view(scene, aim, replicate, cosine)) continue;
    const DiscView cone = cone_of(scene, aim, vec_of(replicate.origin));
    const float largest = aim.disc >= 0 ? largest_image : 1.0f;
    if (!(cone.density * replicate.acceptance_sr * largest >= 1)) continue;
    const double met_here = most_met<L>(frame, task, replicate, cone);
    const double most = static_cast<double>(aim.brightest) * met_here;
    if (!(most > 0 && most >= least)) continue;
    if (aim.disc >= 0 && is_seen_already(scene, found, i, cone)) continue;
    found.bits[i / 32] |= 1u << (i % 32);
    ++found.count;
    met += met_here;
    all += most;
  }
  found.light = static_cast<float>(all);
  return met;
}

// What one replicate aims at. It is the same for all scrambles of an ommatidium: what its rays
// leave out is what it aims at.
template <typename L>
OMMA_HD_CALLED void find_in_view(const FrameView& frame, const BlockTask& task,
                                 const Replicate& replicate, AimsInView& found) {
  const double floor = static_cast<double>(frame.scene->light->least_aimed);
  const double met = take_in_view<L>(frame, task, replicate, floor, found);
  if (found.count < 2) return;
  const bool is_full = found.count > few_aims && met > often_met;
  const double least = static_cast<double>(found.light) * (is_full ? 1.0 / few_aims : least_share);
  take_in_view<L>(frame, task, replicate, fmax(least, floor), found);
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
    if (memory.in_view[u].count == 0) continue;
    const Vec3 from = vec_of(load_vector<float>(replicates.origin, u));
    for_each_in_view(
        memory.in_view[u], scene.light->aim_count, [&](int i) __attribute__((always_inline)) {
          const DiscView cone = cone_of(scene, scene.light->aims[i], from);
          for (int lane = l; lane < end; ++lane)
            if (is_in_cone(cone, vec_at(packet.rays.direction, lane))) inside.add(lane);
        });
  }
  return inside;
}

}  // namespace omma
