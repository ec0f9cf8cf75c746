// Discs of the sky, such as the sun, as ommatidia see them: next-event estimation from the eye, as
// they are too small and too bright to be found by rays that an ommatidium sends by its acceptance.
// Of a disc it gets, in band b,
//
//   D[b] = ∫ S L[b] V dω / ∫ S dω   over the disc,
//
// V the part of the light that nothing hides. The integral without V is a quadrature; how much of
// it is open comes of shadow rays to points all over the disc (a ratio estimator, within 0 and the
// whole). First a few of them, which are not counted, say whether the disc is partly hidden; only
// then there are many. As they choose how many there are and nothing else, the mean stays right.
//
// Rays from the eye leave out what is sampled here (counts_by_rays): discs that are not much larger
// than the acceptance. What fills an acceptance is found by its rays as well as any other surface
// is.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/path/direct_light.h"
#include "physics/rays/head_motion.h"
#include "physics/rays/replicates.h"

namespace omma {

// Below this part of what a surface gets, as radiance, a disc adds nothing: dim responses are some
// thousandths of that.
inline constexpr double least_disc_light = 1e-7;
// The same of what ommatidia aim at, of which rays find what is less.
inline constexpr double least_aimed_light = 1e-6;

// Points on a disc, for each batch: where all of the pilot's see the disc, or none, and else.
struct DiscEffort {
  int pilot = 0, plain = 0, mixed = 0;  // the pilot's are all in one
};

// `most`: a bound on what the disc adds, in units of what a surface gets; `over`: how many times
// the acceptance's solid angle the disc is, as only that part of its points counts. A half hidden
// disc that outshines all else is then off by some 0.4 %, others by less than what rays of the rest
// are.
OMMA_HD DiscEffort choose_disc_effort(double most, double over) {
  if (!(most >= least_disc_light)) return {};
  DiscEffort effort{64, 8, 512};
  if (most < 50) effort = {32, 4, 128};
  if (most < 5) effort = {16, 2, 32};
  if (most < 0.5) effort = {16, 2, 8};
  if (most < 0.003) effort = {0, 2, 2};
  for (double least = 1; least < over; least *= 2) {
    effort.pilot *= 2;
    effort.plain *= 2;
    effort.mixed *= 2;
  }
  return effort;
}

// Density of an ommatidium's rays per solid angle, at a polar angle and an azimuth from its axis.
// `scale`: EyeView::scale, by which sines of polar angles of its warp are multiplied.
OMMA_HD double eye_pdf(const AcceptanceWarpView& warp, double scale, double theta_rad,
                       double azimuth_rad) {
  if (scale == 1) return acceptance_pdf(warp, theta_rad, azimuth_rad);
  const double sine = sin(theta_rad) / scale;
  if (sine >= 1) return 0;
  const double cosine = sqrt(1 - sine * sine);
  const double unscaled_rad = atan2(sine, cos(theta_rad) < 0 ? -cosine : cosine);
  return acceptance_pdf(warp, unscaled_rad, azimuth_rad) * fabs(cos(theta_rad)) /
         (scale * scale * cosine);
}

// What a replicate (replicates.h) is when it looks at a disc: everything that stays the same over
// its points.
struct DiscTask {
  const FrameView* frame = nullptr;
  const BlockTask* task = nullptr;
  const AcceptanceWarpView* warp = nullptr;
  const DiscView* disc = nullptr;
  Replicate replicate;
  std::uint32_t hash = 0;  // of replicate and disc
};

// How much of what comes from the rim's side is darkened, of a direction at this chord^2 from the
// centre; 0 there.
OMMA_HD double disc_darkening(const DiscView& disc, double chord_2) {
  const double sine_2 = chord_2 * (1 - 0.25 * chord_2);
  const double cosine_2 = 1 - sine_2 * static_cast<double>(disc.per_sine_2);
  return 1 - sqrt(fmax(cosine_2, 0.0));
}

// A point of the unit circle, evenly, of two numbers in (0, 1).
template <typename F>
OMMA_HD DiscPoints<F> even_disc_points(const UnitPair<F>& pair) {
  const F radius = sqrt_lanes(pair.x);
  const SineCosine<F> turn = sine_cosine((2.0f * pair.y - 1.0f) * 3.14159265f);
  return {radius * turn.cosine, radius * turn.sine};
}

// A direction in a disc, `x` and `y` in the unit circle, which is mapped evenly by solid angle.
OMMA_HD Vec3 disc_direction(const DiscView& disc, float x, float y) {
  const Vec3 n = disc.direction;
  const Axes<float> axes = make_axes(vector_of(n));
  const Vector3<float>&s = axes.tangent, &t = axes.bitangent;
  const float chord_2 = (x * x + y * y) * disc.chord_2;
  const float across = sqrtf(disc.chord_2 * (1.0f - 0.25f * chord_2)),
              along = 1.0f - 0.5f * chord_2;
  return vec_of(vector_of(n) * along + (s * x + t * y) * across);
}

// Density of the replicate's rays in a world direction, where the head is turned by `turn`.
OMMA_HD double unit_pdf(const DiscTask& of, Vec3 direction, const float (&turn)[3][4]) {
  const Replicate& replicate = of.replicate;
  const float w[3] = {direction.x, direction.y, direction.z};
  double x = 0, y = 0, z = 0;
  for (int c = 0; c < 3; ++c) {
    const double d = static_cast<double>(turn[0][c] * w[0] + turn[1][c] * w[1] + turn[2][c] * w[2]);
    x += d * static_cast<double>(replicate.s[c]);
    y += d * static_cast<double>(replicate.t[c]);
    z += d * static_cast<double>(replicate.axis[c]);
  }
  const double azimuth = of.warp->azimuth == nullptr ? 0 : atan2(y, x);
  return eye_pdf(*of.warp, static_cast<double>(replicate.scale), atan2(sqrt(x * x + y * y), z),
                 azimuth);
}

// How the head is turned when sample `sample` looks, and where its centre is: as HeadMotion's
// nodes.
OMMA_HD void disc_turn(const DiscTask& of, std::uint32_t hash, int sample, float (&turn)[3][4]) {
  if (of.task->motion != nullptr) {
    head_turn<float, std::int32_t>(*of.task->motion, hash, static_cast<std::uint32_t>(sample),
                                   turn);
    return;
  }
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) turn[r][c] = r == c ? 1.0f : 0.0f;
}

// Bound on the density of the replicate's rays in the disc: where it is nearest to the axis, in its
// middle and where it is furthest, at some times of a frame that lasts.
OMMA_HD double most_unit_pdf(const DiscTask& of) {
  const Replicate& replicate = of.replicate;
  const AcceptanceWarpView& warp = *of.warp;
  const double radius_rad = 2 * asin(0.5 * sqrt(static_cast<double>(of.disc->chord_2)));
  const bool ends =
      warp.sensitivity.kernel == Kernel::gaussian || warp.sensitivity.kernel == Kernel::pillbox;
  const double scale = static_cast<double>(replicate.scale);
  // Beyond 3.5 widths a Gaussian is below 2e-15 of its peak.
  const double reach_rad =
      radius_rad + 3.5 * scale * fmax(warp.sensitivity.width_rad, warp.sensitivity.minor_width_rad);
  const int times = of.task->motion != nullptr ? 32 : 1;
  double most = 0;
  for (int k = 0; k < times; ++k) {
    float turn[3][4];
    disc_turn(of, of.hash, k, turn);
    double local[3] = {};
    const float w[3] = {of.disc->direction.x, of.disc->direction.y, of.disc->direction.z};
    for (int c = 0; c < 3; ++c) {
      const double d =
          static_cast<double>(turn[0][c] * w[0] + turn[1][c] * w[1] + turn[2][c] * w[2]);
      local[0] += d * static_cast<double>(replicate.s[c]);
      local[1] += d * static_cast<double>(replicate.t[c]);
      local[2] += d * static_cast<double>(replicate.axis[c]);
    }
    const double from_axis_2 =
        local[0] * local[0] + local[1] * local[1] + (local[2] - 1) * (local[2] - 1);
    if (ends && from_axis_2 > reach_rad * reach_rad) continue;  // a chord is shorter than its arc
    const double theta = atan2(sqrt(local[0] * local[0] + local[1] * local[1]), local[2]);
    const double azimuth = warp.azimuth == nullptr ? 0 : atan2(local[1], local[0]);
    for (const double at : {fmax(theta - radius_rad, 0.0), theta, fmin(theta + radius_rad, pi)})
      most = fmax(most, eye_pdf(warp, scale, at, azimuth));
  }
  return most;
}

// ∫ over the disc of the density of the replicate's rays, [0], and times the darkening, [1]: in
// cosines at the disc by Gauss and Legendre's rule, which limb darkening is smooth in, and in turns
// about its centre. Where S has edges in many small pieces. While the head moves a mean over times
// too.
OMMA_HD void integrate_disc(const DiscTask& of, double (&integral)[2]) {
  constexpr double node[8] = {0.0198550717512319, 0.1016667612931866, 0.2372337950418355,
                              0.4082826787521751, 0.5917173212478249, 0.7627662049581645,
                              0.8983332387068134, 0.9801449282487681};
  constexpr double weight[8] = {0.0506142681451881, 0.1111905172266872, 0.1568533229389436,
                                0.1813418916891810, 0.1813418916891810, 0.1568533229389436,
                                0.1111905172266872, 0.0506142681451881};
  const Kernel kernel = of.warp->sensitivity.kernel;
  const bool has_edges = kernel == Kernel::pillbox || kernel == Kernel::table;
  const int pieces = has_edges ? 4 : 1, turns = has_edges ? 128 : 16;
  const int times = of.task->motion != nullptr ? 16 : 1;
  const DiscView& disc = *of.disc;
  integral[0] = integral[1] = 0;
  int k = 0;
  for (int ring = 0; ring < 8 * pieces; ++ring) {
    const double cosine = (ring / 8 + node[ring % 8]) / pieces;
    const double part = weight[ring % 8] / pieces * 2 * cosine / (turns * times);
    const double radius_2 = 1 - cosine * cosine, radius = sqrt(radius_2);
    const double darkened = disc_darkening(disc, radius_2 * static_cast<double>(disc.chord_2));
    for (int j = 0; j < turns; ++j) {
      const SineCosine<float> at =
          sine_cosine(static_cast<float>((2.0 * (j + 0.5) / turns - 1) * pi));
      const Vec3 direction = disc_direction(disc, static_cast<float>(radius) * at.cosine,
                                            static_cast<float>(radius) * at.sine);
      for (int i = 0; i < times; ++i) {
        float turn[3][4];
        disc_turn(of, of.hash, k++, turn);
        const double x = part * unit_pdf(of, direction, turn);
        integral[0] += x;
        integral[1] += x * darkened;
      }
    }
  }
  for (double& x : integral) x /= static_cast<double>(disc.density);
}

// Sums over a replicate's points on a disc, [batch][band]: of all of their light, and of what
// reaches the eye; and whether some, or not all, does.
struct DiscSums {
  double *all = nullptr, *seen = nullptr;
  bool any_open = false, any_hidden = false;
};

// Points on a disc: `each` for each of some batches. Sets of other numbers are independent.
struct PointSet {
  std::uint32_t number;
  int batches, each;
};

// Shadow rays of a replicate to the points of a set on the disc.
template <typename L, typename Search>
OMMA_HD_CALLED void trace_disc(const DiscTask& of, Search& search, const BlockMemory& memory,
                               const PointSet& set, DiscSums& sums) {
  using F = typename L::F;
  using I = typename L::I;
  using U = typename L::U;
  constexpr int n = L::count;
  const SceneView& scene = *of.frame->scene;
  const Replicate& replicate = of.replicate;
  const DiscView& disc = *of.disc;
  const int bands = scene.bands, rays = set.batches * set.each;
  const bool dims = lets_through(scene);
  sums.any_open = sums.any_hidden = false;
  for (int i = 0; i < set.batches * bands; ++i) sums.all[i] = sums.seen[i] = 0;
  Packet<L> shadow;
  clear<L>(shadow.rays);
  for (int begin = 0; begin < rays; begin += n) {
    alignas(n * 4) float x[n], y[n], from_x[n], from_y[n];
    alignas(n * 4) std::int32_t hash[n], sample[n];
    float weight[n], darkened[n];
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
    LaneMask<L> asked;
    for (int l = 0; l < n; ++l) {
      const Vec3 direction = disc_direction(disc, x[l], y[l]);
      float turn[3][4];
      disc_turn(of, uint_of(hash[l]), sample[l], turn);
      weight[l] = begin + l < rays ? static_cast<float>(unit_pdf(of, direction, turn)) : 0.0f;
      darkened[l] =
          static_cast<float>(disc_darkening(disc, static_cast<double>(x[l] * x[l] + y[l] * y[l]) *
                                                      static_cast<double>(disc.chord_2)));
      if (weight[l] > 0.0f) asked.add(l);
      Vector3<float> from = replicate.origin + replicate.s * from_x[l] + replicate.t * from_y[l];
      if (of.task->motion != nullptr) from = move_point(*of.task->motion, turn, from);
      store_vector(shadow.rays.origin, l, from);
      store_vector(shadow.rays.direction, l, without_noise(vector_of(direction)));
      shadow.rays.t_near_m[l] = replicate.t_near_m;
      shadow.rays.t_far_m[l] = INFINITY;
      shadow.rays.mask[l] = of.task->sees.from_eye;
      shadow.footprint_rad[l] = 0;
    }
    if (!asked.any()) continue;
    const LaneMask<L> open =
        dims ? trace_transmittance<L>(scene, search, asked, shadow, memory.paths.shadow)
             : asked & ~search.occluded(asked, shadow.rays);
    sums.any_open = sums.any_open || open.any();
    sums.any_hidden = sums.any_hidden || !(open == asked);
    asked.for_each([&](int l) {
      const int row = (begin + l) / set.each * bands;
      const bool is_open = open.has(l);
      for (int b = 0; b < bands; ++b) {
        const float limb = disc.limb != nullptr ? disc.limb[b] : 0.0f;
        const double light = static_cast<double>(weight[l] * (1.0f - limb * darkened[l]));
        const float left = dims && is_open ? memory.paths.shadow.throughput[b * n + l] : 1.0f;
        if (left < 1.0f) sums.any_hidden = true;
        sums.all[row + b] += light;
        if (is_open) sums.seen[row + b] += light * static_cast<double>(left);
      }
    });
  }
}

// Adds what a replicate sees of a disc to `light` [band], and the square of its error to
// `variance`.
template <typename L, typename Search>
OMMA_HD void add_disc_of_replicate(const DiscTask& of, const DiscEffort& effort, Search& search,
                                   const BlockMemory& memory, double* light, double* variance) {
  const int bands = of.frame->scene->bands;
  DiscSums sums{memory.disc_all, memory.disc_seen};
  int each = effort.plain;
  if (effort.pilot > 0) {
    trace_disc<L>(of, search, memory, {1, 1, effort.pilot}, sums);
    if (sums.any_open && sums.any_hidden) each = effort.mixed;
  }
  trace_disc<L>(of, search, memory, {0, disc_batches, each}, sums);
  if (!sums.any_open) return;
  double integral[2];
  integrate_disc(of, integral);
  const DiscView& disc = *of.disc;
  for (int b = 0; b < bands; ++b) {
    const double limb = disc.limb != nullptr ? static_cast<double>(disc.limb[b]) : 0;
    const double whole = static_cast<double>(disc.radiance[b]) * (integral[0] - limb * integral[1]);
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
    variance[b] += whole * whole * squares * k / ((k - 1) * all * all);
  }
}

// Whether ommatidia of a frame sample discs; rays that neighbours share have no acceptance.
OMMA_HD bool has_discs(const FrameView& frame) {
  return frame.scene->light != nullptr && frame.scene->light->disc_count > 0 &&
         frame.directions->warps != nullptr;
}

// Adds what replicates see of discs that their rays leave out to memory.beside, and the square of
// its error to memory.beside_variance.
template <typename L, typename Search>
OMMA_HD void add_eye_discs(const FrameView& frame, const BlockTask& task, const ReplicateList& list,
                           Search& search, const BlockMemory& memory) {
  const LightView& light = *frame.scene->light;
  const DirectionsView& directions = *frame.directions;
  const int bands = frame.scene->bands;
  Replicates<L> replicates;
  make_replicates<L>(*frame.eye, task, directions, list, {true, false}, replicates);
  find_acceptances(frame, replicates, list.count);
  for (int u = 0; u < list.count; ++u) {
    const Replicate replicate = replicate_at(replicates, u);
    double *of_band = memory.disc_light, *error_2 = of_band + bands;
    bool any = false;
    for (int i = 0; i < light.disc_count; ++i) {
      const DiscView& disc = light.discs[i];
      if (counts_by_rays(disc, replicate.acceptance_sr)) continue;
      const DiscTask of{&frame,
                        &task,
                        directions.warps + replicate.warp,
                        &disc,
                        replicate,
                        mix_bits_32(replicate.hash + static_cast<std::uint32_t>(i) * 0x85ebca6bu)};
      float most = 0;
      for (int b = 0; b < bands; ++b) most = fmaxf(most, disc.radiance[b]);
      const double solid_sr = 1 / static_cast<double>(disc.density);
      const DiscEffort effort =
          choose_disc_effort(static_cast<double>(most) * solid_sr * most_unit_pdf(of),
                             solid_sr / static_cast<double>(replicate.acceptance_sr));
      if (effort.plain == 0) continue;
      if (!any)
        for (int b = 0; b < 2 * bands; ++b) of_band[b] = 0;
      any = true;
      add_disc_of_replicate<L>(of, effort, search, memory, of_band, error_2);
    }
    if (!any) continue;
    const int components = frame.scene->polarized ? 3 : 1;
    for (int o = 0; o < frame.outputs; ++o) {
      double sum = 0, squares = 0;
      if (frame.output_from_band == nullptr) {
        if (o >= bands) continue;
        sum = of_band[o], squares = error_2[o];
      } else {
        // Bands err together, as they share the rays.
        double error = 0;
        for (int b = 0; b < bands; ++b) {
          const auto weight =
              static_cast<double>(frame.output_from_band[o * bands * components + b]);
          sum += weight * of_band[b];
          error += weight * sqrt(error_2[b]);
        }
        squares = error * error;
      }
      memory.beside[o * memory.stride + u] += sum;
      memory.beside_variance[o * memory.stride + u] += squares;
    }
  }
}

}  // namespace omma
