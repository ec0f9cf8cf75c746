// Light that arrives at the eye along the paths of a packet: from afar, from surfaces that shine, past
// what lets it by. Where paths stand, and what light from their end still counts: a number for each
// band times, where light is polarised, one Mueller matrix for all bands, as lobes that polarise do so
// alike in all bands, and all others leave of a Stokes vector its I alone.
#pragma once

#include "physics/far_lanes.h"
#include "physics/lit_surface.h"
#include "physics/passed.h"
#include "physics/path_points.h"
#include "physics/vector3.h"

namespace omma {

// Most flights of a path. Roulette ends them long before, but for light that goes straight through
// more sheets than that.
inline constexpr int most_flights = 4096;

// From so many scatterings on a path may end before it leaves the scene, and it goes on with at
// most this probability.
inline constexpr int roulette_after = 3;
inline constexpr float most_survival = 0.95f;

// Below this fraction what lies behind a surface that lets light by counts for nothing.
inline constexpr float least_passing = 1e-7f;

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
  alignas(n * 4) std::int32_t scatterings[n];
  alignas(n * 4) std::int32_t flight[n];  // how many flights lie behind
  // Whether rays begin at a surface and gather what scattered light comes there: they see neither
  // discs nor what shines until they have met another surface.
  bool gathers = false;
};

// Paths that have not left yet; what is by band is in PathMemory.
template <typename L>
OMMA_HD void begin_paths(const SceneView& scene, PathState<L>& state, const PathMemory& memory) {
  constexpr int n = L::count;
  for (int i = 0; i < scene.bands * n; ++i) memory.throughput[i] = 1;
  for (int l = 0; l < n; ++l) {
    state.density[l] = INFINITY;
    state.scatterings[l] = state.flight[l] = 0;
  }
  if (!scene.polarized) return;
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < n; ++l) state.mueller[k][l] = k % 4 == 0 ? 1.0f : 0.0f;
}

// A bit for each lane of a packet for which `holds(l)`, of lanes from l on, is so.
template <typename L, typename Holds>
OMMA_HD unsigned bits_where(const Holds& holds) {
  unsigned bits = 0;
  for (int l = 0; l < L::count; l += L::width) bits |= lane_bits(holds(l)) << l;
  return bits;
}

// The pair of numbers for a choice on the present flight, of lanes from l on.
template <typename L>
OMMA_HD UnitPair<typename L::F> choose(const Packet<L>& packet, const PathState<L>& state, int l,
                                       Choice choice) {
  using U = typename L::U;
  const U first = load<U>(state.flight + l) * static_cast<std::uint32_t>(Choice::count);
  return path_pair(load<U>(packet.hash + l), load<U>(packet.sample + l),
                   first + static_cast<std::uint32_t>(choice));
}

// One node for each of a packet's places on the sky; `choice` is what asks for it.
template <typename L>
OMMA_HD void choose_nodes(const Packet<L>& packet, const PathState<L>& state, Choice choice,
                          SkyPlaces<typename L::F, typename L::I> (&places)[L::count / L::width]) {
  using U = typename L::U;
  for (int l = 0; l < L::count; l += L::width)
    choose_node(places[l / L::width],
                mix_bits_32(load<U>(packet.hash + l) + load<U>(packet.sample + l) * 0x9e3779b9u +
                            load<U>(state.flight + l) * 0x85ebca6bu +
                            (static_cast<std::uint32_t>(choice) + 1u) * 0x68bc21ebu));
}

// The reference axis of light from afar in a direction (omma/light.h).
template <typename F>
OMMA_HD Vector3<F> vertical_axis(const Vector3<F>& d) {
  const F level = d.x * d.x + d.z * d.z, one = broadcast<F>(1.0f);
  const auto is_zenith = level < 1e-14f;  // or nadir: of azimuth 0
  const F scale = 1.0f / sqrt_lanes(is_zenith ? one : level);
  return {is_zenith ? F{} : (0.0f - d.y * d.x) * scale, is_zenith ? F{} : level * scale,
          is_zenith ? (d.y > 0.0f ? one : 0.0f - one) : (0.0f - d.y * d.z) * scale};
}

// The same of a packet's directions, [lane].
template <typename L>
OMMA_HD void vertical_axes(const float (&direction)[3][L::count], float (&axis)[3][L::count]) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width)
    store_vector(axis, l, vertical_axis(load_vector<F>(direction, l)));
}

template <typename L>
OMMA_HD Mueller3<typename L::F> load_mueller(const PathState<L>& state, int l) {
  Mueller3<typename L::F> m;
  for (int k = 0; k < 9; ++k) m.m[k / 3][k % 3] = load<typename L::F>(state.mueller[k] + l);
  return m;
}

// Whether of light that arrives at a path's end more than I counts: not where a diffuse surface lies
// on it.
template <typename L>
OMMA_HD bool keeps_polarisation(const PathState<L>& state, int l) {
  for (int k = 0; k < 9; ++k)
    if (k % 3 != 0 && state.mueller[k][l] != 0.0f) return true;
  return false;
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
    const auto is_on = w != 0.0f;
    if (!any_lane(is_on)) continue;
    Mueller3<F> path{};
    bool keeps = false;
    if (scene.polarized) {
      path = load_mueller(state, l);
      for (int k = l; k < l + L::width; ++k) keeps = keeps || keeps_polarisation<L>(state, k);
      if (axis != nullptr && keeps) {
        const auto own = load_vector<F>(packet.reference, l);
        const Vector3<F> across = cross(load_vector<F>(packet.rays.direction, l), own);
        path = path * frame_turn(own, across,
                                 {load<F>(axis[0] + l), load<F>(axis[1] + l), load<F>(axis[2] + l)});
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
      if (!keeps) {
        for (int p = 0; p < 3; ++p) add(p, path.m[p][0] * s.i);
        continue;
      }
      if (axis != nullptr)
        s.q = load<F>(light + stride + at), s.u = load<F>(light + 2 * stride + at);
      s = path * s;
      add(0, s.i);
      add(1, s.q);
      add(2, s.u);
    }
  }
}

// Lanes whose path's Mueller matrix has something in one of the places for which `counts(k)` is so.
template <typename L, typename Counts>
OMMA_HD unsigned where_mueller(const PathState<L>& state, const Counts& counts) {
  return bits_where<L>([&](int l) {
    using F = typename L::F;
    F most{};
    for (int k = 0; k < 9; ++k) {
      if (!counts(k)) continue;
      const F x = load<F>(state.mueller[k] + l);
      most = most + x * x;
    }
    return most > 0.0f;
  });
}

// Lanes of whose path's light more than I counts: those without a diffuse surface on it.
template <typename L>
OMMA_HD unsigned keeping_polarisation(const PathState<L>& state) {
  return where_mueller<L>(state, [](int k) { return k % 3 != 0; });
}

// Lanes whose path brings more than I to the eye: not where the surface nearest to it is diffuse.
template <typename L>
OMMA_HD unsigned bringing_polarisation(const PathState<L>& state) {
  return where_mueller<L>(state, [](int k) { return k / 3 != 0; });
}

// Where the light from afar along the rays of some lanes is to be looked up. What lies at nodes is
// asked for from memory.
template <typename L>
struct FarPlaces {
  SkyPlaces<typename L::F, typename L::I> on_sky[L::count / L::width];
  unsigned by_chance, keeps;  // lanes whose direction was chosen; of whose light more than I counts
  bool at_nodes;              // of the sky, else between them
};

template <typename L>
OMMA_HD void find_far_places(const SceneView& scene, const Packet<L>& packet,
                             const PathState<L>& state, unsigned lanes, FarPlaces<L>& places) {
  using F = typename L::F;
  places.keeps = scene.polarized ? keeping_polarisation<L>(state) & lanes : 0;
  places.by_chance =
      lanes & bits_where<L>([&](int l) { return load<F>(state.density + l) < INFINITY; });
  places.at_nodes = places.by_chance == lanes;
  find_far_lanes<L>(*scene.light, packet.rays.direction, lanes, places.on_sky);
  if (!places.at_nodes) return;
  choose_nodes<L>(packet, state, Choice::light, places.on_sky);
  fetch_sky_nodes<L>(scene.light->sky, lanes, places.keeps, places.on_sky);
}

// Light from afar along the rays of some lanes, which met nothing, of those whose places were found.
template <typename L>
OMMA_HD void add_far(const SceneView& scene, const Packet<L>& packet, const PathState<L>& state,
                     unsigned lanes, const FarPlaces<L>& places, const PathMemory& memory,
                     float* radiance) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  const LightView& light = *scene.light;
  const float(&direction)[3][n] = packet.rays.direction;
  alignas(n * 4) float weight[n], pdf[n] = {}, axis[3][n] = {};
  const unsigned keeps = places.keeps & lanes, by_chance = places.by_chance & lanes;
  const unsigned with_discs =
      state.gathers
          ? lanes & bits_where<L>([&](int l) { return load<I>(state.scatterings + l) > 0; })
          : lanes;
  if (by_chance != 0) find_far_pdf<L>(light, direction, places.on_sky, by_chance, pdf);
  eval_sky_lanes<L>(light, direction, places.on_sky, lanes, scene.polarized ? 3 : 1, keeps,
                    places.at_nodes, memory.light);
  alignas(n * 4) float acceptance_sr[n];
  for (int l = 0; l < n; l += L::width)
    store(acceptance_sr + l, lanes_on<L>(by_chance, l) ? F{} : load<F>(packet.acceptance_sr + l));
  add_disc_light<L>(light, direction, with_discs, acceptance_sr, memory.light);
  for (int l = 0; l < n; l += L::width) {
    const F one = broadcast<F>(1.0f), density = load<F>(state.density + l);
    const F weighed = balance(density, load<F>(pdf + l));
    store(weight + l, keep(lanes_on<L>(lanes, l), lanes_on<L>(by_chance, l) ? weighed : one));
  }
  if (keeps != 0) vertical_axes<L>(direction, axis);
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
    if (state.gathers && state.scatterings[l] == 0) continue;
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

}  // namespace omma
