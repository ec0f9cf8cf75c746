// A world in which things move: what is seen of them is what is seen of a world built with them
// there, what stays is as it was, and what cannot be is refused and changes nothing.
#include "omma/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "omma/camera.h"
#include "backend/backend.h"
#include "world_tests.h"

namespace omma::test {
namespace {

// Things are placed in single precision, by an instance's transform or vertex by vertex: hits
// differ by 1e-7 of some metres, colours by what textures of a few texels a metre make of that.
// Rays that pass an edge, of a triangle or of a nearest texel, within that meet something else:
// some 20 edges a metre long around the ray's 10 m, times 1e-6 m, of a sphere of 4 pi 3 m^2: one in
// a million, and a few more where cut-outs multiply edges. A wrong transform changes most of what
// is seen.
void expect_alike(const std::vector<float>& found, const std::vector<float>& expected,
                  const std::string& what) {
  ASSERT_EQ(found.size(), expected.size());
  std::size_t others = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    others += std::fabs(found[i] - expected[i]) > 2e-3f * std::max(1.0f, expected[i]) ? 1 : 0;
  EXPECT_LE(others, found.size() / 1000) << what;
}

Mat4 random_place(Random& random, double mirror = 1) {
  const Mat4 first_turn = random_rotation(random);
  const Mat4 size =
      scaling({mirror * random.uniform(0.5, 2), random.uniform(0.5, 2), random.uniform(0.5, 2)});
  const Mat4 last_turn = random_rotation(random);
  const Vec3d towards = random.direction();
  return translation(towards * random.uniform(2, 5)) * last_turn * size * first_turn;
}

// Moves in a world and in a copy of its scene.
struct Pair {
  Scene scene;
  World world;

  explicit Pair(const Scene& from) : scene(from), world(make_world(from)) {}

  void move(const std::vector<int>& instances, const std::vector<Mat4>& transforms) {
    world.set_transforms(instances, transforms);
    for (std::size_t k = 0; k < instances.size(); ++k)
      scene.instances[static_cast<std::size_t>(instances[k])].world_from_mesh = transforms[k];
  }
};

TEST(World, AMovedSquareCoversWhereItIs) {
  // Of a picture 4 m wide with 64 x 64 pixels a square of 1 m fills 16 x 16, if all of it is
  // inside.
  Scene scene;
  Material lamp;
  lamp.base_color = {0, 0, 0, 1};
  lamp.emissive = {1, 1, 1};
  add_quad(scene, {0, 0, -2}, {0.5, 0, 0}, {0, 0.5, 0}, add_material(scene, lamp));
  World world = make_world(scene);
  Camera camera;
  camera.type = CameraType::orthographic;
  camera.xmag_m = camera.ymag_m = 2;
  const auto covered = [&] {
    std::vector<float> picture(64 * 64 * rgb_bands);
    render_camera(world, camera, {{64, 64}, 1}, picture);
    double sum = 0;
    for (const float value : picture) sum += value;
    return sum / rgb_bands;
  };
  const int square = 0;
  const auto move_to = [&](const Mat4& t) { world.set_transforms({&square, 1}, {&t, 1}); };
  EXPECT_EQ(covered(), 256);
  move_to(translation({1.75, 0, 0}));  // from 1.25 m on, of 2 m
  EXPECT_EQ(covered(), 12 * 16);
  move_to(translation({2, 2, 0}));
  EXPECT_EQ(covered(), 8 * 8);
  move_to(scaling({2, 0.5, 1}));
  EXPECT_EQ(covered(), 32 * 8);
  move_to(translation({0, 0, 5}));  // behind the camera
  EXPECT_EQ(covered(), 0);
  move_to(rotation({0, 1, 0}, pi / 2) * translation({0, 0, 2}));  // seen edge on
  EXPECT_EQ(covered(), 0);
  move_to({});
  EXPECT_EQ(covered(), 256);
}

TEST(World, MovedIsAsBuiltThere) {
  const Eye eye = single_rays();
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    Random random{seed};
    Pair pair(random_scene(seed));
    const std::vector<float> at_first = seen(pair.world, eye);
    // One, then others, then some of both again; every third mirrored.
    for (const std::vector<int>& instances : {std::vector{3}, {0, 7, 11, 15}, {3, 7, 1}, {15, 3}}) {
      std::vector<Mat4> transforms;
      for (const int i : instances) transforms.push_back(random_place(random, i % 3 == 0 ? -1 : 1));
      pair.move(instances, transforms);
      expect_alike(seen(pair.world, eye), seen(make_world(pair.scene), eye),
                   "seed " + std::to_string(seed));
    }
    EXPECT_NE(seen(pair.world, eye), at_first);
    for (const int i : {0, 1, 3, 7, 11, 15}) {
      const Mat4 back = random_scene(seed).instances[static_cast<std::size_t>(i)].world_from_mesh;
      pair.move({i}, {back});
    }
    expect_alike(seen(pair.world, eye), at_first, "moved back, seed " + std::to_string(seed));
  }
}

// Fields of view with texture, at any pose, through every way of sampling.
TEST(World, ResponsesAreThoseOfAWorldBuiltThere) {
  const Eye eye = make_eye(sphere_directions(200), 0.2);
  Random random{11};
  Pair pair(random_scene(4));
  pair.move({2, 5}, {random_place(random), random_place(random)});
  const std::vector<Mat4> poses = turning_poses(3);
  for (const RenderSettings& settings :
       {RenderSettings{.sampling = Fixed{16}},
        RenderSettings{.sampling = Fixed{16}, .points = Points::random},
        RenderSettings{.sampling = Shared{16}},
        RenderSettings{.sampling = Fixed{16}, .footprints = false}}) {
    const Result moved = render(Renderer(pair.world, eye, settings), poses);
    const Result built = render(Renderer(make_world(pair.scene), eye, settings), poses);
    expect_alike(moved.response, built.response, "responses");
  }
}

// A wall of fine texture that is moved away and scaled as much looks the same; footprints are in
// metres of the mesh, and rays that took them for eight times as wide would see grey.
TEST(World, FootprintsFollowTheScaleOfWhatMoves) {
  Scene scene;
  Material material;
  material.double_sided = true;
  Random random{9};
  material.base_color_texture.texture = add_texture(scene, make_image(512, 512, [&](int, int) {
                                                      const auto grey =
                                                          static_cast<float>(random.uniform());
                                                      return Vec4{grey, grey, grey, 1};
                                                    }));
  add_quad(scene, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}, add_material(scene, material));
  Pair pair(scene);
  std::vector<Vec3d> axes;
  for (int i = 0; i < 300; ++i)
    axes.push_back(normalize(Vec3d{random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), -1}));
  const Eye eye = make_eye(axes, 2 * degree);
  const RenderSettings settings{.sampling = Fixed{16}};
  const Renderer renderer(pair.world, eye, settings);
  const std::vector<float> at_first = seen(renderer);
  for (const double scale : {1.0, 8.0, 0.125, 8.0}) {
    pair.move({0}, {scaling({scale, scale, scale})});
    expect_alike(seen(renderer), seen(Renderer(make_world(pair.scene), eye, settings)), "scaled");
    expect_alike(seen(renderer), at_first, "scaled, against before");
  }
}

TEST(World, WhatStaysKeepsItsBits) {
  const Eye eye = make_eye(sphere_directions(300), 0.2);
  for (const std::uint64_t seed : {2u, 4u}) {
    const Scene scene = random_scene(seed);
    World world = make_world(scene);
    const std::vector<float> before = seen(world, eye);
    EXPECT_EQ(seen(make_renderer(scene, eye, {.sampling = Fixed{1}})), before);
    // Behind everything else, and small.
    const int away = 6;
    const Mat4 far = translation({0, 0, 900}) * scaling({1e-6, 1e-6, 1e-6});
    world.set_transforms({&away, 1}, {&far, 1});
    Scene without = scene;
    without.instances[6].mesh = add_mesh(without, Mesh{});
    EXPECT_EQ(seen(world, eye), seen(make_world(without), eye));
  }
}

// A floor of `count` small tiles, and where they lie once they are moved.
Scene tiles(int count) {
  Scene scene;
  scene.background = constant_background({0.1f, 0.2f, 0.3f});
  const int mesh = add_mesh(
      scene, quad({0, 0, 0}, {0.04, 0, 0}, {0, 0, -0.04}, add_color(scene, {1, 0.5f, 0.25f})));
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  for (int i = 0; i < count; ++i)
    add_instance(scene, mesh,
                 translation({0.1 * (i % side - side / 2.0), -1, 0.1 * (i / side - side / 2.0)}));
  return scene;
}

TEST(World, MovesOneAHundredAndTenThousand) {
  const Eye eye = single_rays(2000);
  for (const int count : {1, 100, 10000}) {
    Random random{7};
    Pair pair(tiles(10000));
    for (int round = 0; round < 3; ++round) {
      std::vector<int> instances;
      std::vector<Mat4> transforms;
      for (int i = 0; i < count; ++i) {
        instances.push_back(i * (10000 / count));
        transforms.push_back(random_place(random));
      }
      pair.move(instances, transforms);
      expect_alike(seen(pair.world, eye), seen(make_world(pair.scene), eye), std::to_string(count));
    }
  }
}

// More triangles, placed twice, than are copied: there all instances are Embree's.
TEST(World, MovesInLargeScenesToo) {
  Scene scene = random_scene(3);
  Mesh fine;
  constexpr std::uint32_t cells = 600;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      fine.positions.push_back(to_float({0.002 * i - 0.6, 0, 0.002 * j - 0.6}));
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i;
      fine.triangles.push_back({a, a + cells + 1, a + 1});
      fine.triangles.push_back({a + 1, a + cells + 1, a + cells + 2});
    }
  fine.material = add_color(scene, {1, 0, 0});
  const int mesh = add_mesh(scene, std::move(fine));
  for (int i = 0; i < 2; ++i) add_instance(scene, mesh, translation({0, -1.0 - i, 0}));
  Random random{5};
  Pair pair(scene);
  const Eye eye = single_rays();
  for (int round = 0; round < 2; ++round) {
    pair.move({17, 2}, {random_place(random), random_place(random, -1)});
    expect_alike(seen(pair.world, eye), seen(make_world(pair.scene), eye), "large");
  }
}

// Layers of glass in one place, each of two triangles that share an edge the rays hit: every layer
// counts once, moved or not.
TEST(World, LayersThatMoveCountOnce) {
  Scene scene;
  scene.background = constant_background({1, 1, 1});
  Material glass;
  glass.base_color = {0, 0, 0, 0.25f};
  glass.alpha_mode = AlphaMode::blend;
  glass.double_sided = true;
  const int mesh =
      add_mesh(scene, quad({0, 0, -1}, {1, 0, 0}, {0, 1, 0}, add_material(scene, glass)));
  for (int i = 0; i < 4; ++i) add_instance(scene, mesh, translation({5, 0, 0}));
  World world = make_world(scene);
  std::vector<Vec3d> axes;
  for (int i = -9; i <= 9; ++i) axes.push_back({0.09 * i, -0.09 * i, -1});  // along the diagonal
  for (int i = -9; i <= 9; ++i) axes.push_back({0.09 * i, 0.03, -1});
  const Eye eye = make_eye(axes, 0);
  const auto expect_layers = [&](int layers) {
    const std::vector<float> found = seen(world, eye);
    // Products of four rounded floats.
    for (const float value : found) EXPECT_NEAR(value, std::pow(0.75, layers), 1e-6) << layers;
  };
  expect_layers(0);
  const std::vector<int> all{0, 1, 2, 3};
  for (int moved = 1; moved <= 4; ++moved) {
    const std::vector<Mat4> here(static_cast<std::size_t>(moved));
    world.set_transforms(std::span(all).first(static_cast<std::size_t>(moved)), here);
    expect_layers(moved);
  }
  // One lies where another was never moved to, the others one behind the other.
  const std::vector<Mat4> behind{
      {}, translation({0, 0, -1}), translation({0, 0, -2}), scaling({-1, 1, 1})};
  world.set_transforms(all, behind);
  std::vector<Vec3d> inner;
  for (int i = -3; i <= 3; ++i) inner.push_back({0.09 * i, -0.09 * i, -1});
  for (const float value : seen(world, make_eye(inner, 0)))
    EXPECT_NEAR(value, std::pow(0.75, 4), 1e-6);
}

TEST(World, ANodeIsOneThing) {
  Scene scene;
  const int red = add_color(scene, {1, 0, 0}), green = add_color(scene, {0, 1, 0});
  scene.instances.push_back(
      {"tree", add_mesh(scene, quad({-0.5, 0, -1}, {0.5, 0, 0}, {0, 1, 0}, red)), {}, 7});
  scene.instances.push_back(
      {"stone", add_mesh(scene, quad({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, red)), {}, 2});
  scene.instances.push_back(
      {"tree", add_mesh(scene, quad({0.5, 0, -1}, {0.5, 0, 0}, {0, 1, 0}, green)), {}, 7});
  World world = make_world(scene);
  const std::vector<WorldInstance> instances = world.instances();
  ASSERT_EQ(instances.size(), 2u);
  EXPECT_EQ(instances[0].name, "tree");
  EXPECT_EQ(instances[1].name, "stone");
  const int tree = world.find_instance("tree");
  const Mat4 up = translation({0, 2, 0});
  world.set_transforms({&tree, 1}, {&up, 1});
  EXPECT_EQ(world.instances()[0].world_from_node.m[1][3], 2);
  const Eye eye = make_eye(std::vector<Vec3d>{{-0.2, 2, -1}, {0.2, 2, -1}, {-0.2, 0, -1}}, 0);
  EXPECT_EQ(seen(world, eye), (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 0}));
  // Instances of one node are in one place.
  scene.instances[2].world_from_mesh = up;
  EXPECT_THROW(make_world(scene), Error);
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(World, FindsThingsByName) {
  Scene scene;
  add_mesh(scene, quad({0, 0, -1}, {1, 0, 0}, {0, 1, 0}, -1));
  for (const char* name : {"flower 1", "flower 2", "stone", "flower 2", "tussock", "beetle", "ant"})
    scene.instances.push_back({name, 0, {}});
  const World world = make_world(scene);
  EXPECT_EQ(world.find_instance("stone"), 2);
  EXPECT_EQ(world.find_instance("flower 1"), 0);
  const std::string twice = message_of([&] { world.find_instance("flower 2"); });
  EXPECT_TRUE(has(twice, "2 things are called \"flower 2\": 1, 3")) << twice;
  const std::string none = message_of([&] { world.find_instance("flower 3"); });
  EXPECT_TRUE(has(none, "nearest to it are \"flower 1\", \"flower 2\"")) << none;
  EXPECT_TRUE(has(none, ", ...")) << none;
  EXPECT_TRUE(has(message_of([&] { make_world({}).find_instance("x"); }), "the scene is empty"));
}

TEST(World, WhatCannotBeIsRefusedAndChangesNothing) {
  const Eye eye = single_rays(500);
  World world = make_world(random_scene(2));
  const int moved[] = {4, 5};
  Random random{3};
  const std::vector<Mat4> places{random_place(random), random_place(random)};
  world.set_transforms(moved, places);
  const std::vector<float> before = seen(world, eye);
  const auto refused = [&](const std::vector<int>& instances, const std::vector<Mat4>& transforms) {
    const std::string message = message_of([&] { world.set_transforms(instances, transforms); });
    EXPECT_EQ(seen(world, eye), before) << message;
    return message;
  };
  const Mat4 good = translation({1, 2, 3});
  Mat4 nan = good;
  nan.m[1][2] = std::nan("");
  EXPECT_TRUE(has(refused({4, 5}, {good, nan}), "transforms[1], of \"\": expected a finite"));
  EXPECT_TRUE(has(refused({1}, {scaling({1, 0, 1})}), "one without an inverse"));
  EXPECT_TRUE(has(refused({1}, {scaling({1e-11, 1e-11, 1e-11})}), "determinant"));
  EXPECT_TRUE(has(refused({1}, {scaling({1e11, 1e11, 1e11})}), "determinant"));
  EXPECT_TRUE(has(refused({1, 4}, {good, translation({2e12, 0, 0})}), "within 1e+12 m"));
  EXPECT_TRUE(has(refused({16}, {good}), "instances[0]: expected an index into the 16 instances"));
  EXPECT_TRUE(has(refused({-1}, {good}), "found -1"));
  EXPECT_TRUE(has(refused({4, 5, 4}, {good, good, good}), "instances[2]: 4 is there twice"));
  EXPECT_TRUE(has(refused({4, 5}, {good}), "transforms: expected one for each of 2"));
  EXPECT_NO_THROW(world.set_transforms({}, {}));
  EXPECT_EQ(seen(world, eye), before);
  EXPECT_THROW(World(nullptr), Error);
  EXPECT_TRUE(has(message_of([] { make_world({}, {.backend = "cuda"}); }), "found \"cuda\""));
  for (const Backend& backend : backends())
    EXPECT_EQ(make_world({}, {.backend = backend.name}).backend().rfind(backend.name, 0), 0u);
}

TEST(World, GoesFarAwayAsAWhole) {
  const Eye eye = single_rays();
  const Scene scene = random_scene(6);
  World world = make_world(scene);
  const std::vector<float> expected = seen(world, eye);
  EXPECT_EQ(world.precision_warning(std::vector<Mat4>(1)), "");
  std::vector<int> all;
  for (int i = 0; i < 16; ++i) all.push_back(i);
  for (const Vec3d there : {Vec3d{4e6, 0, 2e6}, {-3e8, 1e8, 0}, {0.5, 0.5, 0.5}}) {
    std::vector<Mat4> transforms;
    for (const Instance& instance : scene.instances)
      transforms.push_back(translation(there) * instance.world_from_mesh);
    world.set_transforms(all, transforms);
    const Mat4 pose = translation(there);
    expect_alike(seen(world, eye, pose), expected, "far away");
    EXPECT_EQ(world.precision_warning({&pose, 1}), "");
  }
  // One thing alone: the world has become large, and that is told of poses beside it.
  const int one = 0;
  const Mat4 far = translation({1e6, 0, 0});
  world.set_transforms({&one, 1}, {&far, 1});
  EXPECT_NE(world.precision_warning({&far, 1}), "");
}

}  // namespace
}  // namespace omma::test
