// A lit world that has all that a world can have: what the physics reads of it leaves no array out
// but those of large scenes.
#pragma once

#include <memory>

#include "light_maps.h"
#include "omma/world.h"
#include "test_scenes.h"

namespace omma::test {

// Materials with textures of all kinds, normals, lamps, surfaces that shine. `glass`: light goes
// straight through some.
inline Scene scene_with_everything(bool glass) {
  Scene scene = random_scene(7);
  const int textures = static_cast<int>(scene.textures.size());
  int use = 0;
  const auto next = [&] {
    TextureUse texture;
    texture.texture = use++ % textures;
    texture.texcoord_set = use % 2;
    return texture;
  };
  const Spectrum spectrum{{300, 500, 700}, {0.1, 0.4, 0.3}};
  for (std::size_t i = 0; i < scene.meshes.size(); ++i)
    scene.meshes[i].material = static_cast<int>(i);
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    Material& m = scene.materials[i];
    m.unlit = i == 4;
    m.double_sided = true;
    if (!glass && m.alpha_mode == AlphaMode::blend) m.alpha_mode = AlphaMode::opaque;
    m.roughness = 0.5f;
    m.metallic = i % 2 == 0 ? 0.5f : 0.0f;
    m.metallic_roughness_texture = next();
    m.normal_texture = next();
    m.specular_texture = next();
    if (i % 3 == 0) m.specular_color_texture = next();
    m.specular_color = {0.9f, 0.8f, 0.7f};
    m.ior = i % 4 == 0 ? 1.3f : 1.5f;
    if (glass && i % 2 == 1) {
      m.transmission = 0.5f;
      m.transmission_texture = next();
    }
    m.diffuse_transmission = 0.3f;
    m.diffuse_transmission_texture = next();
    if (i % 2 == 0) m.diffuse_transmission_factor_texture = next();
    m.clearcoat = i % 2 == 0 ? 0.5f : 0.0f;
    m.clearcoat_roughness = 0.3f;
    m.clearcoat_texture = next();
    m.clearcoat_roughness_texture = next();
    if (i % 4 == 0) m.clearcoat_normal_texture = next();
    if (i % 3 == 1) {
      m.reflectance = spectrum;
      m.transmittance = spectrum;
    } else {
      m.extra.texture = next();
      m.extra.spectrum[1] = spectrum;
    }
    if (i == 0)
      m.boundary = {{300, 700}, 2, {1, 0, -0.9f, 0.2f, 0, -0.2f, 1, 0, 1, 0.6f, 0.3f, -0.4f}};
    if (i == 2) {
      m.emissive = {1, 1, 1};
      m.emissive_texture = next();
      m.emission = spectrum;
    }
  }
  for (Mesh& mesh : scene.meshes)
    if (mesh.material % 2 == 0)
      for (const Vec3 p : mesh.positions) mesh.normals.push_back(p + Vec3{0, 0, 3});
  const Mat4 above = translation({0, 1, 0}) * rotation({1, 0, 0}, -1.2);
  for (const PunctualLightType type :
       {PunctualLightType::point, PunctualLightType::spot, PunctualLightType::directional})
    scene.lights.push_back({"", type, {1, 0.9f, 0.8f}, 100, 0, 0.2, 0.7, above, {}});
  scene.lights.back().spectrum = spectrum;
  return scene;
}

inline Lighting lighting_with_everything(bool polarized, std::size_t discs) {
  Lighting lighting;
  lighting.polarized = polarized;
  Light& light = lighting.light;
  light.cloud_shadow = std::make_shared<const CloudShadow>(
      CloudShadow{3, 2, 2.5, 20, 1, -1, {0, 0.5f, 1, 2, 0.1f, 0.3f}});
  light.unit = LightUnit::watts;
  light.bands = narrow_bands(5);
  auto sky = std::make_shared<SkyMap>(
      *made_sky(9, 4, polarized ? 3 : 1, 2, [](int half, int row, int column, int component, int) {
        return (component == 0 ? 1.0 + 0.1 * column : 0.2) * (half == 0 ? 1.0 + row : 0.5);
      }));
  for (int k = 0; k < 10; ++k) sky->band_from_channel.push_back(0.1 * (1 + k));
  light.sky = sky;
  for (std::size_t d = 0; d < discs; ++d) {
    Disc disc;
    disc.direction = to_float(from_azimuth_elevation(1.0 + static_cast<double>(d), 0.8));
    disc.angular_radius_rad = 0.005;
    disc.radiance.assign(5, 2e4);
    if (d == 0) disc.limb_darkening.assign(5, 0.6);
    light.discs.push_back(disc);
  }
  return lighting;
}

}  // namespace omma::test
