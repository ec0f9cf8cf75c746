// Textures read through the footprint of a ray: coarser levels keep the mean, fine texture is no
// noise, and the acceptance function stays what it is.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "backend/shading_data.h"
#include "backend/texture_levels.h"
#include "omma/camera.h"
#include "omma/io.h"
#include "physics/surface/footprint.h"
#include "physics/surface/texture.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

// --- Levels.
Image random_image(int width, int height, std::uint64_t seed, bool eight_bit) {
  Random random{seed};
  Image image;
  image.width = width, image.height = height;
  for (int i = 0; i < 4 * width * height; ++i)
    if (eight_bit)
      image.rgba_srgb8.push_back(static_cast<std::uint8_t>(random.index(256)));
    else
      image.rgba_linear.push_back(static_cast<float>(random.uniform()));
  return image;
}

// Sums over a level: colour as it is seen, coverage, texels.
struct LevelSums {
  double seen[3] = {}, coverage = 0;
};

LevelSums mean_of_level(const TextureView& view, int level, AlphaMode use) {
  const auto l = level_of(view, level);
  LevelSums sums;
  const float unit = view.linear == nullptr ? 1 / 65535.0f : 1;
  const double share = 1.0 / (l.width * l.height);
  for (int i = 0; i < l.width * l.height; ++i) {
    const Color<float> c = load_texel<float>(view, l.first_texel + i) * unit;
    const double coverage = use == AlphaMode::opaque ? 1 : c.a;
    sums.seen[0] += share * coverage * c.r;
    sums.seen[1] += share * coverage * c.g;
    sums.seen[2] += share * coverage * c.b;
    sums.coverage += share * coverage;
  }
  return sums;
}

// Any size, even or not: every texel of the image has the same weight in every level. Rounding to
// 16 bits moves each texel of a level, colour and alpha, by 7.6e-6 at most; sums in float move the
// mean by less than 1e-6.
TEST(TextureLevels, KeepTheMeanAndTheCoverage) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, {2, 1}, {7, 5}, {64, 64}, {33, 1}, {1, 90}, {250, 101}})
    for (const bool eight_bit : {true, false})
      for (const AlphaMode use : {AlphaMode::opaque, AlphaMode::blend}) {
        const Image image = random_image(width, height, 5, eight_bit);
        const TextureLevels levels = make_texture_levels(image, ImageCodes::srgb, use, true);
        const TextureView view = view_levels(image, levels);
        const auto last = level_of(view, view.last_level);
        EXPECT_EQ(last.width * last.height, 1);
        const LevelSums all = mean_of_level(view, 0, use);
        for (int level = 1; level <= view.last_level; ++level) {
          const LevelSums sums = mean_of_level(view, level, use);
          EXPECT_NEAR(sums.coverage, all.coverage, 9e-6) << width << ' ' << height;
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(sums.seen[c], all.seen[c], 1.7e-5)
                << width << " x " << height << ", level " << level;
        }
      }
}

// At a power of two the finer level's weight runs out just as the coarser one takes over.
TEST(TextureLevels, AreContinuousInTheWidth) {
  const Image image = random_image(64, 64, 8, false);
  const TextureLevels levels = make_texture_levels(image, ImageCodes::srgb, {}, true);
  const TextureView view = view_levels(image, levels);
  for (const float width : {1.0f, 2.0f, 4.0f, 32.0f, 64.0f}) {
    const float below = eval_texture(view, 0.3f, 0.7f, width * (1 - 1e-6f)).r;
    const float above = eval_texture(view, 0.3f, 0.7f, width * (1 + 1e-6f)).r;
    EXPECT_NEAR(below, above, 1e-5) << width;
  }
  EXPECT_EQ(eval_texture(view, 0.3f, 0.7f, 1e9f).r, eval_texture(view, 0.3f, 0.7f, 64.0f).r);
  EXPECT_EQ(eval_texture(view, 0.3f, 0.7f, 1.0f).r, eval_texture(view, 0.3f, 0.7f, 0.0f).r);
}

TEST(TextureLevels, OneLaneIsManyLanes) {
  Random random{3};
  for (const bool eight_bit : {true, false})
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirrored_repeat, Wrap::clamp_to_edge}) {
      const Image image = random_image(37, 20, 9, eight_bit);
      const TextureLevels levels = make_texture_levels(image, ImageCodes::srgb, {}, true);
      TextureView view = view_levels(image, levels);
      view.wrap_u = view.wrap_v = wrap;
      for (int i = 0; i < 1000; ++i) {
        Floats u{}, v{}, width{};
        for (int l = 0; l < lane_width; ++l) {
          u[l] = static_cast<float>(random.uniform(-3, 3));
          v[l] = static_cast<float>(random.uniform(-3, 3));
          width[l] = static_cast<float>(std::exp2(random.uniform(-1, 7)));
        }
        const Color<Floats> many = eval_texture(view, u, v, width);
        for (int l = 0; l < lane_width; ++l)
          EXPECT_EQ(eval_texture<float>(view, u[l], v[l], width[l]).g, many.g[l]);
      }
    }
}

// The image of a large scene stays 8-bit; what is read is the same to the last bit, by one lane and
// by many, whose levels differ. Level 0 costs nothing then, the others a third of it.
TEST(TextureLevels, OfLargeScenesAreTheSameBits) {
  Random random{4};
  for (const auto& [width, height] :
       {std::pair{1, 1}, {2, 1}, {5, 3}, {64, 64}, {33, 1}, {1, 90}, {250, 101}, {6, 11}})
    for (const ImageCodes codes : {ImageCodes::srgb, ImageCodes::linear})
      for (const AlphaMode use : {AlphaMode::opaque, AlphaMode::blend})
        for (const bool with_levels : {true, false}) {
          const Image image = random_image(width, height, 6, true);
          const TextureLevels small = make_texture_levels(image, codes, use, with_levels);
          const TextureLevels large = make_texture_levels(image, codes, use, with_levels, true);
          ASSERT_EQ(large.linear16.size() + 2 * static_cast<std::size_t>(width * height),
                    small.linear16.size());
          const TextureView a = view_levels(image, small), b = view_levels(image, large);
          const auto expect_same = [](const auto& x, const auto& y) {
            EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0);
          };
          for (int i = 0; i < 300; ++i) {
            Floats u{}, v{}, wide{};
            for (int l = 0; l < lane_width; ++l) {
              u[l] = static_cast<float>(random.uniform(-3, 3));
              v[l] = static_cast<float>(random.uniform(-3, 3));
              wide[l] = static_cast<float>(std::exp2(random.uniform(i % 3 - 2, 4)));
            }
            expect_same(eval_texture(a, u, v, wide), eval_texture(b, u, v, wide));
            expect_same(eval_texture<float>(a, u[0], v[0], wide[0]),
                        eval_texture<float>(b, u[0], v[0], wide[0]));
          }
        }
}

// A scene is large by the texels of all its images; what is built of it then has no copy of them.
TEST(TextureLevels, OfLargeImagesAreNoCopies) {
  Scene scene;
  Image image;
  image.width = 4096;
  for (const bool large : {false, true}) {
    image.height = large ? 4097 : 4096;
    image.rgba_srgb8.assign(static_cast<std::size_t>(image.width * image.height) * 4, 7);
    Material material;
    scene = {};
    material.base_color_texture.texture = add_texture(scene, image);
    add_material(scene, material);
    const auto shading = make_shading_data(scene);
    std::size_t bytes = 0;
    for (const TextureLevels& levels : shading->levels)
      bytes += levels.linear16.size() * sizeof(std::int32_t);
    const std::size_t texels = image.rgba_srgb8.size() / 4;
    // Levels 1, 2, ... have a third of the texels of level 0, and a few for what is rounded up.
    const double expected = static_cast<double>(texels) * 8 * (large ? 1 / 3.0 : 4 / 3.0);
    EXPECT_NEAR(static_cast<double>(bytes), expected, 0.001 * expected);
    scene.background.type = BackgroundType::image;
    scene.background.image = image;
    const BackgroundData background = make_background_data(scene.background);
    EXPECT_EQ(background.levels.linear16.size() * sizeof(std::int32_t), bytes);
  }
}

// --- What an ommatidium sees.
RenderSettings with_footprints(int samples, bool footprints, Kernel kernel = Kernel::gaussian) {
  RenderSettings settings;
  settings.noise = Noise::new_every_frame;
  settings.sampling = Fixed{samples};
  settings.kernel = kernel;
  settings.footprints = footprints;
  return settings;
}

// A wall 1 m ahead, 8 m wide and high, with a random 8-bit image of so many texels a side.
Scene wall(int texels, const Mat4& world_from_mesh = {}, double mesh_scale = 1) {
  Scene scene;
  Material material;
  material.double_sided = true;
  material.base_color_texture.texture = add_texture(scene, random_image(texels, texels, 17, true));
  const int index = add_material(scene, material);
  const double half = 4 / mesh_scale;
  add_instance(scene,
               add_mesh(scene, quad({0, 0, -1 / mesh_scale}, {half, 0, 0}, {0, half, 0}, index)),
               world_from_mesh);
  return scene;
}

std::vector<float> many_estimates(const Scene& scene, const RenderSettings& settings) {
  const std::vector<Mat4> poses(500);
  return render(make_renderer(scene, make_eye(Vec3d{0.1, 0.2, -1}, 5 * degree), settings), poses)
      .response;
}

std::pair<double, double> mean_and_deviation(const std::vector<float>& values) {
  double sum = 0, squares = 0;
  const auto n = static_cast<double>(values.size());
  for (const float x : values) sum += x;
  for (const float x : values) squares += (x - sum / n) * (x - sum / n);
  return {sum / n, std::sqrt(squares / n)};
}

// Texels of 0.11 degrees and an ommatidium of 5: footprints of 0.63 degrees cover 30 of them, read
// bilinearly 4/9 x 4/9 of the variance stays at either scale.
TEST(Footprints, FineTextureIsNotNoise) {
  const Scene scene = wall(4096);
  const auto [mean_without, noise_without] =
      mean_and_deviation(many_estimates(scene, with_footprints(16, false)));
  const auto [mean_with, noise_with] =
      mean_and_deviation(many_estimates(scene, with_footprints(16, true)));
  EXPECT_LT(noise_with, 0.25 * noise_without);
  // 1,500 values: the mean without footprints is known to a 38th of their deviation.
  EXPECT_NEAR(mean_with, mean_without, 3 * noise_without / 38);
}

TEST(Footprints, CoarseTexturesAndSingleRaysAreReadAsEver) {
  // Texels of 0.13 m at 1 m are wider than any footprint of a 5 degree ommatidium.
  EXPECT_EQ(many_estimates(wall(61), with_footprints(16, true)),
            many_estimates(wall(61), with_footprints(16, false)));
  const Eye eye = make_eye(sphere_directions(300), 0);
  EXPECT_EQ(render(wall(4096), eye, with_footprints(1, true)).response,
            render(wall(4096), eye, with_footprints(1, false)).response);
}

// The same wall as a small mesh made large, as it is, and as a mirrored instance.
TEST(Footprints, FollowTheScaleOfAnInstance) {
  const RenderSettings settings = with_footprints(16, true);
  const std::vector<float> one = many_estimates(wall(4096), settings);
  const std::vector<float> large = many_estimates(wall(4096, scaling({20, 20, 20}), 20), settings);
  const std::vector<float> mirrored =
      many_estimates(wall(4096, scaling({-20, -20, -20}), -20), settings);
  ASSERT_EQ(one.size(), large.size());
  // Float rounding of the hit and the level: texels differ by 0.3 on the average, a level of
  // texels 16 times as wide moves by 1e-5 of one.
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(one[i], large[i], 2e-4);
    EXPECT_NEAR(one[i], mirrored[i], 2e-4);
  }
}

// --- The modulation transfer, as in render_acceptance.cpp: gratings round the horizon, or from it
// up and down, at phases spread over a period; `texels` on a ring or as a background.
struct Grating {
  int cycles = 0;
  bool vertical = false, on_surface = false;
};

Scene grating_scene(const Grating& grating) {
  constexpr int pixels = 32768;
  const auto value = [&](double angle_rad) {
    const auto v = static_cast<float>(0.5 + 0.5 * std::cos(grating.cycles * angle_rad));
    return Vec4{v, v, v, 1};
  };
  const double step = 2 * pi / pixels;
  Scene scene;
  const Image round =
      make_image(pixels, 1, [&](int column, int) { return value((column + 0.5) * step - pi); });
  if (!grating.on_surface) {
    scene.background = image_background(
        grating.vertical
            ? make_image(1, pixels / 2,
                         [&](int, int row) { return value(pi / 2 - (row + 0.5) * step); })
            : round);
    return scene;
  }
  Material material;
  material.double_sided = true;
  material.base_color_texture.texture = add_texture(scene, round);
  Mesh ring;
  ring.material = add_material(scene, material);
  constexpr unsigned sides = 2048;
  for (unsigned i = 0; i <= sides; ++i)
    for (const double up : {-3.0, 3.0}) {
      const double azimuth = 2 * pi * (static_cast<double>(i) / sides - 0.5);
      ring.positions.push_back(to_float(from_azimuth_elevation(azimuth, 0) + Vec3d{0, up, 0}));
      ring.texcoords[0].push_back({static_cast<float>(i) / sides, up < 0 ? 1.0f : 0.0f});
    }
  for (unsigned i = 0; i < 2 * sides; i += 2) {
    ring.triangles.push_back({i, i + 2, i + 1});
    ring.triangles.push_back({i + 1, i + 2, i + 3});
  }
  add_instance(scene, add_mesh(scene, ring));
  return scene;
}

double measured_modulation(const Grating& grating, const RenderSettings& settings,
                           double acceptance_rad) {
  constexpr int phases = 64;
  std::vector<Vec3d> axes;
  std::vector<double> phase;
  for (int i = 0; i < phases; ++i) {
    const double angle = 2 * pi / grating.cycles * (static_cast<double>(i) / phases - 0.5);
    phase.push_back(grating.cycles * angle);
    axes.push_back(grating.vertical ? from_azimuth_elevation(1, angle)
                                    : from_azimuth_elevation(angle, 0));
  }
  const std::vector<Mat4> poses(
      static_cast<std::size_t>(std::max(1, 8192 / std::get<Fixed>(settings.sampling).samples)));
  const Result result = render(
      make_renderer(grating_scene(grating), make_eye(axes, acceptance_rad), settings), poses);
  double modulation = 0;
  for (std::size_t p = 0; p < poses.size(); ++p)
    for (std::size_t i = 0; i < phases; ++i)
      modulation += 2.0 / phases * 2 * (result.at(p * phases + i) - 0.5) * std::cos(phase[i]);
  return modulation / static_cast<double>(poses.size());
}

// The promise, at the default number of rays and at others. What the footprints do is the
// difference to the same rays without; tables of few patterns of one or four rays have a modulation
// of their own. At 16 that is below 0.001, and so is what the sphere differs from the plane.
TEST(Footprints, GratingsFollowTheGaussianWithinAHundredth) {
  const double acceptance_deg = 2.6;
  for (const int samples : {1, 4, 16, 64})
    for (const double cycles_per_width : {0.25, 0.4, 0.53, 0.7, 1.0, 3.9, 7.7})
      for (const Grating way : {Grating{0, false, false}, {0, true, false}, {0, false, true}}) {
        Grating grating = way;
        grating.cycles = static_cast<int>(std::lround(360 / acceptance_deg * cycles_per_width));
        const double nu = grating.cycles * acceptance_deg / 360;
        const auto modulation = [&](bool footprints) {
          return measured_modulation(grating, with_footprints(samples, footprints),
                                     acceptance_deg * degree);
        };
        const double found = modulation(true);
        EXPECT_NEAR(found, modulation(false), 0.01) << samples << " samples, " << nu;
        if (samples != 16) continue;
        EXPECT_NEAR(found, std::exp(-3.5597 * nu * nu), 0.01) << nu;
      }
}

// That they are in use there: without them the law is met five times as closely.
TEST(Footprints, WidenTheAcceptanceFunctionALittle) {
  const Grating grating{73, false, true};
  const double nu = 73 * 2.6 / 360, law = std::exp(-3.5597 * nu * nu);
  EXPECT_GT(law - measured_modulation(grating, with_footprints(16, true), 2.6 * degree), 0.004);
  EXPECT_NEAR(measured_modulation(grating, with_footprints(16, false), 2.6 * degree), law, 0.002);
}

TEST(Footprints, GratingsFollowTheOtherKernelsWithinAHundredth) {
  const double acceptance = 2.6 * degree;
  for (const double cycles_per_width : {0.3, 0.6, 0.9, 1.5, 2.5, 5.0, 10.0}) {
    const int cycles = static_cast<int>(std::lround(360 / 2.6 * cycles_per_width));
    const double x = pi * cycles * 2.6 / 360, z = 4 * x * x / (2.35482 * 2.35482) / 4;
    EXPECT_NEAR(measured_modulation({cycles, false, false},
                                    with_footprints(16, true, Kernel::pillbox), acceptance),
                2 * std::cyl_bessel_j(1.0, x) / x, 0.01)
        << "pillbox " << cycles_per_width;
    EXPECT_NEAR(measured_modulation({cycles, false, false},
                                    with_footprints(16, true, Kernel::compoundray), acceptance),
                std::exp(-z) * std::cyl_bessel_i(0.0, z), 0.01)
        << "compoundray " << cycles_per_width;
  }
}

// --- Bias in real scenes: 65,536 rays in renders of 16, each with its footprint, against as many
// in one without footprints, for every n-th ommatidium.
struct Bias {
  double mean = 0, rms = 0, largest = 0;  // over ommatidia and channels
  double error = 0;                       // RMS of a single render of 16 rays
};

Bias measured_bias(const std::string& scene_path, const std::string& eye_path, const Mat4& pose,
                   std::size_t every) {
  const auto scene = std::make_shared<const Scene>(load_scene(scene_path));
  const Eye whole = load_eye(eye_path);
  Eye eye;
  for (std::size_t i = 0; i < whole.size(); i += every) {
    eye.position_m.push_back(whole.position_m[i]);
    eye.axis.push_back(whole.axis[i]);
    eye.acceptance_angle_rad.push_back(whole.acceptance_angle_rad[i]);
    eye.focal_offset_m.push_back(whole.focal_offset_m[i]);
    eye.eye_id.push_back(whole.eye_id[i]);
  }
  const Renderer exact(scene, eye, with_footprints(65536, false));
  const Renderer default_rays(exact, eye, with_footprints(16, true));
  const Result expected = render(exact, std::span(&pose, 1));
  std::vector<double> sum(expected.response.size());
  Bias bias;
  constexpr std::size_t at_once = 64, times = 64;
  const std::vector<Mat4> poses(at_once, pose);
  for (std::size_t t = 0; t < times; ++t) {
    const Result some = render(default_rays, poses, false, t * at_once);
    for (std::size_t i = 0; i < some.response.size(); ++i) {
      const double d = some.response[i] - expected.response[i % sum.size()];
      sum[i % sum.size()] += d;
      bias.error += d * d;
    }
  }
  const auto n = static_cast<double>(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const double d = sum[i] / (at_once * times);
    bias.mean += d / n, bias.rms += d * d / n;
    bias.largest = std::max(bias.largest, std::fabs(d));
  }
  bias.rms = std::sqrt(bias.rms);
  bias.error = std::sqrt(bias.error / (n * at_once * times));
  return bias;
}

TEST(Footprints, BiasInRealScenes) {
  const std::string shared = OMMA_SHARED_DATA "/compound-ray";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << "no shared data";
  const std::string eye = shared + "/bees/AM_60185-real.eye";
  const std::string meadow = shared + "/scenes/natural-standin-sky.gltf";
  const std::string arena = shared + "/scenes/ofstad-arena.gltf",
                    grass = OMMA_EXAMPLES "/meadow.glb";
  const auto pose_of = [](const std::string& path, CameraType type) {
    for (const Camera& camera : load_scene(path).cameras)
      if (camera.type == type) return camera.world_from_camera;
    return Mat4{};
  };
  Mat4 in_arena = pose_of(arena, CameraType::compound);
  const double scale = std::cbrt(std::fabs(determinant(in_arena)));
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) in_arena.m[r][c] /= scale;
  const Mat4 in_grass = find_camera(load_scene(grass), "bee").world_from_camera;
  for (const Bias& bias :
       {measured_bias(meadow, eye, translation({0, 0.15, 0}), 16),
        measured_bias(arena, eye, in_arena, 16), measured_bias(grass, eye, in_grass, 64)}) {
    // Measured: 0.02, 0.04 and 0.02 of the error of one render; about half of each is noise.
    EXPECT_LT(bias.rms, 0.1 * bias.error);
    EXPECT_LT(bias.largest, bias.error);
    EXPECT_LT(std::fabs(bias.mean), 1e-4);
  }
}

}  // namespace
}  // namespace omma::test
