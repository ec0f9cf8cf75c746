// Whole surfaces: energy, reciprocity, polarisation, mirrors, sides.
#include <gtest/gtest.h>

#include "scatter_surfaces.h"

namespace omma::test {
namespace {

// The table's thousandth, 2e-4 of its mean, and 5e-4 of sums over 4096 directions.
constexpr double energy_error = 1.7e-3;
// Of metals: their own table's error (physics_specular_albedo.cpp), which is largest where E is
// near 1, so that it is about the same share of what is looked up.
constexpr double metal_error = 4e-3;

double white_albedo(const ScatterPoint<float>& p, double rho) {
  return rho * lobe_albedo(p, Lobe::diffuse_reflection) +
         (1 - rho) * lobe_albedo(p, Lobe::diffuse_transmission) + lobe_albedo(p, Lobe::dielectric) +
         lobe_albedo(p, Lobe::metal) + lobe_albedo(p, Lobe::straight) + lobe_albedo(p, Lobe::coat);
}

TEST(PhysicsScatter, NothingGivesBackMoreThanItGets) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 1);
  double most = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const ScatterSurface<float> s = random_surface(random);
    const ScatterPoint<float> p = make_scatter_point(s);
    const double albedo = white_albedo(p, any(random));
    EXPECT_LE(albedo, 1 + energy_error + s.metallic * metal_error)
        << trial << " roughness " << s.roughness << " cosine " << p.o.z << " ior " << s.ior
        << " metal " << s.metallic;
    EXPECT_GE(albedo, 0);
    most = std::max(most, albedo);
  }
  EXPECT_GT(most, 0.99);
}

TEST(PhysicsScatter, WhiteSheetsGiveBackAll) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    ScatterSurface<float> s = random_surface(random);
    s.metallic = 0;
    s.coat_table = nullptr;
    EXPECT_NEAR(white_albedo(make_scatter_point(s), any(random)), 1, energy_error)
        << trial << " roughness " << s.roughness << " ior " << s.ior;
  }
}

// In a white furnace, at every roughness and from every side: facets that pass light on lose none.
// What they hide of it without that is 0.43 at a roughness of 0.8 and more than half at 1.
TEST(PhysicsScatter, WhiteMetalsGiveBackAll) {
  double least = 1;
  for (int r = 0; r <= 10; ++r)
    for (const double cosine : {0.02, 0.1, 0.3, 0.6, 0.9, 1.0}) {
      ScatterSurface<float> s = surface({std::sqrt(1 - cosine * cosine), -cosine, 0}, {0, 1, 0});
      s.roughness = 0.1f * static_cast<float>(r);
      s.metallic = 1;
      const ScatterPoint<float> p = make_scatter_point(s);
      EXPECT_NEAR(lobe_albedo(p, Lobe::metal, 1, 16384), 1, metal_error)
          << "roughness " << s.roughness << " cosine " << cosine;
      const double lost =
          lobe_albedo(p, Lobe::metal, 1, 4096) / (1 + static_cast<double>(p.metal_gain));
      least = std::min(least, lost);
      // What is not white loses each time that its facets are met: gold's red more than its blue.
      EXPECT_LT(lobe_albedo(p, Lobe::metal, 0.5f), 0.5 + 0.5 * std::pow(1 - cosine, 5) + 0.2);
    }
  EXPECT_LT(least, 0.5);
}

// Light that goes the other way, from where the viewer was to where the light came from. (What a
// metal's facets pass on depends on the viewer's side alone.)
TEST(PhysicsScatter, LobesAreReciprocal) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 500; ++trial) {
    ScatterSurface<float> s = random_surface(random);
    const Direction normal = {s.normal[0], s.normal[1], s.normal[2]};
    const Direction of_coat = {s.coat_normal[0], s.coat_normal[1], s.coat_normal[2]};
    const auto view = [&](const Direction& from) {
      copy(scaled_sum(from, -1, from, 0), s.direction);
      const double side = dot(from, normal) > 0 ? 1 : -1;
      copy(scaled_sum(of_coat, side, of_coat, 0), s.coat_normal);
      copy(scaled_sum(normal, side, normal, 0), s.normal);
      copy(scaled_sum(normal, side, normal, 0), s.geometric_normal);
      return make_scatter_point(s);
    };
    Direction a = random_direction(random), b = random_direction(random);
    // Not where the viewer's normal is bent; and the mirror's narrow lobes magnify rounding.
    const auto is_bent = [&](const Direction& from) {
      const double cosine = dot(from, normal), on_coat = dot(from, of_coat);
      return std::abs(cosine) < 0.01 || on_coat * (cosine > 0 ? 1 : -1) < 0.01;
    };
    if (is_bent(a) || is_bent(b)) continue;
    s.roughness = std::max(s.roughness, 0.1f);
    Vector3<float> to_a, to_b;
    copy(a, to_a);
    copy(b, to_b);
    const ScatterValue<float> one = eval_scatter(view(a), to_b),
                              other = eval_scatter(view(b), to_a);
    for (int k = 0; k < lobe_count; ++k) {
      const auto lobe = static_cast<Lobe>(k);
      const bool is_coat = lobe == Lobe::coat;
      const double x = eval_lobe(lobe, one, 0.5f, 0) /
                       std::abs(is_coat ? dot(b, of_coat) : static_cast<double>(one.cosine));
      const double y = eval_lobe(lobe, other, 0.5f, 0) /
                       std::abs(is_coat ? dot(a, of_coat) : static_cast<double>(other.cosine));
      EXPECT_NEAR(x, y, 1e-4 * x + 1e-9) << trial << ' ' << k;
    }
    EXPECT_NEAR(one.dielectric.c / one.cosine, other.dielectric.c / other.cosine,
                1e-4 * std::abs(one.dielectric.a / one.cosine) + 1e-9);
  }
}

// What uniform unpolarised light of radiance 1 becomes, in the frame whose first axis lies across
// the plane of view and normal.
Stokes<double> reflect_uniform(const ScatterPoint<float>& p, const Direction& across_plane,
                               float rho) {
  Vector3<float> e1;
  copy(across_plane, e1);
  const Vector3<float> e2 = cross(p.direction, e1);
  const double diffuse = rho * lobe_albedo(p, Lobe::diffuse_reflection);
  Stokes<double> sum{diffuse, diffuse * diffuse_polarization(p), 0};
  constexpr std::uint32_t count = 20000;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec2 u = square_point(i);
    constexpr auto lobe = static_cast<std::int32_t>(Lobe::dielectric);
    const Vector3<float> w = sample_scatter(lobe, p, u.x, u.y);
    const ScatterValue<float> v = eval_scatter(p, w);
    if (!(v.boundary_pdf > 0)) continue;
    const Vector3<float> s = reflection_axis(p.direction, w, e1);
    const Mueller3<float> path = identity_mueller<float>() * frame_turn(e1, e2, s) *
                                 (v.dielectric * (1 / pdf_scatter(lobe, v)));
    const Stokes<float> seen = path * Stokes<float>{1, 0, 0};
    sum.i += seen.i / count;
    sum.q += seen.q / count;
    sum.u += seen.u / count;
  }
  return sum;
}

// A smooth leaf at Brewster's angle. The boundary polarises half of R_s, and what the base sends out
// through it takes off rho of that; with the base dimmed by what the boundary reflects the degree is
// R_s / 2 (1 - rho) / (R_s / 2 + rho (1 - R_s / 2)).
TEST(PhysicsScatter, LeavesPolarizeAtBrewstersAngle) {
  const double angle = std::atan(1.5);
  ScatterSurface<float> s = surface({std::sin(angle), -std::cos(angle), 0}, {0, 1, 0});
  s.roughness = 0;
  const ScatterPoint<float> p = make_scatter_point(s);
  const double half = 0.5 * std::pow(1.25 / 3.25, 2);
  for (const float rho : {0.02f, 0.06f, 0.12f}) {
    const auto r = static_cast<double>(rho);
    const Stokes<double> seen = reflect_uniform(p, {0, 0, 1}, rho);
    // The lobe is not infinitely narrow: its tails see other angles.
    EXPECT_NEAR(seen.q / seen.i, half * (1 - r) / (half + r * (1 - half)), 4e-3) << rho;
    EXPECT_NEAR(seen.u / seen.i, 0, 1e-3);
  }
}

// Diffuse light out of a smooth boundary, as Atkinson and Hancock 2006 (Recovery of surface
// orientation from diffuse polarization, equation 6) write it; tables are within 1e-3 of it.
TEST(PhysicsScatter, DiffuseLightIsPolarizedOnItsWayOut) {
  constexpr double n = 1.5;
  for (int degrees = 0; degrees <= 85; degrees += 5) {
    const double angle = degrees * pi / 180;
    ScatterSurface<float> s = surface({std::sin(angle), -std::cos(angle), 0}, {0, 1, 0});
    s.roughness = 0;
    const double sin2 = std::sin(angle) * std::sin(angle);
    const double degree = (n - 1 / n) * (n - 1 / n) * sin2 /
                          (2 + 2 * n * n - (n + 1 / n) * (n + 1 / n) * sin2 +
                           4 * std::cos(angle) * std::sqrt(n * n - sin2));
    EXPECT_NEAR(diffuse_polarization(make_scatter_point(s)), -degree, 2e-3) << degrees;
    s.specular = 0;
    EXPECT_EQ(diffuse_polarization(make_scatter_point(s)), 0) << degrees;
  }
}

// Light that is the same from everywhere and unpolarised leaves a white surface as it came, or
// polarised light would come of heat alone.
TEST(PhysicsScatter, WhiteSurfacesLeaveUniformLightUnpolarized) {
  for (const float roughness : {0.0f, 0.3f, 0.6f, 1.0f})
    for (const int degrees : {20, 40, 56, 70}) {
      const double angle = degrees * pi / 180;
      ScatterSurface<float> s = surface({std::sin(angle), -std::cos(angle), 0}, {0, 1, 0});
      s.roughness = roughness;
      const Stokes<double> seen = reflect_uniform(make_scatter_point(s), {0, 0, 1}, 1);
      EXPECT_NEAR(seen.i, 1, 2e-3) << roughness << ' ' << degrees;
      EXPECT_NEAR(seen.q, 0, 2e-3) << roughness << ' ' << degrees;
    }
}

// Gloss that is rough polarises too, as an integral over the hemisphere in doubles says, with
// Fresnel's laws, Walter's D and fields of facets written anew.
TEST(PhysicsScatter, RoughGlossPolarizesAsTheIntegralSays) {
  const double angle = 1.0, alpha = 0.16, cos_o = std::cos(angle);
  const Direction o = {-std::sin(angle), cos_o, 0};
  double i_sum = 0, q_sum = 0;
  constexpr int polar = 1200, azimuths = 1200;
  const auto root = [&](double c) { return std::sqrt(c * c + alpha * alpha * (1 - c * c)); };
  for (int i = 0; i < polar; ++i)
    for (int j = 0; j < azimuths; ++j) {
      const double theta = (i + 0.5) / polar * pi / 2, phi = (j + 0.5) / azimuths * 2 * pi;
      const Direction w = {std::sin(theta) * std::cos(phi), std::cos(theta),
                           std::sin(theta) * std::sin(phi)};
      const Direction h = unit(scaled_sum(o, 1, w, 1));
      const double c = dot(o, h), g = std::sqrt(1.25 + c * c);
      const double rs = std::pow((c - g) / (c + g), 2);
      const double rp = std::pow((2.25 * c - g) / (2.25 * c + g), 2);
      const double d = alpha * alpha / pi / std::pow(h[1] * h[1] * (alpha * alpha - 1) + 1, 2);
      const double value = 0.5 * d * w[1] / (w[1] * root(cos_o) + cos_o * root(w[1])) *
                           std::sin(theta) * (pi / 2 / polar) * (2 * pi / azimuths);
      // The angle of the facet's s axis from the z axis, seen along the ray.
      const Direction d_ray = scaled_sum(o, -1, o, 0);
      const Direction s =
          unit({d_ray[1] * w[2] - d_ray[2] * w[1], d_ray[2] * w[0] - d_ray[0] * w[2],
                d_ray[0] * w[1] - d_ray[1] * w[0]});
      const double cos_psi = s[2];
      i_sum += value * 0.5 * (rs + rp);
      q_sum += value * 0.5 * (rs - rp) * (2 * cos_psi * cos_psi - 1);
    }
  ScatterSurface<float> s = surface(scaled_sum(o, -1, o, 0), {0, 1, 0});
  s.roughness = 0.4f;
  const Stokes<double> seen = reflect_uniform(make_scatter_point(s), {0, 0, 1}, 0);
  EXPECT_NEAR(seen.i, i_sum, 1e-4);
  EXPECT_NEAR(seen.q, q_sum, 1e-4);
  EXPECT_NEAR(seen.u, 0, 1e-4);
  const Albedo by_quadrature = specular_albedo(1.5, 0.4, cos_o);
  EXPECT_NEAR(by_quadrature.all, i_sum, 2e-4);
  EXPECT_NEAR(by_quadrature.polarized, q_sum, 2e-4);
}

TEST(PhysicsScatter, SmoothIsAMirror) {
  for (const double cosine : {0.1, 0.3, 0.6, 1.0}) {
    ScatterSurface<float> s = surface({std::sqrt(1 - cosine * cosine), -cosine, 0}, {0, 1, 0});
    s.roughness = 0;
    s.table = 2;
    const ScatterPoint<float> p = make_scatter_point(s);
    const Mueller<float> exact = mueller_of(fresnel_dielectric(static_cast<float>(cosine), 1.5f));
    EXPECT_NEAR(lobe_albedo(p, Lobe::dielectric), exact.a, 2e-3);
    int near = 0;
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const Vec2 u = square_point(i);
      const Vector3<float> w =
          sample_scatter(static_cast<std::int32_t>(Lobe::dielectric), p, u.x, u.y);
      const Direction off = {w[0] - s.direction[0], w[1] + s.direction[1], w[2] - s.direction[2]};
      near += std::sqrt(dot(off, off)) < 0.06 * degree;
    }
    EXPECT_GE(near, 495) << cosine;  // half of them, as microfacet.h says
  }
}

// Light that gets to the viewer must be on one side of both the triangle and its shading normal.
TEST(PhysicsScatter, WrongSidesAreDark) {
  ScatterSurface<float> s = surface({0, -1, 0}, {0, 1, 0});
  copy(unit({1, 1, 0}), s.normal);
  copy(unit({1, 1, 0}), s.coat_normal);
  s.metallic = 0.5f;
  s.coat = 0.5f;
  s.coat_table = coat_table();
  const ScatterPoint<float> p = make_scatter_point(s);
  const auto eval = [&](const Direction& towards) {
    Vector3<float> w;
    copy(unit(towards), w);
    return eval_scatter(p, w);
  };
  for (int k = 0; k < lobe_count; ++k) {
    const auto lobe = static_cast<Lobe>(k);
    const bool reflects = lobe != Lobe::diffuse_transmission && lobe != Lobe::straight;
    EXPECT_EQ(eval_lobe(lobe, eval({0.3, 1, 0}), 0.5f, p.metal_gain) > 0, reflects) << k;
    EXPECT_EQ(eval_lobe(lobe, eval({-0.3, -1, 0}), 0.5f, p.metal_gain) > 0,
              lobe == Lobe::diffuse_transmission);
    EXPECT_EQ(eval_lobe(lobe, eval({-1, 0.2, 0}), 0.5f, p.metal_gain), 0)
        << k;  // above the triangle alone
    EXPECT_EQ(eval_lobe(lobe, eval({1, -0.2, 0}), 0.5f, p.metal_gain), 0)
        << k;  // above the normal alone
  }
}

// Normals that turn away from the viewer, and rays that met nothing.
TEST(PhysicsScatter, OddNormalsStayFinite) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 100; ++trial) {
    ScatterSurface<float> s = random_surface(random);
    if (trial < 90) copy(random_direction(random), s.normal);
    if (trial == 0) copy({s.direction[0], s.direction[1], s.direction[2]}, s.normal);
    if (trial >= 90) s.normal = s.geometric_normal = {};
    const ScatterPoint<float> p = make_scatter_point(s);
    EXPECT_GE(p.o.z, 0.99f * least_cosine);
    const double albedo = white_albedo(p, 0.5);
    EXPECT_TRUE(std::isfinite(albedo)) << trial;
    EXPECT_LE(albedo, 1 + energy_error) << trial;
  }
}

}  // namespace
}  // namespace omma::test
