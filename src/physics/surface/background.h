// Light from directions in which there is no surface, linear RGB, which path.h lifts to the bands of
// the scene. World frame, +Y up, unit directions.
#pragma once

#include "physics/surface/texture.h"

namespace omma {

// Arc sine for 0 <= x <= 1, error below 2e-8 (Abramowitz and Stegun 4.4.46). Branch-free, so that
// the sky is evaluated for a whole packet at once.
OMMA_HD float asin_positive(float x) {
  float p = -0.0012624911f;
  p = p * x + 0.0066700901f;
  p = p * x - 0.0170881256f;
  p = p * x + 0.0308918810f;
  p = p * x - 0.0501743046f;
  p = p * x + 0.0889789874f;
  p = p * x - 0.2145988016f;
  p = p * x + 1.5707963050f;
  return 1.57079632679f - sqrtf(1.0f - x) * p;
}

// CompoundRay's `simple_sky`: from the horizon colour linearly in elevation to the zenith colour.
OMMA_HD Vec3 eval_simple_sky(Vec3 direction) {
  const float up = clamp_unit_lanes(direction.y);
  const float height = asin_positive(up) * 0.636619772f;  // elevation over pi/2
  const float s = 0.8f / 255.0f, z = 1.0f / 255.0f;
  return {143.0f * s + height * (1.0f * z - 143.0f * s),
          179.0f * s + height * (31.0f * z - 179.0f * s),
          203.0f * s + height * (117.0f * z - 203.0f * s)};
}

// CompoundRay's `default_background`: azimuth in red, elevation in green, black great circles.
OMMA_HD Vec3 eval_test_pattern(Vec3 direction) {
  const float line = 0.01f;
  if (fabsf(direction.x) < line || fabsf(direction.y) < line || fabsf(direction.z) < line)
    return {};
  const float p = static_cast<float>(pi);
  const float y = fminf(fmaxf(direction.y, -1.0f), 1.0f);
  return {(atan2f(direction.z, direction.x) + p) / (2 * p), (asinf(y) + p / 2) / p, 0.0f};
}

// Equirectangular image: forward (-Z) in the middle, +X to the right, +Y at the top.
OMMA_HD Vec3 eval_background_image(const BackgroundView& background, Vec3 direction,
                                       float footprint_rad) {
  const float p = static_cast<float>(pi);
  const float y = fminf(fmaxf(direction.y, -1.0f), 1.0f);
  const Vec2 uv{0.5f + atan2f(direction.x, -direction.z) / (2 * p), 0.5f - asinf(y) / p};
  const Color<float> c =
      eval_texture(background.image, uv.x, uv.y, footprint_rad * background.image_density);
  return {c.r, c.g, c.b};
}

}  // namespace omma
