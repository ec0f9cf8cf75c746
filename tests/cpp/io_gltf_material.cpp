// glTF materials, textures, images, cameras, backgrounds and extensions, feature by feature.
#include "gltf_builder.h"

namespace omma::test {
namespace {

json png_image(const std::string& bytes) {
  return {{"uri", data_uri(bytes, "image/png")}};
}

GltfBuilder red_triangle() {
  return textured_triangle(png_image(png_1x1(255, 0, 0)));
}

// The material of a triangle that has this one.
Material material(const json& description) {
  GltfBuilder b = one_triangle();
  b.push("materials", description);
  b.document["meshes"][0]["primitives"][0]["material"] = 0;
  const Scene scene = load(b);
  EXPECT_EQ(scene.meshes.at(0).material, 0);
  return scene.materials.at(0);
}

TEST(GltfMaterial, Defaults) {
  const Material m = material(json::object());
  expect_near(m.base_color, {1, 1, 1, 1});
  expect_near(m.emissive, {0, 0, 0});
  EXPECT_EQ(m.base_color_texture.texture, -1);
  EXPECT_EQ(m.emissive_texture.texture, -1);
  EXPECT_EQ(m.alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(m.alpha_cutoff, 0.5f);
  EXPECT_FALSE(m.double_sided);
  EXPECT_FALSE(m.unlit);
  EXPECT_EQ(load(one_triangle()).meshes.at(0).material, -1);
}

TEST(GltfMaterial, BaseColorAndSides) {
  const Material m =
      material({{"name", "leaf"},
                {"doubleSided", true},
                {"pbrMetallicRoughness", {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}}}});
  EXPECT_EQ(m.name, "leaf");
  EXPECT_TRUE(m.double_sided);
  expect_near(m.base_color, {0.1f, 0.2f, 0.3f, 0.4f});
}

TEST(GltfMaterial, AlphaModes) {
  EXPECT_EQ(material({{"alphaMode", "OPAQUE"}}).alpha_mode, AlphaMode::opaque);
  const Material mask = material({{"alphaMode", "MASK"}, {"alphaCutoff", 0.25}});
  EXPECT_EQ(mask.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(mask.alpha_cutoff, 0.25f);
  EXPECT_EQ(material({{"alphaMode", "BLEND"}}).alpha_mode, AlphaMode::blend);
  GltfBuilder b = one_triangle();
  b.push("materials", {{"name", "odd"}, {"alphaMode", "GLASS"}});
  expect_load_error(b, {"material 0 \"odd\"", "alphaMode", "GLASS"});
}

TEST(GltfMaterial, EmissionWithStrength) {
  expect_near(material({{"emissiveFactor", {0.5, 0.25, 1}}}).emissive, {0.5f, 0.25f, 1});
  expect_near(
      material({{"emissiveFactor", {0.5, 0.25, 1}},
                {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}})
          .emissive,
      {2, 1, 4});
  GltfBuilder b = red_triangle();
  b.document["materials"][0]["emissiveTexture"] = {{"index", 0}, {"texCoord", 1}};
  const Scene scene = load(b);
  EXPECT_EQ(scene.materials[0].emissive_texture.texture, 0);
  EXPECT_EQ(scene.materials[0].emissive_texture.texcoord_set, 1);
  EXPECT_EQ(scene.images.size(), 1u);  // read once for both uses
}

TEST(GltfMaterial, UnlitIsTheBaseColorAlone) {
  const Material m = material(
      {{"emissiveFactor", {1, 1, 1}}, {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  EXPECT_TRUE(m.unlit);
  expect_near(m.emissive, {0, 0, 0});
}

TEST(GltfMaterial, NotThere) {
  GltfBuilder b = one_triangle();
  b.document["meshes"][0]["primitives"][0]["material"] = 3;
  expect_load_error(b, {"mesh 0", "primitive 0", "material 3", "there are 0"});
}

TEST(GltfTexture, SamplersWithEachWrapModeAndFilter) {
  const auto texture = [](const json& sampler) {
    GltfBuilder b = red_triangle();
    b.push("samplers", sampler);
    b.document["textures"][0]["sampler"] = 0;
    return load(b).textures.at(0);
  };
  const Texture plain = load(red_triangle()).textures.at(0);
  EXPECT_EQ(plain.wrap_u, Wrap::repeat);
  EXPECT_EQ(plain.wrap_v, Wrap::repeat);
  EXPECT_EQ(plain.filter, Filter::linear);
  EXPECT_EQ(texture({{"wrapS", 33071}}).wrap_u, Wrap::clamp_to_edge);
  EXPECT_EQ(texture({{"wrapS", 33648}}).wrap_u, Wrap::mirrored_repeat);
  EXPECT_EQ(texture({{"wrapS", 33071}}).wrap_v, Wrap::repeat);
  EXPECT_EQ(texture({{"wrapT", 33071}}).wrap_v, Wrap::clamp_to_edge);
  EXPECT_EQ(texture({{"wrapT", 33648}}).wrap_v, Wrap::mirrored_repeat);
  EXPECT_EQ(texture({{"wrapT", 10497}}).wrap_v, Wrap::repeat);
  EXPECT_EQ(texture({{"magFilter", 9728}}).filter, Filter::nearest);
  EXPECT_EQ(texture({{"magFilter", 9729}, {"minFilter", 9728}}).filter, Filter::linear);
  expect_error([&] { texture({{"wrapS", 1}}); }, {"scene.gltf", "sampler 0", "wrapS", "found 1"});
  expect_error([&] { texture({{"magFilter", 9987}}); }, {"sampler 0", "magFilter", "9987"});
}

TEST(GltfTexture, Transform) {
  GltfBuilder b = red_triangle();
  json& info = b.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  b.document["extensionsUsed"] = {"KHR_texture_transform"};
  info["texCoord"] = 0;
  info["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.1, 0.2}}, {"scale", {3, 4}}, {"rotation", 0.5}, {"texCoord", 1}};
  const TextureUse use = load(b).materials.at(0).base_color_texture;
  EXPECT_EQ(use.offset.x, 0.1f);
  EXPECT_EQ(use.offset.y, 0.2f);
  EXPECT_EQ(use.scale.x, 3);
  EXPECT_EQ(use.scale.y, 4);
  EXPECT_EQ(use.rotation_rad, 0.5f);
  EXPECT_EQ(use.texcoord_set, 1);  // the extension's wins
  info["extensions"]["KHR_texture_transform"]["texCoord"] = 2;
  expect_load_error(b, {"material 0 \"painted\"", "set 2"});
}

TEST(GltfTexture, WithoutTextureCoordinates) {
  GltfBuilder b = red_triangle();
  b.document["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  EXPECT_TRUE(has_warning(load(b), "texture coordinates"));
}

TEST(GltfTexture, WithoutAnImageCountsAsWhite) {
  GltfBuilder b = red_triangle();
  b.document["textures"][0] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
  const Scene scene = load(b);
  EXPECT_EQ(scene.materials[0].base_color_texture.texture, -1);
  EXPECT_TRUE(has_warning(scene, "texture"));
}

TEST(GltfTexture, HandlesThatLeadNowhere) {
  GltfBuilder b = red_triangle();
  b.document["textures"][0]["source"] = 7;
  expect_load_error(b, {"texture 0", "image 7", "there are 1"});
  b = red_triangle();
  b.document["textures"][0]["sampler"] = 7;
  expect_load_error(b, {"texture 0", "sampler 7", "there are 0"});
  b = red_triangle();
  b.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 7;
  expect_load_error(b, {"material 0", "texture 7", "there are 1"});
}

TEST(GltfImage, FromABufferView) {
  GltfBuilder b = red_triangle();
  const int view = b.view(png_1x1(1, 2, 3, 4));
  b.document["images"][0] = {{"bufferView", view}, {"mimeType", "image/png"}, {"name", "small"}};
  const Image image = load(b).images.at(0);
  EXPECT_EQ(image.name, "small");
  EXPECT_EQ(image.rgba_srgb8, (std::vector<std::uint8_t>{1, 2, 3, 4}));
}

TEST(GltfImage, SixteenBitsBecomeLinear) {
  const Scene scene =
      load(textured_triangle(png_image(png<std::uint16_t>(1, 1, 4, {65535, 32768, 0, 32768}))));
  const Image& image = scene.images.at(0);
  ASSERT_EQ(image.rgba_linear.size(), 4u);
  EXPECT_TRUE(image.rgba_srgb8.empty());
  EXPECT_EQ(image.rgba_linear[0], 1);
  // ((0.5000076 + 0.055) / 1.055)^2.4, single precision
  EXPECT_NEAR(image.rgba_linear[1], 0.2140483, 1e-6);
  EXPECT_EQ(image.rgba_linear[2], 0);
  EXPECT_NEAR(image.rgba_linear[3], 0.5000076, 1e-6);
}

TEST(GltfImage, Jpeg) {
  const Image image =
      load(textured_triangle({{"uri", data_uri(color_jpeg(), "image/jpeg")}})).images.at(0);
  EXPECT_EQ(image.width, 8);
  EXPECT_NEAR(image.rgba_srgb8[0], 200, 1);  // the transform rounds
  EXPECT_NEAR(image.rgba_srgb8[1], 100, 1);
  EXPECT_NEAR(image.rgba_srgb8[2], 50, 1);
  EXPECT_EQ(image.rgba_srgb8[3], 255);
}

TEST(GltfImage, ManyAreReadInTheirOrder) {
  GltfBuilder b = red_triangle();
  for (int i = 1; i < 40; ++i) {
    b.push("images", png_image(png_1x1(static_cast<std::uint8_t>(i), 0, 0)));
    b.push("textures", {{"source", i}});
    b.push("materials", {{"emissiveTexture", {{"index", i}}}});
  }
  const Scene scene = load(b);
  ASSERT_EQ(scene.images.size(), 40u);
  for (std::size_t i = 1; i < 40; ++i) {
    const auto texture = static_cast<std::size_t>(scene.materials[i].emissive_texture.texture);
    EXPECT_EQ(scene.images[static_cast<std::size_t>(scene.textures[texture].image)].rgba_srgb8[0],
              i);
  }
}

// A material for each of the file's images.
void show_all_images(GltfBuilder& b, int count) {
  for (int i = 1; i < count; ++i) {
    b.push("textures", {{"source", i}});
    b.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
  }
}

TEST(GltfImage, TheSameBytesAreReadOnce) {
  const std::string uri = data_uri(png_1x1(3, 2, 1));
  GltfBuilder b = textured_triangle({{"uri", uri}});
  const int view = b.view(png_1x1(1, 2, 3));
  b.push("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  b.push("images", {{"uri", uri}});
  b.push("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  show_all_images(b, 4);
  const Scene scene = load(b);
  ASSERT_EQ(scene.images.size(), 2u);
  ASSERT_EQ(scene.textures.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(scene.images[static_cast<std::size_t>(scene.textures[i].image)].rgba_srgb8[0],
              i % 2 == 0 ? 3 : 1);
}

// 17 kB may be an image of 16,384 x 8,192 pixels, half a GB. Two of them are read, and there are
// files with more; but then they are not so small. Refused by their headers: what would be decoded
// here is not there.
TEST(GltfImage, PixelsAreChargedBeforeTheyAreDecoded) {
  const std::string one = png_1x1(0, 0, 0);
  const std::string header = big_endian_u32(16384) + big_endian_u32(8192) + one.substr(24, 5);
  GltfBuilder b = one_triangle();
  for (int i = 0; i < 30; ++i) {
    const std::string filler = png_chunk("fiLl", std::string(17000, static_cast<char>(i)));
    const int view = b.view(one.substr(0, 8) + png_chunk("IHDR", header) + filler + one.substr(33));
    b.push("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  }
  b.push("textures", {{"source", 0}});
  b.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  show_all_images(b, 30);
  // 2^30 bytes, and 256 for each of the file's.
  expect_load_error(b, {"image 2", "16384 x 8192 pixels need 536870912 bytes",
                        "those before it 1073741824", "images of 512"});
}

TEST(GltfImage, OnlyThoseShownAreRead) {
  GltfBuilder b = red_triangle();
  b.push("images", {{"uri", "not-there.png"}});
  b.push("textures", {{"source", 1}});
  b.document["materials"][0]["occlusionTexture"] = {{"index", 1}};
  EXPECT_EQ(load(b).images.size(), 1u);
}

TEST(GltfImage, WhatDoesNotDecodeIsNamed) {
  expect_load_error(textured_triangle({{"name", "bark"}, {"uri", "not-there.png"}}),
                    {"image 0 \"bark\"", "not-there.png", "no such file"});
  expect_load_error(textured_triangle({{"name", "bark"}, {"uri", data_uri("rubbish")}}),
                    {"image 0 \"bark\"", "PNG"});
  expect_load_error(textured_triangle(json::object()),
                    {"image 0", "neither a URI nor a buffer view"});
  expect_load_error(textured_triangle({{"bufferView", 77}}), {"image 0", "buffer view 77"});
  const std::string whole = png<std::uint8_t>(16, 16, 4, std::vector<std::uint8_t>(1024, 9));
  expect_load_error(textured_triangle({{"name", "bark"}, {"uri", data_uri(whole.substr(0, 200))}}),
                    {"image 0 \"bark\"", "does not decode"});
}

TEST(GltfExtension, RequiredAndNotSupportedIsAnError) {
  for (const char* name : {"KHR_texture_basisu", "EXT_of_tomorrow"}) {
    GltfBuilder b = one_triangle();
    b.document["extensionsUsed"] = b.document["extensionsRequired"] = {name};
    expect_load_error(b, {"requires", name});
  }
  GltfBuilder b = one_triangle();
  b.document["extensionsRequired"] = {"KHR_texture_basisu"};
  expect_load_error(b, {"to convert it: gltf-transform ktxdecompress in.glb out.glb"});
}

TEST(GltfExtension, UsedAndNotSupportedIsAWarning) {
  GltfBuilder b = one_triangle();
  b.document["extensionsUsed"] = {"KHR_materials_sheen", "KHR_materials_unlit", "EXT_moves"};
  EXPECT_TRUE(load(b).warnings.empty());  // nothing has them
  b.document["materials"] = {{{"extensions", {{"KHR_materials_sheen", json::object()}}}}};
  b.document["nodes"][0]["extensions"]["EXT_moves"] = {{"by", 1}};
  b.document["nodes"][0]["extensions"]["MSFT_lod"] = {{"ids", {0}}};  // coarser levels
  b.root({{"extensions", {{"EXT_moves", {{"by", 2}}}}}});
  const Scene scene = load(b);
  EXPECT_EQ(scene.warnings,
            (std::vector<std::string>{
                "the glTF extension EXT_moves is not read: what it moves, adds or hides is missing "
                "from the picture (nodes[0] and 1 more)",
                "the glTF extension KHR_materials_sheen is not read: surfaces look as they would "
                "without it (materials[0])"}));
}

TEST(GltfExtension, NodesThatAreNotVisible) {
  GltfBuilder b = one_triangle();
  b.document["nodes"][0]["children"] = {1};
  b.push("nodes", {{"mesh", 0}, {"camera", 0}});
  b.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
  EXPECT_EQ(load(b).instances.size(), 2u);
  b.document["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = false;
  EXPECT_EQ(load(b).instances.size(), 1u);
  b.document["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = false;
  b.document["nodes"][1].erase("extensions");
  const Scene scene = load(b);
  EXPECT_TRUE(scene.instances.empty());
  EXPECT_EQ(scene.cameras.size(), 1u);  // who looks is no part of the picture
}

TEST(GltfLight, WhatOnlyLightShowsIsSaidOnceWithCounts) {
  GltfBuilder b = one_triangle();
  EXPECT_TRUE(load(b).warnings.empty());  // nothing says that it is meant to be lit
  b.document["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_unlit"};
  b.document["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  EXPECT_TRUE(load(b).warnings.empty());  // no node has the light
  b.root({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  b.root({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  ASSERT_EQ(load(b).warnings.size(), 1u);
  EXPECT_EQ(load(b).warnings[0],
            "without a light surfaces show their own colours, unshaded; made for light: 2 lamps");
  b.document["materials"] = {{{"name", "lit"}}};
  b.document["meshes"][0]["primitives"][0]["material"] = 0;
  ASSERT_EQ(load(b).warnings.size(), 1u);
  EXPECT_TRUE(has_warning(load(b), "made for light: 1 of 1 materials, 2 lamps"));
  b.document["materials"][0]["extensions"]["KHR_materials_unlit"] = json::object();
  EXPECT_FALSE(has_warning(load(b), "materials"));
}

TEST(GltfExtension, RequiredAndSupported) {
  GltfBuilder b = one_triangle();
  b.document["extensionsUsed"] = b.document["extensionsRequired"] = {
      "KHR_materials_unlit", "KHR_texture_transform", "KHR_materials_emissive_strength",
      "KHR_mesh_quantization"};
  EXPECT_TRUE(load(b).warnings.empty());
}

TEST(GltfCamera, Perspective) {
  GltfBuilder b;
  b.push("cameras",
         {{"name", "eye"},
          {"type", "perspective"},
          {"perspective", {{"yfov", 0.5}, {"znear", 0.1}, {"zfar", 90}, {"aspectRatio", 1.5}}},
          {"extras", {{"compound-eye", "true"}, {"compound-structure", "eyes/bee.eye"}}}});
  b.root(
      {{"name", "head"}, {"camera", 0}, {"translation", {1, 2, 3}}, {"scale", {0.02, 0.02, 0.02}}});
  const Scene scene = load(b);
  const Camera& camera = scene.cameras.at(0);
  EXPECT_EQ(camera.name, "head");
  EXPECT_EQ(camera.data_name, "eye");
  EXPECT_EQ(camera.type, CameraType::compound);
  EXPECT_EQ(camera.yfov_rad, 0.5);
  EXPECT_EQ(camera.aspect_ratio, 1.5);
  EXPECT_EQ(camera.znear_m, 0.1);
  EXPECT_EQ(camera.zfar_m, 90);
  EXPECT_EQ(camera.world_from_camera.m[1][3], 2);
  EXPECT_EQ(camera.world_from_camera.m[0][0], 0.02);  // the node's scale is kept
  EXPECT_EQ(camera.compound_structure, "eyes/bee.eye");
  EXPECT_EQ(json::parse(camera.extras_json).at("compound-eye"), "true");
  EXPECT_EQ(&find_camera(scene, "head"), &camera);
}

TEST(GltfCamera, Orthographic) {
  GltfBuilder b;
  b.push("cameras", {{"name", "above"},
                     {"type", "orthographic"},
                     {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 10}}}});
  b.root({{"camera", 0}});
  const Camera camera = load(b).cameras.at(0);
  EXPECT_EQ(camera.name, "above");  // the node has no name
  EXPECT_EQ(camera.type, CameraType::orthographic);
  EXPECT_EQ(camera.xmag_m, 2);
  EXPECT_EQ(camera.ymag_m, 3);
  EXPECT_EQ(camera.zfar_m, 10);
  EXPECT_EQ(camera.extras_json, "");
}

// CompoundRay's flags: bools, or strings in any case; an orthographic camera stays one.
TEST(GltfCamera, KindsInExtras) {
  const struct {
    json extras;
    CameraType expected;
  } cases[] = {{{{"panoramic", true}}, CameraType::panoramic},
               {{{"panoramic", "TRUE"}}, CameraType::panoramic},
               {{{"panoramic", "yes"}}, CameraType::perspective},
               {{{"panoramic", 1}}, CameraType::perspective},
               {{{"panoramic", false}, {"compound-eye", "True"}}, CameraType::compound},
               {{{"panoramic", true}, {"compound-eye", true}}, CameraType::panoramic},
               {{{"compound-structure", "bee.eye"}}, CameraType::perspective},
               {json::array({"panoramic"}), CameraType::perspective}};
  for (const auto& c : cases) {
    GltfBuilder b;
    b.push("cameras", {{"type", "perspective"},
                       {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}},
                       {"extras", c.extras}});
    b.root({{"camera", 0}});
    EXPECT_EQ(load(b).cameras.at(0).type, c.expected) << c.extras;
    b.document["cameras"][0]["type"] = "orthographic";
    b.document["cameras"][0]["orthographic"] = {
        {"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 10}};
    EXPECT_EQ(load(b).cameras.at(0).type, CameraType::orthographic) << c.extras;
  }
}

TEST(GltfCamera, ProjectionInExtras) {
  GltfBuilder b;
  b.push("cameras", {{"type", "perspective"},
                     {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}},
                     {"extras", {{"compound-projection", "single_dimension"}}}});
  b.root({{"camera", 0}});
  EXPECT_EQ(load(b).cameras.at(0).compound_projection, "single_dimension");
  b.document["cameras"][0]["extras"]["compound-projection"] = 7;
  EXPECT_EQ(load(b).cameras.at(0).compound_projection, "");
}

// As CompoundRay numbers them: roots by their index, whatever the order in which a scene lists
// them, children as their parent lists them.
TEST(GltfCamera, Order) {
  GltfBuilder b;
  for (const char* name : {"a", "b", "c", "d"})
    b.push("cameras", {{"name", name},
                       {"type", "perspective"},
                       {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}});
  b.push("nodes", {{"camera", 3}});
  b.push("nodes", {{"children", {3, 2}}});
  b.push("nodes", {{"camera", 1}});
  b.push("nodes", {{"camera", 2}});
  b.push("nodes", {{"camera", 0}});
  b.document["scenes"] = {{{"nodes", {4, 1, 0}}}};
  std::string order;
  for (const Camera& camera : load(b).cameras) order += camera.data_name;
  EXPECT_EQ(order, "dcba");
}

TEST(GltfCamera, OneUnderManyNodes) {
  GltfBuilder b;
  b.push(
      "cameras",
      {{"name", "eye"}, {"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}});
  b.root({{"name", "left"}, {"camera", 0}, {"children", {1}}});
  b.push("nodes", {{"name", "right"}, {"camera", 0}, {"translation", {5, 0, 0}}});
  const Scene scene = load(b);
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(find_camera(scene, "right").world_from_camera.m[0][3], 5);
  EXPECT_EQ(find_camera(scene, "right").zfar_m, 0);
}

TEST(GltfCamera, OfNoKnownKind) {
  GltfBuilder b;
  b.push("cameras", {{"type", "fisheye"}});
  b.root({{"camera", 0}});
  expect_load_error(b, {"fisheye"});
  b.document["cameras"][0] = {{"type", "perspective"}, {"perspective", {{"znear", 0.1}}}};
  expect_load_error(b, {"cameras[0].perspective.yfov", "missing"});
  b.document["cameras"][0] = {{"type", "perspective"}};
  expect_load_error(b, {"amera"});
  b.document["nodes"][0]["camera"] = 4;
  b.document.erase("cameras");
  expect_load_error(b, {"node 0", "camera 4", "there are 0"});
}

TEST(GltfBackground, FromTheExtrasOfTheScene) {
  const auto scene = [](const json& shader) {
    GltfBuilder b = one_triangle();
    b.document["scenes"][0]["extras"]["background-shader"] = shader;
    return load(b);
  };
  EXPECT_EQ(scene("simple_sky").background.type, BackgroundType::simple_sky);
  EXPECT_EQ(scene("default_background").background.type, BackgroundType::test_pattern);
  EXPECT_TRUE(scene("simple_sky").warnings.empty());
  const Background none = load(one_triangle()).background;
  EXPECT_EQ(none.type, BackgroundType::constant);
  expect_near(none.color, {0, 0, 0});
  const Scene other = scene("lava");
  EXPECT_EQ(other.background.type, BackgroundType::constant);
  expect_near(other.background.color, {0, 0, 0});
  EXPECT_TRUE(has_warning(other, "lava"));
}

}  // namespace
}  // namespace omma::test
