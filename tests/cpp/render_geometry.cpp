// Where rays start and go: focal offsets, poses, frames; which sides, cut-outs and layers they see.
// Single rays along the axis (no acceptance angle) make every expected value exact.
#include <gtest/gtest.h>

#include "omma/pose.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

constexpr Vec3d forward{0, 0, -1}, right{1, 0, 0}, up{0, 1, 0};

// A wall across the view, `distance_m` in front, its front towards the eye.
void add_wall(Scene& scene, double distance_m, int material) {
  add_quad(scene, forward * distance_m, right * 50, up * 50, material);
}

Vec3 seen(const Scene& scene, const Eye& eye, const Mat4& pose = {}) {
  const Result result = render(scene, eye, {.sampling = Fixed{1}}, pose);
  return {result.response[0], result.response[1], result.response[2]};
}

Vec3 seen(const Scene& scene, Vec3d axis = forward, const Mat4& pose = {}) {
  return seen(scene, make_eye(axis, 0), pose);
}

void expect_color(Vec3 found, Vec3 expected, double tolerance = 1e-6) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

// A box with another colour on each side, around the origin.
Scene six_sides() {
  Scene scene;
  const Vec3 colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0.5f}};
  const Vec3d sides[] = {right, up, forward * -1, right * -1, up * -1, forward};
  for (int i = 0; i < 6; ++i) {
    const auto [u, v] = tangents(sides[i]);
    add_quad(scene, sides[i] * 2, u * 2, v * 2, add_color(scene, colors[i]));
  }
  return scene;
}

TEST(Geometry, HeadFrameIsRightUpAndForwardAlongMinusZ) {
  const Scene scene = six_sides();
  expect_color(seen(scene, right), {1, 0, 0});
  expect_color(seen(scene, up), {0, 1, 0});
  expect_color(seen(scene, forward), {0, 0, 0.5f});
  expect_color(seen(scene, forward * -1), {0, 0, 1});
  // Turned left about +Y by a quarter, forward is world -X and right is world -Z.
  const Mat4 left_turn = rotation(up, pi / 2);
  expect_color(seen(scene, forward, left_turn), {0.5f, 0, 0});
  expect_color(seen(scene, right, left_turn), {0, 0, 0.5f});
  // Pitched up by a quarter, forward is world up.
  expect_color(seen(scene, forward, rotation(right, pi / 2)), {0, 1, 0});
  const double h = std::sqrt(0.5);
  expect_color(seen(scene, forward, pose_from_quaternion({}, 0, h, 0, h)), {0.5f, 0, 0});
  expect_color(seen(scene, forward, look_at({}, {3, 0, 0})), {1, 0, 0});
}

TEST(Geometry, PositionsMoveWithTheHead) {
  Scene scene;
  scene.background = constant_background({0, 0, 1});
  // A small target 4 m ahead and 1 m to the right.
  add_quad(scene, {1, 0, -4}, right * 0.1, up * 0.1, add_color(scene, {1, 0, 0}));
  Eye eye = make_eye(forward, 0);
  expect_color(seen(scene, eye), {0, 0, 1});
  eye.position_m[0] = {1, 0, 0};
  expect_color(seen(scene, eye), {1, 0, 0});
  expect_color(seen(scene, eye, translation({-1, 0, 0})), {0, 0, 1});
  eye.position_m[0] = {0, 0, 0};
  expect_color(seen(scene, eye, translation({1, 0, 0})), {1, 0, 0});
  // Scale enlarges the eye: from 0.5 m right of the centre to 1 m.
  eye.position_m[0] = {0.5f, 0, 0};
  expect_color(seen(scene, eye), {0, 0, 1});
  expect_color(seen(scene, eye, scaling({2, 2, 2})), {1, 0, 0});
  // A mirrored head has its right on the left.
  eye.position_m[0] = {-1, 0, 0};
  expect_color(seen(scene, eye, scaling({-1, 1, 1})), {1, 0, 0});
}

TEST(Geometry, DirectionsFollowANonRigidPose) {
  Scene scene;
  add_quad(scene, {2, 0, -1}, right * 0.05, up * 0.05, add_color(scene, {1, 0, 0}));
  const Vec3d diagonal = normalize(Vec3d{1, 0, -1});
  expect_color(seen(scene, diagonal), {0, 0, 0});
  expect_color(seen(scene, diagonal, scaling({2, 1, 1})), {1, 0, 0});
  // Scale alone turns no direction and widens no acceptance angle.
  const Eye wide = make_eye(diagonal, 20 * degree);
  const RenderSettings settings{.sampling = Fixed{1000}};
  Scene sky;
  sky.background.type = BackgroundType::simple_sky;
  const double plain = render(sky, wide, settings).at(0);
  EXPECT_NEAR(render(sky, wide, settings, scaling({0.02, 0.02, 0.02})).at(0), plain, 1e-6);
}

TEST(Geometry, RaysStartAtTheFocalOffsetAndIgnoreWhatIsNearer) {
  Scene scene;
  add_wall(scene, 3, add_color(scene, {0, 1, 0}));
  add_wall(scene, 0.1, add_color(scene, {1, 0, 0}));
  // Behind the nodal point but in front of the ray's origin.
  add_wall(scene, -0.2, add_color(scene, {0, 0, 1}));
  Eye eye = make_eye(forward, 0);
  expect_color(seen(scene, eye), {1, 0, 0});
  // Origin 0.5 m behind: walls lie 0.3, 0.6 and 3.5 m along the ray, hits count from 0.5 m.
  eye.focal_offset_m[0] = 0.5f;
  expect_color(seen(scene, eye), {1, 0, 0});
  // The origin itself moves: what passes beside the nodal point is seen from farther back.
  Scene beside;
  beside.background = constant_background({0, 0, 1});
  add_quad(beside, {1, 0, -1}, right * 0.01, up * 0.01, add_color(beside, {1, 0, 0}));
  Eye oblique = make_eye(normalize(Vec3d{1, 0, -1}), 0);
  expect_color(seen(beside, oblique), {1, 0, 0});
  oblique.focal_offset_m[0] = 0.7f;  // along the axis: the same line
  expect_color(seen(beside, oblique), {1, 0, 0});
  oblique.focal_offset_m[0] = 1.5f;  // the target is 1.414 + 1.5 m along the ray
  expect_color(seen(beside, oblique), {1, 0, 0});
  oblique.position_m[0] = {2, 0, -2};  // past the target by 1.414 m: nearer than the offset
  expect_color(seen(beside, oblique), {0, 0, 1});
}

TEST(Geometry, FocalOffsetScalesWithThePose) {
  Scene scene;
  add_wall(scene, 2, add_color(scene, {0, 1, 0}));
  add_wall(scene, -0.3, add_color(scene, {0, 0, 1}));
  Eye eye = make_eye(forward, 0);
  eye.focal_offset_m[0] = 0.25f;
  expect_color(seen(scene, eye), {0, 1, 0});
  // At scale 4 the origin is 1 m behind; the blue wall 0.7 m along the ray is inside the eye.
  expect_color(seen(scene, eye, scaling({4, 4, 4})), {0, 1, 0});
  // At scale 1.5 of the depth axis alone too: 0.375 m, the wall 0.075 m along the ray.
  expect_color(seen(scene, eye, scaling({1, 1, 1.5})), {0, 1, 0});
  // Shifted so that the wall lies 1.1 m along the ray, beyond the metre.
  expect_color(seen(scene, eye, translation({0, 0, 0.4}) * scaling({4, 4, 4})), {0, 0, 1});
}

// With a wide acceptance the oblique rays start at the same point behind: the share of a Gaussian
// within a disc seen from the origin, not from the nodal point.
TEST(Geometry, OffsetNarrowsWhatADiscCovers) {
  Scene scene;
  Mesh disc;
  disc.material = add_color(scene, {1, 1, 1});
  constexpr unsigned corners = 512;
  disc.positions.push_back({0, 0, -1});
  for (unsigned i = 0; i < corners; ++i) {
    const double phi = 2 * pi * i / corners;
    disc.positions.push_back(to_float({std::cos(phi), std::sin(phi), -1}));
    disc.triangles.push_back({0, i + 1, (i + 1) % corners + 1});
  }
  add_instance(scene, add_mesh(scene, disc));
  Eye eye = make_eye(forward, 120 * degree, 16);
  for (float& offset : eye.focal_offset_m) offset = 0.9f;
  const Result result = render(scene, eye, {Fixed{4096}, 1, Kernel::pillbox});
  double mean = 0;
  for (std::size_t i = 0; i < eye.size(); ++i) mean += result.at(i) / 16;
  // Cap of half angle atan(1 / 1.9) out of one of 60 degrees; noise and polygon under 2e-4.
  const double expected = (1 - 1.9 / std::hypot(1, 1.9)) / (1 - std::cos(pi / 3));
  EXPECT_NEAR(mean, expected, 1e-3);
}

TEST(Geometry, BackFacesAreInvisibleUnlessDoubleSided) {
  for (const bool double_sided : {false, true})
    for (const bool mirrored : {false, true})
      for (const bool turned : {false, true}) {
        Scene scene;
        scene.background = constant_background({0, 0, 1});
        Material red;
        red.base_color = {1, 0, 0, 1};
        red.double_sided = double_sided;
        const int mesh = add_mesh(scene, quad({}, right, up, add_material(scene, red)));
        // Turning shows the back. Mirroring an object in its plane's normal shows the other side;
        // mirroring it sideways keeps the side that is shown: a mirrored front is still a front.
        Mat4 place = translation(forward * 2);
        if (turned) place = place * rotation(up, pi);
        if (mirrored) place = place * scaling({-1, 1, 1});
        add_instance(scene, mesh, place);
        const bool visible = double_sided || !turned;
        expect_color(seen(scene), visible ? Vec3{1, 0, 0} : Vec3{0, 0, 1});
        Scene flipped = scene;
        flipped.instances[0].world_from_mesh = place * scaling({1, 1, -1});
        expect_color(seen(flipped), double_sided || turned ? Vec3{1, 0, 0} : Vec3{0, 0, 1});
      }
}

TEST(Geometry, MaskIsExact) {
  Scene scene;
  scene.background = constant_background({0, 0, 1});
  Material leaf;
  leaf.alpha_mode = AlphaMode::mask;
  leaf.alpha_cutoff = 0.5f;
  leaf.base_color = {0.5f, 1, 1, 1};
  // Alpha 0.25, 0.5, 0.75, 1 from left to right: the second is just not cut out.
  leaf.base_color_texture.texture =
      add_texture(scene,
                  make_image(4, 1,
                             [](int c, int) {
                               return Vec4{1, 1, 1, 0.25f * (c + 1.0f)};
                             }),
                  {-1, Wrap::repeat, Wrap::repeat, Filter::nearest});
  add_quad(scene, forward, right, up, add_material(scene, leaf));
  const auto at = [&](double x) { return seen(scene, normalize(Vec3d{x, 0.1, -1})); };
  expect_color(at(-0.75), {0, 0, 1});
  expect_color(at(-0.25), {0.5f, 1, 1});
  expect_color(at(0.25), {0.5f, 1, 1});
  expect_color(at(0.75), {0.5f, 1, 1});
  scene.materials[0].base_color.w = 0.6f;  // 0.15, 0.3, 0.45, 0.6
  expect_color(at(0.25), {0, 0, 1});
  expect_color(at(0.75), {0.5f, 1, 1});
  scene.materials[0].alpha_mode = AlphaMode::opaque;  // alpha does not count
  expect_color(at(-0.75), {0.5f, 1, 1});
}

TEST(Geometry, BlendIsLayeredFrontToBack) {
  Scene scene;
  scene.background = constant_background({0, 0, 1});
  Material glass;
  glass.alpha_mode = AlphaMode::blend;
  glass.base_color = {1, 0.5f, 0, 0.25f};
  // Added out of order: what is nearer comes first on the ray, not in the file.
  glass.base_color = {0, 1, 0, 0.5f};
  add_wall(scene, 3, add_material(scene, glass));
  glass.base_color = {1, 0.5f, 0, 0.25f};
  add_wall(scene, 1, add_material(scene, glass));
  // 0.25 (1, .5, 0) + 0.75 (0.5 (0, 1, 0) + 0.5 (0, 0, 1))
  expect_color(seen(scene), {0.25f, 0.5f, 0.375f});
  // An opaque wall between the two hides the rest.
  add_wall(scene, 2, add_color(scene, {1, 1, 1}));
  expect_color(seen(scene), {1, 0.875f, 0.75f});
  // Seen from behind, single-sided layers are not there.
  expect_color(seen(scene, forward, translation(forward * 5) * rotation(up, pi)), {1, 1, 1});
  // Many layers: 40 of alpha 0.1 leave 0.9^40 of the background.
  Scene stack;
  stack.background = constant_background({1, 0, 0});
  glass.base_color = {0, 1, 0, 0.1f};
  const int material = add_material(stack, glass);
  for (int i = 1; i <= 40; ++i) add_wall(stack, i, material);
  const double rest = std::pow(0.9, 40);
  expect_color(seen(stack), {static_cast<float>(rest), static_cast<float>(1 - rest), 0}, 1e-5);
}

// An eye that lies in a transparent surface: every ray meets it at distance zero, once.
TEST(Geometry, RaysLeaveATransparentSurfaceTheyStartIn) {
  for (const float alpha : {0.0f, 1e-6f}) {
    Scene scene;
    scene.background = constant_background({0.25f, 0.5f, 1});
    Material glass;
    glass.base_color = {1, 1, 1, alpha};
    glass.alpha_mode = AlphaMode::blend;
    glass.double_sided = true;
    add_instance(
        scene, add_mesh(scene, quad({0, 0, 0}, {4, 0, 0}, {0, 4, 0}, add_material(scene, glass))));
    const Result result =
        render(scene, make_eye(sphere_directions(100), 40 * degree), {.sampling = Fixed{64}});
    for (std::size_t i = 0; i < 100; ++i) EXPECT_NEAR(result.at(i, 0), 0.25, 2e-6);
  }
}

TEST(Geometry, EmissionAddsUnlessUnlit) {
  Scene scene;
  Material lamp;
  lamp.base_color = {0.25f, 0.5f, 0, 1};
  lamp.emissive = {0.5f, 0, 20};  // radiance is not clipped
  add_wall(scene, 1, add_material(scene, lamp));
  expect_color(seen(scene), {0.75f, 0.5f, 20});
  // KHR_materials_unlit: the colour is the base colour term alone.
  scene.materials[0].unlit = true;
  expect_color(seen(scene), {0.25f, 0.5f, 0});
}

// Legal in a file, senseless to look at: whatever texel comes out, none is read outside the image
// (the sanitizers tell), and the response is one of its colours.
TEST(Geometry, HugeTextureCoordinatesStayInTheImage) {
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirrored_repeat, Wrap::clamp_to_edge})
    for (const Filter filter : {Filter::nearest, Filter::linear})
      for (const float size : {3e6f, 3e9f, 1e20f, 3e38f}) {
        Scene scene;
        Material material;
        material.base_color_texture.texture =
            add_texture(scene,
                        make_image(3, 2,
                                   [](int, int) {
                                     return Vec4{0.5f, 0.5f, 0.5f, 1};
                                   }),
                        {-1, wrap, wrap, filter});
        Mesh wall = quad(forward, right, up, add_material(scene, material));
        for (Vec2& uv : wall.texcoords[0]) uv = {(uv.x - 0.4f) * size, (0.6f - uv.y) * size};
        add_instance(scene, add_mesh(scene, wall));
        const Result result =
            render(scene, make_eye(forward, 30 * degree), {.sampling = Fixed{64}});
        EXPECT_NEAR(result.at(0), 0.5, 1e-5) << size;
      }
}

TEST(Geometry, AMeshWithoutMaterialIsWhite) {
  Scene scene;
  add_wall(scene, 1, -1);
  expect_color(seen(scene), {1, 1, 1});
}

}  // namespace
}  // namespace omma::test
