// One of many lights: chosen as often as is said, and about by what it sends to a place.
#include <gtest/gtest.h>

#include "backend/light_tree_data.h"
#include "physics/light/light_tree.h"
#include "test_scenes.h"

namespace omma {
namespace {

using namespace test;

std::vector<TreeLight> some_lights(int count, std::uint64_t seed) {
  Random random{seed};
  std::vector<TreeLight> lights;
  for (int i = 0; i < count; ++i)
    lights.push_back(tree_light(random.direction() * random.uniform(1, 9),
                                i % 7 == 3 ? 0.0 : random.uniform(0.5, 2), i % 5 == 1));
  return lights;
}

// A lamp with a switch stands in each tree but the smallest; that of 40,000 has several a leaf.
TEST(LightTree, ChoosesAsOftenAsItSays) {
  for (const int count : {1, 2, 3, 8, 45, 1000, 40000}) {
    SCOPED_TRACE(count);
    const LightTree tree = make_light_tree(some_lights(count, 1), 3);
    const LightTreeView view = tree.view();
    const LitPoint place{{2, -1, 3}, {}};
    double sum = 0;
    std::vector<double> said;
    for (int i = 0; i < count; ++i) {
      said.push_back(static_cast<double>(light_tree_probability(view, place, i)));
      sum += said.back();
      EXPECT_TRUE(i % 7 != 3 || said.back() == 0);
    }
    EXPECT_NEAR(sum, 1, 1e-4);
    // Evenly spaced numbers meet each light by its probability, but for one at either end. Sums
    // are in steps of 2^-24, of which a leaf of several lights has a thousand.
    constexpr int samples = 1 << 20;
    std::vector<int> found(static_cast<std::size_t>(count), 0);
    for (int s = 0; s < samples; ++s) {
      const ChosenLight chosen =
          sample_light_tree(view, place, (static_cast<float>(s) + 0.5f) / samples);
      const auto i = static_cast<std::size_t>(chosen.index);
      ++found[i];
      ASSERT_GE(chosen.left, 0);
      ASSERT_LT(chosen.left, 1);
      ASSERT_NEAR(static_cast<double>(chosen.probability) / said[i], 1, 1e-5);
    }
    for (std::size_t i = 0; i < said.size(); ++i)
      EXPECT_NEAR(found[i], said[i] * samples, 2 + 1e-3 * said[i] * samples) << i;
  }
}

TEST(LightTree, OfDirectionalLampsIsTheSameEverywhere) {
  std::vector<TreeLight> lights;
  for (int i = 0; i < 4; ++i) lights.push_back(tree_light({}, 1 + i, true));
  const LightTree tree = make_light_tree(lights, 5);
  for (int i = 0; i < 4; ++i)
    for (const float x : {0.0f, 50.0f})
      EXPECT_NEAR(light_tree_probability(tree.view(), {{x, 0, 0}, {}}, i), (1 + i) / 10.0, 1e-6);
}

// At the distance at which weights are meant a directional lamp and another one are alike; at half
// of it the other one sends four times as much.
TEST(LightTree, KnowsTheDistanceOfWeights) {
  const LightTree tree = make_light_tree({tree_light({}, 3), tree_light({}, 3, true)}, 10);
  EXPECT_NEAR(light_tree_probability(tree.view(), {{10, 0, 0}, {}}, 0), 0.5, 1e-6);
  EXPECT_NEAR(light_tree_probability(tree.view(), {{0, 5, 0}, {}}, 0), 0.8, 1e-6);
}

// Variance of one sample's estimate of the sum over all lights of power / distance^2, over that
// sum squared.
double variance_of(const LightTree& tree, const std::vector<TreeLight>& lights, Vec3d place) {
  double sum = 0, squares = 0, never = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Vec3d way = lights[i].centre_m - place;
    const double sent = lights[i].weight / dot(way, way);
    sum += sent;
    const auto chosen = static_cast<double>(
        light_tree_probability(tree.view(), {to_float(place), {}}, static_cast<std::int32_t>(i)));
    if (chosen > 0)
      squares += sent * sent / chosen;
    else  // below the precision of 1 - share
      never += sent;
  }
  EXPECT_LE(never, 1e-7 * sum);
  return squares / (sum * sum) - 1;
}

// A lamp far weaker than another is chosen by what it sends, also where the other is near.
TEST(LightTree, DoesNotOverrateWhatIsWeak) {
  const LightTree tree = make_light_tree({tree_light({}, 1e-6), tree_light({9, 0, 0}, 1)});
  EXPECT_NEAR(light_tree_probability(tree.view(), {{9, 3, 0}, {}}, 0) / (1e-6 * 9 / 90), 1, 1e-4);
  EXPECT_NEAR(light_tree_probability(tree.view(), {{0, 1e-3f, 0}, {}}, 0),
              1 / (1 + 1e-6 / 1e-6 / 81), 1e-4);
}

// 400 lamps 6 m apart, 4 m up: lights chosen evenly have a variance of 7 to 26 times the square.
TEST(LightTree, ChoosesByWhatIsSent) {
  std::vector<TreeLight> lights;
  for (int i = 0; i < 400; ++i)
    lights.push_back(tree_light({6.0 * (i % 20), 4, 6.0 * std::floor(i / 20)}, 1));
  const LightTree tree = make_light_tree(lights);
  Random random{3};
  double worst = 0;
  for (int k = 0; k < 200; ++k)
    worst = std::max(worst, variance_of(tree, lights,
                                        {random.uniform(0, 114), 0, random.uniform(0, 114)}));
  EXPECT_LT(worst, 3);
}

// One far away, as strong as each of the others or a million times as strong.
TEST(LightTree, LetsWhatIsFarFromAllOthersStandAlone) {
  Random random{4};
  std::vector<TreeLight> lights;
  for (int i = 0; i < 300; ++i)
    lights.push_back(tree_light({random.uniform(-60, 60), 4, random.uniform(-60, 60)}, 1));
  for (const double strength : {1.0, 1e6}) {
    std::vector<TreeLight> with_far = lights;
    with_far.push_back(tree_light({3e4, 4, 0}, strength));
    const LightTree tree = make_light_tree(lights), far = make_light_tree(with_far);
    for (int k = 0; k < 50; ++k) {
      const Vec3d at{random.uniform(-50, 50), 0, random.uniform(-50, 50)};
      EXPECT_LT(variance_of(far, with_far, at), 2 * variance_of(tree, lights, at) + 0.1);
    }
  }
}

// Strong ones that send nothing, by their cone or below the ground, among weak ones: these are
// chosen as if the strong ones were not there. When a node had both its lights were taken for
// strong, and those of the others came once in a thousand times.
TEST(LightTree, StrongOnesThatSendNothingLeaveTheOthersAlone) {
  Random random{6};
  std::vector<TreeLight> weak;
  for (int i = 0; i < 40; ++i)
    weak.push_back(tree_light({random.uniform(-60, 60), 4, random.uniform(-60, 60)}, 1));
  struct Strong {
    int count;
    bool up;  // by their cone, else below the ground
  };
  for (const Strong strong : {Strong{1, true}, {9, true}, {2, false}}) {
    std::vector<TreeLight> all = weak;
    for (int i = 0; i < strong.count; ++i) {
      all.push_back(tree_light({-20.0 + 50 * (i % 3), strong.up ? 3.0 : -2.0, 5.0 * i}, 500));
      if (strong.up) all.back().axis = {0, 1, 0}, all.back().reach_rad = 0.5;
    }
    const LightTree tree = make_light_tree(all), without = make_light_tree(weak);
    for (int k = 0; k < 50; ++k) {
      const LitPoint place{{static_cast<float>(random.uniform(-50, 50)), 0,
                            static_cast<float>(random.uniform(-50, 50))},
                           {0, 1, 0}};
      for (int i = 0; i < 40; ++i)
        EXPECT_NEAR(light_tree_probability(tree.view(), place, i) /
                        light_tree_probability(without.view(), place, i),
                    1, 0.5);
    }
  }
}

TEST(LightTree, FindsPlacesInItsOwnFrame) {
  Random random{3};
  const Mat4 placed = translation({70, -20, 5}) * random_rotation(random) * scaling({3, -0.1, 2});
  float to_frame[12];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) to_frame[4 * r + c] = static_cast<float>(placed.m[r][c]);
  const Vec3d at{4, -6, 9};
  const Vec3d found = to_double(place_before(to_frame, to_float(transform_point(placed, at))));
  // Places 70 m from the origin are rounded by 4e-6 m, a tenth of the scale.
  EXPECT_LT(length(found - at), 1e-4);
  const float flat[12] = {1, 0, 0, 5, 0, 0, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(place_before(flat, {1, 2, 3}), Vec3{});
}

TEST(LightTree, FollowsLightsThatMove) {
  std::vector<TreeLight> lights = some_lights(64, 5);
  for (TreeLight& light : lights) light.is_steady = false;
  LightTree tree = make_light_tree(lights);
  const LitPoint place{{30, 0, 0}, {}};
  EXPECT_LT(light_tree_probability(tree.view(), place, 12), 0.1);
  lights[12] = tree_light({30, 0.5, 0}, lights[12].weight);
  place_lights(tree, lights);
  EXPECT_GT(light_tree_probability(tree.view(), place, 12), 0.5);
}

// A part is chosen evenly, so that no light is outshone by one that may be hidden.
TEST(LightTree, ChoosesAPartEvenly) {
  std::vector<TreeLight> lights = some_lights(9, 2);
  lights[4].weight = 1e9;
  const LightTree tree = make_light_tree(lights);
  const LightTreeView view = tree.view();
  const LitPoint at{{3, 1, -2}, {}};
  constexpr int samples = 1 << 20;
  std::vector<int> found(lights.size(), 0);
  for (int s = 0; s < samples; ++s) {
    const ChosenLight chosen = choose_light(view, at, (static_cast<float>(s) + 0.5f) / samples);
    ++found[static_cast<std::size_t>(chosen.index)];
    ASSERT_GE(chosen.left, 0);
    ASSERT_LT(chosen.left, 1);
    ASSERT_FLOAT_EQ(chosen.probability, choose_light_probability(view, at, chosen.index));
  }
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const float said = choose_light_probability(view, at, static_cast<std::int32_t>(i));
    EXPECT_GE(said, 0.2f / 9);
    EXPECT_NEAR(found[i], said * samples, 3);
  }
}

// Spots with ranges about a surface: what sends light there can be chosen, and of what is known to
// send none nothing is chosen.
TEST(LightTree, KnowsConesRangesAndHorizons) {
  Random random{8};
  std::vector<TreeLight> lights;
  for (int i = 0; i < 300; ++i) {
    const Vec3d middle = random.direction() * 30;
    TreeLight light = tree_light(middle + random.direction() * random.uniform(0, 6), 1);
    light.range_m = random.uniform(5, 40);
    light.axis = random.direction();
    light.reach_rad = random.uniform(0.1, pi / 2);
    if (i % 9 == 0) light.reach_rad = pi;
    lights.push_back(light);
  }
  const LightTree tree = make_light_tree(lights);
  int reaching = 0;
  double told_apart = 0, never = 0;
  for (int k = 0; k < 300; ++k) {
    const Vec3d place = random.direction() * random.uniform(0, 30), normal = random.direction();
    const LitPoint at{to_float(place), to_float(normal)};
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const TreeLight& light = lights[i];
      const Vec3d to = light.centre_m - place;
      const double distance = length(to);
      const bool reaches = distance < light.range_m && dot(to, normal) > 0 &&
                           dot(to, light.axis) <= -std::cos(light.reach_rad) * distance;
      const float chosen = light_tree_probability(tree.view(), at, static_cast<std::int32_t>(i));
      if (reaches) {
        ++reaching;
        EXPECT_GT(chosen, 0) << i;
      } else {
        ++never;
        told_apart += chosen == 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(reaching, 1000);
  EXPECT_GT(told_apart / never, 0.99);  // a light alone is known exactly
}

TEST(LightTree, GivesNothingWhereNothingIsSent) {
  TreeLight up = tree_light({0, 1, 0}, 1);
  up.axis = {0, 1, 0};
  up.reach_rad = 0.3;
  TreeLight beside = up;
  beside.box = {{9, 1, 0}, {9, 1, 0}, false};
  beside.centre_m = {9, 1, 0};
  const LightTree tree = make_light_tree({up, beside});
  const ChosenLight none = sample_light_tree(tree.view(), {{0, 0, 0}, {}}, 0.3f);
  EXPECT_EQ(none.index, -1);
  EXPECT_EQ(none.probability, 0);
}

}  // namespace
}  // namespace omma
