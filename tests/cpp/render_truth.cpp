// Ground truth beside radiance against closed forms: distances in a sphere and before a plane,
// places, normals, shares of discs, optic flow against its formula and against differences of
// directions.
#include <gtest/gtest.h>

#include <limits>

#include "test_scenes.h"

namespace omma::test {
namespace {

// Room for all that a call can ask.
struct TruthRoom {
  std::vector<float> responses, errors, distance, nearest, inverse, source, met, normal, shares,
      rotation, translation, objects;
  std::vector<double> position;
  std::vector<std::int32_t> share_of_instance, moving, rays;
  std::vector<Velocity> head, velocities;
  int share_count = 0;
  bool with_error = false, with_rays = false;

  void render(const Renderer& renderer, std::span<const Mat4> poses) {
    const std::size_t size = poses.size() * renderer.eye().size();
    responses.resize(size * rgb_bands);
    for (auto* one : {&distance, &nearest, &inverse, &source, &met}) one->resize(size);
    position.resize(size * 3);
    normal.resize(size * 3);
    shares.resize(size * static_cast<std::size_t>(share_count));
    for (auto* flow : {&rotation, &translation, &objects}) flow->resize(size * 2);
    RenderCall call;
    if (with_error) errors.resize(responses.size());
    if (with_rays) rays.resize(size);
    call.standard_error = errors;
    call.rays = rays;
    TruthCall& truth = call.truth;
    truth.distance_m = distance;
    truth.nearest_m = nearest;
    truth.inverse_distance_per_m = inverse;
    truth.source_distance_m = source;
    truth.met = met;
    truth.position_m = position;
    truth.normal = normal;
    truth.shares = shares;
    truth.share_of_instance = share_of_instance;
    truth.share_count = share_count;
    truth.flow_rotation = rotation;
    truth.flow_translation = translation;
    truth.flow_objects = objects;
    truth.head = head;
    truth.moving = moving;
    truth.objects = velocities;
    renderer.render(poses, responses, call);
  }
  void render(const Renderer& renderer, const Mat4& pose = {}) {
    render(renderer, std::span(&pose, 1));
  }
};

constexpr Vec3d forward{0, 0, -1}, right{1, 0, 0}, up{0, 1, 0};

Vec3d turned(const Mat4& frame, Vec3d v) {
  return transform_point(frame, v) - transform_point(frame, {0, 0, 0});
}

// Of a frame that neither scales nor mirrors.
Mat4 undo(const Mat4& frame) {
  Mat4 back;
  for (int r = 0; r < 3; ++r) {
    back.m[r][3] = 0;
    for (int c = 0; c < 3; ++c) {
      back.m[r][c] = frame.m[c][r];
      back.m[r][3] -= frame.m[c][r] * frame.m[c][3];
    }
  }
  return back;
}

// A sphere of triangles around the origin, finer than what tests ask for: `count` rings.
Mesh sphere(double radius_m, int count, int material) {
  Mesh mesh;
  mesh.material = material;
  for (int i = 0; i <= count; ++i)
    for (int k = 0; k <= 2 * count; ++k) {
      const double elevation = pi * (static_cast<double>(i) / count - 0.5);
      mesh.positions.push_back(
          to_float(from_azimuth_elevation(pi * k / count, elevation) * radius_m));
    }
  const auto row = static_cast<std::uint32_t>(2 * count + 1);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i)
    for (std::uint32_t k = 0; k + 1 < row; ++k) {
      const std::uint32_t a = i * row + k;
      if (i > 0) mesh.triangles.push_back({a, a + 1, a + row});
      if (i + 1 < static_cast<std::uint32_t>(count))
        mesh.triangles.push_back({a + 1, a + row + 1, a + row});
    }
  return mesh;
}

TEST(Truth, OfASphereAround) {
  Scene scene;
  add_instance(scene, add_mesh(scene, sphere(2, 200, add_color(scene, {1, 1, 1}))));
  const Eye eye = make_eye(sphere_directions(100), 5 * degree);
  for (const int samples : {3, 16, 40}) {
    const Renderer renderer = make_renderer(scene, eye, {.sampling = Fixed{samples}});
    TruthRoom truth;
    truth.render(renderer);
    for (std::size_t i = 0; i < eye.size(); ++i) {
      // Chords of 0.9 degrees lie up to 2 (1 - cos 0.45 degrees cos 0.45 degrees) = 1.2e-4 m
      // inside.
      EXPECT_EQ(truth.met[i], 1);
      EXPECT_NEAR(truth.distance[i], 2, 2e-4);
      EXPECT_NEAR(truth.nearest[i], 2, 2e-4);
      EXPECT_LE(truth.nearest[i], truth.distance[i] + 1e-6);
      EXPECT_NEAR(truth.inverse[i], 0.5, 5e-5);
      EXPECT_EQ(truth.source[i], truth.distance[i]);
      const Vec3d axis = to_double(eye.axis[i]);
      const Vec3d place{truth.position[3 * i], truth.position[3 * i + 1],
                        truth.position[3 * i + 2]};
      const Vec3d normal{truth.normal[3 * i], truth.normal[3 * i + 1], truth.normal[3 * i + 2]};
      // Means of few directions around the axis: some hundredths off it.
      EXPECT_GT(dot(normalize(place), axis), 0.998);
      EXPECT_LT(dot(normalize(normal), axis), -0.998);
      // Each ray's place is -2 times its normal, but for the chords' slant of half a degree.
      for (const double x :
           {place.x + 2 * normal.x, place.y + 2 * normal.y, place.z + 2 * normal.z})
        EXPECT_NEAR(x, 0, 0.02);
    }
  }
}

TEST(Truth, BeforeAPlane) {
  Scene scene;
  add_quad(scene, {0, -0.25, 0}, forward * 100, right * -100, add_color(scene, {1, 1, 1}));
  std::vector<Vec3d> axes;
  for (int i = 0; i < 60; ++i) axes.push_back(from_azimuth_elevation(i, -0.1 - 0.024 * i));
  const Eye eye = make_eye(axes, 0);  // rays along the axis
  const Renderer renderer = make_renderer(scene, eye, {.sampling = Fixed{1}});
  const Mat4 pose = translation({3, 0.5, -4}) * rotation(up, 0.7);
  TruthRoom truth;
  truth.render(renderer, pose);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3d d = turned(pose, axes[i]);
    const double r = 0.75 / -d.y;
    EXPECT_NEAR(truth.distance[i] / r, 1, 1e-5);
    EXPECT_NEAR(truth.inverse[i] * r, 1, 1e-5);
    EXPECT_NEAR(truth.position[3 * i], 3 + d.x * r, 2e-5 * r);
    EXPECT_NEAR(truth.position[3 * i + 1], -0.25, 1e-6);
    EXPECT_NEAR(truth.position[3 * i + 2], -4 + d.z * r, 2e-5 * r);
    EXPECT_NEAR(truth.normal[3 * i + 1], 1, 1e-6);  // towards the eye, from either side
  }
  truth.render(renderer, translation({0, -1, 0}) * rotation(right, pi));
  EXPECT_NEAR(truth.normal[3 * 30 + 1], -1, 1e-6);
}

TEST(Truth, WhereNothingIs) {
  const Eye eye = make_eye(sphere_directions(20), 5 * degree);
  TruthRoom truth;
  truth.head = {{{1, 2, 3}, {0, 0, 0}}};
  truth.render(make_renderer(Scene{}, eye));
  for (std::size_t i = 0; i < eye.size(); ++i) {
    EXPECT_EQ(truth.met[i], 0);
    EXPECT_EQ(truth.distance[i], std::numeric_limits<float>::infinity());
    EXPECT_EQ(truth.nearest[i], std::numeric_limits<float>::infinity());
    EXPECT_EQ(truth.inverse[i], 0);
    EXPECT_TRUE(std::isnan(truth.position[3 * i]));
    EXPECT_TRUE(std::isnan(truth.normal[3 * i]));
    EXPECT_EQ(truth.translation[2 * i], 0);
  }
}

// A disc of angular radius a around the axis fills 1 - exp(-4 ln 2 (a / width)^2) of a Gaussian; a
// flat disc of radius tan a, where the field is narrow.
TEST(Truth, SharesOfDiscs) {
  Scene scene;
  const double width = 6 * degree;
  const auto disc = [&](double distance_m, double radius_rad, Vec3 color) {
    Mesh mesh;
    mesh.material = add_color(scene, color);
    mesh.positions.push_back(to_float(forward * distance_m));
    constexpr std::uint32_t corners = 720;
    for (std::uint32_t k = 0; k < corners; ++k) {
      const double a = 2 * pi * k / corners, r = distance_m * std::tan(radius_rad);
      mesh.positions.push_back(
          to_float(forward * distance_m + right * (r * std::cos(a)) + up * (r * std::sin(a))));
      mesh.triangles.push_back({0, k + 1, (k + 1) % corners + 1});
    }
    add_instance(scene, add_mesh(scene, mesh));
  };
  disc(1, 2 * degree, {1, 0, 0});
  disc(2, 4 * degree, {0, 1, 0});
  add_quad(scene, forward * 5, right * 50, up * 50, add_color(scene, {0, 0, 1}));
  const Eye eye = make_eye(forward, width);
  TruthRoom truth;
  truth.share_of_instance = {0, 1, -1};
  truth.share_count = 3;  // of which nothing is the third
  // 4 ln 2 a^2 / width^2; the Gaussian of sines and the tangents differ by less than 1e-3 here.
  const auto within = [&](double a) {
    return 1 - std::exp(-4 * std::log(2.0) * a * a / (width * width));
  };
  truth.render(make_renderer(scene, eye, {.sampling = Fixed{4096}}));
  EXPECT_NEAR(truth.shares[0], within(2 * degree), 2e-3);
  EXPECT_NEAR(truth.shares[1], within(4 * degree) - within(2 * degree), 2e-3);
  EXPECT_EQ(truth.shares[2], 0);
  EXPECT_EQ(truth.met[0], 1);
  // They are what radiance says: red, green and blue are the three surfaces.
  EXPECT_NEAR(truth.shares[0], truth.responses[0], 1e-6);
  EXPECT_NEAR(truth.shares[1], truth.responses[1], 1e-6);
  EXPECT_NEAR(1 - truth.shares[0] - truth.shares[1], truth.responses[2], 1e-6);
}

// An eye with its nodal points all over the head, apertures and all, and up vectors of their own.
Eye spread_eye() {
  Eye eye = make_eye(sphere_directions(80), 0);
  Random random{3};
  for (std::size_t i = 0; i < eye.size(); ++i) {
    eye.position_m[i] = to_float(random.direction() * 0.01);
    eye.up[i] = to_float(tangents(to_double(eye.axis[i])).first);
    eye.focal_offset_m[i] = 1e-4f;
  }
  validate_eye(eye);
  return eye;
}

// Six walls that are things of their own, around the origin.
Scene room() {
  Scene scene;
  const Vec3d sides[] = {right, up, forward * -1, right * -1, up * -1, forward};
  for (int i = 0; i < 6; ++i) {
    const auto [u, v] = tangents(sides[i]);
    Mesh wall = quad({0, 0, 0}, u * 4, v * 4, add_color(scene, {1, 1, 1}));
    add_instance(scene, add_mesh(scene, wall), translation(sides[i] * (1.0 + 0.3 * i)));
  }
  return scene;
}

Mat4 moved_by(const Velocity& v, const Mat4& frame, double dt) {
  const double speed = std::sqrt(dot(v.angular_rad_s, v.angular_rad_s));
  Mat4 turn = speed > 0 ? rotation(v.angular_rad_s * (1 / speed), speed * dt) : Mat4{};
  Mat4 origin = frame;
  const Vec3d at{frame.m[0][3], frame.m[1][3], frame.m[2][3]};
  for (int r = 0; r < 3; ++r) origin.m[r][3] = 0;
  return translation(at + v.linear_m_s * dt) * turn * origin;
}

// Where a point is seen to move, from where it is before and after, in the ommatidium's frame.
TEST(Truth, FlowIsHowDirectionsOfPointsChange) {
  const Eye eye = spread_eye();
  const Scene scene = room();
  const World world = make_world(scene);
  const Renderer renderer(world, eye, {.sampling = Fixed{1}});
  const Mat4 pose = translation({0.1, 0.05, -0.2}) * rotation(normalize(Vec3d{1, 2, 3}), 0.9);
  TruthRoom truth;
  truth.head = {{{0.8, -0.3, 1.1}, {2, -1, 0.5}}};
  truth.moving = {1, 3};
  truth.velocities = {{{-0.4, 0.2, 0.3}, {0.7, 1.5, -2}}, {{1, 0, 0}, {0, 0, 0}}};
  truth.share_of_instance = {0, 1, 2, 3, 4, 5};
  truth.share_count = 6;
  truth.render(renderer, pose);
  constexpr double dt = 1e-4;
  int moving = 0;
  for (std::size_t i = 0; i < eye.size(); ++i) {
    Vec3d point{truth.position[3 * i], truth.position[3 * i + 1], truth.position[3 * i + 2]};
    Velocity own;
    Mat4 frame;
    for (std::size_t k = 0; k < truth.moving.size(); ++k)
      if (truth.shares[6 * i + static_cast<std::size_t>(truth.moving[k])] == 1) {
        own = truth.velocities[k];
        frame = scene.instances[static_cast<std::size_t>(truth.moving[k])].world_from_mesh;
        ++moving;
      }
    // The point as it moves with its thing, seen from the ommatidium as it moves with the head: in
    // the frame of an ommatidium that is turned to the point.
    const auto direction_at = [&](double t, bool turns) {
      const Mat4 thing = moved_by(own, frame, t) * undo(frame);
      Velocity head = truth.head[0];
      const Mat4 now = moved_by(head, pose, t);
      const Vec3d axis = to_double(eye.axis[i]);
      const Vec3d start = to_double(eye.position_m[i]) - axis * 1e-4;
      const Vec3d d = normalize(transform_point(thing, point) - transform_point(now, start));
      return turned(undo(turns ? now : pose), d);
    };
    const Vec3d axis = to_double(eye.axis[i]), its_up = to_double(eye.up[i]);
    const Vec3d its_right = cross(axis, its_up);
    const Vec3d all = (direction_at(dt, true) - direction_at(-dt, true)) * (0.5 / dt);
    const Vec3d moved = (direction_at(dt, false) - direction_at(-dt, false)) * (0.5 / dt);
    const double speed = std::sqrt(dot(all, all));
    for (const auto& [k, along] :
         {std::pair{std::size_t{0}, its_right}, {std::size_t{1}, its_up}}) {
      const std::size_t at = 2 * i + k;
      const double flow =
          static_cast<double>(truth.rotation[at]) + truth.translation[at] + truth.objects[at];
      EXPECT_NEAR(flow, dot(all, along), 1e-3 * speed) << i;
      EXPECT_NEAR(truth.translation[at] + truth.objects[at], dot(moved, along), 1e-3 * speed) << i;
      // -(w x d), along the axis.
      const Vec3d w = turned(undo(pose), truth.head[0].angular_rad_s);
      EXPECT_NEAR(truth.rotation[at], -dot(cross(w, axis), along), 1e-5);
    }
  }
  EXPECT_GT(moving, 10);
}

// The formula with the distance of the plane, and the mean over a wide field against its
// quadrature.
TEST(Truth, FlowOfAWideFieldIsTheMeanOfItsRays) {
  const Eye eye = make_eye(std::vector<Vec3d>{from_azimuth_elevation(0.4, -0.6)}, 20 * degree);
  Scene scene;
  add_quad(scene, up * -1, forward * 1e4, right * -1e4, add_color(scene, {1, 1, 1}));
  TruthRoom truth;
  truth.head = {{{0.3, 0.1, -2}, {1, -2, 0.4}}};
  truth.render(make_renderer(scene, eye, {.sampling = Fixed{1 << 14}}));
  const Vec3d axis = to_double(eye.axis[0]), t = truth.head[0].linear_m_s,
              w = truth.head[0].angular_rad_s;
  const Vec3d eye_up = normalize(up - axis * dot(up, axis));
  double weight = 0, mean[4] = {};
  constexpr int rings = 400, spokes = 400;
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < spokes; ++k) {
      const double theta = 60 * degree * (i + 0.5) / rings, phi = 2 * pi * (k + 0.5) / spokes;
      const Vec3d d =
          axis * std::cos(theta) +
          (eye_up * std::cos(phi) + cross(axis, eye_up) * std::sin(phi)) * std::sin(theta);
      const double s =
          std::sin(theta) * std::exp(-4 * std::log(2.0) * theta * theta / std::pow(20 * degree, 2));
      // Up and right turned about axis x d, by the angle between the two.
      const Vec3d about = normalize(cross(axis, d));
      const Mat4 turn = rotation(about, theta);
      const Vec3d ray_up = turned(turn, eye_up);
      const Vec3d ray_right = turned(turn, cross(axis, eye_up));
      const double inverse_r = d.y < 0 ? -d.y : 0;  // the plane lies 1 m below
      const Vec3d turning = cross(w, d) * -1, passing = (t - d * dot(t, d)) * -inverse_r;
      weight += s;
      mean[0] += s * dot(turning, ray_right);
      mean[1] += s * dot(turning, ray_up);
      mean[2] += s * dot(passing, ray_right);
      mean[3] += s * dot(passing, ray_up);
    }
  // 16,384 even rays over a field with a horizon at its rim: within 1e-3 of its largest value.
  EXPECT_NEAR(truth.rotation[0], mean[0] / weight, 2e-3);
  EXPECT_NEAR(truth.rotation[1], mean[1] / weight, 2e-3);
  EXPECT_NEAR(truth.translation[0], mean[2] / weight, 2e-3);
  EXPECT_NEAR(truth.translation[1], mean[3] / weight, 2e-3);
}

std::vector<float> all_of(const TruthRoom& t) {
  std::vector<float> all;
  for (const auto* part : {&t.responses, &t.errors, &t.distance, &t.nearest, &t.inverse, &t.met,
                           &t.normal, &t.shares, &t.rotation, &t.translation, &t.objects})
    all.insert(all.end(), part->begin(), part->end());
  for (const double x : t.position) all.push_back(static_cast<float>(x));
  return all;
}

// Layers, cut-outs, textures, instances: the same bits for any threads, and radiance keeps its own.
TEST(Truth, SameBitsForAnyThreadsAndRadianceKeepsItsOwn) {
  const Scene scene = random_scene(5);
  const World world = make_world(scene);
  const Eye eye = make_eye(sphere_directions(300), 8 * degree);
  const std::vector<Mat4> poses = turning_poses(3);
  const std::size_t things = world.instances().size();
  for (const Sampling& sampling :
       {Sampling{Fixed{5}}, Sampling{Fixed{21}}, Sampling{ToError{0.02, 4, 256}}})
    for (const bool with_error : {false, true}) {
      std::vector<float> first;
      for (const int threads : {1, 3}) {
        const Renderer renderer(world, eye, {.sampling = sampling, .threads = threads});
        TruthRoom truth;
        truth.with_error = with_error;
        truth.head.assign(poses.size(), {{1, 2, 3}, {0.5, -1, 2}});
        truth.share_count = static_cast<int>(things);
        for (std::size_t k = 0; k < things; ++k)
          truth.share_of_instance.push_back(static_cast<std::int32_t>(k));
        truth.moving = {0};
        truth.velocities.assign(poses.size(), {{0, 1, 0}, {1, 0, 0}});
        truth.render(renderer, poses);
        EXPECT_TRUE(same_bits(truth.responses, render(renderer, poses, with_error).response));
        for (std::size_t i = 0; i < truth.met.size(); ++i) {
          double sum = 0;
          for (std::size_t k = 0; k < things; ++k) sum += truth.shares[i * things + k];
          EXPECT_NEAR(sum, truth.met[i], 1e-6);
          EXPECT_LE(truth.nearest[i], truth.distance[i] * (1 + 1e-6f));
          if (truth.met[i] > 0) {
            EXPECT_GE(truth.inverse[i] * truth.distance[i], truth.met[i] * truth.met[i] * 0.99f);
          }
        }
        if (first.empty()) first = all_of(truth);
        EXPECT_TRUE(same_bits(all_of(truth), first));
      }
    }
}

// Scrambles and rounds add up to means over all rays.
TEST(Truth, IsTheMeanOverAllScrambles) {
  const Scene scene = room();
  const Eye eye = make_eye(sphere_directions(30), 10 * degree);
  TruthRoom few, many;
  few.head = many.head = {{{1, 0.5, 0}, {0, 1, 0}}};
  few.with_error = true;
  few.render(make_renderer(scene, eye, {.sampling = Fixed{256}}));
  many.render(make_renderer(scene, eye, {.sampling = Fixed{2048}}));
  for (std::size_t i = 0; i < eye.size(); ++i) {
    // Two estimates from 2,048 even rays of what varies by a few tenths over a field.
    EXPECT_NEAR(few.distance[i], many.distance[i], 3e-3);
    EXPECT_NEAR(few.translation[2 * i], many.translation[2 * i], 3e-3);
    EXPECT_NEAR(few.rotation[2 * i], many.rotation[2 * i], 1e-3);
  }
}

// A layer that lets light through in part is what is met, a hole in a cut-out is not.
TEST(Truth, TheFirstSurfaceMetCounts) {
  Scene scene;
  Material sheet;
  sheet.base_color = {1, 1, 1, 0.25f};
  sheet.alpha_mode = AlphaMode::blend;
  sheet.double_sided = true;
  add_quad(scene, forward * 5, right * 50, up * 50, add_color(scene, {1, 1, 1}));
  const Eye eye = make_eye(forward, 1 * degree);
  TruthRoom truth;
  truth.share_of_instance = {-1, 0};
  truth.share_count = 1;
  add_quad(scene, forward * 2, right * 50, up * 50, add_material(scene, sheet));
  truth.render(make_renderer(scene, eye));
  EXPECT_NEAR(truth.distance[0], 2, 1e-3);
  EXPECT_EQ(truth.shares[0], 1);
  scene.materials.back().alpha_mode = AlphaMode::mask;
  truth.render(make_renderer(scene, eye));
  EXPECT_NEAR(truth.distance[0], 5, 1e-3);
  EXPECT_EQ(truth.shares[0], 0);
}

TEST(Truth, FarFromTheOrigin) {
  Scene scene = room();
  const Vec3d far{3e6, -2e6, 5e6};
  for (Instance& one : scene.instances)
    one.world_from_mesh = translation(far) * one.world_from_mesh;
  const Eye eye = make_eye(sphere_directions(40), 0);
  TruthRoom here, there;
  here.head = there.head = {{{1, 2, 0}, {0, 1, 0}}};
  here.moving = there.moving = {0, 1, 2, 3, 4, 5};
  here.velocities.assign(6, {{0, 0, 1}, {0, 3, 0}});
  there.velocities = here.velocities;
  here.render(make_renderer(room(), eye));
  there.render(make_renderer(scene, eye), translation(far));
  for (std::size_t i = 0; i < eye.size(); ++i) {
    EXPECT_NEAR(there.position[3 * i] - far.x, here.position[3 * i], 1e-5);
    EXPECT_NEAR(there.position[3 * i + 2] - far.z, here.position[3 * i + 2], 1e-5);
    EXPECT_NEAR(there.distance[i], here.distance[i], 1e-5);
    EXPECT_NEAR(there.objects[2 * i], here.objects[2 * i], 1e-4);
  }
}

TEST(Truth, WhatCannotBeIsRefused) {
  const Eye eye = make_eye(forward, 1 * degree, 4);
  const Renderer renderer = make_renderer(room(), eye);
  const Mat4 pose;
  const auto message = [&](const TruthCall& truth, const Renderer& by) -> std::string {
    std::vector<float> responses(eye.size() * rgb_bands);
    RenderCall call;
    call.truth = truth;
    try {
      by.render(std::span(&pose, 1), responses, call);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  std::vector<float> room_of_4(4), room_of_8(8);
  std::vector<std::int32_t> groups(6, 0), wrong(6, 2), few(2, 0);
  std::vector<Velocity> two(2), infinite(1, {{std::numeric_limits<double>::infinity(), 0, 0}, {}});
  const std::int32_t nobody[] = {6}, twice[] = {1, 1};
  EXPECT_EQ(message({.distance_m = room_of_4}, renderer), "");
  EXPECT_NE(message({.distance_m = room_of_8}, renderer).find("distance_m: expected room for 4"),
            std::string::npos);
  EXPECT_NE(message({.shares = room_of_4, .share_of_instance = few, .share_count = 1}, renderer)
                .find("share_of_instance: expected a group for each of 6 instances, found 2"),
            std::string::npos);
  EXPECT_NE(message({.shares = room_of_4, .share_of_instance = wrong, .share_count = 1}, renderer)
                .find("share_of_instance[0]: expected -1 to 0, found 2"),
            std::string::npos);
  EXPECT_NE(message({.flow_rotation = room_of_8, .head = two}, renderer)
                .find("head: expected 1 velocities (pose), found 2"),
            std::string::npos);
  EXPECT_NE(message({.flow_rotation = room_of_8, .head = infinite}, renderer).find("head[0]"),
            std::string::npos);
  EXPECT_NE(
      message({.flow_objects = room_of_8, .moving = nobody, .objects = std::span(two).first(1)},
              renderer)
          .find("moving[0]: expected an index into the 6 instances of the world, found 6"),
      std::string::npos);
  EXPECT_NE(message({.flow_objects = room_of_8, .moving = twice, .objects = two}, renderer)
                .find("moving[1]: 1 is there twice"),
            std::string::npos);
  const Renderer shared(make_world(room()), make_eye(sphere_directions(4), 60 * degree),
                        {.sampling = Shared{4}});
  EXPECT_NE(message({.distance_m = room_of_4}, shared).find("truth: not where rays are shared"),
            std::string::npos);
}

}  // namespace
}  // namespace omma::test
