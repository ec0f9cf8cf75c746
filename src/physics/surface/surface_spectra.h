// What the materials and textures of one mesh say of a place on it: in each band how much it
// reflects, transmits and shines, and the factors of its lobes.
#pragma once

#include "physics/surface/surface.h"
#include "physics/views/path_memory.h"

namespace omma {

// Spectra of the lanes of one mesh; `keep_at(values, b, x)` stores them.
template <typename F, typename I, typename Store>
OMMA_HD void eval_spectra(const SceneView& scene, const MeshView& mesh, const Color<F>& base,
                          const SurfacePoint<F, I>& p, const SpectraMemory& memory,
                          const Store& keep_at) {
  const ScatterView& scatter = scene.scatter[mesh.material];
  Color<F> through = base, extra{};
  if (scatter.transmittance != nullptr && !scatter.transmits_base_color) {
    const Vec3 factor = scatter.transmission_color;
    through = {broadcast<F>(factor.x), broadcast<F>(factor.y), broadcast<F>(factor.z),
               broadcast<F>(1.0f)};
    if (mesh.transmission_uv != nullptr)
      through = through * eval_texture_at(scene, mesh, scatter.transmission_texture,
                                          mesh.transmission_uv, mesh.transmission_density, p);
  }
  if (mesh.extra_uv != nullptr && scatter.extra != nullptr)
    extra =
        eval_texture_at(scene, mesh, scatter.extra_texture, mesh.extra_uv, mesh.extra_density, p);
  const auto of = [](const float* row, const Color<F>& c) {
    return c.r * row[0] + c.g * row[1] + c.b * row[2];
  };
  // What a texture says of how much goes through, and what is then left to be reflected.
  const bool varies = mesh.factors != nullptr && mesh.factors->diffuse_transmission.texture >= 0;
  F part_through = broadcast<F>(1.0f), rest = part_through;
  if (varies) {
    const TextureRead& read = mesh.factors->diffuse_transmission;
    part_through =
        clamp_unit_lanes(eval_texture_at(scene, mesh, read.texture, read.uv, read.density, p).a) *
        scatter.diffuse_transmission;
    if (scatter.reflects_the_rest) rest = 1.0f - part_through;
  }
  for (int b = 0; b < scene.bands; ++b) {
    const float* row = scatter.reflectance + 4 * b;
    F reflected = of(row, base) + row[3];
    if (varies) reflected = reflected * rest;
    if (scatter.extra != nullptr) reflected = reflected + of(scatter.extra + 3 * b, extra);
    reflected = clamp_unit_lanes(reflected);
    F transmitted = broadcast<F>(0.0f);
    if (scatter.transmittance != nullptr) {
      const float* of_sheet = scatter.transmittance + 4 * b;
      transmitted = of(of_sheet, through) + of_sheet[3];
      if (varies) transmitted = transmitted * part_through;
      transmitted = clamp_unit_lanes(transmitted);
      // No sheet gives back more than it gets, whatever its textures say.
      const F sum = reflected + transmitted, scale = sum > 1.0f ? 1.0f / sum : broadcast<F>(1.0f);
      reflected *= scale;
      transmitted *= scale;
    }
    keep_at(memory.reflectance, b, reflected);
    keep_at(memory.transmittance, b, transmitted);
    keep_at(memory.tint, b,
            broadcast<F>(scatter.specular_tint != nullptr ? scatter.specular_tint[b] : 1.0f));
  }
}

// Emission by band, of the lanes of one mesh that shines.
template <typename F, typename I, typename Store>
OMMA_HD void eval_emitted(const SceneView& scene, const MeshView& mesh, const ScatterView& scatter,
                          const SurfacePoint<F, I>& p, const Store& keep_band) {
  const Color<F> rgb = emitted_rgb(scene, mesh, p);
  for (int b = 0; b < scene.bands; ++b) {
    const float* row = scatter.emission + 3 * b;
    keep_band(b, rgb.r * row[0] + rgb.g * row[1] + rgb.b * row[2]);
  }
}

// Tint by band, of the lanes of one mesh whose specular colour is a texture.
template <typename F, typename I, typename Store>
OMMA_HD void eval_tint(const SceneView& scene, const MeshView& mesh, const ScatterView& scatter,
                       const SurfacePoint<F, I>& p, const Store& keep_band) {
  const TextureRead& read = mesh.factors->specular_color;
  const Color<F> rgb = eval_texture_at(scene, mesh, read.texture, read.uv, read.density, p);
  for (int b = 0; b < scene.bands; ++b) {
    const float* row = scatter.tint_from_rgb + 3 * b;
    keep_band(b, clamp_unit_lanes(rgb.r * row[0] + rgb.g * row[1] + rgb.b * row[2]));
  }
}

// What textures of factors are multiplied to.
template <typename F>
struct SurfaceFactors {
  F specular, transmission, coat, coat_roughness;
};

// Factors of one mesh times their textures.
template <typename F, typename I>
OMMA_HD void multiply_factors(const SceneView& scene, const MeshView& mesh,
                              const SurfacePoint<F, I>& p, SurfaceFactors<F>& own) {
  const FactorTextures& textures = *mesh.factors;
  const TextureRead* const reads[] = {&textures.specular, &textures.transmission, &textures.coat,
                                      &textures.coat_roughness};
  F* const factors[] = {&own.specular, &own.transmission, &own.coat, &own.coat_roughness};
  // A loop, so that the code that reads a texture is there once.
  for (int k = 0; k < 4; ++k) {
    if (reads[k]->texture < 0) continue;
    const Color<F> c =
        eval_texture_at(scene, mesh, reads[k]->texture, reads[k]->uv, reads[k]->density, p);
    *factors[k] = *factors[k] * clamp_unit_lanes(k == 0 ? c.a : k == 3 ? c.g : c.r);
  }
}

}  // namespace omma
