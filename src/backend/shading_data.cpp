// Flattens a validated Scene for the physics.
#include "backend/shading_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "threads/parallel.h"

namespace omma {
namespace {

// Texture coordinates beyond this have no fraction left in a float; legal in a file, but a texel
// index must come of them.
constexpr float most_repeats = 4194304.0f;  // 2^22

// Per triangle corner: one place in memory per hit instead of an index and three vertices.
template <typename T>
std::vector<T> per_corner(const Mesh& mesh, const std::vector<T>& per_vertex) {
  std::vector<T> corners(3 * mesh.triangles.size());
  parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = per_vertex[mesh.triangles[i][k]];
  });
  return corners;
}

// KHR_texture_transform: uv' = offset + rotation * (scale * uv). The rotation is counter-clockwise
// as seen with v pointing down, u' = cos u + sin v, v' = -sin u + cos v: what the test model and
// the implementations do; the matrix printed in the extension's text turns the other way
// (KhronosGroup/glTF issue 1563). Of every corner, or of every vertex.
std::vector<Vec2> made_texcoords(const Mesh& mesh, const TextureUse& use, bool of_vertices) {
  const auto& source = mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)];
  const auto bounded = [](Vec2 t) {
    return Vec2{std::clamp(t.x, -most_repeats, most_repeats),
                std::clamp(t.y, -most_repeats, most_repeats)};
  };
  const std::size_t count = of_vertices ? mesh.positions.size() : 3 * mesh.triangles.size();
  if (source.empty()) return std::vector<Vec2>(count, bounded(use.offset));
  std::vector<Vec2> uv = of_vertices ? source : per_corner(mesh, source);
  const float c = std::cos(use.rotation_rad), s = std::sin(use.rotation_rad);
  parallel_for(std::size_t{0}, uv.size(), [&](std::size_t i) {
    const Vec2 p{uv[i].x * use.scale.x, uv[i].y * use.scale.y};
    uv[i] = bounded({c * p.x + s * p.y + use.offset.x, -s * p.x + c * p.y + use.offset.y});
  });
  return uv;
}

// Whether vertices' coordinates are what made_texcoords would make of them.
bool is_as_made(const std::vector<Vec2>& source, const TextureUse& use) {
  const auto bounded = [](Vec2 t) {
    return std::fabs(t.x) <= most_repeats && std::fabs(t.y) <= most_repeats;
  };
  return !source.empty() && use.offset.x == 0 && use.offset.y == 0 && use.scale.x == 1 &&
         use.scale.y == 1 && use.rotation_rad == 0 &&
         std::all_of(source.begin(), source.end(), bounded);
}

// Textures as materials use them: where their alpha matters, coarser levels differ.
struct TextureTable {
  const Scene& scene;
  ShadingData& data;
  bool large;  // see most_fast_texels
  std::map<std::tuple<int, AlphaUse, bool>, const TextureLevels*> levels_of_image = {};
  std::map<std::tuple<int, AlphaUse>, std::int32_t> view_of_texture = {};

  // Index of the view, made where there is none yet.
  std::int32_t find(int texture, AlphaUse alpha) {
    if (texture < 0) return -1;
    const auto [known, is_new] = view_of_texture.try_emplace(
        {texture, alpha}, static_cast<std::int32_t>(data.textures.size()));
    if (!is_new) return known->second;
    const Texture& t = scene.textures[static_cast<std::size_t>(texture)];
    const Image& image = scene.images[static_cast<std::size_t>(t.image)];
    // CompoundRay's colours are not linear before they are interpolated, nearest texels are asked
    // for as they are: neither can be averaged.
    const bool levels = scene.color_rule == ColorRule::gltf && t.filter == Filter::linear;
    const TextureLevels*& made = levels_of_image[{t.image, alpha, levels}];
    if (made == nullptr) {
      data.levels.push_back(make_texture_levels(image, scene.color_rule, alpha, levels, large));
      made = &data.levels.back();
    }
    TextureView view = view_levels(image, *made);
    view.wrap_u = t.wrap_u;
    view.wrap_v = t.wrap_v;
    view.filter = t.filter;
    data.textures.push_back(view);
    return known->second;
  }
};

std::size_t texels_of_8_bits(const Scene& scene) {
  std::size_t texels = 0;
  for (const Image& image : scene.images) texels += image.rgba_srgb8.size() / 4;
  return texels;
}

MaterialView material_view(const Material& m, TextureTable& textures) {
  AlphaUse alpha{m.alpha_mode};
  if (m.alpha_mode == AlphaMode::mask && m.base_color.w > 0)
    alpha.cutoff = m.alpha_cutoff / m.base_color.w;
  return {m.base_color,
          m.unlit ? Vec3{} : m.emissive,  // KHR_materials_unlit: the base colour and nothing else
          textures.find(m.base_color_texture.texture, alpha),
          textures.find(m.emissive_texture.texture, {}),
          m.alpha_cutoff,
          m.alpha_mode,
          m.double_sided};
}

}  // namespace

std::unique_ptr<ShadingData> make_shading_data(const Scene& scene) {
  auto data = std::make_unique<ShadingData>();
  // The last material is glTF's default, for meshes without one: white, single-sided.
  TextureTable textures{scene, *data, texels_of_8_bits(scene) > most_fast_texels};
  for (const Material& material : scene.materials)
    data->materials.push_back(material_view(material, textures));
  data->materials.push_back(material_view({}, textures));
  data->materials.back().double_sided = scene.color_rule == ColorRule::compoundray;

  std::size_t triangles = 0;
  for (const Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  const bool large = triangles > most_fast_triangles;

  for (const Mesh& mesh : scene.meshes) {
    MeshView view;
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
        const std::vector<Vec2>* uvs = &mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)];
        if (!large || !is_as_made(*uvs, use)) {
          data->uvs.push_back(made_texcoords(mesh, use, large));
          uvs = &data->uvs.back();
        }
        uv = &uvs->data()->x;
        const TextureView& t = data->textures[static_cast<std::size_t>(texture)];
        if (t.last_level == 0) return;
        data->densities.push_back(texel_density(mesh, *uvs, large, t));
        density = data->densities.back().data();
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
  view.meshes = data->meshes.data();
  view.materials = data->materials.data();
  view.textures = data->textures.data();
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
  return data;
}

BackgroundData make_background_data(const Background& background) {
  BackgroundData data;
  data.view.type = background.type;
  data.view.color = background.color;
  if (background.type == BackgroundType::image) {
    const Image& image = background.image;
    const bool large = image.rgba_srgb8.size() / 4 > most_fast_texels;
    data.levels = make_texture_levels(image, ColorRule::gltf, {}, true, large);
    data.view.image = view_levels(background.image, data.levels);
    data.view.image.wrap_v = Wrap::clamp_to_edge;
    data.view.image_density = panorama_density(data.view.image);
  }
  return data;
}

}  // namespace omma
