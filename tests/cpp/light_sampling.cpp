// Directions sampled by how much light comes from them.
#include <gtest/gtest.h>

#include "backend/sky_data.h"
#include "light_maps.h"
#include "physics/sampling/cumulative.h"
#include "test_scenes.h"

namespace omma {
namespace {

using namespace test;

// Uneven and in part dark, with two discs.
Light uneven_light() {
  Random random{5};
  Light light;
  light.bands = narrow_bands(2);
  light.sky = made_sky(9, 6, 1, 2, [&](int half, int row, int column, int, int) {
    const bool dark = (half == 1 && row > 2) || (column > 3 && column < 7);
    return dark ? 0 : std::pow(random.uniform(), 4) * 10;
  });
  Disc disc;
  disc.direction = to_float(normalize(Vec3d{0.2, 0.7, 0.4}));
  disc.angular_radius_rad = 0.00465;
  disc.radiance = {5e4, 1e4};
  light.discs.push_back(disc);
  disc.direction = to_float(normalize(Vec3d{0.1, -0.9, 0.1}));
  disc.angular_radius_rad = 0.01;
  disc.radiance = {0, 1e4};
  light.discs.push_back(disc);
  return light;
}

double cell_solid_angle(const SkyMap& sky, int row) {
  const double step = pi / 2 / (sky.rows - 1);
  return (std::sin((row + 1) * step) - std::sin(row * step)) * 2 * pi / sky.columns;
}

Vec3 cell_middle(const SkyMap& sky, int half, int row, int column) {
  const double step = pi / 2 / (sky.rows - 1);
  const double sine = (std::sin((row + 1) * step) + std::sin(row * step)) / 2;
  return to_float(
      direction_of(2 * pi * (column + 0.5) / sky.columns, (half == 0 ? 1 : -1) * std::asin(sine)));
}

double total_disc_probability(const LightView& view) {
  double sum = 0;
  for (int i = 0; i < view.disc_count; ++i) sum += static_cast<double>(view.discs[i].probability);
  return sum;
}

TEST(FarSampling, DensityIntegratesToOne) {
  const Light light = uneven_light();
  const auto data = light_alone(light);
  const SkyMap& sky = *light.sky;
  // Cells are evenly dense, and their middles lie outside of the discs.
  double sum = 0;
  for (int half = 0; half < 2; ++half)
    for (int row = 0; row < sky.rows - 1; ++row)
      for (int column = 0; column < sky.columns; ++column)
        sum += static_cast<double>(far_pdf(data->view, cell_middle(sky, half, row, column))) *
               cell_solid_angle(sky, row);
  EXPECT_NEAR(sum, static_cast<double>(data->view.sky.probability), 1e-5);
  EXPECT_NEAR(sum + total_disc_probability(data->view), 1, 1e-5);
}

TEST(FarSampling, DirectionsAreAsDenseAsTheySay) {
  const Light light = uneven_light();
  const auto data = light_alone(light);
  const SkyMap& sky = *light.sky;
  // Bins: a cell of the sky, cut into 2 x 2 as what lies in one must be even, and each disc.
  constexpr int samples = 2000000;
  const int cells = 2 * (sky.rows - 1) * sky.columns;
  std::vector<double> counts(static_cast<std::size_t>(4 * cells + 2), 0.0),
      expected(counts.size(), 0.0);
  Random random{17};
  for (int i = 0; i < samples; ++i) {
    const auto u0 = static_cast<float>(random.uniform()), u1 = static_cast<float>(random.uniform());
    const Vec3 sample = sample_far_direction(data->view, std::min(u0, 0x1.fffffep-1f),
                                             std::min(u1, 0x1.fffffep-1f));
    ASSERT_NEAR(dot(sample, sample), 1, 1e-6);
    ASSERT_GT(far_pdf(data->view, sample), 0);
    std::size_t bin = 0;
    const Vec3d d = to_double(sample);
    bool in_disc = false;
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec3d away = d - to_double(light.discs[k].direction);
      if (length(away) < 2 * std::sin(light.discs[k].angular_radius_rad / 2)) {
        bin = static_cast<std::size_t>(4 * cells) + k;
        in_disc = true;
      }
    }
    if (!in_disc) {
      const double step = pi / 2 / (sky.rows - 1);
      const double e = std::asin(std::fabs(d.y)) / step;
      double azimuth = std::atan2(d.x, -d.z);
      if (azimuth < 0) azimuth += 2 * pi;
      const double c = azimuth / (2 * pi) * sky.columns;
      const int row = std::min(static_cast<int>(e), sky.rows - 2);
      const int column = std::min(static_cast<int>(c), sky.columns - 1);
      const int half = d.y < 0 ? 1 : 0;
      const double middle = (std::sin(row * step) + std::sin((row + 1) * step)) / 2;
      const int part = (std::fabs(d.y) > middle ? 2 : 0) + (c - column > 0.5 ? 1 : 0);
      const int cell = (half * (sky.rows - 1) + row) * sky.columns + column;
      bin = static_cast<std::size_t>(4 * cell + part);
    }
    ++counts[bin];
  }
  for (int half = 0; half < 2; ++half)
    for (int row = 0; row < sky.rows - 1; ++row)
      for (int column = 0; column < sky.columns; ++column)
        for (int part = 0; part < 4; ++part)
          expected[static_cast<std::size_t>(
              4 * ((half * (sky.rows - 1) + row) * sky.columns + column) + part)] =
              samples * cell_solid_angle(sky, row) / 4 *
              static_cast<double>(far_pdf(data->view, cell_middle(sky, half, row, column)));
  for (std::size_t k = 0; k < 2; ++k) {
    // A disc takes what the sky has there besides.
    const auto& disc = light.discs[k];
    const double half_sine = std::sin(disc.angular_radius_rad / 2);
    expected[static_cast<std::size_t>(4 * cells) + k] =
        samples * static_cast<double>(far_pdf(data->view, disc.direction)) * 4 * pi * half_sine *
        half_sine;
  }
  // What the discs take of the bins they lie in is a thousandth of those.
  double chi_2 = 0, bins = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (expected[i] < 50) continue;
    chi_2 += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
    ++bins;
  }
  EXPECT_GT(bins, 150);
  // Five standard deviations of chi^2.
  EXPECT_LT(chi_2, bins + 5 * std::sqrt(2 * bins));
}

struct Estimate {
  double mean = 0, error = 0;
};

// Of the integral over all directions of value(direction) times radiance.
template <typename Value>
Estimate estimate(const LightData& data, std::uint64_t seed, int samples, const Value& value) {
  Random random{seed};
  double sum = 0, squares = 0;
  for (int i = 0; i < samples; ++i) {
    const auto u0 = static_cast<float>(random.uniform() * (1 - 1e-7));
    const auto u1 = static_cast<float>(random.uniform() * (1 - 1e-7));
    const Vec3 d = sample_far_direction(data.view, u0, u1);
    const float pdf = far_pdf(data.view, d);
    if (!(pdf > 0)) continue;  // on the rim of a disc, by rounding
    const double x = static_cast<double>(far_at(data, d)[0]) * value(d) / static_cast<double>(pdf);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / samples;
  return {mean, std::sqrt(std::max(squares / samples - mean * mean, 0.0) / samples)};
}

double one(Vec3) {
  return 1;
}
double up_cosine(Vec3 d) {
  return std::max(static_cast<double>(d.y), 0.0);
}

TEST(FarSampling, UniformSkyIsFourPi) {
  Light light;
  light.bands = narrow_bands(1);
  light.sky = made_sky(36, 19, 1, 1, [](int, int, int, int, int) { return 1; });
  const Estimate all = estimate(*light_alone(light), 1, 100000, one);
  // Each sample is 4 pi, but for steps of 2^-24 in how often a column of 1/36 is chosen.
  EXPECT_NEAR(all.mean / (4 * pi), 1, 1e-5);
  EXPECT_LT(all.error / all.mean, 1e-5);
}

TEST(FarSampling, SkyThatBrightensUpwards) {
  Light light;
  light.bands = narrow_bands(1);
  light.sky = made_sky(8, 181, 1, 1, [](int half, int row, int, int, int) {
    return half == 1 ? 0.0 : (1 + 2 * std::sin(pi / 2 * row / 180)) / 3;
  });
  const auto data = light_alone(light);
  // Bilinear between rows of half a degree: within 1e-5 of the sine.
  const Estimate all = estimate(*data, 2, 1000000, one),
                 ground = estimate(*data, 3, 1000000, up_cosine);
  EXPECT_LT(all.error / all.mean, 1e-3);
  EXPECT_NEAR(all.mean, 4 * pi / 3, 3 * all.error + 1e-5 * all.mean);
  EXPECT_LT(ground.error / ground.mean, 1e-3);
  EXPECT_NEAR(ground.mean, 7 * pi / 9, 3 * ground.error + 1e-5 * ground.mean);
}

TEST(FarSampling, SunsFluxIsItsRadianceTimesItsSolidAngle) {
  Light light;
  light.bands = narrow_bands(1);
  Disc sun;
  sun.direction = to_float(direction_of(0.7, 30 * degree));
  sun.angular_radius_rad = 0.2665 * degree;
  sun.radiance = {1e22};
  for (const double limb : {0.0, 0.6}) {
    sun.limb_darkening = {limb};
    light.discs = {sun};
    const double flux = 1e22 * 2 * pi * (1 - std::cos(sun.angular_radius_rad));
    const auto data = light_alone(light);
    const Estimate all = estimate(*data, 4, 200000, one);
    EXPECT_LT(all.error / all.mean, 1e-3);
    // 1e-4: places on the rim are known to 1e-7 of 5e-3, and those beyond it are dark.
    EXPECT_NEAR(all.mean / flux, 1, 3 * all.error / flux + 1e-4);
    const Estimate ground = estimate(*data, 5, 200000, up_cosine);
    EXPECT_NEAR(ground.mean / flux, 0.5, 3 * ground.error / flux + 1e-4);
  }
}

// One bright node in a large dark map, as in a panorama with its sun: samples are bounded.
TEST(FarSampling, BrightSpotsOfPanoramasAreFound) {
  Light light;
  light.bands = narrow_bands(1);
  light.sky = made_sky(1024, 257, 1, 1, [](int half, int row, int column, int, int) {
    return half == 0 && row == 100 && column == 700 ? 1e6 : 1.0;
  });
  const auto data = light_alone(light);
  const Estimate all = estimate(*data, 6, 1000000, one);
  EXPECT_LT(all.error / all.mean, 1e-3);
  // Around a node the map is a tent of its height over one cell's area each way.
  const double step = pi / 2 / 256, e = 100 * step;
  const double spot = (1e6 - 1) * 2 * pi / 1024 * std::cos(e) * 2 * (1 - std::cos(step)) / step;
  EXPECT_NEAR(all.mean, 4 * pi + spot, 3 * all.error + 1e-5 * all.mean);
}

TEST(FarSampling, DarknessGivesNothing) {
  Light light;
  light.bands = narrow_bands(1);
  const auto dark = light_alone(light);
  EXPECT_EQ(far_pdf(dark->view, sample_far_direction(dark->view, 0.5f, 0.5f)), 0);
  EXPECT_EQ(far_pdf(dark->view, {0, 1, 0}), 0);
  light.sky = made_sky(4, 2, 1, 1, [](int, int, int, int, int) { return 0; });
  const auto black = light_alone(light);
  EXPECT_EQ(far_pdf(black->view, sample_far_direction(black->view, 0.5f, 0.5f)), 0);
  EXPECT_EQ(black->view.from_afar.all, 0);
}

TEST(RunningSum, IsInStepsOfRandomNumbersAndNeverLosesWhatShines) {
  const std::vector<float> sum = running_sum({0, 1, 1e-9, 0, 1, 0});
  EXPECT_EQ(sum.front(), 0);
  EXPECT_EQ(sum.back(), 1);
  EXPECT_EQ(sum[1], 0);
  EXPECT_EQ(sum[3], sum[4]);
  EXPECT_EQ(sum[5], 1);
  EXPECT_GT(sum[3], sum[2]);
  for (const float x : sum) EXPECT_EQ(x * 0x1p24f, std::round(x * 0x1p24f));
  EXPECT_EQ(running_sum({0, 0}), (std::vector<float>{0, 0, 0}));
  // Intervals without width are never found.
  for (int i = 0; i < 1000; ++i) {
    const auto k =
        static_cast<std::size_t>(find_in_sum(sum.data(), 6, static_cast<float>(i) / 1000));
    EXPECT_GT(sum[k + 1], sum[k]);
  }
}

}  // namespace
}  // namespace omma
