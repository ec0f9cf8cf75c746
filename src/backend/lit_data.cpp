// Puts together what a lit world reads.
#include "backend/lit_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "backend/albedo_tables.h"
#include "model/new_version.h"
#include "physics/surface/boundary_table.h"
#include "physics/surface/scatter.h"

namespace omma {
namespace {

// A table of the boundary's albedo for each refractive index, and whose is which.
void make_albedos(LitData& lit) {
  std::map<float, std::int32_t> table_of_ior;
  for (ScatterView& material : lit.scatter->materials) {
    const auto table = static_cast<std::int32_t>(table_of_ior.size());
    const auto [known, is_new] = table_of_ior.try_emplace(material.ior, table);
    material.albedo_table = known->second;
    if (!is_new) continue;
    const std::vector<float> made = make_specular_albedo(static_cast<double>(material.ior));
    lit.albedos.insert(lit.albedos.end(), made.begin(), made.end());
  }
  const bool has_coat =
      std::any_of(lit.scatter->materials.begin(), lit.scatter->materials.end(),
                  [](const ScatterView& material) { return material.clearcoat > 0; });
  if (has_coat) lit.coat_albedo = make_specular_albedo(static_cast<double>(coat_ior));
  const bool has_metal =
      std::any_of(lit.scatter->materials.begin(), lit.scatter->materials.end(),
                  [](const ScatterView& material) { return material.metallic > 0; });
  if (has_metal) lit.metal_albedo = make_specular_albedo(std::numeric_limits<double>::infinity());
}

// The lights that baked light leaves to next-event estimation: discs and lamps.
void leave_out_baked(const LightData& data, BakedReading& reading) {
  LightView& light = reading.left_out;
  light = data.view;
  reading.discs_alone = data.discs;
  light.discs = reading.discs_alone.data();
  float discs = 0;
  for (const DiscView& disc : reading.discs_alone) discs += disc.probability;
  for (DiscView& disc : reading.discs_alone) disc.probability /= discs > 0 ? discs : 1.0f;
  light.sky.probability = 0;
  light.from_surfaces = {};
  reading.discs_sent.assign(static_cast<std::size_t>(light.bands), 0.0f);
  float all = 0;
  for (const DiscView& disc : reading.discs_alone)
    for (int b = 0; b < light.bands && disc.probability > 0; ++b) {
      const float sent = disc.radiance[b] / disc.density;
      reading.discs_sent[static_cast<std::size_t>(b)] += sent;
      all += sent;
    }
  light.from_afar = {reading.discs_sent.data(), all};
}

}  // namespace

void read_baked(const BakedLight& baked, const LightData& light, const MovingFrames& frames,
                BakedReading& reading) {
  leave_out_baked(light, reading);
  reading.mesh_cells.clear();
  for (const std::vector<std::int32_t>& first : baked.cell_of_triangle)
    reading.mesh_cells.push_back(
        first.empty() ? MeshCells{}
                      : MeshCells{first.data(), static_cast<std::int32_t>(first.size()) - 1});
  BakedView& view = reading.view;
  view.version = new_version();
  view.values = baked.lines.empty() ? nullptr : baked.lines.front().values;
  view.errors = baked.errors.empty() ? nullptr : baked.errors.data();
  view.first_cell = baked.first_cell.data();
  view.mesh_cells = reading.mesh_cells.data();
  view.moves = frames.moves;
  view.probe_values = baked.probe_values.data();
  for (int a = 0; a < 3; ++a) {
    view.probe_origin_m[a] = baked.probe_origin_m[a];
    view.probe_spacing_m[a] = baked.probe_spacing_m[a];
    view.probes[a] = baked.probes[a];
  }
  view.first_origin_m = frames.lamp_origin_now_m;
  view.unit = static_cast<float>(baked.unit / light.radiance_unit);
  constexpr std::size_t values_per_line = sizeof(BakedLine) / sizeof(std::uint16_t);
  view.value_count = static_cast<std::int64_t>(baked.lines.size() * values_per_line);
  view.cell_count = baked.cells;
  view.instance_count = static_cast<std::int32_t>(baked.first_cell.size());
  view.mesh_count = static_cast<std::int32_t>(reading.mesh_cells.size());
}

std::unique_ptr<LitData> make_lit_data(const Lighting& lighting, const Scene& scene,
                                       const Placement& placement, const MovingFrames& frames) {
  auto lit = std::make_unique<LitData>();
  const Light& light = lighting.light;
  lit->shading = make_shading_data(scene);
  lit->scatter = make_scatter_data(scene, light, *lit->shading);
  std::vector<ScatterView>& materials = lit->scatter->materials;
  make_albedos(*lit);
  check_emission(light, scene);
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    lit->emission.push_back(make_emission_matrix(light, scene.materials[m]));
    if (!lit->emission.back().empty()) materials[m].emission = lit->emission.back().data();
  }
  if (!scene.splats.empty())
    lit->splat_emission = make_splat_emission(light, scene.splats.front().bands_nm);
  SceneView& view = lit->view;
  view = lit->shading->view;
  view.version = new_version();
  view.shines = std::any_of(materials.begin(), materials.end(),
                            [](const ScatterView& m) { return m.emission != nullptr; });
  view.frame_from_mesh = frames.frame_from_mesh;
  view.bands = static_cast<int>(light.bands.count());
  view.scatter = materials.data();
  view.specular_albedo = lit->albedos.data();
  view.albedo_table_count = static_cast<std::int32_t>(lit->albedos.size() / albedo_floats);
  view.coat_albedo = lit->coat_albedo.empty() ? nullptr : lit->coat_albedo.data();
  view.metal_albedo = lit->metal_albedo.empty() ? nullptr : lit->metal_albedo.data();
  if (!lit->scatter->boundaries.empty()) {
    view.boundaries = lit->scatter->boundaries.data();
    const std::size_t floats = 2 * static_cast<std::size_t>(boundary_pairs) * light.bands.count();
    view.boundary_count = static_cast<std::int32_t>(lit->scatter->boundaries.size() / floats);
  }
  view.has_glass = std::any_of(materials.begin(), materials.end(),
                               [](const ScatterView& m) { return m.transmission > 0; });
  view.has_volumes = std::any_of(materials.begin(), materials.end(),
                                 [](const ScatterView& m) { return m.refracts; });
  view.depth = lighting.depth;
  view.polarized = lighting.polarized;
  lit->light = make_light_data(light, scene, placement, view);
  if (!lighting.polarized) keep_intensity_alone(*lit->light);
  scale_to_radiance_unit(*lit->light);
  place_lamps(*lit->light, scene, frames.lamp_origin_m);
  lit->light->view.lamp_origin_m = frames.lamp_origin_now_m;
  view.light = &lit->light->view;
  const auto per_unit = static_cast<float>(1 / lit->light->radiance_unit);
  for (std::vector<float>& matrix : lit->emission)
    for (float& x : matrix) x *= per_unit;
  for (float& x : lit->splat_emission) x *= per_unit;
  if (!lit->splat_emission.empty()) view.splat_emission = lit->splat_emission.data();
  if (lighting.baked != nullptr) {
    lit->baked_light = lighting.baked;
    read_baked(*lighting.baked, *lit->light, frames, lit->baked);
    view.light = &lit->baked.left_out;
    view.baked = &lit->baked.view;
    if (lit->baked.view.errors != nullptr) view.all_lights = &lit->light->view;
  }
  return lit;
}

}  // namespace omma
