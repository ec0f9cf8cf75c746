// Lamps without size (glTF's KHR_lights_punctual): what one sends to a place, and one of many
// chosen by that. No ray meets them by itself, so that they are always sampled.
#pragma once

#include "physics/light/light_sample.h"
#include "physics/light/light_tree.h"

namespace omma {

// What a lamp does at a place: irradiance across `direction` is its strength times `scale`.
struct LampAt {
  Vec3 direction;    // unit, towards the lamp
  float distance_m;  // INFINITY where directional
  float scale;       // 0 where it does not shine
};

// Inverse square, the window over the range and the cone of a spot are those that the extension
// recommends (sections "Range Property" and "Inner and Outer Cone Angles").
OMMA_HD LampAt eval_lamp_at(const LampView& lamp, Vec3 position) {
  if (lamp.type == PunctualLightType::directional) return {lamp.direction * -1.0f, INFINITY, 1.0f};
  const Vec3 to_lamp = lamp.position - position;
  const float distance_2 = dot(to_lamp, to_lamp);
  if (!(distance_2 > 0.0f)) return {{0, 1, 0}, 0.0f, 0.0f};
  const float distance = sqrtf(distance_2);
  const Vec3 direction = to_lamp * (1.0f / distance);
  const float of_range_2 = distance_2 * lamp.per_range_2;
  float scale = fmaxf(1.0f - of_range_2 * of_range_2, 0.0f) / distance_2;
  if (lamp.type == PunctualLightType::spot) {
    const float cosine = -dot(direction, lamp.direction);
    const float inside = fminf(fmaxf(cosine * lamp.cone_scale + lamp.cone_offset, 0.0f), 1.0f);
    scale *= inside * inside;
  }
  return {direction, distance, scale};
}

// So many lamps are weighed one by one by what each sends to a point; of more a tree knows about
// where they are.
inline constexpr std::int32_t few_lamps = 16;

// A point that takes light from all around, or a mean over directions, in place of a cosine.
inline constexpr float mean_cosine = 0.5f;

OMMA_HD LitPoint from_lamps(const LightView& light, const LitPoint& at) {
  const float* origin = light.lamp_origin_m;
  return origin == nullptr
             ? at
             : LitPoint{at.position - Vec3{origin[0], origin[1], origin[2]}, at.normal, at.rise_m};
}

// About what a lamp sends to a point, all bands: gloss may send back much of what falls on it at
// grazing angles, so that no lamp above a surface counts for nothing.
OMMA_HD float lamp_irradiance(const LightView& light, std::int32_t lamp, const LitPoint& at) {
  const LampAt lit = eval_lamp_at(light.lamps[lamp], at.position);
  const Vec3 n = at.normal;
  const float length_2 = dot(n, n);
  if (!(length_2 > 0.0f)) return light.lamps[lamp].power * lit.scale * mean_cosine;
  const float cosine = dot(n, lit.direction);
  constexpr float least = 0.1f;
  return cosine > 0.0f ? light.lamps[lamp].power * lit.scale * fmaxf(cosine, least) : 0.0f;
}

// What all lamps send there, over that at 1 m (KindView).
OMMA_HD float eval_lamps(const LightView& light, const LitPoint& at) {
  if (light.lamp_count > few_lamps)
    return mean_cosine * eval_light_node(light.lamp_tree.nodes[0], at);
  float all = 0;
  for (std::int32_t i = 0; i < light.lamp_count; ++i) all += lamp_irradiance(light, i, at);
  return all / light.from_lamps.all;
}

// By what each sends, but for the part that is chosen evenly of those that send any.
OMMA_HD ChosenLight choose_of_few_lamps(const LightView& light, const LitPoint& at, float u) {
  float all = 0;
  std::int32_t lit = 0;
  for (std::int32_t i = 0; i < light.lamp_count; ++i) {
    const float sent = lamp_irradiance(light, i, at);
    all += sent;
    lit += sent > 0.0f ? 1 : 0;
  }
  if (lit == 0) return {};
  const float evenly = even_part(lit);
  const bool is_even = u < evenly;
  std::int32_t left = is_even ? choose_evenly(lit, u).index : lit - 1;
  float below = is_even ? INFINITY : (u - evenly) / (1.0f - evenly) * all;
  ChosenLight chosen;
  for (std::int32_t i = 0; i < light.lamp_count && left >= 0 && below >= 0.0f; ++i) {
    const float sent = lamp_irradiance(light, i, at);
    if (!(sent > 0.0f)) continue;
    below -= sent;
    --left;
    chosen = {i, in_part_evenly(sent / all, lit), 0.0f};
  }
  return chosen;
}

OMMA_HD ChosenLight choose_lamp(const LightView& light, const LitPoint& at, float u) {
  if (light.lamp_count == 1) return {0, 1.0f, 0.0f};
  if (light.lamp_count > few_lamps) return choose_light(light.lamp_tree, at, u);
  return choose_of_few_lamps(light, at, u);
}

OMMA_HD void sample_lamps(const LightView& light, const LitPoint& point, float u,
                          LightSample& sample) {
  const LitPoint at = from_lamps(light, point);
  const ChosenLight chosen = choose_lamp(light, at, u);
  if (chosen.index < 0) return;
  sample.index = chosen.index;
  const LampAt lit = eval_lamp_at(light.lamps[sample.index], at.position);
  sample.kind = LightKind::lamp;
  sample.is_delta = true;
  sample.direction = lit.direction;
  sample.distance_m = lit.distance_m;
  sample.scale = lit.scale;
  if (lit.scale > 0.0f) sample.pdf = chosen.probability;
}

}  // namespace omma
