// Rays that ommatidia aim at what is small and bright in their view (aims_in_view.h). Their own
// rays, by their acceptance, would find it by chance.
//
// The integral over directions is divided: within a cone about each of these aims, where it is much
// smaller than the acceptance, the ommatidium sends rays evenly over the cone, each weighed by the
// density of its own,
//
//   ∫ over the cone p L dω = mean of p(ω) L(ω) times the cone's solid angle,   p = S / ∫ S,
//
// and its own rays count outside of all cones alone. Both follow whole paths, so that the sum is
// right whatever stands there, also where an aim has moved away from its cone.
#pragma once

#include "physics/block/aims_in_view.h"
#include "physics/block/eye_discs.h"
#include "physics/block/outputs.h"
#include "physics/path/lit_path.h"
#include "physics/sampling/mean_of_estimates.h"

namespace omma {

// Takes away the radiance [row][lane] of some lanes.
template <typename L>
OMMA_HD void drop_lanes(LaneMask<L> lanes, int rows, float* radiance) {
  lanes.for_each([&](int l) {
    for (int i = 0; i < rows; ++i) radiance[i * L::count + l] = 0;
  });
}

// Rays all over the cone about number `aim` of the light's aims, `each` for each batch: sums of
// what they bring, weighed, in memory.aimed [batch][output].
struct ConeRays {
  const AimsInView* seen;
  int aim, each;
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

// Leaves out directions that are in the cone of an aim before this one.
template <typename L>
OMMA_HD void leave_out_earlier(const DiscTask& of, const ConeRays& rays,
                               const Vec3 (&direction)[L::count], float (&weight)[L::count]) {
  const SceneView& scene = *of.frame->scene;
  const Vec3 from = vec_of(of.replicate->origin);
  for_each_in_view(
      *rays.seen, rays.aim, [&](int j) __attribute__((always_inline)) {
        const DiscView earlier = cone_of(scene, scene.light->aims[j], from);
        const float apart = sqrtf(of.disc->chord_2) + sqrtf(earlier.chord_2);
        if (chord_2(vector_of(earlier.direction), of.disc->direction) > 1.01f * apart * apart)
          return;
        for (int l = 0; l < L::count; ++l)
          if (is_in_cone(earlier, direction[l])) weight[l] = 0;
      });
}

// Those from number `begin` on, in a packet; `weight` [lane]: the density of the replicate's own
// rays there, 0 where they do not count.
template <typename L>
OMMA_HD_CALLED void write_cone_rays(const DiscTask& of, const ConeRays& rays, int begin,
                                    Packet<L>& packet, float (&weight)[L::count]) {
  const Replicate& replicate = *of.replicate;
  const int count = disc_batches * rays.each;
  Vec3 direction[L::count];
  for (int l = 0; l < L::count; ++l) {
    const int ray = begin + l < count ? begin + l : count - 1;
    const auto sample = static_cast<std::uint32_t>(ray);
    const DiscPoints<float> lens = even_disc_points(path_pair(of.hash, sample, 1u));
    direction[l] = cone_direction(of, sample);
    float turn[3][4];
    disc_turn(of, of.hash, ray, turn);
    weight[l] = begin + l < count ? static_cast<float>(unit_pdf(of, direction[l], turn)) : 0.0f;
    const Vector3<float> towards = vector_of(direction[l]);
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
  leave_out_earlier<L>(of, rays, direction, weight);
}

// Errors of cells that they meet do not count: there are few of them.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_cone(const DiscTask& of, const ConeRays& rays, Search& search,
                               const BlockMemory& memory) {
  constexpr int n = L::count;
  const FrameView& frame = *of.frame;
  const int outputs = frame.outputs, count = disc_batches * rays.each;
  for (int i = 0; i < disc_batches * outputs; ++i) memory.aimed[i] = 0;
  for (int i = 0; frame.beside_moments && i < axis_moments * outputs; ++i)
    memory.aimed_moments[i] = 0;
  InMemory<L, Packet<L>> own;
  Packet<L>& packet = own.in(memory.packet);
  clear<L>(packet.rays);
  packet.light_sees = of.task->sees.by_light;
  for (int begin = 0; begin < count; begin += n) {
    float weight[n];
    write_cone_rays(of, rays, begin, packet, weight);
    LaneMask<L> counting;
    for (int l = 0; l < n; ++l)
      if (weight[l] > 0) counting.add(l);
    eval_lit_path<L>(*frame.scene, search, packet, counting, memory.paths, memory.radiance);
    const float* brought = memory.radiance;
    if (frame.output_from_band != nullptr) {
      make_outputs<L>(frame, memory.radiance, memory.output);
      brought = memory.output;
    }
    counting.for_each([&](int l) {
      double* const sums = memory.aimed + (begin + l) / rays.each * outputs;
      for (int o = 0; o < outputs; ++o)
        sums[o] += static_cast<double>(weight[l] * brought[o * n + l]);
      if (frame.beside_moments) add_aimed_moments<L>(of, begin + l, weight[l], brought + l, memory);
    });
  }
}

// What a replicate's rays bring, in the unit of the bounds on what it aims at: where that is least
// beside them.
OMMA_HD double light_of_rays(const FrameView& frame, const BlockMemory& memory) {
  for (int b = 0; b < frame.scene->bands; ++b) memory.disc_bound[b] = 1;
  double least = INFINITY;
  for (int o = 0; o < outputs_of_discs(frame); ++o) {
    const double of_one = fabs(output_of(frame, o, memory.disc_bound));
    if (of_one > 0) least = fmin(least, memory.by_rays[o] / of_one);
  }
  return least;
}

// Rays to an aim, for each batch, all scrambles together, by the share that it has of the response
// at most. Where it fills two thirds of its cone 8 batches of 2 are off by some 10 % of it, of 8 by
// 4 %, of 32 by 1.5 %. With more rays of its own an ommatidium sends as many times more of these.
OMMA_HD int rays_to_aim(const FrameView& frame, double share, bool few) {
  int rays = few ? 2 : 1;
  if (share >= 0.003) rays = few ? 8 : 2;
  if (share >= 0.1) rays = 32;
  const int samples = frame.most_samples > 0 ? 16 : frame.directions->samples;
  if (samples > 16) rays *= samples / 16;
  // Sets of different scrambles are less even together than one of as many points.
  const int sets = frame.scrambles > 1 ? frame.scrambles / 2 : 1;
  return rays > sets ? rays / sets : 1;
}

// The mean over batches of what trace_cone has summed up in output o.
OMMA_HD MeanOfEstimates traced(const FrameView& frame, const BlockMemory& memory, int o) {
  return mean_of_estimates(disc_batches,
                           [&](int r) { return memory.aimed[r * frame.outputs + o]; });
}

// By what the mean of sums over the rays of a batch, `each` of them, is what is seen in a cone.
OMMA_HD double per_sum(const DiscView& cone, int each) {
  return 1 / (static_cast<double>(cone.density) * each);
}

// Rays to an aim, for each batch, with which its part of an error that is to be reached would be:
// 0.4 of it, by what `each` rays found, in the output that needs most. 0: `each` are enough, or all
// that there may be.
template <typename L>
OMMA_HD_CALLED int more_rays(const DiscTask& of, int each, double share,
                             const BlockMemory& memory) {
  constexpr double batches = disc_batches;
  const FrameView& frame = *of.frame;
  const int largest = frame.most_samples / disc_batches;
  if (each >= largest) return 0;
  const double scale = per_sum(*of.disc, each);
  double more = 1;
  for (int o = 0; o < frame.outputs; ++o) {
    const MeanOfEstimates found = traced(frame, memory, o);
    const double response = fabs(found.mean) * scale / share;
    const double asked =
        0.4 * fmax(frame.relative_error * response, frame.error / frame.radiance_unit);
    const double variance = found.squares * scale * scale / (batches * (batches - 1));
    if (asked > 0) more = fmax(more, variance / (asked * asked));
  }
  if (!(more > 1)) return 0;
  return more * each < largest ? static_cast<int>(more * each) + 1 : largest;
}

// Adds what trace_cone has summed up over `each` rays a batch.
template <typename L>
OMMA_HD_CALLED void add_traced(const FrameView& frame, double scale, const BlockMemory& memory) {
  const int outputs = frame.outputs;
  constexpr double batches = disc_batches;
  for (int o = 0; o < outputs; ++o) {
    const MeanOfEstimates found = traced(frame, memory, o);
    memory.beside[o] += found.mean * scale;
    memory.beside_variance[o] += found.squares * scale * scale / (batches * (batches - 1));
    for (int m = 0; frame.beside_moments && m < axis_moments; ++m)
      memory.beside_moments[m * outputs + o] +=
          memory.aimed_moments[m * outputs + o] * scale / batches;
  }
}

// Adds what a replicate sees of what it aims at to memory.beside, the square of its error to
// memory.beside_variance and its moments to memory.beside_moments.
template <typename L, typename Search>
OMMA_HD_CALLED void add_aimed(const FrameView& frame, const BlockTask& task,
                              const Replicate& replicate, const AimsInView& seen, Search& search,
                              const BlockMemory& memory) {
  const LightView& light = *frame.scene->light;
  const double all = light_of_rays(frame, memory) + static_cast<double>(seen.light);
  for_each_in_view(
      seen, light.aim_count, [&](int i) __attribute__((always_inline)) {
        const DiscView cone = cone_of(*frame.scene, light.aims[i], vec_of(replicate.origin));
        const double share = static_cast<double>(light.aims[i].brightest) *
                             most_met<L>(frame, task, replicate, cone) / all;
        DiscTask of = look_at(frame, task, replicate, cone);
        of.hash = replicate.hash + 0x2545f491u * static_cast<std::uint32_t>(i + 1);
        int each = 0;
        for (int next = rays_to_aim(frame, share, seen.count <= few_aims); next > 0;) {
          each = next;
          of.hash = mix_bits_32(of.hash);
          trace_cone<L>(of, {&seen, i, each}, search, memory);
          next = more_rays<L>(of, each, share, memory);
        }
        add_traced<L>(frame, per_sum(cone, each), memory);
      });
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
  const bool any_in_view =
      has_aims(frame) && find_all_in_view(frame, task, replicates, list.count, memory);
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
    if (any_in_view && memory.in_view[u].count > 0)
      add_aimed<L>(frame, task, replicate, memory.in_view[u], search, memory);
    calls.take(u);
  }
}

// Whether there is any of that.
OMMA_HD bool sees_beside_rays(const FrameView& frame) {
  return has_discs(frame) || has_aims(frame);
}

}  // namespace omma
