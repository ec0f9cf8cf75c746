// Lights that cannot be are refused, with the member's name.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "light/check_light.h"
#include "light_maps.h"
#include "omma/error.h"

namespace omma {
namespace {

using namespace test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

Light sound_light() {
  Light light;
  light.bands = narrow_bands(2);
  light.sky = made_sky(4, 2, 3, 2, [](int, int, int, int component, int) {
    return component == 0 ? 1 : component == 1 ? 0.6 : -0.8;
  });
  Disc disc;
  disc.direction = {0.6f, 0.8f, 0};
  disc.angular_radius_rad = 0.005;
  disc.radiance = {1, 0};
  disc.limb_darkening = {0.5, 1};
  light.discs = {disc};
  light.ultraviolet = {{0, 0, 1, 0}, {0, 0, 0, 0.04}};
  return light;
}

// What is said of a light that `change` has made wrong.
std::string said_of(const std::function<void(Light&, SkyMap&)>& change) {
  Light light = sound_light();
  auto sky = std::make_shared<SkyMap>(*light.sky);
  change(light, *sky);
  light.sky = sky;
  try {
    validate_light(light, 2);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

testing::AssertionResult begins(const std::string& text, const std::string& with) {
  if (text.rfind(with + ": expected ", 0) == 0) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << text << "' does not begin with " << with;
}

TEST(LightCheck, SoundOnesPass) {
  EXPECT_EQ(said_of([](Light&, SkyMap&) {}), "");
  Light dark;
  dark.bands = narrow_bands(1);
  EXPECT_NO_THROW(validate_light(dark, 7));
}

TEST(LightCheck, Bands) {
  const auto said = [](const Bands& bands) {
    return said_of([&](Light& light, SkyMap&) { light.bands = bands; });
  };
  EXPECT_TRUE(begins(said({}), "bands.wavelength_nm"));
  EXPECT_TRUE(begins(said({{500, 500}, {1, 0, 0, 1}}), "bands.wavelength_nm"));
  EXPECT_TRUE(begins(said({{500, nan}, {1, 0, 0, 1}}), "bands.wavelength_nm"));
  EXPECT_TRUE(begins(said({{500, infinity}, {1, 0, 0, 1}}), "bands.wavelength_nm"));
  EXPECT_TRUE(begins(said({{-500, 500}, {1, 0, 0, 1}}), "bands.wavelength_nm"));
  EXPECT_TRUE(begins(said({{500, 510}, {1, 0, 1}}), "bands.weight"));
  EXPECT_TRUE(begins(said({{500, 510}, {}}), "bands.weight"));
  EXPECT_TRUE(begins(said({{500, 510}, {2, -1, 0, 1}}), "bands.weight"));
  EXPECT_TRUE(begins(said({{500, 510}, {1, 0, nan, 1}}), "bands.weight"));
  EXPECT_TRUE(begins(said({{500, 510}, {1, 0, 0, 1 + 2e-6}}), "bands.weight"));
  EXPECT_TRUE(begins(said({{500}, std::vector<double>(129, 1.0)}), "bands.weight"));
}

TEST(LightCheck, Sky) {
  const auto said = [](const std::function<void(SkyMap&)>& change) {
    return said_of([&](Light&, SkyMap& sky) { change(sky); });
  };
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.columns = 3; }), "sky.columns"));
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.rows = 1; }), "sky.rows"));
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.rows = 1 << 20; }), "sky.rows"));
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.components = 2; }), "sky.components"));
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.channels = 3; }), "sky.channels"));
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.radiance.pop_back(); }), "sky.radiance"));
  EXPECT_TRUE(begins(said([](SkyMap& s) { s.band_from_channel = {1}; }), "sky.band_from_channel"));
  EXPECT_TRUE(begins(said([](SkyMap& s) {
                       s.band_from_channel = {1, 0, -1, 0};
                     }),
                     "sky.band_from_channel"));
  for (const float bad : {-1.0f, static_cast<float>(nan), static_cast<float>(infinity), 1e35f})
    EXPECT_TRUE(begins(said([&](SkyMap& s) { s.radiance[0] = bad; }), "sky.radiance"));
  // Q and U of more than I, by more than a table's rounding.
  EXPECT_EQ(said([](SkyMap& s) { s.radiance[2] = 0.6001f; }), "");
  const std::string over = said([](SkyMap& s) { s.radiance[6 * 4 * 2 + 2] = 0.61f; });
  EXPECT_TRUE(begins(over, "sky.radiance"));
  EXPECT_NE(over.find("row 0 below the horizon"), std::string::npos) << over;
  EXPECT_TRUE(
      begins(said([](SkyMap& s) { s.radiance[3] = static_cast<float>(nan); }), "sky.radiance"));
}

TEST(LightCheck, Discs) {
  const auto said = [](const std::function<void(Disc&)>& change) {
    return said_of([&](Light& light, SkyMap&) { change(light.discs[0]); });
  };
  EXPECT_TRUE(begins(said([](Disc& d) { d.direction.x = 0.61f; }), "discs[0].direction"));
  EXPECT_TRUE(
      begins(said([](Disc& d) { d.direction.x = static_cast<float>(nan); }), "discs[0].direction"));
  for (const double bad : {0.0, -0.1, 9e-7, 0.1, nan})
    EXPECT_TRUE(
        begins(said([&](Disc& d) { d.angular_radius_rad = bad; }), "discs[0].angular_radius_rad"));
  EXPECT_TRUE(begins(said([](Disc& d) { d.radiance.pop_back(); }), "discs[0].radiance"));
  for (const double bad : {-1.0, nan, infinity, 1e31})
    EXPECT_TRUE(begins(said([&](Disc& d) { d.radiance[1] = bad; }), "discs[0].radiance"));
  EXPECT_TRUE(
      begins(said([](Disc& d) { d.limb_darkening.pop_back(); }), "discs[0].limb_darkening"));
  for (const double bad : {-0.1, 1.1, nan})
    EXPECT_TRUE(
        begins(said([&](Disc& d) { d.limb_darkening[1] = bad; }), "discs[0].limb_darkening"));
}

TEST(LightCheck, Ultraviolet) {
  const auto said = [](const std::vector<std::array<double, 4>>& weights) {
    return said_of([&](Light& light, SkyMap&) { light.ultraviolet = weights; });
  };
  EXPECT_EQ(said({}), "");
  EXPECT_TRUE(begins(said({{0, 0, 1, 0}}), "ultraviolet"));
  EXPECT_TRUE(begins(said({{0, 0, 1, 0.1}, {}}), "ultraviolet"));
  EXPECT_TRUE(begins(said({{0, 0, -1, 0}, {}}), "ultraviolet"));
  EXPECT_TRUE(begins(said({{0, 0, nan, 0}, {}}), "ultraviolet"));
}

}  // namespace
}  // namespace omma
