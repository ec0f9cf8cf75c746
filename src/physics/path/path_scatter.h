// What the surfaces that a packet met make of light: of a sample of a light, which they scatter
// towards the eye, and of the path itself, which goes on in one direction of one of their lobes.
// The two are weighed against each other, each lobe by itself (direct_light.h).
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/path/path_light.h"
#include "physics/path/polarized_paths.h"
#include "physics/path/refraction.h"
#include "physics/path/scattered.h"

namespace omma {

// Scatters `light` [component][band][lane], which comes from directions `w` [lane] with Stokes
// vectors by vertical axes, towards the eye, in place: by the rays' own reference axes.
template <typename L, typename Search>
OMMA_HD_CALLED void scatter_light(const Flight<L, Search>& flight,
                                  const ScatteringPacket<L>& points, const Scattered<L>& by,
                                  const float (&w)[3][L::count], float* light) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  for (int l = 0; l < L::count; l += L::width) {
    const LobeValues<F> lobes = load_lobes(by, l);
    with_metal_lobe(scene, points.boundary, by, l, [&](const auto& metal_in) {
      if (scene.polarized) {
        scatter_polarized_light(flight, points, by, {w, l}, metal_in, light);
        return;
      }
      for (int b = 0; b < scene.bands; ++b) {
        const int at = b * L::count + l;
        const BandColor<F> color = load_color<L>(flight.memory, at);
        const F metal = metal_in(lobes, color, b).a;
        store(light + at, all_lobes(lobes, color, metal) * load<F>(light + at));
      }
    });
  }
}

// What glass and water mirror may be a sky, and what lies behind them dark. At the first surface
// that a ray from the eye meets, what is mirrored has at least this share of the rays that go one
// way or the other.
inline constexpr float least_mirrored = 0.25f;

template <typename L>
OMMA_HD void raise_mirrored(const PathState<L>& state, int l, typename L::F (&weight)[lobe_count]) {
  using F = typename L::F;
  F& mirrored = weight[static_cast<int>(Lobe::dielectric)];
  F& straight = weight[static_cast<int>(Lobe::straight)];
  const F both = mirrored + straight, least = both * least_mirrored;
  const auto is_raised =
      load<typename L::I>(state.flight + l) == 0 && mirrored > 0.0f && mirrored < least;
  mirrored = is_raised ? least : mirrored;
  straight = is_raised ? both - least : straight;
}

template <typename L, typename Search>
OMMA_HD_CALLED void make_scattering(const Flight<L, Search>& flight, const LitSurface<L>& surface,
                                    LaneMask<L> reads_baked, ScatteringPacket<L>& scattering) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  scattering.samples_all = scene.all_lights != nullptr ? ~reads_baked : LaneMask<L>{};
  scattering.bends = {};
  for (int l = 0; l < L::count; l += L::width) {
    const int v = l / L::width;
    ScatterPoint<F>& point = scattering.point[v];
    point = make_scatter_point(scatter_surface<L>(scene, flight.packet.rays, surface, l));
    if (scene.has_volumes) make_boundary_point(flight, surface, l, scattering);
    if (scene.polarized) polarize_diffuse(flight.packet, l, scattering);
    const auto table = boundary_of(scene, surface, l);
    store(scattering.boundary + l, table);
    // By what all bands get of each lobe.
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
    const auto has_table = table >= 0;
    if (any_lane(has_table)) {
      const BoundaryPlace<F> at = find_boundary(scene.bands, table, F{});
      F mean{};
      for (int b = 0; b < scene.bands; ++b) mean = mean + boundary_mean(scene.boundaries, at, b);
      colors.metal = has_table ? mean * each : colors.metal;
    }
    // What diffuse lobes send is in the baked light where that is read.
    const auto reads = reads_baked.at(l);
    colors.reflectance = reads ? F{} : colors.reflectance;
    colors.transmittance = reads ? F{} : colors.transmittance;
    lobe_weights(point, colors, scattering.weight[v]);
    if (scene.has_glass && !flight.state.gathers)
      raise_mirrored(flight.state, l, scattering.weight[v]);
  }
}

// How the surfaces scatter a sample of light for each lane: f_j cos θ w_j / p of each lobe j, w_j
// by the heuristic for p and q_j p_j, or 1 where is_delta; `near`: lanes whose light is not from
// afar.
template <typename L>
OMMA_HD_CALLED void scatter_light_samples(const ScatteringPacket<L>& scattering,
                                          const float (&to_light)[3][L::count],
                                          const float* light_density, const float* is_delta,
                                          LaneMask<L> near, Scattered<L>& direct) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const int v = l / L::width;
    const F(&weight)[lobe_count] = scattering.weight[v];
    const auto w = load_vector<F>(to_light, l);
    const ScatterValue<F> seen = eval_scatter(scattering.point[v], w);
    const F density = load<F>(light_density + l);
    const F over = 1.0f / (density > 0.0f ? density : broadcast<F>(1.0f));
    const auto delta = load<F>(is_delta + l) > 0.0f, is_near = near.at(l);
    // Each lobe by itself, as the path may find the same light by that lobe.
    const auto weighed = [&](Lobe lobe, F pdf) {
      const F found = weight[static_cast<int>(lobe)] * pdf;
      F share = balance(density, found);
      if (near.any()) share = is_near ? power_heuristic(density, found) : share;
      return over * (delta ? broadcast<F>(1.0f) : share);
    };
    const F by_dielectric = weighed(Lobe::dielectric, seen.boundary_pdf);
    const F by_metal = weighed(Lobe::metal, seen.boundary_pdf);
    const F by_coat = weighed(Lobe::coat, seen.coat_pdf);
    store(direct.reflected + l,
          seen.diffuse_reflection * weighed(Lobe::diffuse_reflection, cosine_pdf(seen.cosine)));
    store(direct.transmitted + l,
          seen.diffuse_transmission *
              weighed(Lobe::diffuse_transmission, cosine_pdf(0.0f - seen.cosine)));
    store(direct.dielectric[0] + l, seen.dielectric.a * by_dielectric);
    store(direct.dielectric[1] + l, seen.dielectric.b * by_dielectric);
    store(direct.dielectric[2] + l, seen.dielectric.c * by_dielectric);
    store(direct.metal + l, seen.metal * by_metal);
    store(direct.metal_gain + l, scattering.point[v].metal_gain);
    store(direct.half_cosine + l, seen.half_cosine);
    store(direct.coat[0] + l, seen.coat.a * by_coat);
    store(direct.coat[1] + l, seen.coat.b * by_coat);
    store(direct.coat[2] + l, seen.coat.c * by_coat);
  }
}

// Where the paths of some lanes go on: a lobe j by its probability q_j, a direction of it by its
// density p_j, and what the throughput is multiplied by, f_j cos θ / (q_j p_j).
template <typename L>
OMMA_HD_CALLED void sample_scattering(const Packet<L>& packet, const PathState<L>& state,
                                      const ScatteringPacket<L>& scattering, LaneMask<L> lanes,
                                      ScatteringSample<L>& sample) {
  using F = typename L::F;
  sample.samples_all = scattering.samples_all;
  for (int l = 0; l < L::count; l += L::width) {
    const int v = l / L::width;
    const ScatterPoint<F>& point = scattering.point[v];
    const auto pair = choose<L>(packet, state, l, Choice::lobe_and_roulette);
    const auto place = choose<L>(packet, state, l, Choice::direction);
    const LobeChoice<F> chosen = choose_lobe(scattering.weight[v], pair.x);
    const Vector3<F> w = sample_scatter(chosen.lobe, point, place.x, place.y);
    const ScatterValue<F> found = eval_scatter(point, w);
    const F own = chosen.probability * pdf_scatter(chosen.lobe, found);
    const auto is = [&](Lobe one) { return chosen.lobe == static_cast<std::int32_t>(one); };
    const auto is_straight = is(Lobe::straight);
    const F inverse = keep(own > 0.0f, 1.0f / (own > 0.0f ? own : broadcast<F>(1.0f)));
    const auto of_lobe = [&](Lobe one, F x) { return keep(is(one), x * inverse); };
    // Light that goes straight on was chosen as before: what reflects it is by `reflected`.
    const F straight =
        point.straight / (chosen.probability > 0.0f ? chosen.probability : broadcast<F>(1.0f));
    store(sample.by.reflected + l,
          is_straight ? straight : of_lobe(Lobe::diffuse_reflection, found.diffuse_reflection));
    store(sample.by.transmitted + l,
          of_lobe(Lobe::diffuse_transmission, found.diffuse_transmission));
    store(sample.by.dielectric[0] + l, of_lobe(Lobe::dielectric, found.dielectric.a));
    store(sample.by.dielectric[1] + l, of_lobe(Lobe::dielectric, found.dielectric.b));
    store(sample.by.dielectric[2] + l, of_lobe(Lobe::dielectric, found.dielectric.c));
    store(sample.by.metal + l, of_lobe(Lobe::metal, found.metal));
    store(sample.by.metal_gain + l, point.metal_gain);
    store(sample.by.half_cosine + l, found.half_cosine);
    store(sample.by.coat[0] + l, of_lobe(Lobe::coat, found.coat.a));
    store(sample.by.coat[1] + l, of_lobe(Lobe::coat, found.coat.b));
    store(sample.by.coat[2] + l, of_lobe(Lobe::coat, found.coat.c));
    store_vector(sample.direction, l, without_noise(w));
    store(sample.roulette + l, pair.y);
    store(sample.density + l, is_straight ? load<F>(state.density + l) : own);
    const auto goes_on = lanes.at(l) && chosen.probability > 0.0f;
    store(sample.lobe + l, goes_on ? chosen.lobe : chosen.lobe * 0 + no_lobe);
  }
}

// Throughput, and Mueller matrices, of paths that have gone on by a sample; `most` [lane]: the
// largest throughput of a path's bands.
template <typename L, typename Search>
OMMA_HD void update_throughput(const Flight<L, Search>& flight, const ScatteringPacket<L>& points,
                               const ScatteringSample<L>& sample, float* most) {
  using F = typename L::F;
  using I = typename L::I;
  const SceneView& scene = flight.scene;
  const PathMemory& memory = flight.memory;
  for (int l = 0; l < L::count; l += L::width) {
    const Scattered<L>& by = sample.by;
    const LobeValues<F> lobes = load_lobes(by, l);
    const auto is_by = load<I>(sample.lobe + l) == let_by;
    F largest{};
    with_metal_lobe(scene, points.boundary, by, l, [&](const auto& metal_in) {
      for (int b = 0; b < scene.bands; ++b) {
        const int at = b * L::count + l;
        const BandColor<F> color = load_color<L>(memory, at);
        const F part = all_lobes(lobes, color, metal_in(lobes, color, b).a);
        const F before = load<F>(memory.throughput + at);
        const F after = is_by ? before : before * part;
        store(memory.throughput + at, after);
        largest = after > largest ? after : largest;
      }
    });
    store(most + l, largest);
    if (scene.polarized) lengthen_matrices(flight, points, sample, l);
  }
}

}  // namespace omma
