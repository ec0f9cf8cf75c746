// Flattens a validated Scene for the physics.
#include "backend/shading_data.h"

#include <cmath>

#include "backend/texture_table.h"
#include "model/new_version.h"
#include "model/scene_light.h"

namespace omma {
namespace {

MaterialView material_view(const Scene& scene, const Material& m, ShadingData& data) {
  const bool gltf = scene.color_rule == ColorRule::gltf;
  const ImageCodes codes = gltf ? ImageCodes::srgb : ImageCodes::linear;
  return {m.base_color,
          m.unlit ? Vec3{} : m.emissive,  // KHR_materials_unlit: the base colour and nothing else
          find_texture(scene, data, m.base_color_texture.texture, m.alpha_mode, codes),
          find_texture(scene, data, m.emissive_texture.texture, {}, codes),
          m.alpha_cutoff,
          m.alpha_mode,
          m.double_sided || refracts(m),  // a volume is left through backs
          !m.unlit && m.transmission > 0};
}

}  // namespace

bool is_large(const Scene& scene) {
  std::size_t triangles = 0;
  for (const Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  return triangles > most_fast_triangles;
}

std::unique_ptr<ShadingData> make_shading_data(const Scene& scene) {
  auto data = std::make_unique<ShadingData>();
  // The last material is glTF's default, for meshes without one: white, single-sided.
  for (const Material& material : scene.materials)
    data->materials.push_back(material_view(scene, material, *data));
  data->materials.push_back(material_view(scene, {}, *data));
  data->materials.back().double_sided = scene.color_rule == ColorRule::compoundray;

  const bool large = is_large(scene);

  for (const Mesh& mesh : scene.meshes) {
    MeshView view;
    view.triangle_count = static_cast<std::int32_t>(mesh.triangles.size());
    view.vertex_count = static_cast<std::int32_t>(mesh.positions.size());
    if (!mesh.triangles.empty()) {
      view.positions = &mesh.positions.data()->x;
      view.triangles = reinterpret_cast<const std::int32_t*>(mesh.triangles[0].data());
    }
    if (large) view.vertex_of_corner = view.triangles;
    view.material =
        mesh.material >= 0 ? mesh.material : static_cast<std::int32_t>(scene.materials.size());
    if (mesh.material >= 0) {
      const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
      const MaterialView& seen = data->materials[static_cast<std::size_t>(mesh.material)];
      const auto lay_out = [&](const TextureUse& use, std::int32_t texture, const float*& uv,
                               const float*& density) {
        if (texture < 0) return;
        const Vec2* uvs = texture_coordinates(mesh, use, large, *data);
        uv = &uvs->x;
        density = texel_densities(mesh, uvs, texture, large, *data);
      };
      lay_out(material.base_color_texture, seen.base_texture, view.base_uv, view.base_density);
      lay_out(material.emissive_texture, seen.emissive_texture, view.emissive_uv,
              view.emissive_density);
      data->view.has_blend |= material.alpha_mode == AlphaMode::blend;
    }
    if (!mesh.colors.empty()) {
      if (!large) data->colors.push_back(per_corner(mesh, mesh.colors));
      view.colors = large ? &mesh.colors.data()->x : &data->colors.back().data()->x;
    }
    data->meshes.push_back(view);
  }

  SceneView& view = data->view;
  view.version = new_version();
  for (MeshView& mesh : data->meshes) mesh.shape_version = view.version;
  view.meshes = data->meshes.data();
  view.materials = data->materials.data();
  view.textures = data->textures.data();
  view.mesh_count = static_cast<std::int32_t>(data->meshes.size());
  view.material_count = static_cast<std::int32_t>(data->materials.size());
  view.texture_count = static_cast<std::int32_t>(data->textures.size());
  view.instance_count = static_cast<std::int32_t>(scene.instances.size());
  if (scene.color_rule == ColorRule::compoundray) {
    for (int i = 0; i < power_22_size; ++i)
      data->power_22.push_back(static_cast<float>(std::pow(i / (power_22_size - 1.0), 2.2)));
    view.power_22 = data->power_22.data();
  }

  std::vector<std::size_t> triangle_counts;
  for (const Mesh& mesh : scene.meshes) triangle_counts.push_back(mesh.triangles.size());
  data->opacity = make_opacity_maps(view, triangle_counts);
  for (std::size_t m = 0; m < data->meshes.size(); ++m)
    if (!data->opacity.triangles[m].empty())
      data->meshes[m].opacity = data->opacity.triangles[m].data();
  view.opacity_states = data->opacity.states.data();
  view.opacity_word_count = static_cast<std::int64_t>(data->opacity.states.size());
  return data;
}

BackgroundData make_background_data(const Background& background) {
  BackgroundData data;
  data.view.type = background.type;
  data.view.color = background.color;
  if (background.type == BackgroundType::image) {
    const Image& image = background.image;
    const bool large = image.rgba_srgb8.size() / 4 > most_fast_texels;
    data.levels = make_texture_levels(image, ImageCodes::srgb, {}, true, large);
    data.view.image = view_levels(background.image, data.levels);
    data.view.image.wrap_v = Wrap::clamp_to_edge;
    data.view.image_density = panorama_density(data.view.image);
  }
  return data;
}

}  // namespace omma
