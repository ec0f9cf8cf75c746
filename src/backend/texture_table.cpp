// Textures and their coordinates as flat arrays.
#include "backend/texture_table.h"

#include <algorithm>
#include <cmath>

namespace omma {
namespace {

// Texture coordinates beyond this have no fraction left in a float; legal in a file, but a texel
// index must come of them.
constexpr float most_repeats = 4194304.0f;  // 2^22

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

// Whether footprints read averages of a texture. CompoundRay's colours are not linear before they
// are interpolated, nearest texels are asked for as they are: neither can be averaged. Of cut-outs
// rays meet the image's own outline, and what a footprint averages over is not what is seen: tips
// of grass would have the colour of what lies beside them in the image.
bool is_averaged(const Scene& scene, const Texture& texture, AlphaMode alpha) {
  return scene.color_rule == ColorRule::gltf && texture.filter == Filter::linear &&
         alpha != AlphaMode::mask;
}

std::size_t texels_of_8_bits(const Scene& scene) {
  std::size_t texels = 0;
  for (const Image& image : scene.images) texels += image.rgba_srgb8.size() / 4;
  return texels;
}

}  // namespace

std::int32_t find_texture(const Scene& scene, ShadingData& data, int texture, AlphaMode alpha,
                          ImageCodes codes) {
  if (texture < 0) return -1;
  const auto [known, is_new] = data.view_of_texture.try_emplace(
      {texture, alpha, codes}, static_cast<std::int32_t>(data.textures.size()));
  if (!is_new) return known->second;
  const Texture& t = scene.textures[static_cast<std::size_t>(texture)];
  const Image& image = scene.images[static_cast<std::size_t>(t.image)];
  const bool levels = is_averaged(scene, t, alpha);
  TextureLevels*& made = data.levels_of_image[{t.image, alpha, codes, levels}];
  if (made == nullptr) {
    const bool large = texels_of_8_bits(scene) > most_fast_texels;
    data.levels.push_back(make_texture_levels(image, codes, alpha, levels, large));
    made = &data.levels.back();
  }
  TextureView view = view_levels(image, *made);
  view.wrap_u = t.wrap_u;
  view.wrap_v = t.wrap_v;
  view.filter = t.filter;
  data.textures.push_back(view);
  return known->second;
}

void replace_image(const Scene& scene, ShadingData& data, int image, const Image& picture) {
  const bool large = texels_of_8_bits(scene) > most_fast_texels;
  std::vector<std::pair<TextureLevels*, TextureLevels>> made;
  for (const auto& [key, levels] : data.levels_of_image) {
    const auto& [of_image, alpha, codes, has_levels] = key;
    if (of_image == image)
      made.emplace_back(levels, make_texture_levels(picture, codes, alpha, has_levels, large));
  }
  for (auto& [levels, now] : made) *levels = std::move(now);
  for (const auto& [key, index] : data.view_of_texture) {
    const auto& [texture, alpha, codes] = key;
    const Texture& t = scene.textures[static_cast<std::size_t>(texture)];
    if (t.image != image) continue;
    const bool has_levels = is_averaged(scene, t, alpha);
    TextureView& view = data.textures[static_cast<std::size_t>(index)];
    view = view_levels(picture, *data.levels_of_image.at({image, alpha, codes, has_levels}));
    view.wrap_u = t.wrap_u;
    view.wrap_v = t.wrap_v;
    view.filter = t.filter;
  }
}

const Vec2* texture_coordinates(const Mesh& mesh, const TextureUse& use, bool large,
                                ShadingData& data) {
  const std::vector<Vec2>& source = mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)];
  if (large && is_as_made(source, use)) return source.data();
  data.uvs.push_back(made_texcoords(mesh, use, large));
  return data.uvs.back().data();
}

const float* texel_densities(const Mesh& mesh, const Vec2* uvs, std::int32_t texture, bool large,
                             ShadingData& data) {
  const TextureView& view = data.textures[static_cast<std::size_t>(texture)];
  if (view.last_level == 0) return nullptr;
  data.densities.push_back(texel_density(mesh, uvs, large, view));
  return data.densities.back().data();
}

}  // namespace omma
