// How surfaces scatter light in bands: RGB and spectra as matrices, textures, normals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "backend/scatter_data.h"
#include "omma/omma.h"
#include "physics/lanes/lanes.h"
#include "physics/surface/boundary_table.h"
#include "physics/surface/texture.h"

namespace omma::test {
namespace {

// Neighbouring bands between these edges, of samples in the middle of each nm.
Bands bands_between(const std::vector<double>& edges_nm) {
  Bands bands;
  for (double at = edges_nm.front() + 0.5; at < edges_nm.back(); ++at)
    bands.wavelength_nm.push_back(at);
  for (std::size_t b = 0; b + 1 < edges_nm.size(); ++b)
    for (const double at : bands.wavelength_nm)
      bands.weight.push_back(
          at > edges_nm[b] && at < edges_nm[b + 1] ? 1 / (edges_nm[b + 1] - edges_nm[b]) : 0);
  return bands;
}

Bands default_bands() {
  std::vector<double> edges;
  for (int i = 0; i <= 16; ++i) edges.push_back(300 + 25 * i);
  return bands_between(edges);
}

// A triangle with one material, and textures of two images, 2 x 2 and 1 x 1.
struct Made {
  Scene scene;
  Light light;
  std::unique_ptr<ShadingData> shading;
  std::unique_ptr<ScatterData> scatter;

  explicit Made(const Material& material, const Bands& bands = default_bands(),
                std::vector<std::array<double, 4>> ultraviolet = {}) {
    Image image;
    image.width = image.height = 2;
    image.rgba_srgb8 = {0, 128, 255, 255, 0, 128, 255, 255, 0, 128, 255, 255, 0, 128, 255, 255};
    scene.images.push_back(image);
    image.width = image.height = 1;
    image.rgba_srgb8.clear();
    image.rgba_linear = {0.25f, 0.5f, 0.75f, 1};
    scene.images.push_back(image);
    scene.textures = {{0}, {1}};
    scene.materials.push_back(material);
    Mesh mesh{"", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}, {}, 0};
    mesh.texcoords[0] = {{0, 0}, {1, 0}, {0, 1}};
    mesh.normals.assign(3, {0, 0, 1});
    scene.meshes.push_back(mesh);
    scene.instances.push_back({"", 0, {}});
    validate_scene(scene);
    light.bands = bands;
    light.ultraviolet = std::move(ultraviolet);
    shading = make_shading_data(scene);
    scatter = make_scatter_data(scene, light, *shading);
  }

  const ScatterView& view() const { return scatter->materials[0]; }
  const MeshView& mesh() const { return shading->meshes[0]; }

  // Of a base colour, in a band.
  double reflectance(std::size_t band, Vec3 color) const {
    return in_band(view().reflectance, band, color);
  }
  double transmittance(std::size_t band, Vec3 color) const {
    return in_band(view().transmittance, band, color);
  }
  static double in_band(const float* matrix, std::size_t band, Vec3 color) {
    const float* row = matrix + 4 * band;
    return static_cast<double>(row[0]) * color.x + row[1] * color.y + row[2] * color.z + row[3];
  }
};

// Sums of single precision.
constexpr double rounding = 1e-6;
constexpr Vec3 white{1, 1, 1};

TEST(ScatterData, WhiteIsWhiteInAllThatIsVisible) {
  const Made made{Material{}};
  for (std::size_t b = 0; b < 16; ++b) {
    EXPECT_NEAR(made.reflectance(b, white), b < 4 ? 0 : 1, rounding) << b;
    EXPECT_NEAR(made.reflectance(b, {0, 0, 0}), 0, 0);
  }
  EXPECT_EQ(made.view().transmittance, nullptr);
  EXPECT_EQ(made.view().extra, nullptr);
  EXPECT_EQ(made.view().specular_tint, nullptr);
  EXPECT_EQ(made.view().metallic, 0);
  EXPECT_EQ(made.mesh().normals, &made.scene.meshes[0].normals[0].x);
  ASSERT_EQ(made.scatter->materials.size(), 2u);
  EXPECT_EQ(made.scatter->materials[1].metallic, 1);  // glTF's default
}

TEST(ScatterData, UltravioletIsAsTheCallerSays) {
  const Bands bands = bands_between({300, 350, 390, 410, 700});
  const Made made{Material{}, bands, {{0.1, 0.2, 0.3, 0.04}}};
  EXPECT_NEAR(made.reflectance(0, {1, 0, 0}), 0.14, rounding);
  EXPECT_NEAR(made.reflectance(1, {0, 1, 0}), 0.24, rounding);
  // Half of this band is visible.
  EXPECT_NEAR(made.reflectance(2, white), 0.5 * 0.64 + 0.5, rounding);
  EXPECT_NEAR(made.reflectance(2, {0, 0, 0}), 0.02, rounding);
  EXPECT_NEAR(made.reflectance(3, white), 1, rounding);
}

TEST(ScatterData, TablesAreMeansOverBands) {
  Material material;
  // A ramp and a plateau: the mean of a band of the ramp is its middle.
  material.reflectance = {{300, 500, 800}, {0.1, 0.5, 0.5}};
  material.transmittance = {{300, 800}, {0.2, 0.2}};
  material.spectral_luminance = 0.5f;
  const Made made{material};
  const Vec3 half{0.5f, 0.5f, 0.5f};
  for (std::size_t b = 0; b < 16; ++b) {
    const double middle = 312.5 + 25 * static_cast<double>(b);
    EXPECT_NEAR(made.reflectance(b, half), middle < 500 ? 0.1 + 0.002 * (middle - 300) : 0.5,
                rounding);
    EXPECT_NEAR(made.reflectance(b, {0.25f, 0.25f, 0.25f}), made.reflectance(b, half) / 2,
                rounding);
    EXPECT_NEAR(made.transmittance(b, half), 0.2, rounding);
  }
  // Whatever the colour, its luminance counts.
  EXPECT_NEAR(made.reflectance(15, {1, 0, 0}), 0.5 * 0.2126 / 0.5, rounding);
  EXPECT_TRUE(made.view().transmits_base_color);
}

TEST(ScatterData, BoundariesAreMeansOverBandsAtCosines) {
  Material material;
  material.metallic = 1;
  // a: a ramp of wavelengths from 300 to 700 nm, times the cosine; b half of it, c less it.
  material.boundary = {{300, 700}, 3, {}};
  for (const float most : {0.2f, 0.8f})
    for (const float cosine : {0.0f, 0.5f, 1.0f})
      for (const float element : {1.0f, 0.5f, -0.75f})
        material.boundary.mueller.push_back(most * cosine * element);
  const Made made{material};
  ASSERT_EQ(made.view().boundary, 0);
  EXPECT_EQ(made.scatter->materials[1].boundary, -1);  // glTF's default
  ASSERT_EQ(made.scatter->boundaries.size(), std::size_t{16 * boundary_pairs * 2});
  const float* tables = made.scatter->boundaries.data();
  for (int b = 0; b < 16; ++b) {
    const double in_band = 0.2 + 0.6 * (12.5 + 25 * b) / 400;
    for (const float cosine : {0.0f, 0.003f, 0.4999f, 0.75f, 1.0f, 1.001f}) {
      const auto at = find_boundary(16, std::int32_t{0}, cosine);
      const Mueller<float> m = eval_boundary(tables, at, b);
      const double expected = in_band * std::min(static_cast<double>(cosine), 1.0);
      EXPECT_NEAR(m.a, expected, rounding) << b << ' ' << cosine;
      EXPECT_NEAR(m.b, 0.5 * expected, rounding) << b << ' ' << cosine;
      EXPECT_NEAR(m.c, -0.75 * expected, rounding) << b << ' ' << cosine;
      // 2 integral c c dc.
      EXPECT_NEAR(boundary_mean(tables, at, b), in_band * 2 / 3, 2 * rounding) << b;
    }
  }
  // Of lanes without a table nothing is read that is not there.
  EXPECT_EQ(find_boundary(16, std::int32_t{-1}, 0.5f).base, 0);
}

TEST(ScatterData, BeyondTables) {
  Material material;
  material.reflectance = {{425, 600}, {0.2, 0.4}};
  const Made made{material, bands_between({300, 400, 425, 600, 700}), {{0, 0, 0, 0.05}}};
  EXPECT_NEAR(made.reflectance(0, white), 0.05, rounding);  // as said
  EXPECT_NEAR(made.reflectance(1, white), 0.2, rounding);   // its first value
  EXPECT_NEAR(made.reflectance(2, white), 0.3, rounding);
  EXPECT_NEAR(made.reflectance(3, white), 0.4, rounding);  // its last
  material.reflectance = {{300, 350}, {0.2, 0.4}};
  const Made below{material, bands_between({300, 350, 400, 700}), {{0, 0, 0, 0.05}}};
  EXPECT_NEAR(below.reflectance(0, white), 0.3, rounding);
  EXPECT_NEAR(below.reflectance(1, white), 0.05, rounding);
  EXPECT_NEAR(below.reflectance(2, white), 0.4, rounding);
}

TEST(ScatterData, TransmissionOfRgbIsTakenFromWhatIsReflected) {
  Material material;
  material.diffuse_transmission = 0.25f;
  material.diffuse_transmission_color = {1, 0.5f, 0};
  material.diffuse_transmission_texture.texture = 0;
  const Made made{material};
  EXPECT_NEAR(made.reflectance(8, white), 0.75, rounding);
  EXPECT_NEAR(made.transmittance(8, white), 0.25, rounding);
  EXPECT_FALSE(made.view().transmits_base_color);
  EXPECT_EQ(made.view().transmission_color, (Vec3{1, 0.5f, 0}));
  EXPECT_NE(made.mesh().transmission_uv, nullptr);
  // A spectrum of what is reflected stands for itself.
  material.reflectance = {{300, 700}, {0.5, 0.5}};
  EXPECT_NEAR(Made{material}.reflectance(8, white), 0.5, rounding);
  EXPECT_NEAR(Made{material}.transmittance(8, white), 0.25, rounding);
}

TEST(ScatterData, ExtraSpectra) {
  Material material;
  material.extra.texture.texture = 1;
  material.extra.spectrum[1] = {{300, 350}, {0.4, 0.4}};
  const Made made{material};
  for (std::size_t b = 0; b < 16; ++b) {
    EXPECT_NEAR(made.view().extra[3 * b + 1], b < 2 ? 0.4 : 0, rounding);  // 0 beyond
    EXPECT_EQ(made.view().extra[3 * b], 0);
  }
  EXPECT_NE(made.mesh().extra_uv, nullptr);
}

TEST(ScatterData, TexturesOfDataAreTheirCodes) {
  Material material;
  material.base_color_texture.texture = 0;
  material.normal_texture.texture = 0;
  material.metallic_roughness_texture.texture = 0;
  material.diffuse_transmission = 0.5f;
  material.diffuse_transmission_texture.texture = 0;
  const Made made{material};
  const auto texel = [&](std::int32_t texture) {
    return eval_texture<float>(made.shading->view.textures[texture], 0.3f, 0.3f, 0.0f);
  };
  const auto& normal = texel(made.view().normal_texture);
  EXPECT_NEAR(normal.r, 0, 1e-5);  // 16 bits
  EXPECT_NEAR(normal.g, 128 / 255.0, 1e-5);
  EXPECT_NEAR(normal.b, 1, 1e-5);
  EXPECT_NEAR(texel(made.view().transmission_texture).g, 0.2158605, 1e-5);
  // Made once for all that read the same.
  EXPECT_EQ(made.view().roughness_texture, made.view().normal_texture);
  EXPECT_EQ(made.view().transmission_texture, made.shading->materials[0].base_texture);
  EXPECT_EQ(made.mesh().normal_uv, made.mesh().base_uv);
  EXPECT_EQ(made.mesh().normal_uv, made.mesh().roughness_uv);
  // Two texels of level 0 per metre: the triangle's legs are 1 m and a whole image.
  EXPECT_NEAR(made.mesh().normal_density[0], 2, 1e-5);
  // Coarser levels average the values, not light.
  const auto coarse = eval_texture<float>(made.shading->view.textures[made.view().normal_texture],
                                          0.3f, 0.3f, 2.0f);
  EXPECT_NEAR(coarse.g, 128 / 255.0, 1e-5);
}

TEST(ScatterData, CoordinatesOfTheirOwn) {
  Material material;
  material.base_color_texture.texture = 0;
  material.normal_texture.texture = 0;
  material.normal_texture.scale = {2, 2};
  const Made made{material};
  ASSERT_NE(made.mesh().normal_uv, made.mesh().base_uv);
  EXPECT_EQ(made.mesh().normal_uv[2], 2);
  EXPECT_NEAR(made.mesh().normal_density[0], 4, 1e-5);
}

TEST(ScatterData, SpecularColor) {
  Material material;
  material.specular_color = {1, 0, 0};
  const Made made{material};
  ASSERT_NE(made.view().specular_tint, nullptr);
  EXPECT_NEAR(made.view().specular_tint[15], 1, rounding);
  // Below 400 nm as there.
  EXPECT_NEAR(made.view().specular_tint[0], primary_spectra(400)[0], rounding);
}

TEST(ScatterData, TexturesOfFactors) {
  EXPECT_EQ(Made{Material{}}.mesh().factors, nullptr);
  Material material;
  material.specular_texture.texture = 0;
  material.clearcoat_roughness_texture.texture = 1;
  material.clearcoat_roughness_texture.scale = {2, 2};
  const Made made{material};
  ASSERT_NE(made.mesh().factors, nullptr);
  const FactorTextures& factors = *made.mesh().factors;
  EXPECT_EQ(factors.transmission.texture, -1);
  EXPECT_EQ(factors.coat.texture, -1);
  EXPECT_EQ(factors.specular_color.texture, -1);
  EXPECT_EQ(factors.specular.uv[2], 1);
  EXPECT_NEAR(factors.specular.density[0], 2, 1e-5);
  EXPECT_EQ(factors.coat_roughness.uv[2], 2);
  const auto texel = [&](const TextureRead& read, float width) {
    return eval_texture<float>(made.shading->view.textures[read.texture], 0.3f, 0.3f, width);
  };
  EXPECT_NEAR(texel(factors.coat_roughness, 0).g, 0.5, 1e-6);
  EXPECT_EQ(texel(factors.specular, 0).a, 1);
  material.unlit = true;
  EXPECT_EQ(Made{material}.mesh().factors, nullptr);
}

// Of a factor in alpha coarser levels are the mean, where they would be 1 of an opaque colour.
TEST(ScatterData, CoarseAlphaIsTheMean) {
  Material material;
  material.base_color_texture.texture = material.specular_texture.texture = 0;
  Made made{material};
  std::vector<std::uint8_t>& pixels = made.scene.images[0].rgba_srgb8;
  pixels[3] = pixels[7] = pixels[11] = 0;
  made.shading = make_shading_data(made.scene);
  made.scatter = make_scatter_data(made.scene, made.light, *made.shading);
  const TextureView& view = made.shading->view.textures[made.mesh().factors->specular.texture];
  EXPECT_NEAR(eval_texture<float>(view, 0.3f, 0.3f, 2.0f).a, 0.25, 1e-5);
}

TEST(ScatterData, SpecularColorOfATexture) {
  Material material;
  material.specular_color = {1, 0.5f, 0};
  const Made plain{material};
  material.specular_color_texture.texture = 0;
  const Made made{material};
  EXPECT_EQ(made.view().specular_tint, nullptr);
  ASSERT_NE(made.view().tint_from_rgb, nullptr);
  // Where the texture is white its colour is the factor's.
  for (std::size_t b = 0; b < 16; ++b) {
    const float* row = made.view().tint_from_rgb + 3 * b;
    EXPECT_NEAR(row[0] + row[1] + row[2], plain.view().specular_tint[b], rounding);
  }
  const TextureRead& read = made.mesh().factors->specular_color;
  EXPECT_NEAR(eval_texture<float>(made.shading->view.textures[read.texture], 0.3f, 0.3f, 0.0f).g,
              0.2158605, 1e-5);  // sRGB
}

TEST(ScatterData, UnlitIsMatterOfItsColor) {
  Material material;
  material.metallic = material.transmission = material.clearcoat = 1;
  material.unlit = true;
  const ScatterView view = Made{material}.view();
  EXPECT_EQ(view.metallic, 0);
  EXPECT_EQ(view.specular, 0);
  EXPECT_EQ(view.transmission, 0);
  EXPECT_EQ(view.clearcoat, 0);
  EXPECT_NE(view.reflectance, nullptr);
}

TEST(ScatterData, WithoutLightNothingIsThere) {
  Material material;
  material.normal_texture.texture = 0;
  const Made made{material};
  const auto dark = make_shading_data(made.scene);
  EXPECT_EQ(dark->meshes[0].normals, nullptr);
  EXPECT_EQ(dark->meshes[0].normal_uv, nullptr);
  EXPECT_TRUE(dark->textures.empty());
}

TEST(MaterialsWithoutUltraviolet, AreThoseThatAreNotKnownThere) {
  Scene scene;
  const auto add = [&](const Material& material) {
    scene.meshes.push_back({"", {}, {}, {}, {}, {}, static_cast<int>(scene.materials.size())});
    scene.instances.push_back({"", static_cast<int>(scene.meshes.size()) - 1, {}});
    scene.materials.push_back(material);
  };
  Material known;
  known.reflectance = {{300, 700}, {0.5, 0.5}};
  add(Material{});  // 0
  add(known);       // 1
  Material leaf = known;
  leaf.diffuse_transmission = 0.5f;
  add(leaf);  // 2: what it transmits is not known
  leaf.transmittance = {{300, 700}, {0.1, 0.1}};
  add(leaf);  // 3
  Material partly = known;
  partly.reflectance.wavelength_nm = {350, 700};
  add(partly);                            // 4
  scene.materials.push_back(Material{});  // 5, in no use
  EXPECT_EQ(materials_without_ultraviolet(scene, default_bands()), (std::vector<int>{0, 2, 4}));
  EXPECT_EQ(materials_without_ultraviolet(scene, bands_between({350, 700})),
            (std::vector<int>{0, 2}));
  EXPECT_TRUE(materials_without_ultraviolet(scene, bands_between({400, 700})).empty());
  scene.meshes[1].material = -1;
  EXPECT_EQ(materials_without_ultraviolet(scene, bands_between({350, 700})),
            (std::vector<int>{-1, 0, 2}));
  // Samples that weigh nothing do not count.
  Bands visible = bands_between({300, 400, 700});
  visible.weight.erase(visible.weight.begin(), visible.weight.begin() + 400);
  EXPECT_TRUE(materials_without_ultraviolet(scene, visible).empty());
}

}  // namespace
}  // namespace omma::test
