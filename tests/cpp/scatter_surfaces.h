// Surfaces for tests of scattering, and what their lobes give back.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "backend/albedo_tables.h"
#include "physics/surface/scatter.h"
#include "scatter_checks.h"

namespace omma::test {

using Direction = std::array<double, 3>;

inline constexpr double iors[] = {1.0, 1.2, 1.5, 2.5};

inline const std::vector<float>& albedo_tables() {
  static const std::vector<float> tables = [] {
    std::vector<float> all;
    for (const double ior : iors) {
      const std::vector<float> one = make_specular_albedo(ior);
      all.insert(all.end(), one.begin(), one.end());
    }
    return all;
  }();
  return tables;
}

inline const float* coat_table() {
  return albedo_tables().data() + 2 * albedo_floats;
}

inline const float* metal_table() {
  static const std::vector<float> table =
      make_specular_albedo(std::numeric_limits<double>::infinity());
  return table.data();
}

inline Direction scaled_sum(const Direction& a, double s, const Direction& b, double t) {
  return {a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t};
}
inline double dot(const Direction& a, const Direction& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Direction unit(const Direction& a) {
  return scaled_sum(a, 1 / std::sqrt(dot(a, a)), a, 0);
}

inline Direction random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return unit({normal(random), normal(random), normal(random)});
}

// Across the normal, at random.
inline Direction across(std::mt19937& random, const Direction& normal) {
  const Direction d = random_direction(random);
  return unit(scaled_sum(d, 1, normal, -dot(d, normal)));
}

inline void copy(const Direction& from, Vector3<float>& to) {
  to = {static_cast<float>(from[0]), static_cast<float>(from[1]), static_cast<float>(from[2])};
}

// A matt white sheet of ior 1.5, seen along `direction`.
inline ScatterSurface<float> surface(const Direction& direction, const Direction& normal) {
  ScatterSurface<float> s{};
  copy(direction, s.direction);
  copy(normal, s.normal);
  copy(normal, s.coat_normal);
  copy(normal, s.geometric_normal);
  s.roughness = 1;
  s.specular = 1;
  s.ior = 1.5f;
  s.albedo_tables = albedo_tables().data();
  s.table = 2;
  s.metal_table = metal_table();
  return s;
}

inline ScatterSurface<float> random_surface(std::mt19937& random) {
  std::uniform_real_distribution<float> any(0, 1);
  const Direction normal = random_direction(random);
  // Of all cosines, a third grazing.
  const auto cosine = static_cast<double>(std::pow(any(random), any(random) < 0.3f ? 4.0f : 1.0f));
  ScatterSurface<float> s = surface(
      scaled_sum(normal, -cosine, across(random, normal), std::sqrt(1 - cosine * cosine)), normal);
  const auto some = [&] {
    return any(random) < 0.3f ? any(random) : any(random) < 0.5f ? 1.0f : 0.0f;
  };
  s.roughness = any(random) < 0.2f ? 0.0f : any(random);
  s.metallic = some();
  s.specular = some();
  s.transmission = some();
  s.coat = some();
  s.coat_roughness = any(random);
  s.coat_table = any(random) < 0.5f ? coat_table() : nullptr;
  // Some coats have a map of normals.
  if (any(random) < 0.3f)
    copy(unit(scaled_sum(normal, 1, across(random, normal), 0.3 * any(random))), s.coat_normal);
  s.table = static_cast<std::int32_t>(random() % 4);
  s.ior = static_cast<float>(iors[s.table]);
  return s;
}

// What a lobe sends to the viewer of a direction's light, of one colour: full where the light is in
// no way absorbed. `gain`: of a metal, of its point; 0 leaves out light that its facets pass on.
inline float eval_lobe(Lobe lobe, const ScatterValue<float>& v, float f0, float gain) {
  switch (lobe) {
    case Lobe::diffuse_reflection:
      return v.diffuse_reflection;
    case Lobe::diffuse_transmission:
      return v.diffuse_transmission;
    case Lobe::dielectric:
      return v.dielectric.a;
    case Lobe::metal:
      return v.metal * metal_color(f0, schlick_weight(v.half_cosine), gain);
    case Lobe::coat:
      return v.coat.a;
    case Lobe::straight:
      break;
  }
  return 0;
}

// Of uniform light, by the lobe's own sampler.
inline double lobe_albedo(const ScatterPoint<float>& p, Lobe lobe, float f0 = 1,
                          std::uint32_t count = 4096) {
  if (lobe == Lobe::straight) return p.straight;
  if (lobe == Lobe::coat && p.coat_table == nullptr) return 0;
  double sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec2 u = square_point(i);
    const Vector3<float> w = sample_scatter(static_cast<std::int32_t>(lobe), p, u.x, u.y);
    const ScatterValue<float> v = eval_scatter(p, w);
    const float value = eval_lobe(lobe, v, f0, p.metal_gain);
    if (value > 0)
      sum += static_cast<double>(value / pdf_scatter(static_cast<std::int32_t>(lobe), v));
  }
  return sum / count;
}

}  // namespace omma::test
