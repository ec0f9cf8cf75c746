// Paths of light, from the eye backwards: at each surface one light is asked directly (next-event
// estimation), and the path goes on in one direction of one of the surface's lobes. What both could
// have found is weighed by the balance heuristic (Veach 1997, chapter 9), for each lobe by itself.
// Paths end by Russian roulette. Unbiased; the reference for all faster ways.
//
// What light from a path's end still counts is a number for each band times, where light is
// polarised, one Mueller matrix for all bands: lobes that polarise do so alike in all bands, and all
// others leave of a Stokes vector its I alone.
#pragma once

#include "physics/light_sample.h"
#include "physics/lit_surface.h"
#include "physics/passed.h"
#include "physics/path_points.h"

namespace omma {

// From so many scatterings on a path may end before it leaves the scene, and it goes on with at
// most this probability.
inline constexpr int roulette_after = 3;
inline constexpr float most_survival = 0.95f;

// Most flights of a path. Roulette ends them long before, but for light that goes straight through
// more sheets than that.
inline constexpr int most_flights = 4096;

// Below this fraction what lies behind a surface that lets light by counts for nothing.
inline constexpr float least_passing = 1e-7f;

// A light that lies on a surface is not hidden by that surface: a ray to it looks this far.
inline constexpr float up_to_light = 1.0f - 1e-4f;

// Numbers that decide on the way of a path; each a pair of path_points.h for each flight.
enum class Choice : std::uint32_t { light, place_on_light, lobe_and_roulette, direction, count };

// Where the paths of a packet stand, [lane].
template <typename L>
struct PathState {
  static constexpr int n = L::count;
  // Probability per solid angle with which the ray's direction was chosen, that of its lobe
  // included; infinite for rays from the eye.
  alignas(n * 4) float density[n];
  alignas(n * 4) float mueller[9][n];  // row by row, where light is polarised
  alignas(n * 4) std::int32_t active[n];
  std::int32_t scatterings[n];
  int flight = 0;
};

// The pair of numbers for a choice on the present flight, of lanes from l on.
template <typename L>
OMMA_HD UnitPair<typename L::F> choose(const Packet<L>& packet, const PathState<L>& state, int l,
                                       Choice choice) {
  using U = typename L::U;
  const auto first =
      static_cast<std::uint32_t>(state.flight) * static_cast<std::uint32_t>(Choice::count);
  return path_pair(load<U>(packet.hash + l), load<U>(packet.sample + l),
                   first + static_cast<std::uint32_t>(choice));
}

// How light of a direction is scattered towards the eye by what was met, [lane]: scatter.h's values,
// over the density with which the direction was chosen, and weighed.
template <typename L>
struct Scattered {
  static constexpr int n = L::count;
  alignas(n * 4) float reflected[n], transmitted[n];  // of reflectance and transmittance
  alignas(n * 4) float dielectric[3][n];              // a, b, c of its Mueller matrix, of the tint
  alignas(n * 4) float metal[n];
  alignas(n * 4) float schlick[n];
  alignas(n * 4) float coat[3][n];
};

// The reference axis of light from afar in a direction (omma/light.h).
OMMA_HD Vec3 vertical_axis(Vec3 d) {
  const float level = d.x * d.x + d.z * d.z;
  if (level < 1e-14f) return {0, 0, d.y > 0 ? 1.0f : -1.0f};  // of azimuth 0
  const float scale = 1.0f / sqrtf(level);
  return {-d.y * d.x * scale, level * scale, -d.y * d.z * scale};
}

template <int n>
OMMA_HD Vec3 vec_at(const float (&values)[3][n], int l) {
  return {values[0][l], values[1][l], values[2][l]};
}

template <typename F, int n>
OMMA_HD void load_3(const float (&values)[3][n], int l, F (&out)[3]) {
  for (int r = 0; r < 3; ++r) out[r] = load<F>(values[r] + l);
}

template <typename L>
OMMA_HD Mueller3<typename L::F> load_mueller(const PathState<L>& state, int l) {
  Mueller3<typename L::F> m;
  for (int k = 0; k < 9; ++k) m.m[k / 3][k % 3] = load<typename L::F>(state.mueller[k] + l);
  return m;
}

OMMA_HD bool is_from_eye(float density) {
  return !(density < INFINITY);
}

// The balance heuristic's weight of a direction that was chosen with one density and could have been
// with another.
template <typename F>
OMMA_HD F balance(F chosen, F other) {
  const F sum = chosen + other;
  return sum > 0.0f ? chosen / sum : broadcast<F>(0.0f);
}

// Adds light that arrives along the packet's rays, `light` [component][band][lane], with a weight
// for each lane, 0 for none. Its Stokes vectors are by the axes `axis`; where that is null it is
// unpolarised, and `light` has I alone.
template <typename L>
OMMA_HD void add_light(const SceneView& scene, const Packet<L>& packet, const PathState<L>& state,
                       const float* weight, const float (*axis)[L::count],
                       const PathMemory& memory, const float* light, float* radiance) {
  using F = typename L::F;
  const int stride = scene.bands * L::count;
  for (int l = 0; l < L::count; l += L::width) {
    const F w = load<F>(weight + l);
    const auto is_on = w > 0.0f;
    if (!any_lane(is_on)) continue;
    Mueller3<F> path{};
    FrameTurn<F> turn{};
    if (scene.polarized) {
      path = load_mueller(state, l);
      if (axis != nullptr) {
        F d[3], own[3], across[3], theirs[3];
        load_3(packet.rays.direction, l, d);
        load_3(packet.reference, l, own);
        for (int r = 0; r < 3; ++r) theirs[r] = load<F>(axis[r] + l);
        cross_lanes(d, own, across);
        turn = frame_turn(own, across, theirs);
      }
    }
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * L::count + l;
      const F scale = load<F>(memory.throughput + at) * w;
      Stokes<F> s{load<F>(light + at), F{}, F{}};
      const auto add = [&](int component, F x) {
        float* sum = radiance + component * stride + at;
        store(sum, load<F>(sum) + keep(is_on, scale * x));
      };
      if (!scene.polarized) {
        add(0, s.i);
        continue;
      }
      if (axis != nullptr)
        s = turn * Stokes<F>{s.i, load<F>(light + stride + at), load<F>(light + 2 * stride + at)};
      s = path * s;
      add(0, s.i);
      add(1, s.q);
      add(2, s.u);
    }
  }
}

// Light from afar along the rays of some lanes, which met nothing.
template <typename L>
OMMA_HD void add_far(const SceneView& scene, const Packet<L>& packet, const PathState<L>& state,
                     unsigned lanes, const PathMemory& memory, float* radiance) {
  constexpr int n = L::count;
  const int components = scene.polarized ? 3 : 1;
  alignas(n * 4) float weight[n] = {}, axis[3][n] = {};
  // All are asked for before the first is read.
  SkyPlace places[n] = {};
  for (int l = 0; l < n; ++l)
    if ((lanes >> l & 1u) != 0)
      places[l] = find_far(*scene.light, vec_at(packet.rays.direction, l));
  for (int l = 0; l < n; ++l) {
    if ((lanes >> l & 1u) == 0) continue;
    const Vec3 d = vec_at(packet.rays.direction, l);
    eval_far(*scene.light, d, places[l], components, memory.light + l, n, scene.bands * n);
    const float density = state.density[l];
    weight[l] =
        is_from_eye(density) ? 1.0f : balance(density, escaped_light_pdf(scene, d, places[l]));
    if (!scene.polarized) continue;
    const Vec3 up = vertical_axis(d);
    axis[0][l] = up.x, axis[1][l] = up.y, axis[2][l] = up.z;
  }
  add_light<L>(scene, packet, state, weight, axis, memory, memory.light, radiance);
}

// What surfaces that were met shine with themselves.
template <typename L>
OMMA_HD void add_emission(const SceneView& scene, const Packet<L>& packet, const Hits<L>& hits,
                          const LitSurface<L>& surface, const PathState<L>& state, unsigned lanes,
                          const PathMemory& memory, float* radiance) {
  constexpr int n = L::count;
  alignas(n * 4) float weight[n] = {};
  bool any = false;
  for (int l = 0; l < n; ++l) {
    if ((lanes >> l & 1u) == 0 || scene.scatter[surface.material[l]].emission == nullptr) continue;
    weight[l] = surface.alpha[l];
    if (!is_from_eye(state.density[l]))
      weight[l] *= balance(
          state.density[l],
          met_light_pdf(scene, hits.instance[l], int_of(packet.rays.triangle[l]),
                        vec_at(packet.rays.origin, l), vec_at(packet.rays.direction, l),
                        packet.rays.t_far_m[l]));
    any = true;
  }
  if (any) add_light<L>(scene, packet, state, weight, nullptr, memory, memory.emission, radiance);
}

// Straight on through a part of a surface: what is left, [band][lane], of light from behind, where
// it covers little or is glass.
template <typename F>
OMMA_HD F passing(F alpha, F straight, F reflectance) {
  return (1.0f - alpha) + alpha * straight * reflectance;
}

// Shadow rays past surfaces that let light straight through: what is left of it is the throughput.
// Returns the lanes that reach their light.
template <typename L, typename Search>
OMMA_HD unsigned dim_by_passing(const SceneView& scene, Search& search, unsigned lanes,
                                Packet<L>& shadow, const SpectraMemory& memory) {
  using F = typename L::F;
  PassedSurfaces<L::count> passed;
  alignas(L::count * 4) std::int32_t active[L::count];
  alignas(L::count * 4) float t_far_m[L::count];
  for (int l = 0; l < L::count; ++l) {
    active[l] = (lanes >> l & 1u) != 0 ? -1 : 0;
    t_far_m[l] = shadow.rays.t_far_m[l];
  }
  float* const dimmed = memory.throughput;
  for (int i = 0; i < scene.bands * L::count; ++i) dimmed[i] = 1;
  unsigned left = lanes, reached = 0;
  for (int flight = 0; left != 0 && flight < most_flights; ++flight) {
    clear_hits<L>(shadow.rays);
    for (int l = 0; l < L::count; ++l) shadow.rays.t_far_m[l] = t_far_m[l];
    search.closest(active, shadow.rays, &passed, Spread::scattered);
    Hits<L> hits;
    find_hits<L>(search.placed(), shadow, hits);
    HitGeometry<L> geometry;
    eval_geometry<L>(scene, shadow.rays, hits, geometry);
    LitSurface<L> surface;
    eval_lit_surfaces<L>(scene, shadow, hits, geometry, memory, surface);
    for (int l = 0; l < L::count; l += L::width) {
      const auto point = make_scatter_point(scatter_surface<L>(scene, shadow.rays, surface, l));
      F most{};
      for (int b = 0; b < scene.bands; ++b) {
        float* const at = dimmed + b * L::count + l;
        const F part = passing(load<F>(surface.alpha + l), point.straight,
                               load<F>(memory.reflectance + b * L::count + l));
        const auto is_met = load<typename L::I>(surface.material + l) >= 0 &&
                            load<typename L::I>(active + l) != 0;
        const F after = is_met ? load<F>(at) * part : load<F>(at);
        store(at, after);
        most = after > most ? after : most;
      }
      const unsigned bright = lane_bits(most > least_passing) << l;
      for (int k = l; k < l + L::width; ++k) {
        if (active[k] == 0) continue;
        if (surface.material[k] < 0) {
          active[k] = 0;
          reached |= 1u << k;
        } else if ((bright >> k & 1u) == 0) {
          active[k] = 0;
        } else {
          pass(passed, k, shadow.rays);
        }
      }
    }
    left = packet_bits<L>(active);
  }
  return reached;
}

// Scatters `light` [component][band][lane], which comes from direction `w` [lane] with Stokes
// vectors by `axis`, towards the eye, in place: by the rays' own reference axes.
template <typename L>
OMMA_HD void scatter_light(const SceneView& scene, const Packet<L>& packet,
                           const Scattered<L>& by, const float (&w)[3][L::count],
                           const float (&axis)[3][L::count], const PathMemory& memory,
                           float* light) {
  using F = typename L::F;
  const int stride = scene.bands * L::count;
  for (int l = 0; l < L::count; l += L::width) {
    const F reflected = load<F>(by.reflected + l), transmitted = load<F>(by.transmitted + l);
    const F metal = load<F>(by.metal + l), schlick = load<F>(by.schlick + l);
    Mueller<F> dielectric{load<F>(by.dielectric[0] + l), F{}, F{}};
    Mueller<F> coat{load<F>(by.coat[0] + l), F{}, F{}};
    FrameTurn<F> before{}, after{};
    if (scene.polarized) {
      dielectric.b = load<F>(by.dielectric[1] + l);
      dielectric.c = load<F>(by.dielectric[2] + l);
      coat.b = load<F>(by.coat[1] + l);
      coat.c = load<F>(by.coat[2] + l);
      F d[3], from[3], own[3], across[3], theirs[3], s[3];
      load_3(packet.rays.direction, l, d);
      load_3(w, l, from);
      load_3(packet.reference, l, own);
      load_3(axis, l, theirs);
      reflection_axis(d, from, own, s);
      // From the light's axes to s, and from s to the ray's.
      cross_lanes(from, s, across);
      before = frame_turn(s, across, theirs);
      cross_lanes(d, own, across);
      after = frame_turn(own, across, s);
    }
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * L::count + l;
      const F reflectance = load<F>(memory.reflectance + at), tint = load<F>(memory.tint + at);
      const F colour = tint + (1.0f - tint) * schlick;
      const F of_metal = metal * (reflectance + (1.0f - reflectance) * schlick);
      const F diffuse =
          reflected * reflectance + transmitted * load<F>(memory.transmittance + at);
      const F i = load<F>(light + at);
      if (!scene.polarized) {
        store(light + at, (diffuse + dielectric.a * colour + coat.a + of_metal) * i);
        continue;
      }
      const Stokes<F> s =
          before * Stokes<F>{i, load<F>(light + stride + at), load<F>(light + 2 * stride + at)};
      const Mueller<F> all{dielectric.a * colour + coat.a + of_metal,
                           dielectric.b * colour + coat.b,
                           dielectric.c * colour + coat.c - of_metal};
      const Stokes<F> out = after * (all * s);
      store(light + at, out.i + diffuse * i);
      store(light + stride + at, out.q);
      store(light + 2 * stride + at, out.u);
    }
  }
}

// In place of a lobe: none, where a path ends, and past the surface, which let the light by.
inline constexpr std::int32_t no_lobe = -1, let_by = -2;

// The way on of the packet's paths, [lane].
template <typename L>
struct Onward {
  static constexpr int n = L::count;
  alignas(n * 4) float direction[3][n];
  alignas(n * 4) float density[n];   // 0 where the path ends
  alignas(n * 4) float roulette[n];  // a number in (0, 1)
  alignas(n * 4) std::int32_t lobe[n];
  Scattered<L> by;  // of the lobe that was chosen alone, over the density
};

// What the surfaces that were met make of one light sample and where their paths go on.
template <typename L>
OMMA_HD void scatter_packet(const SceneView& scene, const Packet<L>& packet,
                            const LitSurface<L>& surface, const PathState<L>& state,
                            const PathMemory& memory, const float (&to_light)[3][L::count],
                            const float* light_density, const float* is_delta,
                            Scattered<L>& direct, Onward<L>& onward) {
  using F = typename L::F;
  using I = typename L::I;
  for (int l = 0; l < L::count; l += L::width) {
    const auto point = make_scatter_point(scatter_surface<L>(scene, packet.rays, surface, l));

    // Which lobe, by what all bands get of it.
    LobeColors<F> colors{};
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * L::count + l;
      colors.reflectance = colors.reflectance + load<F>(memory.reflectance + at);
      colors.transmittance = colors.transmittance + load<F>(memory.transmittance + at);
    }
    const float each = 1.0f / static_cast<float>(scene.bands);
    colors.reflectance = colors.reflectance * each;
    colors.transmittance = colors.transmittance * each;
    colors.metal = colors.straight = colors.reflectance;
    F weight[lobe_count];
    lobe_weights(point, colors, weight);
    const auto pair = choose<L>(packet, state, l, Choice::lobe_and_roulette);
    store(onward.roulette + l, pair.y);
    const LobeChoice<F> chosen = choose_lobe(weight, pair.x);

    // The light sample: each lobe by itself, as the path may find the same light by that lobe.
    F w[3];
    load_3(to_light, l, w);
    const ScatterValue<F> seen = eval_scatter(point, w);
    const F density = load<F>(light_density + l);
    const F over = 1.0f / (density > 0.0f ? density : broadcast<F>(1.0f));
    const auto delta = load<F>(is_delta + l) > 0.0f;
    const auto weighed = [&](int lobe, F pdf) {
      const F found = weight[lobe] * pdf;
      return over * (delta ? broadcast<F>(1.0f) : balance(density, found));
    };
    const F by_dielectric = weighed(2, seen.boundary_pdf), by_coat = weighed(5, seen.coat_pdf);
    store(direct.reflected + l,
          seen.diffuse_reflection * weighed(0, cosine_pdf(seen.cosine)));
    store(direct.transmitted + l,
          seen.diffuse_transmission * weighed(1, cosine_pdf(0.0f - seen.cosine)));
    store(direct.dielectric[0] + l, seen.dielectric.a * by_dielectric);
    store(direct.dielectric[1] + l, seen.dielectric.b * by_dielectric);
    store(direct.dielectric[2] + l, seen.dielectric.c * by_dielectric);
    store(direct.metal + l, seen.metal * weighed(3, seen.boundary_pdf));
    store(direct.schlick + l, seen.schlick);
    store(direct.coat[0] + l, seen.coat.a * by_coat);
    store(direct.coat[1] + l, seen.coat.b * by_coat);
    store(direct.coat[2] + l, seen.coat.c * by_coat);

    // The way on.
    const auto place = choose<L>(packet, state, l, Choice::direction);
    sample_scatter(chosen.lobe, point, place.x, place.y, w);
    const ScatterValue<F> found = eval_scatter(point, w);
    const F own = chosen.probability * pdf_scatter(chosen.lobe, found);
    const auto is = [&](Lobe one) { return chosen.lobe == static_cast<std::int32_t>(one); };
    const auto is_straight = is(Lobe::straight);
    const F inverse = keep(own > 0.0f, 1.0f / (own > 0.0f ? own : broadcast<F>(1.0f)));
    const auto of_lobe = [&](Lobe one, F x) { return keep(is(one), x * inverse); };
    store(onward.by.reflected + l, of_lobe(Lobe::diffuse_reflection, found.diffuse_reflection));
    store(onward.by.transmitted + l,
          of_lobe(Lobe::diffuse_transmission, found.diffuse_transmission));
    store(onward.by.dielectric[0] + l, of_lobe(Lobe::dielectric, found.dielectric.a));
    store(onward.by.dielectric[1] + l, of_lobe(Lobe::dielectric, found.dielectric.b));
    store(onward.by.dielectric[2] + l, of_lobe(Lobe::dielectric, found.dielectric.c));
    store(onward.by.metal + l, of_lobe(Lobe::metal, found.metal));
    store(onward.by.schlick + l, found.schlick);
    store(onward.by.coat[0] + l, of_lobe(Lobe::coat, found.coat.a));
    store(onward.by.coat[1] + l, of_lobe(Lobe::coat, found.coat.b));
    store(onward.by.coat[2] + l, of_lobe(Lobe::coat, found.coat.c));
    for (int r = 0; r < 3; ++r) store(onward.direction[r] + l, without_noise(w[r]));
    // Light that goes straight on was chosen as before: what reflects it is by `reflected`.
    const F straight = point.straight / (chosen.probability > 0.0f ? chosen.probability
                                                                   : broadcast<F>(1.0f));
    const F reflected = load<F>(onward.by.reflected + l);
    store(onward.by.reflected + l, is_straight ? straight : reflected);
    store(onward.density + l, is_straight ? load<F>(state.density + l) : own);
    const I lobe = chosen.lobe;
    store(onward.lobe + l, chosen.probability > 0.0f ? lobe : lobe * 0 + no_lobe);
  }
}

// Throughput and Mueller matrices lengthened by the way on; `most` [lane]: the largest throughput.
template <typename L>
OMMA_HD void lengthen(const SceneView& scene, Packet<L>& packet, const Onward<L>& onward,
                      PathState<L>& state, const PathMemory& memory, float* most) {
  using F = typename L::F;
  using I = typename L::I;
  for (int l = 0; l < L::count; l += L::width) {
    const Scattered<L>& by = onward.by;
    const F reflected = load<F>(by.reflected + l), transmitted = load<F>(by.transmitted + l);
    const F metal = load<F>(by.metal + l), schlick = load<F>(by.schlick + l);
    const F dielectric = load<F>(by.dielectric[0] + l), coat = load<F>(by.coat[0] + l);
    const I lobe = load<I>(onward.lobe + l);
    const auto is_by = lobe == let_by;
    F largest{};
    for (int b = 0; b < scene.bands; ++b) {
      const int at = b * L::count + l;
      const F reflectance = load<F>(memory.reflectance + at), tint = load<F>(memory.tint + at);
      const F part = reflected * reflectance + transmitted * load<F>(memory.transmittance + at) +
                     dielectric * (tint + (1.0f - tint) * schlick) + coat +
                     metal * (reflectance + (1.0f - reflectance) * schlick);
      const F before = load<F>(memory.throughput + at);
      const F after = is_by ? before : before * part;
      store(memory.throughput + at, after);
      largest = after > largest ? after : largest;
    }
    store(most + l, largest);
    if (!scene.polarized) continue;

    const auto is = [&](Lobe one) { return lobe == static_cast<std::int32_t>(one); };
    F d[3], w[3], own[3], across[3], s[3];
    load_3(packet.rays.direction, l, d);
    load_3(onward.direction, l, w);
    load_3(packet.reference, l, own);
    reflection_axis(d, w, own, s);
    cross_lanes(d, own, across);
    // As parts of what is reflected, which the throughput has.
    const auto is_coat = is(Lobe::coat);
    const auto is_metal = is(Lobe::metal);
    const F a = is_coat ? coat : dielectric;
    const F scale = 1.0f / (a > 0.0f ? a : broadcast<F>(1.0f));
    const F b = (is_coat ? load<F>(by.coat[1] + l) : load<F>(by.dielectric[1] + l)) * scale;
    const F c = (is_coat ? load<F>(by.coat[2] + l) : load<F>(by.dielectric[2] + l)) * scale;
    const F one = broadcast<F>(1.0f);
    const Mueller<F> mirror{one, is_metal ? F{} : b, is_metal ? 0.0f - one : c};
    const Mueller3<F> before = load_mueller(state, l);
    const Mueller3<F> mirrored = before * frame_turn(own, across, s) * mirror;
    const Mueller3<F> diffuse = depolarized(before);
    const auto is_mirrored = is_coat || is_metal || is(Lobe::dielectric);
    const auto is_straight = is(Lobe::straight) || is_by;
    for (int k = 0; k < 9; ++k) {
      const int r = k / 3, q = k % 3;
      const F scattered = is_mirrored ? mirrored.m[r][q] : diffuse.m[r][q];
      store(state.mueller[k] + l, is_straight ? before.m[r][q] : scattered);
    }
    // Any axis across the new ray will do for what was depolarised.
    F any_axis[3], other[3];
    make_axes(w, any_axis, other);
    for (int r = 0; r < 3; ++r) {
      const F next = is_mirrored ? s[r] : any_axis[r];
      store(packet.reference[r] + l, is_straight ? own[r] : next);
    }
  }
}

// Radiance [component][band][lane] of the rays of a packet, where `valid` [lane] is not 0.
template <typename L, typename Search>
OMMA_HD void eval_lit_path(const SceneView& scene, Search& search, const std::int32_t* valid,
                           Packet<L>& packet, const PathMemory& memory, float* radiance) {
  using I = typename L::I;
  constexpr int n = L::count;
  const int components = scene.polarized ? 3 : 1, stride = scene.bands * n;
  const bool lets_through = scene.has_blend || scene.has_glass;
  // Whether the last flight of a path can only find light from afar.
  const bool is_dark = !lets_through && scene.light->emissive_count == 0;
  PathState<L> state;
  PassedSurfaces<n> passed;
  for (int i = 0; i < components * stride; ++i) radiance[i] = 0;
  for (int i = 0; i < stride; ++i) memory.throughput[i] = 1;
  for (int l = 0; l < n; ++l) {
    state.density[l] = INFINITY;
    state.active[l] = valid[l];
    state.scatterings[l] = 0;
    for (int k = 0; k < 9; ++k) state.mueller[k][l] = k % 4 == 0 ? 1.0f : 0.0f;
  }
  unsigned on = packet_bits<L>(state.active);
  for (; on != 0 && state.flight < most_flights; ++state.flight) {
    // What the rays meet, and where they meet nothing the sky.
    Hits<L> hits;
    clear_hits<L>(packet.rays);
    const Spread spread = state.flight == 0 ? Spread::together : Spread::scattered;
    if (is_dark && scene.depth > 0 && state.flight == scene.depth) {
      const unsigned met = search.occluded(state.active, packet.rays, spread);
      return add_far<L>(scene, packet, state, on & ~met, memory, radiance);
    }
    search.closest(state.active, packet.rays, lets_through ? &passed : nullptr, spread);
    find_hits<L>(search.placed(), packet, hits);
    unsigned met = 0;
    for (int l = 0; l < n; l += L::width) met |= lane_bits(load<I>(hits.mesh + l) >= 0) << l;
    met &= on;
    if ((on & ~met) != 0) add_far<L>(scene, packet, state, on & ~met, memory, radiance);
    for (int l = 0; l < n; ++l)
      if ((met >> l & 1u) == 0) hits.mesh[l] = -1;
    if (met == 0) return;

    HitGeometry<L> geometry;
    LitSurface<L> surface;
    eval_geometry<L>(scene, packet.rays, hits, geometry);
    eval_lit_surfaces<L>(scene, packet, hits, geometry, memory, surface);
    add_emission<L>(scene, packet, hits, surface, state, met, memory, radiance);

    // Light that a surface lets by; and the end of paths that have been scattered often enough.
    unsigned by = 0;
    on = met;
    for (int l = 0; l < n; ++l) {
      if ((met >> l & 1u) == 0) continue;
      if (scene.has_blend && surface.alpha[l] < 1.0f &&
          open_unit(mix_bits_32(uint_of(packet.hash[l]) + uint_of(packet.sample[l]) * 0x9e3779b9u +
                                static_cast<std::uint32_t>(state.flight) * 0x85ebca6bu)) >=
              surface.alpha[l])
        by |= 1u << l;
      else if (scene.depth > 0 && state.scatterings[l] >= scene.depth)
        on &= ~(1u << l);
    }
    const unsigned scattering = on & ~by;

    // A light for each, sampled.
    LightSample lights[n];
    alignas(n * 4) float to_light[3][n], light_density[n], is_delta[n];
    alignas(n * 4) float which[n], place_x[n], place_y[n];
    for (int l = 0; l < n; l += L::width) {
      store(which + l, choose<L>(packet, state, l, Choice::light).x);
      const auto place = choose<L>(packet, state, l, Choice::place_on_light);
      store(place_x + l, place.x);
      store(place_y + l, place.y);
    }
    for (int l = 0; l < n; ++l) {
      lights[l] = {};
      if ((scattering >> l & 1u) != 0)
        lights[l] = sample_light(scene, vec_at(geometry.position, l), which[l], place_x[l],
                                 place_y[l]);
      to_light[0][l] = lights[l].direction.x;
      to_light[1][l] = lights[l].direction.y;
      to_light[2][l] = lights[l].direction.z;
      light_density[l] = lights[l].pdf;
      is_delta[l] = lights[l].is_delta ? 1.0f : 0.0f;
    }
    Scattered<L> direct;
    Onward<L> onward;
    scatter_packet<L>(scene, packet, surface, state, memory, to_light, light_density, is_delta,
                      direct, onward);

    // Shadow rays to those from which light would come to the eye.
    Packet<L> shadow;
    clear<L>(shadow.rays);
    alignas(n * 4) std::int32_t asked[n];
    unsigned open = 0;
    for (int l = 0; l < n; ++l) {
      const bool is_seen = direct.reflected[l] > 0 || direct.transmitted[l] > 0 ||
                           direct.dielectric[0][l] > 0 || direct.metal[l] > 0 ||
                           direct.coat[0][l] > 0;
      asked[l] = (scattering >> l & 1u) != 0 && lights[l].pdf > 0 && is_seen ? -1 : 0;
      if (asked[l] != 0) open |= 1u << l;
      const float at[3] = {geometry.position[0][l], geometry.position[1][l],
                           geometry.position[2][l]};
      const float normal[3] = {geometry.normal[0][l], geometry.normal[1][l],
                               geometry.normal[2][l]};
      const float towards[3] = {to_light[0][l], to_light[1][l], to_light[2][l]};
      float from[3];
      leave_surface(at, normal, geometry.reach_m[l], towards, from);
      for (int r = 0; r < 3; ++r) {
        shadow.rays.origin[r][l] = from[r];
        shadow.rays.direction[r][l] = without_noise(towards[r]);
      }
      shadow.rays.t_near_m[l] = 0;
      shadow.rays.t_far_m[l] = lights[l].distance_m * up_to_light;
      shadow.footprint_rad[l] = 0;
    }
    if (open != 0)
      open = lets_through ? dim_by_passing<L>(scene, search, open, shadow, memory.shadow)
                          : open & ~search.occluded(asked, shadow.rays, Spread::scattered);
    if (open != 0) {
      alignas(n * 4) float weight[n] = {}, axis[3][n];
      for (int i = 0; i < components * stride; ++i) memory.light[i] = 0;
      for (int l = 0; l < n; ++l) {
        const Vec3 up = vertical_axis(lights[l].direction);
        axis[0][l] = up.x, axis[1][l] = up.y, axis[2][l] = up.z;
        if ((open >> l & 1u) == 0) continue;
        weight[l] = 1;
        eval_light_sample(scene, lights[l], components, memory.light + l, n, stride);
      }
      if (lets_through)
        for (int c = 0; c < components; ++c)
          for (int i = 0; i < stride; ++i)
            memory.light[c * stride + i] *= memory.shadow.throughput[i];
      scatter_light<L>(scene, packet, direct, to_light, axis, memory, memory.light);
      // Scattered, it is by the rays' own axes.
      add_light<L>(scene, packet, state, weight, packet.reference, memory, memory.light, radiance);
    }

    // On: past what was let by, or as scattered.
    alignas(n * 4) float most[n];
    for (int l = 0; l < n; ++l)
      if ((by >> l & 1u) != 0) onward.lobe[l] = let_by;
    lengthen<L>(scene, packet, onward, state, memory, most);
    for (int l = 0; l < n; ++l) {
      const unsigned bit = 1u << l;
      if ((on & bit) == 0) continue;
      if (onward.lobe[l] == let_by) {
        pass(passed, l, packet.rays);
        continue;
      }
      if (onward.lobe[l] == no_lobe || !(most[l] > 0) || !(onward.density[l] > 0)) {
        on &= ~bit;
        continue;
      }
      if (onward.lobe[l] == static_cast<std::int32_t>(Lobe::straight)) {
        pass(passed, l, packet.rays);
        continue;
      }
      if (++state.scatterings[l] > roulette_after) {
        const float survival = fminf(most[l], most_survival);
        if (onward.roulette[l] >= survival) {
          on &= ~bit;
          continue;
        }
        const float scale = 1.0f / survival;
        for (int b = 0; b < scene.bands; ++b) memory.throughput[b * n + l] *= scale;
      }
      state.density[l] = onward.density[l];
      const float at[3] = {geometry.position[0][l], geometry.position[1][l],
                           geometry.position[2][l]};
      const float normal[3] = {geometry.normal[0][l], geometry.normal[1][l],
                               geometry.normal[2][l]};
      const float towards[3] = {onward.direction[0][l], onward.direction[1][l],
                                onward.direction[2][l]};
      float from[3];
      leave_surface(at, normal, geometry.reach_m[l], towards, from);
      for (int r = 0; r < 3; ++r) {
        packet.rays.origin[r][l] = from[r];
        packet.rays.direction[r][l] = towards[r];
      }
      packet.rays.t_near_m[l] = 0;
      packet.footprint_rad[l] = 0;
      passed.count[l] = 0;
    }
    for (int l = 0; l < n; ++l) state.active[l] = (on >> l & 1u) != 0 ? -1 : 0;
  }
}

}  // namespace omma
