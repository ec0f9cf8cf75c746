// A sample of a light that is near, a lamp or a surface that shines.
#pragma once

#include <cmath>
#include <cstdint>

#include "omma/vec.h"

namespace omma {

enum class LightKind : std::uint8_t { dark, lamp, surface };

struct LightSample {
  LightKind kind = LightKind::dark;
  bool is_delta = false;  // a lamp: no path meets it, and `pdf` is the probability of choosing it
  Vec3 direction;         // unit, towards the light
  float distance_m = INFINITY;
  // Per solid angle, the choice of a light included; 0: no light comes.
  float pdf = 0;
  std::int32_t index = 0;               // of the lamp, or the surface's instance of the scene
  std::int32_t mesh = 0, triangle = 0;  // of a surface
  float u = 0, v = 0;                   // barycentric, where on it
  Vec3 normal;                          // of its triangle, unit
  float reach_m = 0;                    // the largest coordinate of that triangle's corners
  float scale = 1;                      // of a lamp's strength
};

// Three random numbers in [0, 1): for which light, and where on it.
struct LightNumbers {
  float which, u0, u1;
};

}  // namespace omma
