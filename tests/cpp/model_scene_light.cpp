// What a scene must be to be lit: numbers of scattering and lamps, and no more than white.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "model/scene_light.h"
#include "omma/omma.h"

namespace omma::test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::string material_error(const std::function<void(Material&)>& change) {
  Scene scene;
  Material material;
  material.name = "paint";
  change(material);
  scene.materials.push_back(material);
  return error_of([&] { validate_scene(scene); });
}

std::string light_error(const std::function<void(PunctualLight&)>& change) {
  Scene scene;
  PunctualLight light;
  change(light);
  scene.lights.push_back(light);
  return error_of([&] { validate_scene(scene); });
}

TEST(SceneLight, NumbersOfMaterials) {
  EXPECT_EQ(material_error([](Material&) {}), "");
  const std::pair<const char*, float Material::*> fractions[] = {
      {"metallic", &Material::metallic},
      {"roughness", &Material::roughness},
      {"specular", &Material::specular},
      {"transmission", &Material::transmission},
      {"diffuse_transmission", &Material::diffuse_transmission},
      {"clearcoat", &Material::clearcoat},
      {"clearcoat_roughness", &Material::clearcoat_roughness}};
  for (const auto& [name, member] : fractions) {
    const std::string place = std::string("scene: material 0 \"paint\": ") + name;
    for (const float bad : {-0.1f, 1.1f, nan})
      EXPECT_EQ(material_error([&, m = member](Material& one) {
                  one.*m = bad;
                }).find(place + ": expected 0 to 1, found "),
                0u);
    for (const float good : {0.0f, 1.0f})
      EXPECT_EQ(material_error([&, m = member](Material& one) { one.*m = good; }), "");
  }
  for (const float bad : {0.0f, 0.9f, 11.0f, nan})
    EXPECT_NE(material_error([&](Material& m) { m.ior = bad; }).find("ior: expected 1 to 10"),
              std::string::npos);
  EXPECT_NE(material_error([](Material& m) { m.normal_scale = nan; }), "");
  EXPECT_NE(material_error([](Material& m) { m.specular_color.y = 2; }), "");
  EXPECT_NE(material_error([](Material& m) { m.diffuse_transmission_color.z = -1; }), "");
  EXPECT_NE(material_error([](Material& m) { m.spectral_luminance = -1; }), "");
  EXPECT_NE(material_error([](Material& m) { m.normal_texture.texture = 0; }), "");
  EXPECT_NE(material_error([](Material& m) { m.extra.texture.texture = 0; }), "");
  EXPECT_NE(material_error([](Material& m) { m.extra.spectrum[2] = {{300, 400}, {1, 1}}; }), "");
}

TEST(SceneLight, Spectra) {
  const auto with = [](Spectrum spectrum) {
    return material_error([&](Material& m) { m.reflectance = spectrum; });
  };
  EXPECT_EQ(with({{300, 700}, {0, 1}}), "");
  EXPECT_NE(with({{300, 700}, {0, 1, 1}}), "");
  EXPECT_NE(with({{300, 700}, {0, nan}}), "");
  EXPECT_NE(with({{300, nan}, {0, 1}}), "");
  EXPECT_NE(with({{300, 300}, {0, 1}}), "");
  EXPECT_NE(with({{300, 5001}, {0, 1}}), "");
  Spectrum fine{{}, std::vector<double>(10000, 0.5)};
  for (int i = 0; i < 10000; ++i) fine.wavelength_nm.push_back(200 + 0.1 * i);
  EXPECT_EQ(with(fine), "");
  fine.wavelength_nm.push_back(4000);
  fine.value.push_back(0.5);
  EXPECT_NE(with(fine), "");
  // Rounding of what adds up to 1 passes.
  const auto both = [](double reflected, double transmitted) {
    return material_error([&](Material& m) {
      m.reflectance = {{300, 700}, {reflected, reflected}};
      m.transmittance = {{300, 700}, {transmitted, transmitted}};
    });
  };
  EXPECT_EQ(both(0.7, 0.3 + 5e-7), "");
  EXPECT_NE(both(0.7, 0.3 + 5e-6), "");
  EXPECT_NE(material_error([](Material& m) { m.emission = {{300, 700}, {0, infinity}}; }), "");
  EXPECT_EQ(material_error([](Material& m) { m.emission = {{300, 700}, {0, 1e6}}; }), "");
}

TEST(SceneLight, Lamps) {
  EXPECT_EQ(light_error([](PunctualLight&) {}), "");
  EXPECT_EQ(light_error([](PunctualLight& l) {
              l.intensity = infinity;
            }).find("scene: light 0: intensity: expected"),
            0u);
  for (const double bad : {-1.0, infinity, static_cast<double>(nan)}) {
    EXPECT_NE(light_error([&](PunctualLight& l) { l.intensity = bad; }), "");
    EXPECT_NE(light_error([&](PunctualLight& l) { l.range_m = bad; }), "");
    EXPECT_NE(light_error([&](PunctualLight& l) { l.color.y = static_cast<float>(bad); }), "");
    EXPECT_NE(light_error([&](PunctualLight& l) { l.spectrum = {{300, 400}, {0, bad}}; }), "");
  }
  EXPECT_NE(light_error([](PunctualLight& l) { l.world_from_light.m[0][3] = infinity; }), "");
  const auto cones = [](double inner, double outer) {
    return light_error([&](PunctualLight& l) {
      l.inner_cone_rad = inner;
      l.outer_cone_rad = outer;
    });
  };
  EXPECT_EQ(cones(0, pi / 2), "");
  EXPECT_NE(cones(0, 1.6), "");
  EXPECT_NE(cones(0.5, 0.5), "");
  EXPECT_NE(cones(-0.1, 0.5), "");
}

TEST(SceneLight, NormalsThatAreZero) {
  Scene scene;
  scene.meshes.push_back({"m", {{0, 0, 0}}, {}, {{0, 0, 0}}, {}, {}, -1});
  EXPECT_EQ(error_of([&] { validate_scene(scene); }),
            "scene: mesh 0 \"m\": the normal of vertex 0 is zero");
}

// A triangle of one material that is changed.
Scene lit_scene(const std::function<void(Scene&, Material&)>& change) {
  Scene scene;
  scene.materials.emplace_back().name = "paint";
  scene.meshes.push_back({"", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}, {}, 0});
  scene.instances.push_back({"", 0, {}});
  change(scene, scene.materials[0]);
  validate_scene(scene);
  return scene;
}

std::string lit_error(const std::function<void(Scene&, Material&)>& change) {
  const Scene scene = lit_scene(change);
  return error_of([&] { check_lit_scene(scene); });
}

TEST(LitScene, GivesBackNoMoreThanItGets) {
  EXPECT_EQ(lit_error([](Scene&, Material&) {}), "");
  const std::string found = lit_error([](Scene&, Material& m) {
    m.base_color = {0.5f, 1.25f, 0.5f, 1};
  });
  EXPECT_NE(found.find("found more in 0 \"paint\" (1.25)"), std::string::npos) << found;
  EXPECT_NE(lit_error([](Scene& s, Material&) {
              s.meshes[0].colors = {{1, 1, 1, 1}, {1, 1.5f, 1, 1}, {1, 1, 1, 1}};
            }),
            "");
  EXPECT_EQ(lit_error([](Scene& s, Material& m) {
              s.meshes[0].colors.assign(3, {2, 1, 1, 1});
              m.base_color = {0.5f, 1, 1, 1};
            }),
            "");
  EXPECT_NE(lit_error([](Scene& s, Material& m) {
              Image image;
              image.width = image.height = 1;
              image.rgba_linear = {1.5f, 0, 0, 9};
              s.images.push_back(image);
              s.textures.push_back({0});
              m.base_color_texture.texture = 0;
            }),
            "");
  // In no use, it does not matter.
  EXPECT_EQ(lit_error([](Scene& s, Material& m) {
              m.base_color.x = 2;
              s.instances.clear();
            }),
            "");
  // Without a material vertex colours alone count.
  EXPECT_NE(lit_error([](Scene& s, Material&) {
              s.meshes[0].material = -1;
              s.meshes[0].colors.assign(3, {2, 1, 1, 1});
            }),
            "");
}

TEST(LitScene, SpectraScaledByTheColor) {
  const auto with = [](float luminance, double value, float transmitted) {
    return lit_error([&](Scene&, Material& m) {
      m.spectral_luminance = luminance;
      m.reflectance = {{300, 700}, {value, value}};
      m.diffuse_transmission = transmitted;
    });
  };
  EXPECT_EQ(with(1, 1, 0), "");
  EXPECT_NE(with(0.5f, 0.6, 0), "");  // white is twice what the spectrum is of
  EXPECT_EQ(with(1, 0.5, 0.5f), "");
  EXPECT_NE(with(1, 0.6, 0.5f), "");
  EXPECT_EQ(lit_error([](Scene&, Material& m) { m.diffuse_transmission = 0.7f; }), "");
}

}  // namespace
}  // namespace omma::test
