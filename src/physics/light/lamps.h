// Lamps without size (glTF's KHR_lights_punctual), one place at a time: light that no ray meets by
// itself, so that it is always sampled.
#pragma once

#include "physics/views/light_view.h"

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

}  // namespace omma
