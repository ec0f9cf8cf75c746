// Rendering to an error: how far off the worst are. Nothing tells of what few rays miss, so this
// is measured where it is hardest: edges of full contrast that few ommatidia see, and a texture
// far finer than their fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "omma/io.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

// Black and white, as in flight arenas: a wall 9.6 m high at 12 m with vertical stripes, horizontal
// stripes, a checkerboard and squares at random, a quarter each; floor and sky are black.
Scene black_and_white_arena() {
  Scene scene;
  constexpr int columns = 144, rows = 24;
  const int colors[2] = {add_color(scene, {0, 0, 0}), add_color(scene, {1, 1, 1})};
  Mesh meshes[2];
  meshes[0].material = colors[0], meshes[1].material = colors[1];
  Random random{3};
  bool squares[12][12];
  for (auto& column : squares)
    for (bool& is_white : column) is_white = random.index(2) == 1;
  const auto corner = [](int column, int row) {
    const double azimuth = 2 * pi * column / columns;
    return to_float({12 * std::cos(azimuth), 0.4 * row, 12 * std::sin(azimuth)});
  };
  for (int column = 0; column < columns; ++column)
    for (int row = 0; row < rows; ++row) {
      const int quarter = column / 36, k = column % 36;
      const bool patterns[] = {k / 6 % 2 == 1, row / 4 % 2 == 1, (k / 6 + row / 4) % 2 == 1,
                               squares[k / 3][row / 2]};
      Mesh& mesh = meshes[patterns[quarter] ? 1 : 0];
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (const auto& [i, j] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
        mesh.positions.push_back(corner(column + i, row + j));
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  for (Mesh& mesh : meshes) add_instance(scene, add_mesh(scene, std::move(mesh)));
  return scene;
}

// A plane 1.5 m below the eye, of squares 5 cm wide: far finer than its fields.
Scene checkered_ground() {
  Scene scene;
  Material material;
  material.double_sided = true;
  material.base_color_texture.texture =
      add_texture(scene, make_image(256, 256, [](int column, int row) {
                    const float grey = (column / 32 + row / 32) % 2 == 0 ? 0.01f : 0.72f;
                    return Vec4{grey, grey, 0.1f, 1};
                  }));
  Mesh ground = quad({0, 0, 0}, {200, 0, 0}, {0, 0, 200}, add_material(scene, material));
  for (Vec2& t : ground.texcoords[0]) t = {1000 * t.x, 1000 * t.y};
  add_instance(scene, add_mesh(scene, std::move(ground)));
  scene.background.type = BackgroundType::simple_sky;
  return scene;
}

// Of the responses that say that they have reached an error, in multiples of it: the largest over
// the channels, of all renders, sorted.
std::vector<double> errors_of_reached(const Scene& scene, const Eye& eye, const Mat4& pose,
                                      std::span<const float> truth, double error) {
  constexpr std::size_t renders = 16;
  RenderSettings settings;
  settings.sampling = ToError{error};
  settings.noise = Noise::new_every_frame;
  const Result result =
      render(make_renderer(scene, eye, settings), std::vector<Mat4>(renders, pose), true);
  std::vector<double> errors;
  for (std::size_t i = 0; i < result.response.size(); i += rgb_bands) {
    double largest = 0;
    float reported = 0;
    for (std::size_t c = i; c < i + rgb_bands; ++c) {
      const double e = static_cast<double>(result.response[c]) - truth[c % truth.size()];
      largest = std::max(largest, std::fabs(e));
      reported = std::max(reported, result.standard_error[c]);
    }
    if (reported <= static_cast<float>(error)) errors.push_back(largest / error);
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

// docs/sampling.md: 99 of 100 are within twice the error, 999 of 1,000 within four times. While
// an ommatidium heard of its neighbours along the curve their roughness alone, the latter were
// within 14 to 25 times 0.003 and 5 to 8 times 0.01 in the arenas, and on the checkerboard 98.6 of
// 100 within twice 0.03.
void expect_short_tails(const Scene& scene, double height_m) {
  const Eye eye = make_eye(sphere_directions(1000), 2.6 * degree);
  const Mat4 pose = translation({0.3, height_m, 0.1});
  RenderSettings settings;
  settings.sampling = Fixed{32768};  // on the checkerboard 0.0002 off, elsewhere less
  settings.seed = 99;
  settings.footprints = false;
  const std::vector<float> truth = render(scene, eye, settings, pose).response;
  for (const double error : {0.003, 0.01, 0.03}) {
    const std::vector<double> errors = errors_of_reached(scene, eye, pose, truth, error);
    const auto at = [&](double share) {
      return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size()))];
    };
    ASSERT_GT(errors.size(), 8000u) << error;
    EXPECT_LT(at(0.99), 2) << error;
    EXPECT_LT(at(0.999), 4) << error;
  }
}

TEST(RenderToErrorTails, BlackAndWhiteArena) {
  expect_short_tails(black_and_white_arena(), 2.1);
}

TEST(RenderToErrorTails, CheckeredGround) {
  expect_short_tails(checkered_ground(), 1.5);
}

TEST(RenderToErrorTails, OfstadArena) {
  const std::string path = OMMA_SHARED_DATA "/compound-ray/scenes/ofstad-arena.gltf";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no scene at " << path;
  expect_short_tails(load_scene(path), 1.98);
}

}  // namespace
}  // namespace omma::test
