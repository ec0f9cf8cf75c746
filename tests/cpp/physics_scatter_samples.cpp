// Directions that surfaces scatter to, and lobes, against their densities; lanes.
#include <gtest/gtest.h>

#include "scatter_surfaces.h"

namespace omma::test {
namespace {

// Of each lobe, in cells of the sphere. What is sent below the horizon is one cell more.
TEST(PhysicsScatter, SamplersFollowTheirDensities) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(0, 1);
  constexpr int heights = 12, turns = 12, samples = 50000, fine = 40;
  ScatterSurface<float> s = surface(unit({0.7, -0.6, 0.2}), unit({0.2, 0.9, -0.3}));
  s.roughness = 0.7f;
  s.coat = 1;
  s.coat_roughness = 0.5f;
  s.coat_table = coat_table();
  const ScatterPoint<float> p = make_scatter_point(s);
  for (const Lobe lobe : {Lobe::diffuse_reflection, Lobe::diffuse_transmission, Lobe::dielectric,
                          Lobe::metal, Lobe::coat}) {
    const auto k = static_cast<std::int32_t>(lobe);
    std::vector<double> expected(heights * turns + 1, 0.0), count(heights * turns + 1, 0.0);
    double sum = 0;
    for (int i = 0; i < heights * fine; ++i)
      for (int j = 0; j < turns * fine; ++j) {
        const double z = 2 * (i + 0.5) / (heights * fine) - 1, r = std::sqrt(1 - z * z);
        const double phi = 2 * pi * (j + 0.5) / (turns * fine);
        Vector3<float> w;
        copy({r * std::cos(phi), r * std::sin(phi), z}, w);
        const double mass = pdf_scatter(k, p, w) * 4 * pi / (heights * fine * turns * fine);
        expected[static_cast<std::size_t>(i / fine * turns + j / fine)] += samples * mass;
        sum += mass;
      }
    EXPECT_LE(sum, 1 + 1e-3);
    expected.back() = samples * std::max(0.0, 1 - sum);
    for (int i = 0; i < samples; ++i) {
      const float u0 = any(random), u1 = any(random);
      const Vector3<float> w = sample_scatter(k, p, u0, u1);
      const double turn = std::atan2(w[1], w[0]) / (2 * pi);
      const int h = std::min(static_cast<int>((w[2] + 1) / 2 * heights), heights - 1);
      const int t = std::min(static_cast<int>((turn - std::floor(turn)) * turns), turns - 1);
      const bool is_below = lobe != Lobe::diffuse_transmission && omma::dot(p.normal, w) <= 0;
      ++count[is_below ? heights * turns : static_cast<std::size_t>(h * turns + t)];
    }
    EXPECT_LT(chi_square_ratio(count, expected), 1) << k;
  }
}

TEST(PhysicsScatter, LobesAreChosenByTheirWeights) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> any(0, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const ScatterPoint<float> p = make_scatter_point(random_surface(random));
    const float rho = any(random);
    float weight[lobe_count];
    lobe_weights(p, {rho, 1 - rho, any(random), any(random)}, weight);
    double sum = 0;
    for (const float x : weight) sum += x;
    EXPECT_NEAR(sum, 1, 1e-6);
    constexpr int steps = 1000;
    double count[lobe_count] = {};
    for (int i = 0; i < steps; ++i) {
      const auto choice = choose_lobe(weight, (static_cast<float>(i) + 0.5f) / steps);
      EXPECT_EQ(choice.probability, weight[choice.lobe]);
      EXPECT_GT(choice.probability, 0);
      count[choice.lobe] += 1.0 / steps;
    }
    for (int k = 0; k < lobe_count; ++k) EXPECT_NEAR(count[k], weight[k], 1.1 / steps);
    // The last of the lobes takes what rounding leaves.
    EXPECT_GT(choose_lobe(weight, 0x1.fffffep-1f).probability, 0);
  }
  // Of a matt sheet about as much as they give back.
  const ScatterPoint<float> p = make_scatter_point(surface({0.6, -0.8, 0}, {0, 1, 0}));
  float weight[lobe_count];
  lobe_weights(p, {0.3f, 0.2f, 0, 0}, weight);
  EXPECT_NEAR(weight[0] / weight[1], 1.5, 1e-5);
  EXPECT_NEAR(weight[2] / weight[0],
              lobe_albedo(p, Lobe::dielectric) / (0.3 * lobe_albedo(p, Lobe::diffuse_reflection)),
              0.01);
  // A black one that reflects nothing has none.
  ScatterSurface<float> black = surface({0, -1, 0}, {0, 1, 0});
  black.specular = 0;
  lobe_weights(make_scatter_point(black), {0, 0, 0, 0}, weight);
  EXPECT_EQ(choose_lobe(weight, 0.5f).probability, 0);
}

TEST(PhysicsScatter, LanesAgree) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 50; ++trial) {
    ScatterSurface<Floats> all{};
    std::vector<ScatterSurface<float>> single;
    Floats u0{}, u1{};
    Ints lobe{};
    for (int l = 0; l < lane_width; ++l) {
      ScatterSurface<float> s = random_surface(random);
      s.coat_table = coat_table();
      single.push_back(s);
      for (int r = 0; r < 3; ++r) {
        all.direction[r][l] = s.direction[r];
        all.normal[r][l] = s.normal[r];
        all.coat_normal[r][l] = s.coat_normal[r];
        all.geometric_normal[r][l] = s.geometric_normal[r];
      }
      all.roughness[l] = s.roughness;
      all.metallic[l] = s.metallic;
      all.specular[l] = s.specular;
      all.transmission[l] = s.transmission;
      all.ior[l] = s.ior;
      all.coat[l] = s.coat;
      all.coat_roughness[l] = s.coat_roughness;
      all.table[l] = s.table;
      const Vec2 u = square_point(static_cast<std::uint32_t>(trial * lane_width + l));
      u0[l] = u.x;
      u1[l] = u.y;
      lobe[l] = l % lobe_count;
    }
    all.albedo_tables = albedo_tables().data();
    all.coat_table = coat_table();
    all.metal_table = metal_table();
    const ScatterPoint<Floats> point = make_scatter_point(all);
    Floats weight[lobe_count];
    const Vector3<Floats> w = sample_scatter(lobe, point, u0, u1);
    const ScatterValue<Floats> value = eval_scatter(point, w);
    const Floats pdf = pdf_scatter(lobe, value);
    lobe_weights(point, {u0, u1, u0, u1}, weight);
    const LobeChoice<Floats> choice = choose_lobe(weight, u1);
    for (int l = 0; l < lane_width; ++l) {
      const float x = u0[l], y = u1[l];
      const std::int32_t k = lobe[l];
      const ScatterPoint<float> p = make_scatter_point(single[static_cast<std::size_t>(l)]);
      float one_weight[lobe_count];
      const Vector3<float> one = sample_scatter(k, p, x, y);
      for (int r = 0; r < 3; ++r) EXPECT_EQ(one[r], w[r][l]);
      const ScatterValue<float> v = eval_scatter(p, one);
      EXPECT_EQ(v.diffuse_reflection, value.diffuse_reflection[l]);
      EXPECT_EQ(v.diffuse_transmission, value.diffuse_transmission[l]);
      EXPECT_EQ(v.dielectric.a, value.dielectric.a[l]);
      EXPECT_EQ(v.dielectric.c, value.dielectric.c[l]);
      EXPECT_EQ(v.metal, value.metal[l]);
      EXPECT_EQ(v.half_cosine, value.half_cosine[l]);
      EXPECT_EQ(v.coat.b, value.coat.b[l]);
      EXPECT_EQ(pdf_scatter(k, v), pdf[l]);
      EXPECT_EQ(p.straight, point.straight[l]);
      lobe_weights(p, {x, y, x, y}, one_weight);
      const LobeChoice<float> one_choice = choose_lobe(one_weight, y);
      EXPECT_EQ(one_choice.lobe, choice.lobe[l]);
      EXPECT_EQ(one_choice.probability, choice.probability[l]);
    }
  }
}

}  // namespace
}  // namespace omma::test
