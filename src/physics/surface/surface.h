// What a surface is where a ray met it: its base colour, its emission, how much it covers; and
// which surfaces a ray sees at all. One mesh, any number of lanes (lanes.h).
//
// In an unlit scene eval_surface is what comes to the eye: base colour plus emission (CompoundRay's
// default shading). In a lit one lit_surface.h makes spectra and normals of the same. Colours are
// linear RGB, as files have them; path.h lifts them to the bands of the scene.
#pragma once

#include "physics/surface/opacity.h"
#include "physics/surface/power_22.h"
#include "physics/surface/texture.h"

namespace omma {

template <typename F>
struct SurfaceColor {
  F rgb[3];  // linear
  F alpha;   // fraction of what lies behind that the surface covers
};

// Where on a mesh lanes are.
template <typename F, typename I>
struct SurfacePoint {
  I triangle;
  F u, v;         // barycentric weights of the second and third vertex
  F footprint_m;  // width of the ray's footprint, in metres of the mesh
};

// Two of the mesh's values per corner or vertex, of which there are `pairs` pairs, at barycentric
// weights (1 - u - v, u, v).
template <typename F, typename I>
OMMA_HD Pair<F> interpolate(const MeshView& mesh, const float* values, int pairs, int pair,
                            const SurfacePoint<F, I>& p) {
  I at[3] = {p.triangle * 3, p.triangle * 3 + 1, p.triangle * 3 + 2};
  if (mesh.vertex_of_corner != nullptr)
    for (I& corner : at) corner = gather(mesh.vertex_of_corner, corner);
  const Pair<F> a = gather_pair(values, at[0] * pairs + pair),
                b = gather_pair(values, at[1] * pairs + pair),
                c = gather_pair(values, at[2] * pairs + pair);
  const F u = p.u, v = p.v, w = 1.0f - u - v;
  return {a.first * w + b.first * u + c.first * v, a.second * w + b.second * u + c.second * v};
}

template <typename F, typename I>
OMMA_HD Color<F> eval_texture_at(const SceneView& scene, const MeshView& mesh, int texture,
                                 const float* uvs, const float* density,
                                 const SurfacePoint<F, I>& p) {
  const Pair<F> uv = interpolate(mesh, uvs, 1, 0, p);
  // Along the short side of a slanted footprint, so that nothing is blurred by more than its width.
  const F width =
      density != nullptr ? p.footprint_m * gather(density, p.triangle) : broadcast<F>(0.0f);
  return call_eval_texture(scene.textures[texture], uv.first, uv.second, width);
}

template <typename F, typename I>
OMMA_HD Color<F> eval_vertex_color(const MeshView& mesh, const SurfacePoint<F, I>& p) {
  const Pair<F> red_green = interpolate(mesh, mesh.colors, 2, 0, p);
  const Pair<F> blue_alpha = interpolate(mesh, mesh.colors, 2, 1, p);
  return {red_green.first, red_green.second, blue_alpha.first, blue_alpha.second};
}

// Base colour: factor x texture x vertex colour (glTF 2.0, 3.9.2), or CompoundRay's rule: the
// vertex colour in place of all else, textures and vertex colours to the power 2.2.
template <typename F, typename I>
OMMA_HD Color<F> eval_base_color(const SceneView& scene, const MeshView& mesh,
                                 const SurfacePoint<F, I>& p) {
  const MaterialView& material = scene.materials[mesh.material];
  const Vec4 factor = material.base_color;
  Color<F> color{broadcast<F>(factor.x), broadcast<F>(factor.y), broadcast<F>(factor.z),
                 broadcast<F>(factor.w)};
  if (scene.power_22 != nullptr) {
    if (mesh.colors != nullptr) return eval_power_22(scene.power_22, eval_vertex_color(mesh, p));
    if (mesh.base_uv != nullptr)
      color = color *
              eval_power_22(scene.power_22, eval_texture_at(scene, mesh, material.base_texture,
                                                            mesh.base_uv, mesh.base_density, p));
    return color;
  }
  if (mesh.base_uv != nullptr)
    color = color *
            eval_texture_at(scene, mesh, material.base_texture, mesh.base_uv, mesh.base_density, p);
  if (mesh.colors != nullptr) color = color * eval_vertex_color(mesh, p);
  return color;
}

// What a surface sends out by itself: factor x texture, as linear RGB.
template <typename F, typename I>
OMMA_HD Color<F> emitted_rgb(const SceneView& scene, const MeshView& mesh,
                             const SurfacePoint<F, I>& p) {
  const MaterialView& material = scene.materials[mesh.material];
  const Color<F> emitted{broadcast<F>(material.emissive.x), broadcast<F>(material.emissive.y),
                         broadcast<F>(material.emissive.z), broadcast<F>(1.0f)};
  if (mesh.emissive_uv == nullptr) return emitted;
  return emitted * eval_texture_at(scene, mesh, material.emissive_texture, mesh.emissive_uv,
                                   mesh.emissive_density, p);
}

// Fraction of what lies behind that a surface covers, whose base colour is known.
template <typename F>
OMMA_HD F opacity_of(const MaterialView& material, const Color<F>& base) {
  return material.alpha_mode == AlphaMode::blend ? clamp_unit_lanes(base.a) : broadcast<F>(1.0f);
}

template <typename F, typename I>
OMMA_HD F eval_opacity(const SceneView& scene, const MeshView& mesh, const SurfacePoint<F, I>& p) {
  const MaterialView& material = scene.materials[mesh.material];
  if (material.alpha_mode != AlphaMode::blend) return broadcast<F>(1.0f);
  return opacity_of(material, eval_base_color(scene, mesh, p));
}

template <typename F, typename I>
OMMA_HD SurfaceColor<F> eval_surface(const SceneView& scene, const MeshView& mesh,
                                     const SurfacePoint<F, I>& p) {
  const Color<F> base = eval_base_color(scene, mesh, p);
  const Color<F> emitted = emitted_rgb(scene, mesh, p);
  return {{base.r + emitted.r, base.g + emitted.g, base.b + emitted.b},
          opacity_of(scene.materials[mesh.material], base)};
}

OMMA_HD SurfacePoint<float, std::int32_t> point_of(const SurfaceHit& hit) {
  return {static_cast<std::int32_t>(hit.triangle), hit.u, hit.v, hit.footprint_m};
}

// Whether a cut-out is there, asked of its image.
OMMA_HD bool is_above_cutoff(const SceneView& scene, const SurfaceHit& hit) {
  // Always by the texels of the image itself. Coarser ones with a cutoff that keeps the coverage
  // (I. Castano, Computing Alpha Mipmaps, 2010) bias blades and leaves that are a few texels wide
  // in them: in the bundled meadow the error at 64 rays grows by a third. As partial opacity it
  // falls by a sixth, but rays that go on behind every blade take 5.7 times as long.
  const MeshView& mesh = scene.meshes[hit.mesh];
  SurfacePoint<float, std::int32_t> point = point_of(hit);
  point.footprint_m = 0;
  return eval_base_color(scene, mesh, point).a >= scene.materials[mesh.material].alpha_cutoff;
}

// Whether the ray sees the surface there: the back of a single-sided one is invisible (glTF 2.0,
// 3.9.3), and so is a cut-out below its cutoff (3.9.4). The tracer asks this of every candidate.
// The image is read only where the opacity map does not know.
OMMA_HD bool accept_hit(const SceneView& scene, const SurfaceHit& hit, bool from_behind) {
  const MeshView& mesh = scene.meshes[hit.mesh];
  const MaterialView& material = scene.materials[mesh.material];
  if (from_behind && !material.double_sided) return false;
  if (material.alpha_mode != AlphaMode::mask) return true;
  if (mesh.opacity != nullptr) {
    const Opacity known =
        find_opacity(mesh.opacity[hit.triangle], scene.opacity_states, hit.u, hit.v);
    if (known != Opacity::ask) return known == Opacity::opaque;
  }
  return is_above_cutoff(scene, hit);
}

// Whether rays may go on straight behind the surface: a search is then asked to leave out what they
// have passed (passed.h).
OMMA_HD bool lets_rays_on(const MaterialView& material) {
  return material.alpha_mode == AlphaMode::blend || material.is_glass;
}

// Whether accept_hit can ever say no: meshes for which it cannot are traced without asking.
OMMA_HD bool may_reject(const MaterialView& material) {
  return !material.double_sided || material.alpha_mode == AlphaMode::mask;
}

}  // namespace omma
