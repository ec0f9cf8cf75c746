// What is copied to a card that keeps copies of arrays (physics/views/version.h), by the emulated
// one: of a world at rest nothing after the first frame, and later what has changed alone. That no
// array has changed without a new version is held by the emulated card itself, in all tests.
#include <gtest/gtest.h>

#include <algorithm>

#include "backend/cuda/cuda_backend.h"
#include "lit_squares.h"
#include "omma/bake.h"
#include "test_scenes.h"
#include "world/bake_gather.h"
#include "world_tests.h"

namespace omma::test {
namespace {

// A wall of many triangles with a picture, and a thing before it that can be moved.
struct Place {
  World world;
  Eye eye;
  int thing;
};

constexpr int picture_size = 64;
constexpr std::size_t texel_bytes = 4 * sizeof(float);

Image picture(float red) {
  return make_image(picture_size, picture_size, [&](int x, int y) {
    return Vec4{red, static_cast<float>(x) / picture_size, static_cast<float>(y) / picture_size, 1};
  });
}

constexpr std::size_t wall_bytes = 3000u * 9 * sizeof(float);  // corners of its triangles

Place make_place() {
  Scene scene;
  Mesh wall;
  wall.material = add_color(scene, {0.25f, 0.5f, 1});
  const Mesh square = quad({0, 0, -4}, {4, 0, 0}, {0, 4, 0}, wall.material);
  for (std::uint32_t i = 0; i < 1500; ++i) {
    wall.positions.insert(wall.positions.end(), square.positions.begin(), square.positions.end());
    for (const std::array<std::uint32_t, 3>& t : square.triangles)
      wall.triangles.push_back({t[0] + 4 * i, t[1] + 4 * i, t[2] + 4 * i});
  }
  add_instance(scene, add_mesh(scene, wall));
  Material material;
  material.base_color_texture.texture = add_texture(scene, picture(0.5f));
  Mesh thing = quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, add_material(scene, material));
  thing.texcoords[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  add_instance(scene, add_mesh(scene, thing), translation({0, 0, -2}));
  const int moved = static_cast<int>(scene.instances.size()) - 1;
  WorldSettings settings;
  settings.backend = "emulated";
  return {make_world(scene, settings), make_eye(sphere_directions(60), 12 * degree), moved};
}

// What a frame copied to stay, bytes.
std::size_t copied_by(const Renderer& renderer) {
  take_kept_bytes();
  seen(renderer);
  return take_kept_bytes();
}

TEST(KeptCopies, OfAWorldAtRestAreCopiedOnce) {
  const Place of = make_place();
  const Renderer renderer(of.world, of.eye, {});
  EXPECT_GT(copied_by(renderer), wall_bytes);
  EXPECT_EQ(copied_by(renderer), 0u);
  // Another eye is copied, and not the world.
  const Renderer other(of.world, make_eye(sphere_directions(10), 12 * degree),
                       {.sampling = Fixed{4}});
  const std::size_t of_eye = copied_by(other);
  EXPECT_GT(of_eye, 10u * 12 * sizeof(float));
  EXPECT_LT(of_eye, wall_bytes);
  EXPECT_EQ(copied_by(renderer), 0u);
}

// The first move of a thing builds anew; from then on what is placed changes alone.
TEST(KeptCopies, OfWhatMovesAreSmall) {
  Place of = make_place();
  const Renderer renderer(of.world, of.eye, {});
  const auto move_to = [&](double z) {
    const Mat4 there = translation({0, 0, z});
    of.world.set_transforms({&of.thing, 1}, {&there, 1});
  };
  move_to(-3);
  seen(renderer);
  const std::vector<float> before = seen(renderer);
  move_to(-1);
  const std::size_t copied = copied_by(renderer);
  EXPECT_GT(copied, 0u);
  EXPECT_LT(copied, 4096u);
  EXPECT_NE(seen(renderer), before);
  move_to(-3);
  EXPECT_EQ(seen(renderer), before);
}

TEST(KeptCopies, OfColorsAndPicturesAreThoseThatChanged) {
  Place of = make_place();
  const Renderer renderer(of.world, of.eye, {});
  const std::vector<float> before = seen(renderer);
  of.world.set_color(0, {0.125f, 0.875f, 0.25f}, {0, 0, 0});
  const std::size_t of_color = copied_by(renderer);
  EXPECT_GT(of_color, 0u);
  EXPECT_LT(of_color, 4096u);
  const std::vector<float> colored = seen(renderer);
  EXPECT_NE(colored, before);
  of.world.set_image(0, picture(0.9f));
  const std::size_t of_picture = copied_by(renderer);
  const std::size_t texels = picture_size * picture_size * 4 / 3;  // of all levels
  EXPECT_GE(of_picture, texel_bytes * texels);
  EXPECT_LT(of_picture, texel_bytes * texels + 512);
  EXPECT_NE(seen(renderer), colored);
}

TEST(KeptCopies, OfShapesAreRenewed) {
  Place of = make_place();
  const Renderer renderer(of.world, of.eye, {});
  const int mesh = static_cast<int>(of.world.scene().meshes.size()) - 1;
  const auto bend = [&](double half_m) {
    const Mesh bent = quad({0, 0, 0}, {half_m, 0, 0}, {0, half_m, 0}, 0);
    of.world.set_vertices(mesh, bent.positions, {});
  };
  bend(0.5);  // builds anew
  const std::vector<float> before = seen(renderer);
  bend(1.5);
  EXPECT_NE(seen(renderer), before);
  bend(0.5);
  EXPECT_EQ(seen(renderer), before);
}

// A world that is lit anew has all of its own; one before another background only that.
TEST(KeptCopies, OfWorldsOfOneScene) {
  const Place of = make_place();
  seen(of.world, of.eye);
  World before_grey = of.world.with_background(constant_background({0.5f, 0.5f, 0.5f}));
  const Renderer renderer(before_grey, of.eye, {});
  EXPECT_LT(copied_by(renderer), wall_bytes);
  const World lit = of.world.with_lighting(lighting_of(1));
  const Renderer in_light(lit, of.eye, {});
  EXPECT_GT(copied_by(in_light), 3000u * sizeof(float));
  EXPECT_EQ(copied_by(in_light), 0u);
}

// Passes of a bake read in turns what lies at the same places.
TEST(KeptCopies, OfLightThatIsBakedAgainAreRenewed) {
  WorldSettings settings;
  settings.lighting = lighting_of(1);
  settings.backend = "emulated";
  const World world = make_world(squares(), settings);
  BakedLight baked = bake_light(world, {.cell_m = 1, .paths = 16});
  const auto gathered = [&] {
    const GatherWorld reading(world, baked, baked.lines.data());
    std::vector<std::uint16_t> light(static_cast<std::size_t>(world.bands()));
    GatherList list;
    Receiver ahead;
    ahead.normal = {0, 0, -1};
    list.add(ahead, 16, light.data());
    EXPECT_TRUE(reading.gather(list));
    return light;
  };
  const std::vector<std::uint16_t> before = gathered();
  const std::vector<BakedLine> lines = baked.lines;
  for (BakedLine& line : baked.lines) line = {};
  EXPECT_NE(gathered(), before);
  std::copy(lines.begin(), lines.end(), baked.lines.begin());
  EXPECT_EQ(gathered(), before);
}

}  // namespace
}  // namespace omma::test
