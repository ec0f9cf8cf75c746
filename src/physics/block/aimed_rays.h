// Rays that ommatidia aim at what is small and bright besides the discs of the sky: the sun's
// mirror image in smooth water, surfaces that shine (LightView::aims). Their own rays, by their
// acceptance, would find it by chance.
//
// The integral over directions is divided: within a cone about each such thing, where it is much
// smaller than the acceptance, the ommatidium sends rays evenly over the cone, each weighed by the
// density of its own,
//
//   ∫ over the cone p L dω = mean of p(ω) L(ω) times the cone's solid angle,   p = S / ∫ S,
//
// and its own rays count outside of all cones alone. Both follow whole paths, so that the sum is
// right whatever stands there, also where a thing has moved away from its cone.
#pragma once

#include "physics/block/eye_discs.h"
#include "physics/block/outputs.h"
#include "physics/path/lit_path.h"
#include "physics/sampling/mean_of_estimates.h"

namespace omma {

// Whether ommatidia of a frame aim rays: where they are lit and not shared.
OMMA_HD bool has_aims(const FrameView& frame) {
  return frame.scene->light != nullptr && frame.scene->light->aim_count > 0 &&
         frame.directions->warps != nullptr && frame.acceptance_sr < 0;
}

OMMA_HD bool is_in_cone(const AimCone& cone, Vec3 direction) {
  return chord_2(vector_of(direction), cone.direction) <= cone.chord_2;
}

// The cone about a thing as it is seen from a place; its solid angle is 0 where it is all around.
OMMA_HD AimCone cone_of(const AimView& aim, Vec3 from) {
  AimCone cone;
  double cosine;
  if (aim.is_direction) {
    cone.direction = aim.centre;
    cosine = cos(static_cast<double>(aim.radius));
  } else {
    const Vec3 way = aim.centre - from;
    const double distance_2 = static_cast<double>(dot(way, way));
    const double sine_2 =
        static_cast<double>(aim.radius) * static_cast<double>(aim.radius) / distance_2;
    if (!(sine_2 < 0.25)) return {};
    cone.direction = way * static_cast<float>(1 / sqrt(distance_2));
    cosine = sqrt(1 - sine_2);
  }
  // At least as wide as single precision tells directions apart.
  cone.chord_2 = static_cast<float>(fmax(2 * (1 - cosine), 1e-11));
  cone.solid_sr = static_cast<float>(pi) * cone.chord_2;
  return cone;
}

// What a cone is to functions that ask about discs.
OMMA_HD DiscView disc_of(const AimCone& cone) {
  DiscView disc;
  disc.direction = cone.direction;
  disc.chord_2 = cone.chord_2;
  disc.density = 1.0f / cone.solid_sr;
  return disc;
}

// The cones that replicates aim at, into `memory`; false where none does. They are the same for all
// scrambles of an ommatidium: what its rays leave out is what it aims at.
template <typename L>
OMMA_HD_CALLED bool find_cones(const FrameView& frame, const BlockTask& task,
                               const Replicates<L>& replicates, int count,
                               const BlockMemory& memory) {
  const LightView& light = *frame.scene->light;
  bool any = false;
  for (int u = 0; u < count; ++u) {
    std::int32_t& found = memory.cone_count[u];
    found = 0;
    const Replicate replicate = replicate_at(replicates, u);
    const Vec3 from = vec_of(replicate.origin);
    for (int i = 0; i < light.aim_count && found < most_cones; ++i) {
      AimCone cone = cone_of(light.aims[i], from);
      // A cone that fills an acceptance is found by its rays.
      if (!(cone.solid_sr > 0) || cone.solid_sr > 0.5f * replicate.acceptance_sr) continue;
      const DiscView disc = disc_of(cone);
      const DiscTask of{&frame, &task,      frame.directions->warps + replicate.warp,
                        &disc,  &replicate, 0x51ed270bu};
      cone.most = static_cast<float>(static_cast<double>(light.aims[i].brightest * cone.solid_sr) *
                                     most_unit_pdf(of));
      if (!(cone.most >= static_cast<float>(least_aimed_light))) continue;
      memory.cones[u * most_cones + found++] = cone;
      any = true;
    }
  }
  return any;
}

// Of a packet's rays those in a cone of their replicate.
template <typename L>
OMMA_HD LaneMask<L> rays_in_cones(const Packet<L>& packet, const PacketStart& start, int samples,
                                  const BlockMemory& memory) {
  LaneMask<L> inside;
  for (int l = 0; l < start.filled; ++l) {
    const int u = start.replicate + (start.sample + l) / samples;
    for (int k = 0; k < memory.cone_count[u]; ++k)
      if (is_in_cone(memory.cones[u * most_cones + k], vec_at(packet.rays.direction, l)))
        inside.add(l);
  }
  return inside;
}

// Takes away the radiance [row][lane] of some lanes.
template <typename L>
OMMA_HD void drop_lanes(LaneMask<L> lanes, int rows, float* radiance) {
  lanes.for_each([&](int l) {
    for (int i = 0; i < rows; ++i) radiance[i * L::count + l] = 0;
  });
}

// Rays of replicate `u` all over its cone number `k`, `each` for each batch: sums of what they
// bring, weighed, in memory.aimed [batch][output].
struct ConeRays {
  int u, k, each;
};

OMMA_HD Vec3 cone_direction(const DiscTask& of, std::uint32_t ray) {
  const DiscPoints<float> point = even_disc_points(path_pair(of.hash, ray, 0u));
  return disc_direction(*of.disc, point.x, point.y);
}

// Adds the moments of what a ray of a cone brings, [output][lane], to memory.aimed_moments.
template <typename L>
OMMA_HD_CALLED void add_aimed_moments(const DiscTask& of, int ray, float weight,
                                      const float* brought, const BlockMemory& memory) {
  const Vec3 direction = cone_direction(of, static_cast<std::uint32_t>(ray));
  const AxisMoments moments = axis_moments_at(*of.replicate, direction);
  for (int o = 0; o < of.frame->outputs; ++o)
    for (int m = 0; m < axis_moments; ++m)
      memory.aimed_moments[m * of.frame->outputs + o] +=
          static_cast<double>(weight * brought[o * L::count]) * moments.factor[m];
}

// Those from number `begin` on, in a packet; `weight` [lane]: the density of the replicate's own
// rays there. Returns the lanes that count.
template <typename L>
OMMA_HD_CALLED LaneMask<L> write_cone_rays(const DiscTask& of, const ConeRays& cone, int begin,
                                           const BlockMemory& memory, Packet<L>& packet,
                                           float (&weight)[L::count]) {
  const Replicate& replicate = *of.replicate;
  const int rays = disc_batches * cone.each;
  LaneMask<L> counting;
  for (int l = 0; l < L::count; ++l) {
    const int ray = begin + l < rays ? begin + l : rays - 1;
    const auto sample = static_cast<std::uint32_t>(ray);
    const DiscPoints<float> lens = even_disc_points(path_pair(of.hash, sample, 1u));
    const Vec3 direction = cone_direction(of, sample);
    float turn[3][4];
    disc_turn(of, of.hash, ray, turn);
    weight[l] = begin + l < rays ? static_cast<float>(unit_pdf(of, direction, turn)) : 0.0f;
    for (int j = 0; j < cone.k; ++j)
      if (is_in_cone(memory.cones[cone.u * most_cones + j], direction)) weight[l] = 0;
    if (weight[l] > 0) counting.add(l);
    const Vector3<float> towards = vector_of(direction);
    Vector3<float> from = replicate.origin + (replicate.s * lens.x + replicate.t * lens.y) *
                                                 replicate.aperture_radius_m;
    if (of.task->motion != nullptr) from = move_point(*of.task->motion, turn, from);
    store_vector(packet.rays.origin, l, from);
    store_vector(packet.rays.direction, l, without_noise(towards));
    if (of.frame->scene->polarized) {
      const auto up = transform_direction(turn, replicate.up);
      const auto axis = transform_direction(turn, replicate.axis);
      store_vector(packet.reference, l, turn_with(axis, towards, up));
    }
    packet.rays.t_near_m[l] = replicate.t_near_m;
    packet.rays.mask[l] = of.task->sees.from_eye;
    packet.footprint_rad[l] = replicate.footprint_rad;
    packet.hash[l] = int_of(mix_bits_32(of.hash));
    packet.sample[l] = ray;
    packet.acceptance_sr[l] = replicate.acceptance_sr;
  }
  return counting;
}

// Errors of cells that they meet do not count: there are few of them.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_cone(const DiscTask& of, const ConeRays& cone, Search& search,
                               const BlockMemory& memory) {
  constexpr int n = L::count;
  const FrameView& frame = *of.frame;
  const int outputs = frame.outputs, rays = disc_batches * cone.each;
  for (int i = 0; i < disc_batches * outputs; ++i) memory.aimed[i] = 0;
  for (int i = 0; frame.beside_moments && i < axis_moments * outputs; ++i)
    memory.aimed_moments[i] = 0;
  InMemory<L, Packet<L>> own;
  Packet<L>& packet = own.in(memory.packet);
  clear<L>(packet.rays);
  packet.light_sees = of.task->sees.by_light;
  for (int begin = 0; begin < rays; begin += n) {
    float weight[n];
    const LaneMask<L> counting = write_cone_rays(of, cone, begin, memory, packet, weight);
    eval_lit_path<L>(*frame.scene, search, packet, counting, memory.paths, memory.radiance);
    const float* brought = memory.radiance;
    if (frame.output_from_band != nullptr) {
      make_outputs<L>(frame, memory.radiance, memory.output);
      brought = memory.output;
    }
    counting.for_each([&](int l) {
      double* const sums = memory.aimed + (begin + l) / cone.each * outputs;
      for (int o = 0; o < outputs; ++o)
        sums[o] += static_cast<double>(weight[l] * brought[o * n + l]);
      if (frame.beside_moments) add_aimed_moments<L>(of, begin + l, weight[l], brought + l, memory);
    });
  }
}

// Adds what replicate `u` of those traced together sees in its cones to memory.beside, the square
// of its error to memory.beside_variance and its moments to memory.beside_moments.
template <typename L, typename Search>
OMMA_HD_CALLED void add_aimed(const DiscTask& of_replicate, int u, Search& search,
                              const BlockMemory& memory) {
  const int outputs = of_replicate.frame->outputs;
  for (int k = 0; k < memory.cone_count[u]; ++k) {
    const AimCone& cone = memory.cones[u * most_cones + k];
    const DiscView disc = disc_of(cone);
    DiscTask of = of_replicate;
    of.disc = &disc;
    of.hash = mix_bits_32(of.replicate->hash + 0x2545f491u * static_cast<std::uint32_t>(k + 1));
    const int each = cone.most >= 0.3f ? 32 : (cone.most >= 0.003f ? 8 : 2);
    trace_cone<L>(of, {u, k, each}, search, memory);
    for (int o = 0; o < outputs; ++o) {
      const MeanOfEstimates found =
          mean_of_estimates(disc_batches, [&](int r) { return memory.aimed[r * outputs + o]; });
      constexpr double batches = disc_batches;
      const double scale = static_cast<double>(cone.solid_sr) / each;
      memory.beside[o] += found.mean * scale;
      memory.beside_variance[o] += found.squares * scale * scale / (batches * (batches - 1));
      for (int m = 0; of.frame->beside_moments && m < axis_moments; ++m)
        memory.beside_moments[m * outputs + o] +=
            memory.aimed_moments[m * outputs + o] * scale / batches;
    }
  }
}

// What eval_beside_rays calls for replicate u: `give(u, o)`, for what its rays bring in output o
// and the square of its error; `take(u)`, when what it sees besides is in memory.beside,
// beside_variance and beside_moments.
struct ByRays {
  double light, variance;
};
template <typename Give, typename Take>
struct BesideCalls {
  Give give;
  Take take;
};
template <typename Give, typename Take>
BesideCalls(Give, Take) -> BesideCalls<Give, Take>;

// What each replicate of a list sees besides what its rays bring, of discs of the sky and where it
// aims.
template <typename L, typename Search, typename Calls>
OMMA_HD_CALLED void eval_beside_rays(const FrameView& frame, const BlockTask& task,
                                     const ReplicateList& list, Search& search,
                                     const BlockMemory& memory, const Calls& calls) {
  InMemory<L, Replicates<L>> own;
  Replicates<L>& replicates = own.in(memory.replicates);
  make_replicates<L>(*frame.eye, task, *frame.directions, list, {true, frame.scene->polarized},
                     replicates);
  find_acceptances(frame, replicates, list.count);
  const bool has_cones = has_aims(frame) && find_cones(frame, task, replicates, list.count, memory);
  for (int u = 0; u < list.count; ++u) {
    for (int o = 0; o < frame.outputs; ++o) memory.beside[o] = memory.beside_variance[o] = 0;
    for (int o = 0; o < outputs_of_discs(frame); ++o) {
      const ByRays by_rays = calls.give(u, o);
      memory.by_rays[o] = by_rays.light;
      memory.by_rays_variance[o] = by_rays.variance;
    }
    take_sizes(frame, memory);
    for (int i = 0; frame.beside_moments && i < axis_moments * frame.outputs; ++i)
      memory.beside_moments[i] = 0;
    const Replicate replicate = replicate_at(replicates, u);
    if (has_discs(frame)) add_eye_discs<L>(frame, task, replicate, search, memory);
    if (has_cones)
      add_aimed<L>({&frame, &task, frame.directions->warps + replicate.warp, nullptr, &replicate},
                   u, search, memory);
    calls.take(u);
  }
}

// Whether there is any of that.
OMMA_HD bool sees_beside_rays(const FrameView& frame) {
  return has_discs(frame) || has_aims(frame);
}

}  // namespace omma
