// What the lobes of surfaces that were met make of light of one direction, in each band; and where
// paths go on from them.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/surface/boundary_table.h"
#include "physics/surface/scatter.h"
#include "physics/views/path_memory.h"
#include "physics/views/scene_view.h"

namespace omma {

// How light of a direction is scattered towards the eye by what was met, [lane]: scatter.h's
// values, over the density with which the direction was chosen, and weighed.
template <typename L>
struct Scattered {
  static constexpr int n = L::count;
  alignas(n * 4) float reflected[n], transmitted[n];  // of reflectance and transmittance
  alignas(n * 4) float dielectric[3][n];              // a, b, c of its Mueller matrix, of the tint
  alignas(n * 4) float metal[n], metal_gain[n];
  alignas(n * 4) float half_cosine[n];  // ScatterValue's
  alignas(n * 4) float coat[3][n];
};

// The same of the lanes that go at once from l on, without what polarises.
template <typename F>
struct LobeValues {
  F reflected, transmitted, dielectric, metal, metal_gain, schlick, coat;
};

template <typename L>
OMMA_HD LobeValues<typename L::F> load_lobes(const Scattered<L>& by, int l) {
  using F = typename L::F;
  return {load<F>(by.reflected + l), load<F>(by.transmitted + l), load<F>(by.dielectric[0] + l),
          load<F>(by.metal + l),     load<F>(by.metal_gain + l),
          schlick_weight(load<F>(by.half_cosine + l)), load<F>(by.coat[0] + l)};
}

// Where the metals of those lanes lie in SceneView::boundaries, of which there are some. `tables`
// [lane]: boundary_of.
template <typename L>
OMMA_HD BoundaryPlace<typename L::F> load_boundary(const SceneView& scene,
                                                   const std::int32_t* tables,
                                                   const Scattered<L>& by, int l) {
  return find_boundary(scene.bands, load<typename L::I>(tables + l),
                       load<typename L::F>(by.half_cosine + l));
}

// What the surfaces are in a band, of those lanes.
template <typename F>
struct BandColor {
  F reflectance, transmittance, tint;
};

template <typename L>
OMMA_HD BandColor<typename L::F> load_color(const PathMemory& memory, int at) {
  using F = typename L::F;
  return {load<F>(memory.reflectance + at), load<F>(memory.transmittance + at),
          load<F>(memory.tint + at)};
}

// A band's light over that which comes, by lobe: diffuse, and the mirror-like ones.
template <typename F>
OMMA_HD F diffuse_lobes(const LobeValues<F>& by, const BandColor<F>& color) {
  return by.reflected * color.reflectance + by.transmitted * color.transmittance;
}
template <typename F>
OMMA_HD F dielectric_tint(const LobeValues<F>& by, const BandColor<F>& color) {
  return color.tint + (1.0f - color.tint) * by.schlick;
}
template <typename F>
OMMA_HD Mueller<F> metal_lobe(const LobeValues<F>& by, const BandColor<F>& color) {
  const F colored = by.metal * metal_color(color.reflectance, by.schlick, by.metal_gain);
  return {colored, F{}, 0.0f - colored};
}
// Where some lanes have tables. Light that facets pass to each other counts by a table's mean, and
// as that of one reflection.
template <typename F>
OMMA_HD Mueller<F> metal_lobe(const LobeValues<F>& by, const BandColor<F>& color,
                              const float* tables, const BoundaryPlace<F>& at, int band) {
  const Mueller<F> metal = metal_lobe(by, color);
  const auto has_table = at.table >= 0;
  const F gain = 1.0f + boundary_mean(tables, at, band) * by.metal_gain;
  const Mueller<F> table = eval_boundary(tables, at, band) * (by.metal * gain);
  return {has_table ? table.a : metal.a, has_table ? table.b : metal.b,
          has_table ? table.c : metal.c};
}

// Calls `each` with a function of LobeValues, BandColor and a band that gives a metal's lobe: by
// itself where there are no tables, so that loops over bands are as fast as without.
template <typename L, typename Each>
OMMA_HD void with_metal_lobe(const SceneView& scene, const std::int32_t* boundary,
                             const Scattered<L>& by, int l, const Each& each) {
  using F = typename L::F;
  if (scene.boundaries == nullptr) {
    each([](const LobeValues<F>& lobes, const BandColor<F>& color, int) {
      return metal_lobe(lobes, color);
    });
    return;
  }
  const float* const tables = scene.boundaries;
  const BoundaryPlace<F> at = load_boundary(scene, boundary, by, l);
  each([&](const LobeValues<F>& lobes, const BandColor<F>& color, int band) {
    return metal_lobe(lobes, color, tables, at, band);
  });
}

// Of all lobes, Σ_j f_j.
template <typename F>
OMMA_HD F all_lobes(const LobeValues<F>& by, const BandColor<F>& color, F metal) {
  return diffuse_lobes(by, color) + by.dielectric * dielectric_tint(by, color) + by.coat + metal;
}

// The surfaces that a packet met, as they scatter light.
template <typename L>
struct ScatteringPacket {
  using F = typename L::F;
  static constexpr int vectors = L::count / L::width;
  ScatterPoint<F> point[vectors];
  F diffuse_q[vectors], diffuse_u[vectors];               // Q, U over I of the diffuse lobes' light
  F weight[vectors][lobe_count];                          // probability of each lobe for the way on
  alignas(L::count * 4) std::int32_t boundary[L::count];  // boundary_of
  LaneMask<L> bends;        // from the eye, at the boundary of a volume
  LaneMask<L> samples_all;  // whose light is sampled of SceneView::all_lights
  // Where there are near lights: LightKinds [lane], and who takes light from both sides.
  alignas(L::count * 4) float far[L::count], lamp[L::count], surface[L::count];
  LaneMask<L> two_sided;
};

// In place of a lobe: none, where a path ends; past the surface, which let the light by; through
// the boundary of a volume, at which the ray bends.
inline constexpr std::int32_t no_lobe = -1, let_by = -2, refracted = -3;

// Where the packet's paths go on, [lane]: a lobe of the surface, and a direction of it.
template <typename L>
struct ScatteringSample {
  static constexpr int n = L::count;
  alignas(n * 4) float direction[3][n];
  alignas(n * 4) float density[n];   // 0 where the path ends
  alignas(n * 4) float roulette[n];  // a number in (0, 1)
  alignas(n * 4) std::int32_t lobe[n];
  Scattered<L> by;          // of the lobe that was chosen alone, over the density
  LaneMask<L> samples_all;  // as ScatteringPacket's
};

}  // namespace omma
