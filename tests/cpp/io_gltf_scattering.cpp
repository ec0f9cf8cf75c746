// How glTF materials scatter light: metallic-roughness, normals, extensions, spectra in extras.
#include <cmath>

#include "gltf_builder.h"

namespace omma::test {
namespace {

// A triangle with this material and two textures, of different images, to use.
GltfBuilder with_material(const json& material) {
  GltfBuilder b = textured_triangle({{"uri", data_uri(png_1x1(255, 0, 0))}});
  b.push("images", {{"uri", data_uri(png_1x1(128, 128, 255))}});
  b.push("textures", {{"source", 1}});
  b.document["materials"][0] = material;
  return b;
}

Material material(const json& description) {
  return load(with_material(description)).materials.at(0);
}

json extension(const char* name, json values) {
  return {{"extensions", {{name, std::move(values)}}}};
}

json spectrum(std::vector<double> wavelength_nm, std::vector<double> value) {
  return {{"wavelength_nm", std::move(wavelength_nm)}, {"value", std::move(value)}};
}

json extras(json values) {
  return {{"extras", {{"omma", std::move(values)}}}};
}

// Warnings but for the one that says what only light shows.
std::vector<std::string> warnings(const Scene& scene) {
  std::vector<std::string> found;
  for (const std::string& warning : scene.warnings)
    if (warning.find("without a light") == std::string::npos) found.push_back(warning);
  return found;
}

TEST(GltfScattering, DefaultsAreThoseOfTheFormatNotOfMaterial) {
  const Material m = material(json::object());
  EXPECT_EQ(m.metallic, 1);
  EXPECT_EQ(m.roughness, 1);
  Material expected;
  expected.metallic = 1;
  EXPECT_EQ(m, expected);
  EXPECT_EQ(Material{}.metallic, 0);
}

TEST(GltfScattering, SurfaceAndItsTextures) {
  const Material m = material({{"pbrMetallicRoughness",
                                {{"metallicFactor", 0.25},
                                 {"roughnessFactor", 0.5},
                                 {"metallicRoughnessTexture", {{"index", 1}, {"texCoord", 1}}}}},
                               {"normalTexture", {{"index", 0}, {"scale", 0.75}}}});
  EXPECT_EQ(m.metallic, 0.25f);
  EXPECT_EQ(m.roughness, 0.5f);
  EXPECT_EQ(m.metallic_roughness_texture.texture, 0);  // in the order of their first use
  EXPECT_EQ(m.metallic_roughness_texture.texcoord_set, 1);
  EXPECT_EQ(m.normal_texture.texture, 1);
  EXPECT_EQ(m.normal_scale, 0.75f);
}

TEST(GltfScattering, Extensions) {
  EXPECT_EQ(material(extension("KHR_materials_ior", {{"ior", 1.33}})).ior, 1.33f);
  const Material shiny =
      material(extension("KHR_materials_specular",
                         {{"specularFactor", 0.5}, {"specularColorFactor", {0.25, 0.5, 1}}}));
  EXPECT_EQ(shiny.specular, 0.5f);
  EXPECT_EQ(shiny.specular_color, (Vec3{0.25f, 0.5f, 1}));
  EXPECT_EQ(
      material(extension("KHR_materials_transmission", {{"transmissionFactor", 0.5}})).transmission,
      0.5f);
  const Material leaf = material(extension("KHR_materials_diffuse_transmission",
                                           {{"diffuseTransmissionFactor", 0.4},
                                            {"diffuseTransmissionColorFactor", {1, 0, 0.5}},
                                            {"diffuseTransmissionColorTexture", {{"index", 1}}}}));
  EXPECT_EQ(leaf.diffuse_transmission, 0.4f);
  EXPECT_EQ(leaf.diffuse_transmission_color, (Vec3{1, 0, 0.5f}));
  EXPECT_EQ(leaf.diffuse_transmission_texture.texture, 0);
  const Material coated = material(extension(
      "KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.25}}));
  EXPECT_EQ(coated.clearcoat, 0.5f);
  EXPECT_EQ(coated.clearcoat_roughness, 0.25f);
}

TEST(GltfScattering, TexturesOfFactors) {
  const json one = {{"index", 1}}, other = {{"index", 0}, {"texCoord", 1}};
  const auto loaded = [](const char* name, json values) {
    const Scene scene = load(with_material(extension(name, std::move(values))));
    EXPECT_FALSE(has_warning(scene, "not supported")) << name;
    return scene.materials.at(0);
  };
  const Material shiny =
      loaded("KHR_materials_specular", {{"specularTexture", one}, {"specularColorTexture", other}});
  EXPECT_EQ(shiny.specular_texture.texture, 0);  // in the order of their first use
  EXPECT_EQ(shiny.specular_color_texture.texture, 1);
  EXPECT_EQ(shiny.specular_color_texture.texcoord_set, 1);
  const Material pane = loaded("KHR_materials_transmission",
                               {{"transmissionFactor", 1}, {"transmissionTexture", other}});
  EXPECT_EQ(pane.transmission_texture.texture, 0);
  EXPECT_EQ(pane.transmission_texture.texcoord_set, 1);
  const Material coated = loaded(
      "KHR_materials_clearcoat",
      {{"clearcoatFactor", 1}, {"clearcoatTexture", one}, {"clearcoatRoughnessTexture", other}});
  EXPECT_EQ(coated.clearcoat_texture.texture, 0);
  EXPECT_EQ(coated.clearcoat_roughness_texture.texture, 1);
  EXPECT_EQ(coated.clearcoat_normal_texture.texture, -1);
  const Material rippled =
      loaded("KHR_materials_clearcoat",
             {{"clearcoatFactor", 1},
              {"clearcoatNormalTexture", {{"index", 1}, {"texCoord", 1}, {"scale", 0.5}}}});
  EXPECT_EQ(rippled.clearcoat_normal_texture.texture, 0);
  EXPECT_EQ(rippled.clearcoat_normal_texture.texcoord_set, 1);
  EXPECT_EQ(rippled.clearcoat_normal_scale, 0.5f);
  const Material leaf = loaded(
      "KHR_materials_diffuse_transmission",
      {{"diffuseTransmissionFactor", 0.5}, {"diffuseTransmissionTexture", other}});
  EXPECT_EQ(leaf.diffuse_transmission_factor_texture.texture, 0);
  EXPECT_EQ(leaf.diffuse_transmission_factor_texture.texcoord_set, 1);
  expect_load_error(
      with_material(extension("KHR_materials_specular", {{"specularTexture", {{"index", 7}}}})),
      {"specularTexture", "texture 7", "there are 2"});
  expect_load_error(with_material(extension("KHR_materials_clearcoat", {{"clearcoatTexture", 0}})),
                    {"KHR_materials_clearcoat.clearcoatTexture"});
}

// Alpha is the same in sRGB and as data, so that it may be either's.
TEST(GltfScattering, AlphaOfSixteenBitsIsNeitherColorNorData) {
  const std::string bytes = png<std::uint16_t>(1, 1, 4, {32768, 32768, 32768, 32768});
  const auto image = [&](const json& material) {
    GltfBuilder b = textured_triangle({{"uri", data_uri(bytes)}});
    b.document["materials"][0] = material;
    const Scene scene = load(b);
    EXPECT_FALSE(has_warning(scene, "used as colours and as data"));
    EXPECT_NEAR(scene.images.at(0).rgba_linear.at(3), 32768 / 65535.0, 1e-6);
    return scene.images.at(0);
  };
  const json use = {{"index", 0}};
  json both = extension("KHR_materials_specular", {{"specularTexture", use}});
  both["normalTexture"] = use;
  EXPECT_NEAR(image(both).rgba_linear.at(0), 32768 / 65535.0, 1e-6);
  both = extension("KHR_materials_specular",
                   {{"specularTexture", use}, {"specularColorTexture", use}});
  EXPECT_NEAR(image(both).rgba_linear.at(0), 0.2140483, 1e-6);
}

TEST(GltfScattering, WhatIsReadIsNotWarnedOf) {
  GltfBuilder b = one_triangle();
  b.document["extensionsUsed"] = b.document["extensionsRequired"] = {
      "KHR_materials_ior",          "KHR_materials_specular", "KHR_materials_clearcoat",
      "KHR_materials_transmission", "KHR_lights_punctual",    "KHR_materials_diffuse_transmission"};
  EXPECT_TRUE(load(b).warnings.empty());
}

TEST(GltfScattering, Volumes) {
  const auto loaded = [](const json& said, float metallic) {
    json description = extension("KHR_materials_volume", said);
    description["pbrMetallicRoughness"] = {{"metallicFactor", metallic}};
    return load(with_material(description)).materials[0];
  };
  const json tea = {{"thicknessFactor", 0.5},
                    {"attenuationDistance", 2},
                    {"attenuationColor", {0.5, 0.25, 0}}};
  const Material volume = loaded(tea, 0);
  EXPECT_EQ(volume.thickness_m, 0.5f);
  EXPECT_EQ(volume.attenuation_distance_m, 2);
  EXPECT_EQ(volume.attenuation_color, (Vec3{0.5f, 0.25f, 0}));
  EXPECT_EQ(loaded(tea, 0.5f).thickness_m, 0);
  const Material clear = loaded({{"thicknessFactor", 1}}, 0);
  EXPECT_EQ(clear.attenuation_color, (Vec3{1, 1, 1}));
  EXPECT_TRUE(std::isinf(clear.attenuation_distance_m));
}

TEST(GltfScattering, WhatIsPassedOverIsWarnedOf) {
  const auto said = [](const json& description) {
    return warnings(load(with_material(description)));
  };
  // 10 is what a sample of the format's authors has.
  EXPECT_EQ(said(extension("KHR_materials_specular", {{"specularColorFactor", {10, 10, 10}}})),
            std::vector<std::string>{"a specular colour above 1 counts as 1 (material 0)"});
  EXPECT_EQ(said(extension("KHR_materials_ior", {{"ior", 0}})).size(), 1u);
  // Of glTF's usual metal.
  EXPECT_EQ(said(extension("KHR_materials_volume", {{"thicknessFactor", 1}})),
            std::vector<std::string>{"KHR_materials_volume of a metal or under a clear coat is not "
                                     "supported: such surfaces are thin (material 0)"});
  EXPECT_EQ(said(extras({{"emission", spectrum({400, 500}, {1, 1})}})),
            std::vector<std::string>{"a spectrum of emission is not seen where the emissive "
                                     "factor is 0 (material 0)"});
}

TEST(GltfScattering, Spectra) {
  const Material m =
      material(extras({{"reflectance", spectrum({300, 700}, {0.1, 0.9})},
                       {"transmittance", spectrum({300, 500.5, 700}, {0, 0.0625, 0.1})},
                       {"spectral_luminance", 0.5},
                       {"emission", spectrum({400, 500}, {2, 30})},
                       {"extra_reflectance",
                        {{"texture", {{"index", 1}, {"texCoord", 1}}},
                         {"spectra", {nullptr, spectrum({300, 400}, {0.5, 0.5})}}}}}));
  EXPECT_EQ(m.reflectance, (Spectrum{{300, 700}, {0.1, 0.9}}));
  EXPECT_EQ(m.transmittance, (Spectrum{{300, 500.5, 700}, {0, 0.0625, 0.1}}));
  EXPECT_EQ(m.spectral_luminance, 0.5f);
  EXPECT_EQ(m.emission, (Spectrum{{400, 500}, {2, 30}}));
  EXPECT_EQ(m.extra.texture.texture, 0);
  EXPECT_EQ(m.extra.texture.texcoord_set, 1);
  EXPECT_TRUE(m.extra.spectrum[0].empty());
  EXPECT_EQ(m.extra.spectrum[1], (Spectrum{{300, 400}, {0.5, 0.5}}));
  EXPECT_TRUE(m.extra.spectrum[2].empty());
}

TEST(GltfScattering, ExtrasOfOthersSayNothing) {
  for (const json& other : {json("text"), json::array({1}), json{{"author", "somebody"}}})
    EXPECT_EQ(material({{"extras", other}}), material(json::object())) << other;
}

TEST(GltfScattering, BadNumbersAreNamed) {
  const auto expect = [](const json& description, std::vector<std::string> parts) {
    expect_load_error(with_material(description), std::move(parts));
  };
  expect({{"name", "tin"}, {"pbrMetallicRoughness", {{"metallicFactor", 1.5}}}},
         {"material 0 \"tin\": metallic: expected 0 to 1, found 1.5"});
  expect({{"pbrMetallicRoughness", {{"roughnessFactor", -1}}}}, {"roughness: expected 0 to 1"});
  expect({{"pbrMetallicRoughness", {{"roughnessFactor", "high"}}}},
         {"materials[0].pbrMetallicRoughness.roughnessFactor: expected a number"});
  expect(extension("KHR_materials_ior", {{"ior", 0.5}}), {"ior: expected 1 to 10, found 0.5"});
  expect(extension("KHR_materials_ior", {{"ior", {1}}}), {"KHR_materials_ior.ior"});
  expect(extension("KHR_materials_specular", {{"specularFactor", 2}}), {"specular: expected"});
  expect(extension("KHR_materials_specular", {{"specularColorFactor", {-1, 0, 0}}}),
         {"specular_color: expected 0 to 1"});
  expect(extension("KHR_materials_transmission", {{"transmissionFactor", 2}}), {"transmission:"});
  expect(extension("KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 2}}),
         {"diffuse_transmission: expected"});
  expect(
      extension("KHR_materials_diffuse_transmission", {{"diffuseTransmissionColorFactor", {1, 2}}}),
      {"diffuseTransmissionColorFactor: expected an array of 3 numbers"});
  expect(extension("KHR_materials_clearcoat", {{"clearcoatFactor", 2}}), {"clearcoat: expected"});
  expect({{"normalTexture", {{"index", 7}}}}, {"normalTexture", "texture 7", "there are 2"});
  expect({{"normalTexture", {{"index", 0}, {"scale", "1"}}}}, {"normalTexture.scale"});
}

TEST(GltfScattering, BadSpectraAreNamed) {
  const auto expect = [](const json& said, std::vector<std::string> parts) {
    expect_load_error(with_material(extras(said)), std::move(parts));
  };
  expect({{"reflectence", 1}},
         {"materials[0].extras.omma: expected absorption_per_m, boundary, emission",
          "reflectence"});
  expect({{"reflectance", {{"wavelength_nm", {300, 400}}}}}, {"reflectance.value: is missing"});
  expect({{"reflectance", spectrum({300, 400}, {0.5})}},
         {"reflectance: value: expected one for each of 2 wavelengths, found 1"});
  expect({{"reflectance", spectrum({300}, {0.5})}}, {"expected 2 to 10000 wavelengths, found 1"});
  expect({{"reflectance", spectrum({400, 300}, {0.5, 0.5})}},
         {"reflectance: wavelength_nm: expected wavelengths that grow, found 400 and then 300"});
  expect({{"reflectance", spectrum({30, 300}, {0.5, 0.5})}}, {"expected 100 to 5000, found 30"});
  expect({{"reflectance", spectrum({300, 400}, {0.5, 1.25})}},
         {"reflectance: value: expected 0 to 1, found 1.25 at 400 nm"});
  expect({{"transmittance", spectrum({300, 400}, {-0.5, 0})}}, {"transmittance: value: expected"});
  // Where the knots of neither are those of the other.
  expect({{"reflectance", spectrum({300, 400, 500}, {0, 1, 0})},
          {"transmittance", spectrum({350, 450}, {0.25, 0.25})}},
         {"reflectance and transmittance: expected at most 1 together, found 1.25"});
  expect({{"spectral_luminance", 0}}, {"spectral_luminance: expected more than 0"});
  expect({{"emission", spectrum({300, 400}, {-1, 0})}}, {"emission: value: expected numbers"});
  const json texture = {{"index", 0}};
  expect({{"extra_reflectance", {{"texture", texture}}}}, {"spectra: is missing"});
  expect({{"extra_reflectance", {{"texture", texture}, {"spectra", {1}}}}},
         {"spectra: expected an array of at most 3 spectra or nulls"});
  expect({{"extra_reflectance", {{"texture", texture}, {"spectra", json::array()}}}},
         {"expected a texture and spectra, found only a texture"});
  expect({{"extra_reflectance", {{"spectra", json::array()}}}}, {"texture: is missing"});
  const json nm = {300, 700};
  expect({{"boundary", {{"wavelength_nm", nm}, {"cosines", 2}}}}, {"mueller: is missing"});
  expect({{"boundary", {{"wavelength_nm", nm}, {"cosines", 2}, {"mueller", 99}}}},
         {"extras.omma.boundary.mueller"});
  expect({{"boundary", {{"wavelength_nm", nm}, {"cosines", 2}, {"mueller", 0}}}},
         {"boundary: mueller: expected 12 numbers, found"});
}

TEST(GltfScattering, SixteenBitsOfDataAreCodes) {
  const std::string bytes = png<std::uint16_t>(1, 1, 4, {65535, 32768, 13107, 65535});
  GltfBuilder b = textured_triangle({{"uri", data_uri(bytes)}});
  b.document["materials"][0] = {{"normalTexture", {{"index", 0}}}};
  const Image normals = load(b).images.at(0);
  // Their own values, to the rounding of what was decoded in single precision.
  EXPECT_NEAR(normals.rgba_linear.at(0), 1, 1e-6);
  EXPECT_NEAR(normals.rgba_linear[1], 32768 / 65535.0, 1e-6);
  EXPECT_NEAR(normals.rgba_linear[2], 0.2, 1e-6);
  b.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  const Scene both = load(b);
  EXPECT_NEAR(both.images.at(0).rgba_linear[1], 0.2140483, 1e-6);
  EXPECT_TRUE(has_warning(both, "used as colours and as data"));
}

TEST(GltfScattering, CompoundRaysColorsNeedNone) {
  GltfBuilder b = with_material(
      {{"normalTexture", {{"index", 1}}}, {"extras", {{"omma", {{"spectral_luminance", 0.5}}}}}});
  b.document["images"][1] = {{"uri", "not-there.png"}};
  SceneOptions options;
  options.color_rule = ColorRule::compoundray;
  const Scene scene = load(b, options);
  EXPECT_EQ(scene.materials.at(0).normal_texture.texture, -1);
  EXPECT_TRUE(scene.images.empty());
}

TEST(GltfScattering, NormalsThatAreZeroAreThoseOfTriangles) {
  GltfBuilder b = one_triangle();
  json& attributes = b.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  EXPECT_EQ(load(b).meshes.at(0).normals.size(), 3u);
  attributes["NORMAL"] = b.accessor<float>({0, 0, 1, 0, 0, 0, 0, 0, 1}, "VEC3");
  const Scene scene = load(b);
  EXPECT_TRUE(scene.meshes.at(0).normals.empty());
  EXPECT_TRUE(has_warning(scene, "some are zero"));
}

}  // namespace
}  // namespace omma::test
