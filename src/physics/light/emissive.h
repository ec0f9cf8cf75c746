// Surfaces that shine, one triangle at a time: places on them are sampled as they are seen from a
// point, by solid angle, so that light from near surfaces has no spikes.
#pragma once

#include "physics/light/sky.h"
#include "physics/sampling/random_direction.h"
#include "physics/views/light_view.h"
#include "physics/views/scene_view.h"

namespace omma {

// Below, in sr, places are sampled evenly by area instead: the trigonometry of a small triangle has
// no digits left in single precision, and there the two differ little. And above, where a triangle
// surrounds nearly a hemisphere.
inline constexpr float least_sampled_sr = 0.01f, most_sampled_sr = 6.2f;

OMMA_HD Vec3 cross_of(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// One of the d^2 triangles that a triangle is divided into: a place with the barycentric weights
// (a, b) there has (u + scale a, v + scale b) on the whole.
struct Subtriangle {
  float u = 0, v = 0, scale = 1;
};

// They are numbered row by row along v; those of row j, 2 (d - j) - 1, alternate between upright
// ones (scale 1 / d) and inverted ones (-1 / d).
OMMA_HD Subtriangle subtriangle(std::int32_t number, std::int32_t divisions) {
  const std::int32_t left = divisions * divisions - number;
  const auto rows = static_cast<std::int32_t>(ceilf(sqrtf(static_cast<float>(left))));
  const std::int32_t row = divisions - rows, in_row = rows * rows - left;
  const std::int32_t inverted = in_row & 1;
  const float width = 1.0f / static_cast<float>(divisions);
  return {static_cast<float>(in_row / 2 + inverted) * width,
          static_cast<float>(row + inverted) * width, inverted != 0 ? -width : width};
}

// The number of that on which a place of a triangle is.
OMMA_HD std::int32_t subtriangle_at(float u, float v, std::int32_t divisions) {
  const auto along = [&](float x, std::int32_t most) {
    const auto whole = static_cast<std::int32_t>(x * static_cast<float>(divisions));
    return whole < most ? whole : most;
  };
  const std::int32_t row = along(v, divisions - 1), column = along(u, divisions - 1 - row);
  const float beyond = (u + v) * static_cast<float>(divisions) - static_cast<float>(row + column);
  const bool inverted = beyond > 1.0f && row + column + 1 < divisions;
  return row * (2 * divisions - row) + 2 * column + (inverted ? 1 : 0);
}

// A triangle about the point from which it is seen, in the traced frame.
struct LightTriangle {
  Vec3 corner[3];  // m, from the point
  Vec3 normal;     // not unit: twice the area; towards the side that is the front
  Vec3 unit[3];    // corners as directions
  float solid_angle_sr;
  float reach_m;  // the largest coordinate of the whole triangle's corners
};

// Where triangles are divided, one of the parts of a triangle: its number among all of the mesh.
OMMA_HD LightTriangle see_triangle(const SceneView& scene, const EmissiveView& emissive,
                                   std::int32_t number, Vec3 from) {
  const std::int32_t instance = emissive.instance, parts = emissive.divisions * emissive.divisions;
  const std::int32_t triangle = number / parts;
  const MeshView& view = scene.meshes[emissive.mesh];
  const float* m = scene.frame_from_mesh + 12 * static_cast<std::ptrdiff_t>(instance);
  LightTriangle seen;
  seen.reach_m = 0;
  for (int k = 0; k < 3; ++k) {
    const std::ptrdiff_t vertex = view.triangles[3 * static_cast<std::ptrdiff_t>(triangle) + k];
    const float* own = view.positions + 3 * vertex;
    const auto row = [&](int r) {
      return m[4 * r] * own[0] + m[4 * r + 1] * own[1] + m[4 * r + 2] * own[2] + m[4 * r + 3];
    };
    const Vec3 at{row(0), row(1), row(2)};
    seen.reach_m = fmaxf(fmaxf(seen.reach_m, fabsf(at.x)), fmaxf(fabsf(at.y), fabsf(at.z)));
    seen.corner[k] = at - from;
  }
  if (parts > 1) {
    const Subtriangle sub = subtriangle(number - triangle * parts, emissive.divisions);
    const Vec3 e1 = seen.corner[1] - seen.corner[0], e2 = seen.corner[2] - seen.corner[0];
    seen.corner[0] = seen.corner[0] + e1 * sub.u + e2 * sub.v;
    seen.corner[1] = seen.corner[0] + e1 * sub.scale;
    seen.corner[2] = seen.corner[0] + e2 * sub.scale;
  }
  seen.normal = cross_of(seen.corner[1] - seen.corner[0], seen.corner[2] - seen.corner[0]);
  const float det = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                    m[2] * (m[4] * m[9] - m[5] * m[8]);
  if (det < 0.0f) seen.normal = seen.normal * -1.0f;

  float length[3];
  for (int k = 0; k < 3; ++k) {
    length[k] = sqrtf(dot(seen.corner[k], seen.corner[k]));
    seen.unit[k] = seen.corner[k] * (1.0f / fmaxf(length[k], 1e-30f));
  }
  // Van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207; the triple product by the
  // triangle's own normal, which does not cancel where it is small.
  const float triple =
      fabsf(dot(seen.normal, seen.unit[0])) / (fmaxf(length[1], 1e-30f) * fmaxf(length[2], 1e-30f));
  const float below = 1.0f + dot(seen.unit[0], seen.unit[1]) + dot(seen.unit[1], seen.unit[2]) +
                      dot(seen.unit[2], seen.unit[0]);
  const float half = angle_in_quadrant(fabsf(below), triple);
  seen.solid_angle_sr = 2.0f * (below < 0.0f ? 3.14159265f - half : half);
  return seen;
}

OMMA_HD bool is_sampled_by_solid_angle(const LightTriangle& seen) {
  return seen.solid_angle_sr >= least_sampled_sr && seen.solid_angle_sr <= most_sampled_sr;
}

// Probability per solid angle of a place that lies in a unit direction, of those on the triangle; 0
// where it is seen edge on.
OMMA_HD float seen_triangle_pdf(const LightTriangle& seen, Vec3 direction, float distance_m) {
  if (is_sampled_by_solid_angle(seen)) return 1.0f / seen.solid_angle_sr;
  const float twice_projected = fabsf(dot(seen.normal, direction));
  return twice_projected > 0.0f ? 2.0f * distance_m * distance_m / twice_projected : 0.0f;
}

// Sine and cosine of the angle that two great circles make, by their poles.
OMMA_HD SineCosine<float> angle_between(Vec3 a, Vec3 b) {
  const Vec3 across = cross_of(a, b);
  const float sine = sqrtf(dot(across, across)), cosine = dot(a, b);
  const float scale = 1.0f / fmaxf(sqrtf(sine * sine + cosine * cosine), 1e-30f);
  return {sine * scale, cosine * scale};
}

// The part of a that lies across the unit vector n, as a unit vector.
OMMA_HD Vec3 across_unit(Vec3 a, Vec3 n) {
  const Vec3 across = a - n * dot(a, n);
  return across * (1.0f / fmaxf(sqrtf(dot(across, across)), 1e-30f));
}

// A unit direction into the triangle, evenly by solid angle: Arvo 1995, Stratified sampling of
// spherical triangles, doi:10.1145/218380.218500.
OMMA_HD Vec3 sample_spherical_triangle(const LightTriangle& seen, float u0, float u1) {
  const Vec3 a = seen.unit[0], b = seen.unit[1], c = seen.unit[2];
  const SineCosine<float> alpha = angle_between(cross_of(a, b), cross_of(a, c));
  float area = u0 * seen.solid_angle_sr;
  area = area > 3.14159265f ? area - 6.28318531f : area;
  const SineCosine<float> part = sine_cosine(area);
  const float s = part.sine * alpha.cosine - part.cosine * alpha.sine;
  const float t = part.cosine * alpha.cosine + part.sine * alpha.sine;
  const float u = t - alpha.cosine, v = s + alpha.sine * dot(a, b);
  const float below = (v * s + u * t) * alpha.sine;
  const float q = ((v * t - u * s) * alpha.cosine - v) / below;
  // At u0 = 0 it is 0 / 0: c is not moved then.
  const float cosine = q == q ? fminf(fmaxf(q, -1.0f), 1.0f) : dot(a, c);
  const Vec3 moved = a * cosine + across_unit(c, a) * sqrtf(1.0f - cosine * cosine);
  const float z = 1.0f - u1 * (1.0f - dot(moved, b));
  return b * z + across_unit(moved, b) * sqrtf(fmaxf(1.0f - z * z, 0.0f));
}

// A place on a triangle as it is seen.
struct TriangleSample {
  Vec3 direction;  // unit, from the point
  float distance_m;
  float u, v;  // barycentric weights of the second and third corner
  float pdf;   // per solid angle; 0 where there is no such place
};

OMMA_HD TriangleSample sample_triangle(const LightTriangle& seen, float u0, float u1) {
  const Vec3 e1 = seen.corner[1] - seen.corner[0], e2 = seen.corner[2] - seen.corner[0];
  TriangleSample place{};
  if (is_sampled_by_solid_angle(seen)) {
    // Where that direction meets the plane (Moeller and Trumbore 1997, from its first corner).
    place.direction = sample_spherical_triangle(seen, u0, u1);
    const Vec3 p = cross_of(place.direction, e2);
    const float det = dot(e1, p);
    if (det == 0.0f) return place;
    const Vec3 back = seen.corner[0] * -1.0f, r = cross_of(back, e1);
    place.u = fminf(fmaxf(dot(back, p) / det, 0.0f), 1.0f);
    place.v = fminf(fmaxf(dot(place.direction, r) / det, 0.0f), 1.0f - place.u);
    place.distance_m = dot(e2, r) / det;
    if (place.distance_m > 0.0f) place.pdf = 1.0f / seen.solid_angle_sr;
    return place;
  }
  const float root = sqrtf(u0);
  place.u = root * (1.0f - u1);
  place.v = root * u1;
  const Vec3 at = seen.corner[0] + e1 * place.u + e2 * place.v;
  place.distance_m = sqrtf(dot(at, at));
  if (!(place.distance_m > 0.0f)) return place;
  place.direction = at * (1.0f / place.distance_m);
  place.pdf = seen_triangle_pdf(seen, place.direction, place.distance_m);
  return place;
}

// Whether light goes from the triangle's place to the point: single-sided surfaces shine in front.
OMMA_HD bool shines_towards(const SceneView& scene, std::int32_t mesh, const LightTriangle& seen,
                            Vec3 direction) {
  return scene.materials[scene.meshes[mesh].material].double_sided ||
         dot(seen.normal, direction) < 0.0f;
}

}  // namespace omma
