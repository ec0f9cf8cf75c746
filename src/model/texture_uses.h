// The textures that materials read, and meshes without the coordinates for them.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "omma/scene.h"

namespace omma {

// All but that of the extra reflectance.
inline constexpr std::array<TextureUse Material::*, 12> texture_uses = {
    &Material::base_color_texture,         &Material::emissive_texture,
    &Material::metallic_roughness_texture, &Material::normal_texture,
    &Material::specular_texture,           &Material::specular_color_texture,
    &Material::transmission_texture,       &Material::diffuse_transmission_texture,
    &Material::clearcoat_texture,          &Material::clearcoat_roughness_texture,
    &Material::clearcoat_normal_texture,   &Material::diffuse_transmission_factor_texture};

// Whether a mesh is without a set of texture coordinates that its material reads.
inline bool lacks_coordinates(const Mesh& mesh, const Material& material) {
  const auto lacks = [&](const TextureUse& use) {
    return use.texture >= 0 && mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)].empty();
  };
  return lacks(material.extra.texture) ||
         std::any_of(texture_uses.begin(), texture_uses.end(),
                     [&](TextureUse Material::*use) { return lacks(material.*use); });
}

inline constexpr char without_coordinates[] =
    "a mesh has no texture coordinates, which a texture of its material needs: all of it gets the "
    "texel at (0, 0)";

// The meshes of a scene of which that is so: a sentence, or none.
inline std::vector<std::string> coordinate_warnings(const Scene& scene) {
  std::string first;
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (mesh.material < 0 ||
        !lacks_coordinates(mesh, scene.materials[static_cast<std::size_t>(mesh.material)]))
      continue;
    if (count++ == 0)
      first = "mesh " + std::to_string(i) + (mesh.name.empty() ? "" : " \"" + mesh.name + "\"");
  }
  if (count == 0) return {};
  const std::string more = count > 1 ? " and " + std::to_string(count - 1) + " more" : "";
  return {std::string(without_coordinates) + " (" + first + more + ")"};
}

}  // namespace omma
