// Flattens a validated Scene for the kernels.
#include "backend/shading_data.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace omma {
namespace {

// Texture coordinates beyond this have no fraction left in a float; legal in a file, but a texel
// index must come of them.
constexpr float most_repeats = 4194304.0f;  // 2^22

// sRGB code value in [0, 1] to linear (IEC 61966-2-1).
double linear_from_srgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// An 8-bit sRGB image in linear light. 16 bits hold it to within 7.6e-6 of full scale, and reading
// a texel then costs one load and one conversion instead of four table look-ups.
// With CompoundRay's colours the code values themselves are kept: they are raised to their power
// after interpolation.
std::vector<std::int32_t> linear16_from_srgb8(const std::vector<std::uint8_t>& rgba,
                                              ColorRule rule) {
  std::uint32_t color[256];
  for (int i = 0; i < 256; ++i) {
    const double code = i / 255.0;
    const double value = rule == ColorRule::gltf ? linear_from_srgb(code) : code;
    color[i] = static_cast<std::uint32_t>(std::lround(65535.0 * value));
  }
  std::vector<std::int32_t> linear(rgba.size() / 2);
  oneapi::tbb::parallel_for(std::size_t{0}, rgba.size() / 4, [&](std::size_t i) {
    const std::uint8_t* p = rgba.data() + 4 * i;
    linear[2 * i] = static_cast<std::int32_t>(color[p[0]] | color[p[1]] << 16);
    linear[2 * i + 1] = static_cast<std::int32_t>(color[p[2]] | 257u * p[3] << 16);
  });
  return linear;
}

TextureView image_view(const Image& image, const std::vector<std::int32_t>& linear16) {
  TextureView view;
  view.width = image.width;
  view.height = image.height;
  if (!linear16.empty()) view.linear16 = linear16.data();
  if (!image.rgba_linear.empty()) view.linear = image.rgba_linear.data();
  return view;
}

// Per triangle corner: one place in memory per hit instead of an index and three vertices.
template <typename T>
std::vector<T> per_corner(const Mesh& mesh, const std::vector<T>& per_vertex) {
  std::vector<T> corners(3 * mesh.triangles.size());
  oneapi::tbb::parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = per_vertex[mesh.triangles[i][k]];
  });
  return corners;
}

// KHR_texture_transform: uv' = offset + rotation * (scale * uv). The rotation is counter-clockwise
// as seen with v pointing down, u' = cos u + sin v, v' = -sin u + cos v: what the test model and
// the implementations do; the matrix printed in the extension's text turns the other way
// (KhronosGroup/glTF issue 1563).
std::vector<Vec2> corner_texcoords(const Mesh& mesh, const TextureUse& use) {
  const auto& source = mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)];
  const auto bounded = [](Vec2 t) {
    return Vec2{std::clamp(t.x, -most_repeats, most_repeats),
                std::clamp(t.y, -most_repeats, most_repeats)};
  };
  if (source.empty()) return std::vector<Vec2>(3 * mesh.triangles.size(), bounded(use.offset));
  std::vector<Vec2> uv = per_corner(mesh, source);
  const float c = std::cos(use.rotation_rad), s = std::sin(use.rotation_rad);
  oneapi::tbb::parallel_for(std::size_t{0}, uv.size(), [&](std::size_t i) {
    const Vec2 p{uv[i].x * use.scale.x, uv[i].y * use.scale.y};
    uv[i] = bounded({c * p.x + s * p.y + use.offset.x, -s * p.x + c * p.y + use.offset.y});
  });
  return uv;
}

MaterialView material_view(const Material& m) {
  return {m.base_color,
          m.unlit ? Vec3{} : m.emissive,  // KHR_materials_unlit: the base colour and nothing else
          m.base_color_texture.texture,
          m.emissive_texture.texture,
          m.alpha_cutoff,
          m.alpha_mode,
          m.double_sided};
}

}  // namespace

std::unique_ptr<ShadingData> make_shading_data(const Scene& scene) {
  auto data = std::make_unique<ShadingData>();
  for (const Image& image : scene.images)
    data->linear16.push_back(linear16_from_srgb8(image.rgba_srgb8, scene.color_rule));

  for (const Texture& texture : scene.textures) {
    const auto image = static_cast<std::size_t>(texture.image);
    TextureView view = image_view(scene.images[image], data->linear16[image]);
    view.wrap_u = texture.wrap_u;
    view.wrap_v = texture.wrap_v;
    view.filter = texture.filter;
    data->textures.push_back(view);
  }

  // The last material is glTF's default, for meshes without one: white, single-sided.
  for (const Material& material : scene.materials)
    data->materials.push_back(material_view(material));
  data->materials.push_back(material_view({}));
  data->materials.back().double_sided = scene.color_rule == ColorRule::compoundray;

  for (const Mesh& mesh : scene.meshes) {
    MeshView view;
    view.material =
        mesh.material >= 0 ? mesh.material : static_cast<std::int32_t>(scene.materials.size());
    if (mesh.material >= 0) {
      const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
      if (material.base_color_texture.texture >= 0) {
        data->corner_uvs.push_back(corner_texcoords(mesh, material.base_color_texture));
        view.base_uv = &data->corner_uvs.back().data()->x;
      }
      if (material.emissive_texture.texture >= 0) {
        data->corner_uvs.push_back(corner_texcoords(mesh, material.emissive_texture));
        view.emissive_uv = &data->corner_uvs.back().data()->x;
      }
      data->view.has_blend |= material.alpha_mode == AlphaMode::blend;
    }
    if (!mesh.colors.empty()) {
      data->corner_colors.push_back(per_corner(mesh, mesh.colors));
      view.colors = &data->corner_colors.back().data()->x;
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
  return data;
}

BackgroundData make_background_data(const Background& background) {
  BackgroundData data;
  data.view.type = background.type;
  data.view.color = background.color;
  if (background.type == BackgroundType::image) {
    data.linear16 = linear16_from_srgb8(background.image.rgba_srgb8, ColorRule::gltf);
    data.view.image = image_view(background.image, data.linear16);
    data.view.image.wrap_v = Wrap::clamp_to_edge;
  }
  return data;
}

}  // namespace omma
