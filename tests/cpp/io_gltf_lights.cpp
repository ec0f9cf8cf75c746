// Lamps of glTF files, KHR_lights_punctual.
#include "gltf_builder.h"

namespace omma::test {
namespace {

GltfBuilder with_light(const json& light, json node = json::object()) {
  GltfBuilder b = one_triangle();
  b.document["extensions"]["KHR_lights_punctual"]["lights"] = {light};
  node["extensions"]["KHR_lights_punctual"]["light"] = 0;
  b.root(node);
  return b;
}

PunctualLight light(const json& description, const json& node = json::object()) {
  return load(with_light(description, node)).lights.at(0);
}

TEST(GltfLights, Defaults) {
  for (const auto& [word, type] : {std::pair{"directional", PunctualLightType::directional},
                                   {"point", PunctualLightType::point},
                                   {"spot", PunctualLightType::spot}}) {
    PunctualLight expected;
    expected.type = type;
    EXPECT_EQ(light({{"type", word}}), expected);
  }
}

TEST(GltfLights, AllThatTheySay) {
  const PunctualLight spot =
      light({{"type", "spot"},
             {"name", "bulb"},
             {"color", {1, 0.5, 0}},
             {"intensity", 20},
             {"range", 3},
             {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}},
             {"extras",
              {{"omma", {{"spectrum", {{"wavelength_nm", {300, 700}}, {"value", {0.5, 2}}}}}}}}},
            {{"name", "lamp"}, {"translation", {1, 2, 3}}});
  EXPECT_EQ(spot.name, "lamp");
  EXPECT_EQ(spot.color, (Vec3{1, 0.5f, 0}));
  EXPECT_EQ(spot.intensity, 20);
  EXPECT_EQ(spot.range_m, 3);
  EXPECT_EQ(spot.inner_cone_rad, 0.25);
  EXPECT_EQ(spot.outer_cone_rad, 0.5);
  EXPECT_EQ(spot.world_from_light.m[2][3], 3);
  EXPECT_EQ(spot.spectrum, (Spectrum{{300, 700}, {0.5, 2}}));
  EXPECT_EQ(light({{"type", "point"}, {"name", "bulb"}}).name, "bulb");
}

// As an exporter writes a spot with a sharp edge.
TEST(GltfLights, EqualConesHaveANarrowEdge) {
  const PunctualLight spot =
      light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}});
  EXPECT_EQ(spot.outer_cone_rad, 0.5);
  EXPECT_NEAR(spot.inner_cone_rad, 0.4995, 1e-12);
}

TEST(GltfLights, OneUnderManyNodes) {
  GltfBuilder b = with_light({{"type", "point"}});
  b.root({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"scale", {2, 2, 2}}});
  const Scene scene = load(b);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[1].world_from_light.m[0][0], 2);
  SceneOptions options;
  options.color_rule = ColorRule::compoundray;
  EXPECT_TRUE(load(b, options).lights.empty());
}

TEST(GltfLights, BadOnesAreNamed) {
  const auto expect = [](const json& description, std::vector<std::string> parts) {
    expect_load_error(with_light(description), std::move(parts));
  };
  expect({{"name", "bulb"}, {"type", "area"}},
         {"light 0 \"bulb\": type: expected directional, point or spot, found", "area"});
  expect(json::object(), {"extensions.KHR_lights_punctual.lights[0].type: is missing"});
  expect({{"type", "point"}, {"intensity", -1}}, {"light 0: intensity: expected"});
  expect({{"type", "point"}, {"intensity", "bright"}}, {"intensity: expected a number"});
  expect({{"type", "point"}, {"color", {-1, 0, 0}}}, {"light 0: color: expected"});
  expect({{"type", "point"}, {"range", -1}}, {"light 0: range_m: expected"});
  expect({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.25}}}},
         {"light 0: cones: expected 0 <= inner < outer <= pi / 2 rad, found 0.5 and 0.25"});
  expect({{"type", "spot"}, {"spot", {{"outerConeAngle", 2}}}}, {"light 0: cones: expected"});
  expect({{"type", "point"}, {"extras", {{"omma", {{"colour", 1}}}}}},
         {"lights[0].extras.omma: expected spectrum, found", "colour"});
  expect({{"type", "point"},
          {"extras", {{"omma", {{"spectrum", {{"wavelength_nm", {1, 2}}, {"value", {1, 1}}}}}}}}},
         {"light 0: spectrum: wavelength_nm: expected 100 to 5000"});
  GltfBuilder b = with_light({{"type", "point"}});
  b.document["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 3;
  expect_load_error(b, {"node 1: refers to light 3, there are 1"});
  b.document.erase("extensions");
  expect_load_error(b, {"node 1: refers to light 3, there are 0"});
}

}  // namespace
}  // namespace omma::test
