// Discs of the sky, such as the sun, as ommatidia see them: next-event estimation from the eye, as
// they are too small and too bright to be found by rays that an ommatidium sends by its acceptance.
// Of a disc it gets, in band b,
//
//   D[b] = ∫ S L[b] V dω / ∫ S dω   over the disc,
//
// V the part of the light that nothing hides. The integral without V is a quadrature; how much of
// it is open comes of shadow rays to points all over the disc (a ratio estimator, within 0 and the
// whole). First a few of them, which are not counted, say whether the disc is partly hidden; only
// then there are many, by what that makes of the response. As they choose how many there are and
// nothing else, the mean stays right.
//
// Rays from the eye leave out what is sampled here (counts_by_rays): discs that are not much larger
// than the acceptance. What fills an acceptance is found by its rays as well as any other surface
// is.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/block/disc_density.h"
#include "physics/path/direct_light.h"

namespace omma {

// Below this part of what a surface gets, as radiance, a disc adds nothing: dim responses are some
// thousandths of that.
inline constexpr double least_disc_light = 1e-7;

// Points on a disc, for each batch: where all of the pilot's see the disc, or none, and else at
// least.
struct DiscEffort {
  int pilot = 0, plain = 0, mixed = 0;  // the pilot's are all in one
};

// `most`: a bound on what the disc adds, in units of what a surface gets. A half hidden disc that
// outshines all else is then off by some 0.4 %.
OMMA_HD DiscEffort choose_disc_effort(double most) {
  if (most >= 50) return {64, 8, 512};
  if (most >= 5) return {32, 4, 128};
  if (most >= 0.5) return {16, 2, 32};
  return most >= 0.003 ? DiscEffort{16, 2, 8} : DiscEffort{0, 2, 2};
}

// Sums over a replicate's points on a disc, [batch][band]: of all of their light, and of what
// reaches the eye; and whether some, or not all, does.
struct DiscSums {
  double *all = nullptr, *seen = nullptr;
  // The same of all batches times each factor of AxisMoments, [moment][band], or null.
  double *all_moments = nullptr, *seen_moments = nullptr;
  bool any_open = false, any_hidden = false;
};

// Points on a disc: `each` for each of some batches. Sets of other numbers are independent.
struct PointSet {
  std::uint32_t number;
  int batches, each;
};

// Rays of a packet from the eye to a disc, [lane].
template <typename L>
struct DiscRays {
  Packet<L> shadow;
  float weight[L::count];         // density of the replicate's own rays there
  float darkened[L::count];       // towards the rim
  AxisMoments moments[L::count];  // where they are asked for
  LaneMask<L> asked;              // lanes whose weight is not 0
};

// Those to the points of a set from number `begin` on.
template <typename L>
OMMA_HD_CALLED void write_disc_rays(const DiscTask& of, const PointSet& set, int begin,
                                    DiscRays<L>& to) {
  using F = typename L::F;
  using I = typename L::I;
  using U = typename L::U;
  constexpr int n = L::count;
  const Replicate& replicate = *of.replicate;
  const int rays = set.batches * set.each;
  alignas(n * 4) float x[n], y[n], from_x[n], from_y[n];
  alignas(n * 4) std::int32_t hash[n], sample[n];
  for (int l = 0; l < n; ++l) {
    const int ray = begin + l < rays ? begin + l : rays - 1;
    hash[l] = int_of(mix_bits_32(of.hash + set.number));
    sample[l] = ray;
  }
  for (int l = 0; l < n; l += L::width) {
    const I h = load<I>(hash + l), k = load<I>(sample + l);
    const DiscPoints<F> point = even_disc_points(path_pair(uint_of(h), uint_of(k), U{}));
    store(x + l, point.x);
    store(y + l, point.y);
    // From all over the aperture.
    const DiscPoints<F> lens = even_disc_points(path_pair(uint_of(h), uint_of(k), U{} + 1u));
    store(from_x + l, lens.x * replicate.aperture_radius_m);
    store(from_y + l, lens.y * replicate.aperture_radius_m);
  }
  to.asked = {};
  RayPacket<n>& shadow = to.shadow.rays;
  for (int l = 0; l < n; ++l) {
    const Vec3 direction = disc_direction(*of.disc, x[l], y[l]);
    float turn[3][4];
    disc_turn(of, uint_of(hash[l]), sample[l], turn);
    to.weight[l] = begin + l < rays ? static_cast<float>(unit_pdf(of, direction, turn)) : 0.0f;
    to.darkened[l] =
        static_cast<float>(disc_darkening(*of.disc, static_cast<double>(x[l] * x[l] + y[l] * y[l]) *
                                                        static_cast<double>(of.disc->chord_2)));
    if (to.weight[l] > 0.0f) to.asked.add(l);
    if (of.frame->beside_moments) to.moments[l] = axis_moments_at(replicate, direction);
    Vector3<float> from = replicate.origin + replicate.s * from_x[l] + replicate.t * from_y[l];
    if (of.task->motion != nullptr) from = move_point(*of.task->motion, turn, from);
    store_vector(shadow.origin, l, from);
    store_vector(shadow.direction, l, without_noise(vector_of(direction)));
    shadow.t_near_m[l] = replicate.t_near_m;
    shadow.t_far_m[l] = INFINITY;
    shadow.mask[l] = of.task->sees.from_eye;
    to.shadow.footprint_rad[l] = 0;
  }
}

// Shadow rays of a replicate to the points of a set on the disc.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_disc(const DiscTask& of, Search& search, const BlockMemory& memory,
                               const PointSet& set, DiscSums& sums) {
  constexpr int n = L::count;
  const SceneView& scene = *of.frame->scene;
  const DiscView& disc = *of.disc;
  const int bands = scene.bands, rays = set.batches * set.each;
  const bool dims = lets_through(scene);
  sums.any_open = sums.any_hidden = false;
  for (int i = 0; i < set.batches * bands; ++i) sums.all[i] = sums.seen[i] = 0;
  const bool of_moments = of.frame->beside_moments;
  for (int i = 0; of_moments && i < axis_moments * bands; ++i)
    sums.all_moments[i] = sums.seen_moments[i] = 0;
  DiscRays<L> to;
  clear<L>(to.shadow.rays);
  for (int begin = 0; begin < rays; begin += n) {
    write_disc_rays(of, set, begin, to);
    const LaneMask<L> asked = to.asked;
    if (!asked.any()) continue;
    if (scene.has_volumes) begin_in<L>(memory.paths.shadow.media, seen_by_eye);
    const LaneMask<L> open =
        dims ? trace_transmittance<L>(scene, search, asked, to.shadow, memory.paths.shadow)
             : asked & ~search_occluded(search, asked, to.shadow.rays);
    sums.any_open = sums.any_open || open.any();
    sums.any_hidden = sums.any_hidden || !(open == asked);
    asked.for_each([&](int l) {
      const int row = (begin + l) / set.each * bands;
      const bool is_open = open.has(l);
      for (int b = 0; b < bands; ++b) {
        const float limb = disc.limb != nullptr ? disc.limb[b] : 0.0f;
        const double light = static_cast<double>(to.weight[l] * (1.0f - limb * to.darkened[l]));
        const float left = dims && is_open ? memory.paths.shadow.throughput[b * n + l] : 1.0f;
        if (left < 1.0f) sums.any_hidden = true;
        sums.all[row + b] += light;
        if (is_open) sums.seen[row + b] += light * static_cast<double>(left);
        for (int m = 0; of_moments && m < axis_moments; ++m) {
          const double x = light * to.moments[l].factor[m];
          sums.all_moments[m * bands + b] += x;
          if (is_open) sums.seen_moments[m * bands + b] += x * static_cast<double>(left);
        }
      }
    });
  }
}

// Adds what a replicate sees of a disc, by the sums over its points, to `light`: light, [band], and
// the square of its error behind it; and its moments to `moments`, [moment][band], where asked for.
template <typename L>
OMMA_HD_CALLED void add_disc_sums(const DiscTask& of, const DiscSums& sums, double* light,
                                  double* moments) {
  const int bands = of.frame->scene->bands;
  const DiscIntegral integral = integrate_disc(of);
  const DiscView& disc = *of.disc;
  const LightView& light_view = *of.frame->scene->light;
  const float shade = light_view.clouds.optical_depth == nullptr
                          ? 1.0f
                          : eval_cloud_shadow(light_view, disc, of.replicate->origin);
  for (int b = 0; b < bands; ++b) {
    const double limb = disc.limb != nullptr ? static_cast<double>(disc.limb[b]) : 0;
    const auto radiance = static_cast<double>(disc.radiance[b] * shade);
    const double whole = radiance * (integral.whole[0] - limb * integral.whole[1]);
    double all = 0, seen = 0;
    for (int r = 0; r < disc_batches; ++r) {
      all += sums.all[r * bands + b];
      seen += sums.seen[r * bands + b];
    }
    if (!(all > 0)) continue;
    // Of a ratio, to first order: residuals of each batch about it (Cochran 1977, chapter 6).
    const double open = seen / all;
    double squares = 0;
    for (int r = 0; r < disc_batches; ++r) {
      const double d = sums.seen[r * bands + b] - open * sums.all[r * bands + b];
      squares += d * d;
    }
    constexpr double k = disc_batches;
    light[b] += whole * open;
    light[bands + b] += whole * whole * squares * k / ((k - 1) * all * all);
    // As `all` and `seen` change with the density, so does their ratio.
    for (int m = 0; of.frame->beside_moments && m < axis_moments; ++m) {
      const double of_whole = radiance * (integral.moments[0][m] - limb * integral.moments[1][m]);
      const double of_open =
          (sums.seen_moments[m * bands + b] - open * sums.all_moments[m * bands + b]) / all;
      moments[m * bands + b] += of_whole * open + whole * of_open;
    }
  }
}

// Whether ommatidia of a frame sample discs; rays that neighbours share have no acceptance.
OMMA_HD bool has_discs(const FrameView& frame) {
  return frame.scene->light != nullptr && frame.scene->light->disc_count > 0 &&
         frame.directions->warps != nullptr;
}

// The output of number `o` that light in bands makes.
OMMA_HD double output_of(const FrameView& frame, int o, const double* light) {
  const int bands = frame.scene->bands, components = frame.scene->polarized ? 3 : 1;
  if (frame.output_from_band == nullptr) return o < bands ? light[o] : 0;
  double sum = 0;
  for (int b = 0; b < bands; ++b)
    sum += static_cast<double>(frame.output_from_band[o * bands * components + b]) * light[b];
  return sum;
}

// The square of its error, of bands whose squares these are: bands err together, as they share the
// rays.
OMMA_HD double square_of(const FrameView& frame, int o, const double* error_2) {
  const int bands = frame.scene->bands, components = frame.scene->polarized ? 3 : 1;
  if (frame.output_from_band == nullptr) return o < bands ? error_2[o] : 0;
  double error = 0;
  for (int b = 0; b < bands; ++b)
    error +=
        static_cast<double>(frame.output_from_band[o * bands * components + b]) * sqrt(error_2[b]);
  return error * error;
}

// Bounds on what the whole of a disc adds, [band], into memory.disc_bound; returns the largest.
template <typename L>
OMMA_HD_CALLED double bound_disc(const DiscTask& of, const BlockMemory& memory) {
  const double whole = most_unit_pdf(of) / static_cast<double>(of.disc->density);
  double most = 0;
  for (int b = 0; b < of.frame->scene->bands; ++b) {
    memory.disc_bound[b] = static_cast<double>(of.disc->radiance[b]) * whole;
    most = fmax(most, memory.disc_bound[b]);
  }
  return most;
}

// What is dimmer than this part of an ommatidium's largest output is not asked for by its own size.
inline constexpr double dim_output = 0.1;

// Takes what a replicate's rays bring by its size, at least `dim_output` of its largest output.
OMMA_HD void take_sizes(const FrameView& frame, const BlockMemory& memory) {
  double most = 0;
  for (int o = 0; o < outputs_of_discs(frame); ++o) most = fmax(most, fabs(memory.by_rays[o]));
  for (int o = 0; o < outputs_of_discs(frame); ++o)
    memory.by_rays[o] = fmax(fabs(memory.by_rays[o]), dim_output * most);
}

// How many times the acceptance's solid angle a disc is, or 1: only that part of its points counts.
OMMA_HD double over_acceptance(const DiscTask& of) {
  return fmax(1.0, 1 / (static_cast<double>(of.disc->density) *
                        static_cast<double>(of.replicate->acceptance_sr)));
}

// How many points a replicate looks at of a disc, of which `most` is the largest of
// memory.disc_bound. Where its rays bring less than a surface gets, the pilot looks for less.
template <typename L>
OMMA_HD_CALLED DiscEffort disc_effort(const DiscTask& of, double most, const BlockMemory& memory) {
  double over_rays = most;
  for (int o = 0; o < outputs_of_discs(*of.frame); ++o) {
    const double bound = fabs(output_of(*of.frame, o, memory.disc_bound));
    // 100 is as good as infinite.
    const double least = fmax(0.01 * bound, 1e-300);
    over_rays = fmax(over_rays, bound / fmax(memory.by_rays[o], least));
  }
  DiscEffort effort = choose_disc_effort(most);
  effort.pilot = choose_disc_effort(over_rays).pilot;
  const double over = over_acceptance(of);
  for (double least = 1; least < over; least *= 2) {
    effort.pilot *= 2;
    effort.plain *= 2;
    effort.mixed *= 2;
  }
  return effort;
}

// The error that what a replicate sees of a disc may have, of which output o is `light` with it:
// 1.75 % with 16 rays, as those fall; to reach a target 0.4 of what is left of it, as the error of
// batches is claimed, which is some 1.7 times that of all points together.
OMMA_HD double asked_of_disc(const FrameView& frame, const BlockMemory& memory, int o,
                             double light) {
  if (frame.most_samples <= 0)
    return 0.07 * light / sqrt(static_cast<double>(frame.directions->samples));
  const double target = fmax(frame.relative_error * light, frame.error / frame.radiance_unit);
  return 0.4 * sqrt(fmax(target * target - memory.by_rays_variance[o], 0.1 * target * target));
}

// Points for each batch on a disc that is partly hidden, of which the pilot's points, whose sums
// these are, see a part. How much of a disc n even points find open is off by up to n^(-3/4) / 2
// where it has an edge, so that little of it needs many. Powers of two, as last bits must not
// decide.
template <typename L>
OMMA_HD_CALLED int points_of_mixed(const DiscTask& of, const DiscSums& pilot, int least,
                                   const BlockMemory& memory) {
  const FrameView& frame = *of.frame;
  double all = 0, seen = 0;
  for (int b = 0; b < frame.scene->bands; ++b) {
    all += pilot.all[b];
    seen += pilot.seen[b];
  }
  const double open = all > 0 ? seen / all : 0;
  double most = 0;
  for (int o = 0; o < outputs_of_discs(frame); ++o) {
    const double bound = fabs(output_of(frame, o, memory.disc_bound));
    if (!(bound > 0)) continue;
    const double light = memory.by_rays[o] + open * bound;
    most = fmax(most, 0.5 * bound / asked_of_disc(frame, memory, o, light));
  }
  const double over = over_acceptance(of);
  const int samples = frame.most_samples > 0 ? frame.most_samples : frame.directions->samples;
  const int largest = samples < 128 ? 64 * samples : 8192;
  int each = least;
  for (; each < largest; each *= 2) {
    const double n = disc_batches * each / over;
    if (n * n * n >= most * most * most * most) break;
  }
  return each;
}

// Adds what a replicate sees of discs that its rays leave out to memory.beside, the square of its
// error to memory.beside_variance and its moments to memory.beside_moments.
template <typename L, typename Search>
OMMA_HD_CALLED void add_eye_discs(const FrameView& frame, const BlockTask& task,
                                  const Replicate& replicate, Search& search,
                                  const BlockMemory& memory) {
  const LightView& light = *frame.scene->light;
  const int bands = frame.scene->bands;
  double *of_band = memory.disc_light, *error_2 = of_band + bands;
  bool any = false;
  for (int i = 0; i < light.disc_count; ++i) {
    const DiscView& disc = light.discs[i];
    if (counts_by_rays(disc, replicate.acceptance_sr)) continue;
    const DiscTask of{&frame,
                      &task,
                      frame.directions->warps + replicate.warp,
                      &disc,
                      &replicate,
                      mix_bits_32(replicate.hash + static_cast<std::uint32_t>(i) * 0x85ebca6bu)};
    const double most = bound_disc<L>(of, memory);
    if (!(most >= least_disc_light)) continue;
    const DiscEffort effort = disc_effort<L>(of, most, memory);
    if (!any) {
      for (int b = 0; b < 2 * bands; ++b) of_band[b] = 0;
      for (int k = 0; frame.beside_moments && k < axis_moments * bands; ++k)
        memory.disc_moments[k] = 0;
    }
    any = true;
    DiscSums sums{memory.disc_all, memory.disc_seen, memory.disc_all_moments,
                  memory.disc_seen_moments};
    int each = effort.plain;
    if (effort.pilot > 0) {
      trace_disc<L>(of, search, memory, {1, 1, effort.pilot}, sums);
      if (sums.any_open && sums.any_hidden)
        each = points_of_mixed<L>(of, sums, effort.mixed, memory);
    }
    trace_disc<L>(of, search, memory, {0, disc_batches, each}, sums);
    if (sums.any_open) add_disc_sums<L>(of, sums, of_band, memory.disc_moments);
  }
  if (!any) return;
  for (int o = 0; o < frame.outputs; ++o) {
    memory.beside[o] += output_of(frame, o, of_band);
    memory.beside_variance[o] += square_of(frame, o, error_2);
    for (int m = 0; frame.beside_moments && m < axis_moments; ++m)
      memory.beside_moments[m * frame.outputs + o] +=
          output_of(frame, o, memory.disc_moments + m * bands);
  }
}

}  // namespace omma
