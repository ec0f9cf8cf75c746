// What surfaces are where rays met them, for light: the normal that shades, how rough, how
// metallic, and in each band how much they reflect, transmit and shine. How they scatter is
// scatter.h.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/rays/hits.h"
#include "physics/surface/scatter.h"
#include "physics/surface/shading_normals.h"
#include "physics/surface/surface.h"
#include "physics/surface/surface_spectra.h"
#include "physics/views/path_memory.h"

namespace omma {

// All [lane], and anything where nothing was met; what is by band is in SpectraMemory:
//   reflectance    of the base colour; a metal's reflection at normal incidence
//   transmittance  diffuse, through the sheet
//   emission       radiance, where the material shines; else anything
//   tint           of a dielectric's reflection at normal incidence
template <typename L>
struct LitSurface {
  alignas(L::count * 4) float normal[3][L::count];     // that shades, unit, towards the viewer
  alignas(L::count * 4) float geometric[3][L::count];  // of the triangle, unit, towards the viewer
  alignas(L::count * 4) float coat_normal[3][L::count];  // of the coat; anything where none is coated
  alignas(L::count * 4) float roughness[L::count];
  alignas(L::count * 4) float metallic[L::count];
  alignas(L::count * 4) float ior[L::count];
  alignas(L::count * 4) float specular[L::count];
  alignas(L::count * 4) float transmission[L::count];  // straight through
  alignas(L::count * 4) float coat[L::count];
  alignas(L::count * 4) float coat_roughness[L::count];
  alignas(L::count * 4) float alpha[L::count];            // fraction of what lies behind it covers
  alignas(L::count * 4) std::int32_t table[L::count];     // of its ior, ScatterView::albedo_table
  alignas(L::count * 4) std::int32_t boundary[L::count];  // ScatterView's; anything where none is
  alignas(L::count * 4) std::int32_t material[L::count];  // -1 where nothing was met
  // 1 where the ray enters a volume, -1 where it would leave one, 0 else; anything where the scene
  // has none.
  alignas(L::count * 4) std::int32_t volume[L::count];
};

template <typename L>
OMMA_HD_CALLED void eval_lit_surfaces(const SceneView& scene, const Packet<L>& packet,
                                      const Hits<L>& hits, const HitGeometry<L>& geometry,
                                      const SpectraMemory& memory, LitSurface<L>& surface) {
  using F = typename L::F;
  using I = typename L::I;
  for (int l = 0; l < L::count; ++l) surface.material[l] = -1;
  for_each_mesh(hits, [&](std::int32_t index, int l, const auto& is_member) {
    const MeshView& mesh = scene.meshes[index];
    const MaterialView& material = scene.materials[mesh.material];
    const ScatterView& scatter = scene.scatter[mesh.material];
    const auto of_members = [&](const float* x) { return keep(is_member, load<F>(x + l)); };
    const SurfacePoint<F, I> p{keep(is_member, load<I>(packet.rays.triangle + l)),
                               of_members(packet.rays.u), of_members(packet.rays.v),
                               of_members(hits.footprint_m)};
    const auto set = [&](auto* values, auto value) {
      using Vector = decltype(value);
      store(values + l, is_member ? value : load<Vector>(values + l));
    };
    const auto set_band = [&](float* values, int b, F value) { set(values + b * L::count, value); };

    const Color<F> base = eval_base_color(scene, mesh, p);
    eval_spectra(scene, mesh, base, p, memory, set_band);
    if (scatter.emission != nullptr)
      eval_emitted(scene, mesh, scatter, p,
                   [&](int b, F light) { set_band(memory.emission, b, light); });

    const auto facing = load_vector<F>(geometry.normal, l);
    const auto direction = load_vector<F>(packet.rays.direction, l);
    const Vector3<F> geometric = select(dot(facing, direction) > 0.0f, opposite(facing), facing);
    ShadingNormals<F> normals{geometric, geometric};
    const bool maps_coat = mesh.factors != nullptr && mesh.factors->coat_normal.texture >= 0;
    if (mesh.normals != nullptr || mesh.normal_uv != nullptr || maps_coat) {
      F m[3][4];
      load_frames(scene, hits, l, is_member, m);
      normals = eval_shading_normals(scene, mesh, m, p, geometric);
    }
    const auto set_vector = [&](float(&values)[3][L::count], const Vector3<F>& value) {
      store_vector(values, l, select(is_member, value, load_vector<F>(values, l)));
    };
    set_vector(surface.normal, normals.below);
    set_vector(surface.geometric, geometric);
    if (scene.coat_albedo != nullptr) set_vector(surface.coat_normal, normals.coat);

    F roughness = broadcast<F>(scatter.roughness), metallic = broadcast<F>(scatter.metallic);
    if (mesh.roughness_uv != nullptr) {
      const Color<F> c = eval_texture_at(scene, mesh, scatter.roughness_texture, mesh.roughness_uv,
                                         mesh.roughness_density, p);
      roughness = roughness * clamp_unit_lanes(c.g);
      metallic = metallic * clamp_unit_lanes(c.b);
    }
    SurfaceFactors<F> own{broadcast<F>(scatter.specular), broadcast<F>(scatter.transmission),
                          broadcast<F>(scatter.clearcoat),
                          broadcast<F>(scatter.clearcoat_roughness)};
    if (mesh.factors != nullptr) {
      multiply_factors(scene, mesh, p, own);
      if (scatter.tint_from_rgb != nullptr)
        eval_tint(scene, mesh, scatter, p, [&](int b, F tint) { set_band(memory.tint, b, tint); });
    }
    set(surface.roughness, roughness);
    set(surface.metallic, metallic);
    set(surface.ior, broadcast<F>(scatter.ior));
    set(surface.specular, own.specular);
    set(surface.transmission, own.transmission);
    set(surface.alpha, opacity_of(material, base));
    set(surface.coat, own.coat);
    set(surface.coat_roughness, own.coat_roughness);
    set(surface.table, load<I>(hits.mesh + l) * 0 + scatter.albedo_table);
    if (scene.boundaries != nullptr)
      set(surface.boundary, load<I>(hits.mesh + l) * 0 + scatter.boundary);
    if (scene.has_volumes) {
      const I zero = load<I>(hits.mesh + l) * 0;
      const I side = dot(facing, direction) > 0.0f ? zero - 1 : zero + 1;
      set(surface.volume, scatter.refracts ? side : zero);
    }
    set(surface.material, keep(is_member, load<I>(hits.mesh + l) * 0 + mesh.material));
  });
}

// Tables of the boundaries that are met by lanes from l on, -1 where there is none.
template <typename L>
OMMA_HD typename L::I boundary_of(const SceneView& scene, const LitSurface<L>& surface, int l) {
  using I = typename L::I;
  const I material = load<I>(surface.material + l), no_table = material * 0 - 1;
  if (scene.boundaries == nullptr) return no_table;
  return material >= 0 ? load<I>(surface.boundary + l) : no_table;
}

// What is met by lanes from l on, for scatter.h.
template <typename L>
OMMA_HD ScatterSurface<typename L::F> scatter_surface(const SceneView& scene,
                                                      const RayPacket<L::count>& rays,
                                                      const LitSurface<L>& surface, int l) {
  using F = typename L::F;
  using I = typename L::I;
  ScatterSurface<F> s;
  const auto is_met = load<I>(surface.material + l) >= 0;
  const auto met = [&](const float* x) { return keep(is_met, load<F>(x + l)); };
  s.direction = load_vector<F>(rays.direction, l);
  s.geometric_normal = keep(is_met, load_vector<F>(surface.geometric, l));
  s.normal = keep(is_met, load_vector<F>(surface.normal, l));
  s.coat_normal = s.normal;
  if (scene.coat_albedo != nullptr)
    s.coat_normal = keep(is_met, load_vector<F>(surface.coat_normal, l));
  s.roughness = met(surface.roughness);
  s.metallic = met(surface.metallic);
  s.specular = met(surface.specular);
  s.transmission = met(surface.transmission);
  s.ior = is_met ? load<F>(surface.ior + l) : broadcast<F>(1.0f);
  s.coat = met(surface.coat);
  s.coat_roughness = met(surface.coat_roughness);
  s.table = keep(is_met, load<I>(surface.table + l));
  s.albedo_tables = scene.specular_albedo;
  s.coat_table = scene.coat_albedo;
  s.metal_table = scene.metal_albedo;
  return s;
}

}  // namespace omma
