// Lights that are near, for next-event estimation: a direction from a point towards a lamp or a
// surface that shines, with its probability, and what comes from there if nothing is in the way.
// Light from afar, lamps and surfaces are chosen between, and one of many lamps or surfaces, by
// what they send to that point.
#pragma once

#include "physics/light/lamps.h"
#include "physics/light/shining_surfaces.h"
#include "physics/surface/surface.h"

namespace omma {

// Probabilities with which a light sample is from afar, of a lamp, on a surface; they add up to 1,
// or are all 0. Where light from afar and near light have a sample each, that from afar is 1 and
// the others add up to 1.
struct LightKinds {
  float far = 0, lamp = 0, surface = 0;
};

// By each kind's share of the irradiance of a point, the mean over bands:
//
//   p_k = ε / n + (1 - ε) mean_b E_k,b / Σ_j E_j,b,
//
// of the n kinds that send it light a part ε evenly, as any may be hidden. That surface and sky
// turn to each other is left out. `sample_each`: light from afar and near light have a sample each.
OMMA_HD LightKinds choose_kinds(const LightView& light, const LitPoint& at,
                                bool sample_each = false) {
  const KindView kinds[3] = {sample_each ? KindView{} : light.from_afar, light.from_lamps,
                             light.from_surfaces};
  const float far_too = sample_each && light.from_afar.all > 0.0f ? 1.0f : 0.0f;
  const auto is_present = [&](int k) { return kinds[k].all > 0.0f ? 1.0f : 0.0f; };
  if (is_present(0) + is_present(1) + is_present(2) < 2.0f)
    return {is_present(0) + far_too, is_present(1), is_present(2)};
  float here[3] = {};
  if (kinds[0].all > 0.0f) here[0] = mean_cosine;
  if (kinds[1].all > 0.0f) here[1] = eval_lamps(light, from_lamps(light, at));
  if (kinds[2].all > 0.0f)
    here[2] = mean_cosine * eval_light_node(light.emissive_tree.nodes[0], at);
  float share[3] = {}, bands = 0;
  for (int b = 0; b < light.bands; ++b) {
    float sent[3] = {};
    for (int k = 0; k < 3; ++k)
      if (here[k] > 0.0f) sent[k] = here[k] * kinds[k].sent[b];
    const float all = sent[0] + sent[1] + sent[2];
    if (!(all > 0.0f)) continue;
    bands += 1.0f;
    for (int k = 0; k < 3; ++k) share[k] += sent[k] / all;
  }
  const int lit = (share[0] > 0.0f) + (share[1] > 0.0f) + (share[2] > 0.0f);
  const auto probability = [&](int k) {
    return share[k] > 0.0f ? in_part_evenly(share[k] / bands, lit) : 0.0f;
  };
  return {probability(0) + far_too, probability(1), probability(2)};
}

// Towards a lamp or a surface that shines, of the kinds' probabilities; `numbers.which`: less that
// of light from afar.
OMMA_HD void sample_near_light(const SceneView& scene, const LightView& light, const LitPoint& at,
                               const LightKinds& kinds, LightNumbers numbers, LightSample& sample) {
  constexpr float below_1 = 0x1.fffffep-1f;
  sample = {};
  if (numbers.which < kinds.lamp) {
    sample_lamps(light, at, fminf(numbers.which / kinds.lamp, below_1), sample);
    sample.pdf *= kinds.lamp;
  } else if (kinds.surface > 0.0f) {
    const float u = (numbers.which - kinds.lamp) / kinds.surface;
    numbers.which = fminf(fmaxf(u, 0.0f), below_1);
    sample_surfaces(scene, light, at, numbers, sample);
    sample.pdf *= kinds.surface;
  }
}

// What comes from where a sample looks, all bands, `components` of I, Q, U, at
// out[component * component_stride + band * band_stride]: radiance, or from a lamp irradiance
// across its direction.
OMMA_HD void eval_light_sample(const SceneView& scene, const LightSample& sample, int components,
                               float* out, int band_stride, int component_stride) {
  const LightView& light = *scene.light;
  for (int p = 0; p < components; ++p)
    for (int k = 0; k < light.bands; ++k) out[p * component_stride + k * band_stride] = 0;
  if (sample.kind == LightKind::lamp) {
    const float* strength = light.lamps[sample.index].strength;
    for (int k = 0; k < light.bands; ++k) out[k * band_stride] = strength[k] * sample.scale;
  } else if (sample.kind == LightKind::surface) {
    const MeshView& mesh = scene.meshes[sample.mesh];
    const float* matrix = scene.scatter[mesh.material].emission;
    const SurfaceHit place{sample.mesh, static_cast<std::uint32_t>(sample.triangle), sample.u,
                           sample.v, 0.0f};
    // Light from behind is not sampled, so that only cut-outs are asked for here.
    if (matrix == nullptr || !accept_hit(scene, place, false)) return;
    const Color<float> c = emitted_rgb(scene, mesh, point_of(place));
    const float alpha = eval_opacity(scene, mesh, point_of(place));
    for (int k = 0; k < light.bands; ++k) {
      const float* row = matrix + 3 * k;
      out[k * band_stride] = alpha * (c.r * row[0] + c.g * row[1] + c.b * row[2]);
    }
  }
}

}  // namespace omma
