// Fresnel's reflectances against closed forms, and Stokes vectors against electric fields in space.
#include "physics/surface/fresnel.h"

#include <gtest/gtest.h>

#include <random>

namespace omma::test {
namespace {

Mueller<float> reflect(double angle_deg, float ior) {
  return mueller_of(fresnel_dielectric(static_cast<float>(std::cos(angle_deg * degree)), ior));
}

// Brewster: all that comes back swings across the plane of incidence.
TEST(PhysicsFresnel, PolarizesAtBrewstersAngle) {
  for (const double ior : {1.33, 1.5, 2.5}) {
    const double angle = std::atan(ior) / degree;
    const Mueller<float> m = reflect(angle, static_cast<float>(ior));
    const double across = std::pow((ior * ior - 1) / (ior * ior + 1), 2);
    EXPECT_NEAR(m.a + m.b, across, 1e-6) << ior;
    EXPECT_NEAR(m.a - m.b, 0, 1e-6) << ior;
    EXPECT_NEAR(m.c, 0, 1e-6) << ior;
  }
  EXPECT_NEAR(std::atan(1.33) / degree, 53.06, 0.005);
  EXPECT_NEAR(std::atan(1.5) / degree, 56.31, 0.005);
  EXPECT_NEAR(reflect(53.06, 1.33f).a * 2, 0.0771, 5e-5);
}

// Snell's law and Fresnel's laws of sines and tangents.
TEST(PhysicsFresnel, FollowsTheLawsOfSinesAndTangents) {
  for (const float ior : {1.0001f, 1.05f, 1.333f, 1.5f, 2.0f, 2.5f, 10.0f})
    for (int deg = 1; deg < 90; ++deg) {
      const auto cosine = static_cast<float>(std::cos(deg * degree));
      const double i = std::acos(static_cast<double>(cosine));
      const double t = std::asin(std::sin(i) / static_cast<double>(ior));
      const auto r = fresnel_dielectric(cosine, ior);
      EXPECT_NEAR(r.s, -std::sin(i - t) / std::sin(i + t), 1e-6) << ior << ' ' << deg;
      EXPECT_NEAR(r.p, std::tan(i - t) / std::tan(i + t), 1e-6) << ior << ' ' << deg;
    }
}

TEST(PhysicsFresnel, EndsOfItsRange) {
  const auto normal = fresnel_dielectric(1.0f, 1.5f);
  EXPECT_NEAR(normal.s, -0.2, 1e-7);
  EXPECT_NEAR(normal.p, 0.2, 1e-7);
  EXPECT_LT(mueller_of(normal).c, 0);
  const Mueller<float> grazing = mueller_of(fresnel_dielectric(0.0f, 1.5f));
  EXPECT_NEAR(grazing.a, 1, 1e-6);
  EXPECT_NEAR(grazing.b, 0, 1e-6);
  for (const float c : {0.0f, 1e-20f, 0.5f, 1.0f})
    EXPECT_NEAR(mueller_of(fresnel_dielectric(c, 1.0f)).a, 0, 1e-6) << c;
  EXPECT_EQ(schlick_weight(1.0f), 0);
  EXPECT_EQ(schlick_weight(0.0f), 1);
  EXPECT_NEAR(schlick_weight(0.5f), 0.03125, 1e-7);
}

Vec3d random_unit(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return normalize({normal(random), normal(random), normal(random)});
}

struct Frame {
  Vector3<float> e1, e2;
};

// A frame of a ray with direction d.
Frame random_frame(std::mt19937& random, Vec3d d) {
  const Vec3d e1 = normalize(cross(d, random_unit(random))), e2 = cross(d, e1);
  return {vector_of(omma::to_float(e1)), vector_of(omma::to_float(e2))};
}

// Stokes vector of a field, as omma/light.h defines it.
Stokes<double> stokes_of(Vec3d field, const Frame& frame) {
  const double x = dot(field, {frame.e1[0], frame.e1[1], frame.e1[2]});
  const double y = dot(field, {frame.e2[0], frame.e2[1], frame.e2[2]});
  return {x * x + y * y, x * x - y * y, 2 * x * y};
}

void expect_near(const Stokes<float>& a, const Stokes<double>& b) {
  EXPECT_NEAR(a.i, b.i, 2e-6);
  EXPECT_NEAR(a.q, b.q, 2e-6);
  EXPECT_NEAR(a.u, b.u, 2e-6);
}

Stokes<float> to_float(const Stokes<double>& s) {
  return {static_cast<float>(s.i), static_cast<float>(s.q), static_cast<float>(s.u)};
}

TEST(PhysicsFresnel, TurnsOfFramesLeaveTheFieldAsItIs) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3d d = random_unit(random);
    const Frame one = random_frame(random, d), other = random_frame(random, d);
    const Vec3d field = normalize(cross(d, random_unit(random)));
    expect_near(frame_turn(one.e1, one.e2, other.e1) * to_float(stokes_of(field, other)),
                stokes_of(field, one));
  }
}

// At a perfect conductor the field along the surface is turned round and the field across it stays:
// the whole path from one frame to another, as rays are followed, against that.
TEST(PhysicsFresnel, MirrorsAsFieldsDo) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3d normal = random_unit(random);
    Vec3d before = random_unit(random);
    if (dot(before, normal) > 0) before = before * -1.0;
    // At first near normal incidence, where the axis s is not well known.
    if (trial < 20) before = normalize(normal * -1.0 + before * (trial * 1e-7));
    const Vec3d after = before - normal * (2 * dot(before, normal));
    const Frame at_eye = random_frame(random, before), at_light = random_frame(random, after);
    const Vec3d light = normalize(cross(after, random_unit(random)));
    const Vec3d seen = normal * (2 * dot(light, normal)) - light;

    const Vec3 b = omma::to_float(before), a = omma::to_float(after);
    const Vector3<float> ray = vector_of(b), next = vector_of(a);
    const Vector3<float> s = reflection_axis(ray, next, at_eye.e1), beside = cross(next, s);
    const Mueller3<float> path = identity_mueller<float>() * frame_turn(at_eye.e1, at_eye.e2, s) *
                                 mueller_of_metal(1.0f) * frame_turn(s, beside, at_light.e1);
    expect_near(path * to_float(stokes_of(light, at_light)), stokes_of(seen, at_eye));
  }
}

// Light that swings across the plane of incidence keeps its line and falls by rs^2, light in it by
// rp^2; in between the fields add up. In space: p is the axis in the plane and across the ray.
TEST(PhysicsFresnel, ReflectsAsFieldsDo) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3d normal = random_unit(random);
    Vec3d before = random_unit(random);
    if (dot(before, normal) > 0) before = before * -1.0;
    const Vec3d after = before - normal * (2 * dot(before, normal));
    const double cosine = -dot(before, normal), root = std::sqrt(1.25 + cosine * cosine);
    const double rs = (cosine - root) / (cosine + root);
    const double rp = (2.25 * cosine - root) / (2.25 * cosine + root);
    const Vec3d s = normalize(cross(before, normal));
    // Of the fields along p, which both point away from the surface here, none turns round below
    // Brewster's angle.
    const Vec3d p_light = normalize(normal - after * dot(after, normal));
    const Vec3d p_seen = normalize(normal - before * dot(before, normal));
    const Vec3d light = normalize(cross(after, random_unit(random)));
    const Vec3d seen = s * (rs * dot(light, s)) + p_seen * (rp * dot(light, p_light));

    const Frame at_eye = random_frame(random, before), at_light = random_frame(random, after);
    const Vec3 b = omma::to_float(before), a = omma::to_float(after);
    const Vector3<float> ray = vector_of(b), next = vector_of(a);
    const Vector3<float> axis = reflection_axis(ray, next, at_eye.e1), beside = cross(next, axis);
    const Mueller<float> m = mueller_of(fresnel_dielectric(static_cast<float>(cosine), 1.5f));
    const Mueller3<float> path = identity_mueller<float>() *
                                 frame_turn(at_eye.e1, at_eye.e2, axis) * m *
                                 frame_turn(axis, beside, at_light.e1);
    const Stokes<float> incident = to_float(stokes_of(light, at_light));
    expect_near(path * incident, stokes_of(seen, at_eye));
    // Step by step it is the same as with matrices multiplied.
    const Stokes<float> in_plane = m * (frame_turn(axis, beside, at_light.e1) * incident);
    expect_near(frame_turn(at_eye.e1, at_eye.e2, axis) * in_plane, stokes_of(seen, at_eye));
    // What a base sends out does not depend on how the light that falls on it swings.
    const Stokes<float> leaving{1, -0.2f, 0.1f};
    const Stokes<float> after_base = depolarized(path, leaving) * incident;
    const Stokes<float> alone = path * leaving;
    EXPECT_NEAR(after_base.i, alone.i * incident.i, 1e-6);
    EXPECT_NEAR(after_base.q, alone.q * incident.i, 1e-6);
    EXPECT_NEAR(after_base.u, alone.u * incident.i, 1e-6);
  }
}

TEST(PhysicsFresnel, LanesAgree) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(0, 1);
  Floats cosine, ior;
  for (int l = 0; l < lane_width; ++l) {
    cosine[l] = unit(random);
    ior[l] = 1 + unit(random);
  }
  const Mueller<Floats> lanes = mueller_of(fresnel_dielectric(cosine, ior));
  for (int l = 0; l < lane_width; ++l) {
    const Mueller<float> one = mueller_of(fresnel_dielectric(float{cosine[l]}, float{ior[l]}));
    EXPECT_EQ(one.a, lanes.a[l]);
    EXPECT_EQ(one.b, lanes.b[l]);
    EXPECT_EQ(one.c, lanes.c[l]);
  }
}

}  // namespace
}  // namespace omma::test
