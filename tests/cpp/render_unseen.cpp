// Things that some poses do not see, as an animal's own body: their rays go on to what lies behind,
// those of others meet them, and so does light.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "light_maps.h"
#include "test_scenes.h"
#include "world_tests.h"

namespace omma::test {
namespace {

Mesh square(double half_m) {
  const auto h = static_cast<float>(half_m);
  Mesh mesh;
  mesh.material = 0;
  mesh.positions = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// A ground at y = 0, and two things: one of two meshes in front of the eye, one of one behind it.
// `alpha`: of all of them.
Scene two_things(float alpha = 1) {
  Scene scene;
  for (const Vec3 color : {Vec3{0.2f, 0.5f, 0.3f}, Vec3{0.9f, 0.1f, 0.2f}, Vec3{0.1f, 0.3f, 0.9f}}) {
    const int material = add_color(scene, color);
    scene.materials[static_cast<std::size_t>(material)].base_color.w = alpha;
    if (alpha < 1)
      scene.materials[static_cast<std::size_t>(material)].alpha_mode = AlphaMode::blend;
  }
  const double half_m[] = {20, 0.5, 0.7};
  for (int m = 0; m < 3; ++m) {
    scene.meshes.push_back(square(half_m[m]));
    scene.meshes.back().material = m;
  }
  scene.meshes.push_back(scene.meshes[1]);
  for (Vec3& p : scene.meshes.back().positions) p = p + Vec3{1.3f, 0.3f, 0};
  const auto place = [&](const char* name, int mesh, int node, const Mat4& world_from_mesh) {
    scene.instances.push_back({name, mesh, world_from_mesh, node});
  };
  place("ground", 0, 0, rotation({1, 0, 0}, -pi / 2));
  place("front", 1, 1, translation({-0.4, 1, -2}));
  place("front", 3, 1, translation({-0.4, 1, -2}));
  place("behind", 2, 2, translation({0, 1.2, 2}));
  return scene;
}

// Without the things of one node.
Scene without(Scene scene, int node) {
  std::erase_if(scene.instances, [&](const Instance& one) { return one.node == node; });
  return scene;
}

struct Unseen {
  std::vector<std::vector<int>> groups;
  std::vector<int> at;
  bool by_light = false;

  std::vector<float> seen(const Renderer& renderer, const std::vector<Mat4>& poses) const {
    RenderCall call;
    call.unseen = groups;
    call.unseen_at = at;
    call.unseen_by_light = by_light;
    std::vector<float> responses(poses.size() * renderer.eye().size() *
                                 static_cast<std::size_t>(renderer.world().bands()));
    renderer.render(poses, responses, call);
    return responses;
  }
};

std::vector<float> joined(const std::vector<std::vector<float>>& parts) {
  std::vector<float> all;
  for (const std::vector<float>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const Mat4 pose = translation({0, 1, 0});

// A world whose things are in the part of it that moves, as things are that some do not see: where
// they lie is rounded alike then.
World world_apart(const Scene& scene) {
  World world = make_world(scene);
  const std::vector<WorldInstance> things = world.instances();
  for (int k = 0; k < static_cast<int>(things.size()); ++k)
    if (things[static_cast<std::size_t>(k)].name != "ground")
      world.set_transforms(std::span(&k, 1),
                           std::span(&things[static_cast<std::size_t>(k)].world_from_node, 1));
  return world;
}

void expect_each_pose_sees_its_own(const Scene& scene, const RenderSettings& settings) {
  const Eye eye = make_eye(sphere_directions(500), 0.2);
  const World world = world_apart(scene);
  const int front = world.find_instance("front"), behind = world.find_instance("behind");
  const Renderer renderer(world, eye, settings);
  const std::vector<float> all = test::seen(renderer, pose);
  const auto seen_in = [&](const Scene& other) {
    return test::seen(Renderer(world_apart(other), eye, settings), pose);
  };
  const std::vector<float> no_front = seen_in(without(scene, 1)),
                           no_behind = seen_in(without(scene, 2)),
                           neither = seen_in(without(without(scene, 1), 2));
  ASSERT_NE(no_front, all);
  ASSERT_NE(no_behind, all);
  const Unseen unseen{{{front}, {behind}, {behind, front}}, {0, -1, 1, 2, 0}};
  EXPECT_EQ(unseen.seen(renderer, std::vector<Mat4>(5, pose)),
            joined({no_front, all, no_behind, neither, no_front}));
  EXPECT_EQ(test::seen(renderer, pose), all) << "what was not seen is seen again";
}

TEST(Unseen, ThingsAreAsIfTheyWereNotThere) {
  expect_each_pose_sees_its_own(two_things(), {.sampling = Fixed{16}});
}

TEST(Unseen, ThingsThatLetLightThroughToo) {
  expect_each_pose_sees_its_own(two_things(0.5f), {.sampling = Fixed{16}});
}

TEST(Unseen, BySharedRaysToo) {
  expect_each_pose_sees_its_own(two_things(), {.sampling = Shared{16}});
}

TEST(Unseen, GoesWithThingsThatMove) {
  const Eye eye = make_eye(sphere_directions(500), 0.2);
  World world = make_world(two_things());
  const int front = world.find_instance("front"), behind = world.find_instance("behind");
  const Renderer renderer(world, eye, {.sampling = Fixed{16}});
  const Mat4 places[] = {translation({0.3, 1, -1.5}), translation({-0.2, 1.4, 1}),
                         translation({0.3, 1, -1.5}), translation({-0.2, 1.4, 1}),
                         translation({1.0, 1, -1.1}), translation({-0.5, 1.4, 1})};
  const int things[] = {front, behind};
  const std::vector<std::vector<int>> groups{{front}};
  const int at[] = {0, -1, 0};  // the first two poses lie alike
  RenderCall call;
  call.instances = things;
  call.world_from_node = places;
  call.unseen = groups;
  call.unseen_at = at;
  const std::vector<Mat4> poses(3, pose);
  std::vector<float> found(3 * 500 * 3);
  renderer.render(poses, found, call);

  std::vector<std::vector<float>> expected;
  for (const int p : {0, 1, 2}) {
    World other = world_apart(p == 1 ? two_things() : without(two_things(), 1));
    std::vector<int> moved{other.find_instance("behind")};
    std::vector<Mat4> to{places[2 * p + 1]};
    if (p == 1) {
      moved.push_back(other.find_instance("front"));
      to.push_back(places[2 * p]);
    }
    other.set_transforms(moved, to);
    expected.push_back(test::seen(Renderer(other, eye, {.sampling = Fixed{16}}), pose));
  }
  EXPECT_EQ(found, joined(expected));
}

TEST(Unseen, ThrowsItsShadow) {
  WorldSettings settings;
  Lighting lighting;
  lighting.depth = 1;
  lighting.light.bands = narrow_bands(1);
  Disc sun;
  sun.angular_radius_rad = 0.01;
  sun.radiance = {1000};
  lighting.light.discs = {sun};
  settings.lighting = lighting;
  Scene scene = two_things();
  // Level, above the eye: it sees the underside overhead and the shadow below.
  scene.instances[3].world_from_mesh =
      translation({0, 3, 0}) * rotation({1, 0, 0}, -pi / 2);
  const World world = make_world(scene, settings);
  const int roof = world.find_instance("behind");
  const Eye eye = make_eye(std::vector<Vec3d>{{0, -1, 0}, {0.9, -0.43588989435406733, 0}}, 0.02);
  const Renderer renderer(world, eye, {.sampling = Fixed{64}});
  const Unseen unseen{{{roof}}, {0, -1}};
  const std::vector<float> found = unseen.seen(renderer, {pose, pose});
  EXPECT_EQ(found[0], 0) << "the shadow of what it does not see";
  EXPECT_GT(found[1], 0) << "the sunlit ground";
  EXPECT_EQ(found[0], found[2]);
  const std::vector<float> absent = Unseen{{{roof}}, {0, -1}, true}.seen(renderer, {pose, pose});
  EXPECT_GT(absent[0], 0.9f * found[1]) << "no shadow either";
  EXPECT_EQ(absent[2], 0) << "the shadow of who sees it";
  EXPECT_EQ(found[1], found[3]);
}

TEST(Unseen, SaysWhatIsWrong) {
  const World world = make_world(two_things());
  const Renderer renderer(world, single_rays(10));
  const auto message = [&](const Unseen& unseen, std::size_t poses = 1) {
    try {
      unseen.seen(renderer, std::vector<Mat4>(poses, pose));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message({{{7}}, {0}}), "unseen: expected indices of the world's 3 things, found 7");
  EXPECT_EQ(message({{{-1}}, {0}}), "unseen: expected indices of the world's 3 things, found -1");
  EXPECT_EQ(message({{{1}}, {1}}), "unseen_at: expected -1 to 0, found 1");
  EXPECT_EQ(message({{{1}}, {0}}, 2),
            "unseen_at: expected a group, or -1, for each of 2 poses, found 1");
  EXPECT_EQ(message({{}, {0}}), "unseen_at: expected a group, or -1, for each of 0 poses, found 1");
  EXPECT_EQ(message({std::vector<std::vector<int>>(32, {1}), {0}}),
            "unseen: expected at most 31 groups, found 32");
  EXPECT_EQ(message({{{1}}, {0}}), "");
}

}  // namespace
}  // namespace omma::test
