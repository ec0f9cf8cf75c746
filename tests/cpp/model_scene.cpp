// Scenes in memory: what validate_scene refuses, bounds, counts, cameras by name.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "omma/omma.h"

namespace omma::test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// One textured, coloured triangle, twice in the world, and a camera.
Scene good_scene() {
  Scene s;
  s.path = "made.gltf";
  Image image;
  image.width = image.height = 1;
  image.rgba_srgb8 = {1, 2, 3, 255};
  s.images.push_back(image);
  s.textures.push_back({0, Wrap::repeat, Wrap::repeat, Filter::linear});
  Material material;
  material.name = "paint";
  material.base_color_texture.texture = 0;
  s.materials.push_back(material);
  Mesh mesh;
  mesh.name = "Tri";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {100, 100, 100}};  // the last is not used
  mesh.triangles = {{0, 1, 2}};
  mesh.texcoords[0] = {{0, 0}, {1, 0}, {0, 1}, {0, 0}};
  mesh.colors = {{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}};
  mesh.material = 0;
  s.meshes.push_back(mesh);
  Instance instance{"a", 0, {}};
  s.instances.push_back(instance);
  instance.world_from_mesh.m[0][0] = -2;  // mirrored and stretched along x
  instance.world_from_mesh.m[2][3] = 5;
  s.instances.push_back(instance);
  Camera camera;
  camera.name = "cam";
  camera.data_name = "lens";
  s.cameras.push_back(camera);
  return s;
}

void expect_invalid(const std::function<void(Scene&)>& change, const std::string& part) {
  Scene s = good_scene();
  change(s);
  try {
    validate_scene(s);
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("made.gltf: "), 0u) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    return;
  }
  ADD_FAILURE() << "no error; expected one with: " << part;
}

TEST(ValidateScene, GoodOnesPass) {
  EXPECT_NO_THROW(validate_scene(good_scene()));
  EXPECT_NO_THROW(validate_scene({}));
}

TEST(Scene, NormalsAndHitBoxesAreChecked) {
  expect_invalid([](Scene& s) { s.meshes[0].normals = {{0, 0, 1}}; }, "1 normals for 4 vertices");
  expect_invalid(
      [](Scene& s) {
        s.hit_boxes.push_back({"zone", {{0, 0, 0}}, {{0, 0, 1}}, {}});
      },
      "hit box 0 \"zone\": triangle 0 has vertex 1");
  expect_invalid(
      [](Scene& s) {
        s.hit_boxes.push_back({"zone", {{nan, 0, 0}}, {}, {}});
      },
      "hit box 0 \"zone\": the position");
}

TEST(Scene, IsEqualWhereverItCameFrom) {
  Scene a = good_scene(), b = good_scene();
  b.path = "other.gltf";
  b.warnings = {"a"};
  EXPECT_TRUE(a == b);
  a.instances[0].node = 7;  // alone, as without a node
  EXPECT_TRUE(a == b);
  b.meshes[0].colors[0].x = 0.5f;
  EXPECT_FALSE(a == b);
}

TEST(ValidateScene, Handles) {
  expect_invalid([](Scene& s) { s.textures[0].image = 1; },
                 "texture 0: refers to image 1, there are 1");
  expect_invalid([](Scene& s) { s.textures[0].image = -1; }, "texture 0");
  expect_invalid([](Scene& s) { s.materials[0].base_color_texture.texture = 1; },
                 "material 0 \"paint\": refers to texture 1");
  expect_invalid([](Scene& s) { s.materials[0].emissive_texture.texture = -2; }, "material 0");
  expect_invalid([](Scene& s) { s.materials[0].emissive_texture.texcoord_set = 2; }, "set 2");
  expect_invalid([](Scene& s) { s.meshes[0].material = 1; },
                 "mesh 0 \"Tri\": refers to material 1");
  expect_invalid([](Scene& s) { s.instances[1].mesh = 1; }, "instance 1 \"a\": refers to mesh 1");
  expect_invalid([](Scene& s) { s.instances[1].mesh = -1; }, "instance 1");
  expect_invalid([](Scene& s) { s.meshes[0].triangles[0][2] = 4; },
                 "triangle 0 has vertex 4, there are 4");
}

TEST(ValidateScene, Sizes) {
  expect_invalid([](Scene& s) { s.meshes[0].texcoords[1].resize(2); },
                 "2 texture coordinates for 4 vertices");
  expect_invalid([](Scene& s) { s.meshes[0].colors.resize(3); }, "3 colours for 4 vertices");
  expect_invalid([](Scene& s) { s.images[0].width = 2; }, "image 0: 2 x 1 pixels need 8 values");
  expect_invalid([](Scene& s) { s.images[0].height = 0; }, "image 0: has 1 x 0 pixels");
  expect_invalid([](Scene& s) { s.images[0].width = s.images[0].height = 1 << 15; },
                 "image 0: has 1073741824 pixels, an image may have 268435456");
  expect_invalid([](Scene& s) { s.images[0].rgba_linear.resize(4); }, "one of two arrays");
  expect_invalid([](Scene& s) { s.background.type = BackgroundType::image; }, "background");
}

TEST(ValidateScene, Numbers) {
  expect_invalid([](Scene& s) { s.meshes[0].positions[1].y = nan; },
                 "mesh 0 \"Tri\": the position of vertex 1 is not finite");
  expect_invalid([](Scene& s) { s.meshes[0].texcoords[0][2].x = nan; },
                 "texture coordinate of vertex 2");
  expect_invalid([](Scene& s) { s.meshes[0].colors[3].w = nan; }, "colour of vertex 3");
  expect_invalid([](Scene& s) { s.meshes[0].colors[3].y = -1; }, "colour of vertex 3 is negative");
  expect_invalid([](Scene& s) { s.materials[0].base_color.x = nan; }, "base colour");
  expect_invalid([](Scene& s) { s.materials[0].base_color.w = -1; }, "base colour");
  expect_invalid([](Scene& s) { s.materials[0].emissive.z = -1; }, "emission");
  expect_invalid([](Scene& s) { s.materials[0].alpha_cutoff = nan; }, "alpha cutoff");
  expect_invalid([](Scene& s) { s.materials[0].base_color_texture.rotation_rad = nan; },
                 "texture transform");
  expect_invalid([](Scene& s) { s.instances[0].world_from_mesh.m[1][2] = nan; },
                 "world_from_mesh is not finite");
  expect_invalid([](Scene& s) { s.instances[0].world_from_mesh.m[3][0] = 1; },
                 "bottom row of world_from_mesh");
  expect_invalid([](Scene& s) { s.cameras[0].world_from_camera.m[0][0] = nan; },
                 "camera 0 \"cam\": world_from_camera");
  expect_invalid([](Scene& s) { s.cameras[0].yfov_rad = nan; }, "projection");
  expect_invalid([](Scene& s) { s.background.color.y = nan; }, "background");
  expect_invalid(
      [](Scene& s) {
        s.images[0].rgba_srgb8.clear();
        s.images[0].rgba_linear = {0, 0, nan, 1};
      },
      "image 0: expected finite pixels, found nan in row 0, column 0");
}

// Sums, and sums of squares, must stay within single precision whatever is seen.
TEST(ValidateScene, RefusesRadianceBeyondSinglePrecision) {
  expect_invalid([](Scene& s) { s.materials[0].base_color.x = 1.1e15f; },
                 "its colour (factor x texture x vertex colour) would reach 1.1e+15, expected");
  expect_invalid([](Scene& s) { s.materials[0].base_color.w = 1e38f; }, "its colour");
  expect_invalid([](Scene& s) { s.materials[0].emissive.y = 1e38f; },
                 "its emission (factor x texture) would reach 1e+38");
  expect_invalid([](Scene& s) { s.background.color.z = -1e38f; }, "background: its radiance");
  const auto bright_image = [](Scene& s) {
    s.images[0].rgba_srgb8.clear();
    s.images[0].rgba_linear = {0, 0, 1e8f, 1};
  };
  expect_invalid(
      [&](Scene& s) {
        bright_image(s);
        s.materials[0].base_color_texture.texture = 0;
        s.materials[0].base_color.y = 1e8f;
      },
      "material 0");
  expect_invalid(
      [&](Scene& s) {
        s.materials[0].base_color.y = 1e8f;
        s.meshes[0].colors[1].x = 1e8f;
      },
      "mesh 0 \"Tri\": its colour");
  expect_invalid(
      [&](Scene& s) {
        bright_image(s);
        s.background.type = BackgroundType::image;
        s.background.image = s.images[0];
        s.background.image.rgba_linear[1] = 1e16f;
      },
      "background: its radiance would reach 1e+16");
  Scene bright = good_scene();
  bright.materials[0].base_color = {1e15f, 0, 0, 1};
  bright.background.color = {1e15f, 1, 1};
  EXPECT_NO_THROW(validate_scene(bright));
}

TEST(SceneBounds, AroundAllInstances) {
  const Bounds bounds = scene_bounds(good_scene());
  EXPECT_FALSE(bounds.empty);
  EXPECT_EQ(bounds.lower.x, -2);
  EXPECT_EQ(bounds.lower.y, 0);
  EXPECT_EQ(bounds.lower.z, 0);
  EXPECT_EQ(bounds.upper.x, 1);
  EXPECT_EQ(bounds.upper.y, 1);
  EXPECT_EQ(bounds.upper.z, 5);
  EXPECT_TRUE(scene_bounds({}).empty);
}

TEST(TriangleCount, CountsInstances) {
  EXPECT_EQ(triangle_count(good_scene()), 2u);
  EXPECT_EQ(triangle_count({}), 0u);
}

TEST(FindCamera, ByTheNameOfTheNodeOrOfTheCamera) {
  Scene s = good_scene();
  EXPECT_EQ(&find_camera(s, "cam"), &s.cameras[0]);
  EXPECT_EQ(&find_camera(s, "lens"), &s.cameras[0]);
  s.cameras.push_back(s.cameras[0]);
  s.cameras[1].name = "lens";
  EXPECT_EQ(&find_camera(s, "lens"), &s.cameras[1]);  // node names go first
  const auto message = [&](const std::string& name) -> std::string {
    try {
      find_camera(s, name);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("x"), "made.gltf: there is no camera \"x\"; there are 0 \"cam\", 1 \"lens\"");
  s.cameras[1].name = "cam";
  EXPECT_EQ(message("cam"), "made.gltf: 2 cameras are called \"cam\": 0, 1");
  s.cameras.clear();
  EXPECT_EQ(message("x"), "made.gltf: there is no camera \"x\"; the scene has none");
}

}  // namespace
}  // namespace omma::test
