// What a surface sends towards the eye, and which surfaces a ray sees at all.
//
// This is the seam where light comes in: eval_surface returns the unlit base colour plus emission
// (CompoundRay's default shading); illumination will multiply the base colour here.
#pragma once

#include "kernel/texture.h"

namespace omma {

struct SurfaceLight {
  Radiance radiance;
  float alpha = 1;  // share of what lies behind that the surface covers
};

// Asks the cache for what eval_surface will read first. Worth a loop of its own ahead of shading a
// packet: in large scenes each ray's triangle is a cache miss.
OMMA_HD void prefetch_surface(const SceneView& scene, const SurfaceHit& hit) {
#if !defined(__CUDA_ARCH__)
  const MeshView& mesh = scene.meshes[hit.mesh];
  const long long corner = 3 * static_cast<long long>(hit.triangle);
  if (mesh.base_uv != nullptr) __builtin_prefetch(mesh.base_uv + corner);
  if (mesh.colors != nullptr) __builtin_prefetch(mesh.colors + corner);
#endif
}

OMMA_HD Vec2 interpolate(const Vec2* corner, float u, float v) {
  return corner[0] * (1 - u - v) + corner[1] * u + corner[2] * v;
}

OMMA_HD Rgba interpolate(const Vec4* corner, float u, float v) {
  return load_rgba(corner[0]) * (1 - u - v) + load_rgba(corner[1]) * u + load_rgba(corner[2]) * v;
}

// Base colour: factor x texture x vertex colour (glTF 2.0, 3.9.2).
OMMA_HD Rgba eval_base_color(const SceneView& scene, const MeshView& mesh,
                             const MaterialView& material, const SurfaceHit& hit) {
  Rgba color = load_rgba(material.base_color);
  const long long corner = 3 * static_cast<long long>(hit.triangle);
  if (mesh.base_uv != nullptr)
    color = color * eval_texture(scene.textures[material.base_texture],
                                 interpolate(mesh.base_uv + corner, hit.u, hit.v));
  if (mesh.colors != nullptr) color = color * interpolate(mesh.colors + corner, hit.u, hit.v);
  return color;
}

OMMA_HD SurfaceLight eval_surface(const SceneView& scene, const SurfaceHit& hit) {
  const MeshView& mesh = scene.meshes[hit.mesh];
  const MaterialView& material = scene.materials[mesh.material];
  const Rgba base = eval_base_color(scene, mesh, material, hit);
  Vec3 emitted = material.emissive;
  if (mesh.emissive_uv != nullptr) {
    const Vec2 uv =
        interpolate(mesh.emissive_uv + 3 * static_cast<long long>(hit.triangle), hit.u, hit.v);
    const Rgba t = eval_texture(scene.textures[material.emissive_texture], uv);
    emitted = {emitted.x * t[0], emitted.y * t[1], emitted.z * t[2]};
  }
  const float alpha = material.alpha_mode == AlphaMode::blend ? clamp_unit(base[3]) : 1.0f;
  return {{{base[0] + emitted.x, base[1] + emitted.y, base[2] + emitted.z}}, alpha};
}

// Whether the ray sees the surface there: the back of a single-sided one is invisible (glTF 2.0,
// 3.9.3), and so is a cut-out below its cutoff (3.9.4). The tracer asks this of every candidate.
OMMA_HD bool accept_hit(const SceneView& scene, const SurfaceHit& hit, bool from_behind) {
  const MeshView& mesh = scene.meshes[hit.mesh];
  const MaterialView& material = scene.materials[mesh.material];
  if (from_behind && !material.double_sided) return false;
  if (material.alpha_mode != AlphaMode::mask) return true;
  return eval_base_color(scene, mesh, material, hit)[3] >= material.alpha_cutoff;
}

// Whether accept_hit can ever say no: meshes for which it cannot are traced without asking.
OMMA_HD bool may_reject(const MaterialView& material) {
  return !material.double_sided || material.alpha_mode == AlphaMode::mask;
}

}  // namespace omma
