// Lamps without size.
#include <gtest/gtest.h>

#include "light/bands.h"
#include "light_scenes.h"

namespace omma {
namespace {

using namespace test;

// Irradiance across the direction to a lamp of 1 W sr^-1 nm^-1 (or m^-2 nm^-1).
double irradiance(const PunctualLight& lamp, Vec3d at) {
  Scene scene;
  scene.lights = {lamp};
  const auto lit = lit_scene(scene, watts_alone());
  const LitPoint lit_point{to_float(at), {}};
  const LightKinds kinds = choose_kinds(*lit->view.light, lit_point);
  EXPECT_EQ(kinds.lamp, 1);
  LightSample sample;
  sample_near_light(lit->view, *lit->view.light, lit_point, kinds, {0.5f, 0.5f, 0.5f}, sample);
  if (!(sample.pdf > 0)) return 0;
  EXPECT_TRUE(sample.is_delta);
  return radiance_of(*lit, sample) / static_cast<double>(sample.pdf);
}

PunctualLight lamp_of(PunctualLightType type) {
  PunctualLight lamp;
  lamp.type = type;
  lamp.spectrum = {{200, 800}, {1, 1}};
  return lamp;
}

TEST(Lamps, InverseSquare) {
  PunctualLight lamp = lamp_of(PunctualLightType::point);
  lamp.world_from_light = translation({1, 2, 3});
  for (const double d : {0.01, 1.0, 30.0})
    EXPECT_NEAR(irradiance(lamp, {1, 2 + d, 3}) * d * d, 1, 1e-5);
  EXPECT_EQ(irradiance(lamp, {1, 2, 3}), 0);
}

TEST(Lamps, RangeIsAWindow) {
  PunctualLight lamp = lamp_of(PunctualLightType::point);
  lamp.range_m = 10;
  EXPECT_NEAR(irradiance(lamp, {0, 5, 0}), (1 - std::pow(0.5, 4)) / 25, 1e-7);
  EXPECT_EQ(irradiance(lamp, {0, 10, 0}), 0);
  EXPECT_EQ(irradiance(lamp, {0, 11, 0}), 0);
}

TEST(Lamps, SpotsHaveACone) {
  PunctualLight lamp = lamp_of(PunctualLightType::spot);
  lamp.inner_cone_rad = 20 * degree;
  lamp.outer_cone_rad = 40 * degree;
  // Along its own -Z, which is turned to +x.
  lamp.world_from_light = rotation({0, 1, 0}, -pi / 2) * scaling({2, 3, 4});
  const auto at = [&](double angle_deg) {
    return irradiance(lamp, {std::cos(angle_deg * degree), std::sin(angle_deg * degree), 0});
  };
  EXPECT_NEAR(at(0), 1, 1e-6);
  EXPECT_NEAR(at(19.9), 1, 1e-5);
  const double part = (std::cos(30 * degree) - std::cos(40 * degree)) /
                      (std::cos(20 * degree) - std::cos(40 * degree));
  EXPECT_NEAR(at(30), part * part, 1e-5);
  EXPECT_EQ(at(41), 0);
  EXPECT_EQ(at(180), 0);
  // A narrow one is as bright on its axis: cosines are rounded by 6e-8, 1e-4 of its width.
  lamp.inner_cone_rad = 0;
  lamp.outer_cone_rad = 2 * degree;
  EXPECT_NEAR(at(0), 1, 1e-3);
  EXPECT_EQ(at(2.1), 0);
}

TEST(Lamps, DirectionalOnesAreEverywhere) {
  PunctualLight lamp = lamp_of(PunctualLightType::directional);
  lamp.world_from_light = translation({7, 8, 9}) * rotation({1, 0, 0}, -pi / 2);  // down
  Scene scene;
  scene.lights = {lamp};
  const auto lit = lit_scene(scene, watts_alone());
  LightSample sample;
  sample_lamps(*lit->view.light, {{-3, 4, 5}, {}}, 0.2f, sample);
  EXPECT_NEAR(sample.direction.y, 1, 1e-6);
  EXPECT_EQ(sample.distance_m, INFINITY);
  EXPECT_NEAR(irradiance(lamp, {-3, 4, 5}), 1, 1e-6);
}

TEST(Lamps, CandelasOfColour) {
  PunctualLight lamp;
  lamp.intensity = 5;
  lamp.color = {1, 0.5f, 0.25f};
  Scene scene;
  scene.lights = {lamp};
  Light light;
  light.bands = {{450, 550, 650}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const auto lit = lit_scene(scene, light);
  LightSample sample;
  sample_lamps(*lit->view.light, {{0, 2, 0}, {}}, 0.5f, sample);
  std::vector<float> out(9, 1.0f);
  eval_light_sample(lit->view, sample, 3, out.data(), 1, 3);
  const auto per_lumen = primaries_per_lumen(light.bands, light.unit);
  for (std::size_t b = 0; b < 3; ++b) {
    const double expected =
        5.0 / 4 * (per_lumen[b][0] + 0.5 * per_lumen[b][1] + 0.25 * per_lumen[b][2]);
    EXPECT_NEAR(out[b] / expected, 1, 1e-6);
    EXPECT_EQ(out[3 + b], 0);  // Q
    EXPECT_EQ(out[6 + b], 0);  // U
  }
}

TEST(Lamps, EachIsChosenAtTimesAndTogetherTheyAreAll) {
  Scene scene;
  for (int i = 0; i < 4; ++i) {
    PunctualLight lamp = lamp_of(PunctualLightType::point);
    lamp.spectrum.value = {std::pow(10.0, -i), std::pow(10.0, -i)};
    if (i == 2) lamp.spectrum.value = {0, 0};  // off
    lamp.world_from_light = translation({static_cast<double>(i), 0, 0});
    scene.lights.push_back(lamp);
  }
  const auto lit = lit_scene(scene, watts_alone());
  EXPECT_EQ(lit->light->view.lamp_count, 3);
  double sum = 0;
  Random random{1};
  constexpr int samples = 400000;
  const Vec3 at{0, 2, 0};
  int seen[3] = {};
  for (int i = 0; i < samples; ++i) {
    const LightSample sample = light_at(*lit, {at, {}}, random);
    ++seen[sample.index];
    sum += radiance_of(*lit, sample) / static_cast<double>(sample.pdf);
  }
  for (const int count : seen) EXPECT_GT(count, 0);
  // By their strength but for the part that is chosen evenly: a standard error of 4e-4.
  EXPECT_NEAR(sum / samples / (1 / 4.0 + 0.1 / 5 + 0.001 / 13), 1, 2e-3);
}

// The part by share is E_k / Σ E, of lamps as they face the surface; of a kind that sends nothing
// there is none.
TEST(Lamps, AreChosenBesideTheSkyByWhatEachSendsToAPlace) {
  Scene scene;
  PunctualLight lamp = lamp_of(PunctualLightType::point);
  lamp.world_from_light = translation({0, 5, 0});
  lamp.range_m = 100;
  scene.lights = {lamp};
  Light light = watts_alone();
  light.sky = made_sky(4, 2, 1, 1, [](int, int, int, int, int) { return 1e-3; });
  const auto lit = lit_scene(scene, light);
  const double of_sky = 0.5 * 4 * pi * 1e-3;
  const auto near = [&](double x, Vec3 normal) {
    const LightKinds kinds =
        choose_kinds(*lit->view.light, {{static_cast<float>(x), 0, 0}, normal});
    EXPECT_NEAR(kinds.far + kinds.lamp, 1, 1e-6);
    EXPECT_EQ(kinds.surface, 0);
    return static_cast<double>(kinds.lamp);
  };
  for (const double x : {0.0, 3.0, 20.0, 90.0}) {
    const double d_2 = x * x + 25, window = 1 - std::pow(d_2 / 1e4, 2);
    const double cosine = std::max(5 / std::sqrt(d_2), 0.1);
    const double level = window / d_2 * cosine, all_around = window / d_2 * 0.5;
    EXPECT_NEAR(near(x, {0, 1, 0}), 0.1 + 0.8 * level / (level + of_sky), 1e-4);
    EXPECT_NEAR(near(x, {}), 0.1 + 0.8 * all_around / (all_around + of_sky), 1e-4);
    EXPECT_EQ(near(x, {0, -1, 0}), 0);
  }
  EXPECT_EQ(near(101, {0, 1, 0}), 0);
}

TEST(Lamps, FollowTheOriginOfTheTracedFrame) {
  Scene scene;
  PunctualLight lamp = lamp_of(PunctualLightType::point);
  lamp.world_from_light = translation({1000, 0, 0});
  scene.lights = {lamp};
  const auto lit = lit_scene(scene, watts_alone());
  place_lamps(*lit->light, lit->scene, {999, 0, 0});
  EXPECT_EQ(lit->light->lamps[0].position, (Vec3{1, 0, 0}));
}

}  // namespace
}  // namespace omma
