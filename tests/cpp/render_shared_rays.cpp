// Responses from rays that neighbours share: right on average over seeds, far less noisy than those
// of own rays, errors as reported, the same bits however the work is cut up; and what the shared
// nodal points cost close by.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <thread>

#include "test_scenes.h"

namespace omma::test {
namespace {

RenderSettings shared(int samples, std::uint64_t seed = 0, Kernel kernel = Kernel::gaussian) {
  RenderSettings settings;
  settings.sampling = Shared{samples};
  settings.seed = seed;
  settings.kernel = kernel;
  settings.footprints = false;  // so that the reference of many rays sees the same textures
  return settings;
}

Scene clutter() {
  return flat_triangles(3, 600, 20);
}

// Facets 13 degrees apart; all nodal points at one place unless moved.
Eye all_round(double acceptance_rad = 24 * degree, int ommatidia = 250) {
  return make_eye(sphere_directions(ommatidia), acceptance_rad);
}

// Every fifth sees 60 degrees among others of 5, and those ahead crowd together.
Eye mixed_eye() {
  std::vector<Vec3d> axes = sphere_directions(200);
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (i % 4 == 1) axes[i] = normalize(Vec3d{0.1, 0.2, -1} + axes[i] * 0.2);
  Eye eye = make_eye(axes, 5 * degree);
  for (std::size_t i = 0; i < eye.size(); i += 5)
    eye.acceptance_angle_rad[i] = static_cast<float>(60 * degree);
  return eye;
}

// 8 x 8,192 own rays: their error is 2e-4.
std::vector<double> truth(const Scene& scene, const Eye& eye, RenderSettings settings) {
  settings.sampling = Fixed{8192};
  settings.seed = 99;
  settings.noise = Noise::new_every_frame;
  const std::vector<Mat4> poses(8);
  const Result result = render(make_renderer(scene, eye, settings), poses);
  std::vector<double> mean(eye.size() * rgb_bands);
  for (std::size_t i = 0; i < result.response.size(); ++i)
    mean[i % mean.size()] += result.response[i] / static_cast<double>(poses.size());
  return mean;
}

// What many seeds came to, against the truth.
struct Outcome {
  double rms = 0;
  double beyond_four = 0;  // share of means further off than four standard errors and `bias`
  double within_two = 0;   // share of responses within two reported standard errors
};

Outcome measure(const Scene& scene, const Eye& eye, const RenderSettings& settings, int seeds,
                double bias, bool with_error = false) {
  const std::vector<double> expected = truth(scene, eye, settings);
  const std::size_t values = expected.size();
  const Renderer built = make_renderer(scene, eye, settings);
  std::vector<double> sum(values), squares(values);
  Outcome o;
  const double n = seeds, count = static_cast<double>(values);
  const Mat4 pose;
  for (int seed = 0; seed < seeds; ++seed) {
    RenderSettings s = settings;
    s.seed = static_cast<std::uint64_t>(seed);
    const Result r = render(Renderer(built, eye, s), std::span(&pose, 1), with_error);
    for (std::size_t i = 0; i < values; ++i) {
      const double e = r.response[i] - expected[i];
      sum[i] += e, squares[i] += e * e;
      // The reference and floats leave errors of 1e-5, where a standard error may be 0.
      if (with_error) o.within_two += std::fabs(e) <= 2 * r.standard_error[i] + 1e-5;
    }
  }
  o.within_two /= n * count;
  for (std::size_t i = 0; i < values; ++i) {
    o.rms += squares[i] / n / count;
    const double mean = sum[i] / n;
    const double variance = std::max(0.0, squares[i] / n - mean * mean) / (n - 1) + 4e-8;
    o.beyond_four += std::fabs(mean) > 4 * std::sqrt(variance) + bias ? 1 / count : 0;
  }
  o.rms = std::sqrt(o.rms);
  return o;
}

TEST(SharedRaysRender, ConstantSurroundIsOne) {
  Scene scene;
  scene.background = constant_background({1, 1, 1});
  for (const Eye& eye : {all_round(), mixed_eye(), make_eye(Vec3d{0, 1, 0}, 3 * degree),
                         all_round(0), all_round(1 * degree), all_round(1e-20)})
    for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox})
      for (const int samples : {1, 6, 20})
        for (const float r : render(scene, eye, shared(samples, 2, kernel)).response)
          ASSERT_NEAR(r, 1, 1e-6);
}

struct Case {
  std::string name;
  Scene (*scene)();
  Eye (*eye)();
  Kernel kernel;
};

class SharedRaysBias : public testing::TestWithParam<Case> {};

// Beyond four standard deviations a Gaussian's rays are left out: 0.0003 of its weight, and as much
// of the response at most where radiance is 0 to 1. Four standard errors are exceeded by 1e-4 of
// means by chance (100 seeds), and with the means of neighbours go together: a hundred times that
// is allowed. A lattice that leaves out a part of somebody's field is off by tens of them.
TEST_P(SharedRaysBias, IsNoneOverSeeds) {
  const Case& c = GetParam();
  const double truncated = c.kernel == Kernel::gaussian ? 0.0003 : 0;
  const Outcome o = measure(c.scene(), c.eye(), shared(8, 0, c.kernel), 100, truncated);
  EXPECT_LT(o.beyond_four, 0.01);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SharedRaysBias,
    testing::Values(Case{"edges", clutter, [] { return all_round(); }, Kernel::gaussian},
                    Case{"edges_pillbox", clutter, [] { return all_round(); }, Kernel::pillbox},
                    Case{"smooth", smooth_scene, [] { return all_round(); }, Kernel::gaussian},
                    Case{"mixed_eye", clutter, mixed_eye, Kernel::gaussian},
                    Case{"mixed_eye_pillbox", clutter, mixed_eye, Kernel::pillbox}),
    [](const auto& parameter) { return parameter.param.name; });

// At edges, with fields that overlap about as much as a honeybee's, by a factor of 5 to 6.
TEST(SharedRaysRender, ErrorIsFarBelowThatOfOwnRays) {
  for (const int samples : {2, 8}) {
    RenderSettings own = shared(samples);
    own.sampling = Fixed{samples};
    const double with = measure(clutter(), all_round(), shared(samples), 16, 0).rms;
    const double without = measure(clutter(), all_round(), own, 16, 0).rms;
    EXPECT_LT(with, without / 3);
  }
}

// Fields that hardly overlap: nobody is made worse than with rays of its own.
TEST(SharedRaysRender, ErrorDoesNotGrowWhereFieldsDoNotOverlap) {
  const Eye eye = all_round(5 * degree);
  for (const int samples : {16, 64}) {
    RenderSettings own = shared(samples);
    own.sampling = Fixed{samples};
    const double with = measure(clutter(), eye, shared(samples), 8, 0).rms;
    const double without = measure(clutter(), eye, own, 8, 0).rms;
    // Two samples of 6,000 errors that the same distribution has, each rms within 2 %.
    EXPECT_LT(with, 1.05 * without) << samples;
  }
}

// A mean of 8 sets has 7 degrees of freedom: two standard errors hold 91.4 % of a normal variable.
TEST(SharedRaysRender, StandardErrorsAreTrue) {
  const Outcome o = measure(clutter(), all_round(), shared(4), 60, 0, true);
  EXPECT_GT(o.within_two, 0.90);
  EXPECT_LT(o.within_two, 0.97);
}

// --- Gratings of `cycles` round the horizon, seen by those that look at it.
double measured_modulation(const Eye& eye, std::span<const std::size_t> looking,
                           RenderSettings settings, int cycles) {
  constexpr int pixels = 32768;
  Scene scene;
  scene.background = image_background(make_image(pixels, 1, [&](int column, int) {
    const double azimuth = (column + 0.5) * 2 * pi / pixels - pi;
    const auto value = static_cast<float>(0.5 + 0.5 * std::cos(cycles * azimuth));
    return Vec4{value, value, value, 1};
  }));
  const Renderer built = make_renderer(scene, eye, settings);
  constexpr int seeds = 8;
  const Mat4 pose;
  double modulation = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    settings.seed = static_cast<std::uint64_t>(seed);
    const Result result = render(Renderer(built, eye, settings), std::span(&pose, 1));
    for (const std::size_t i : looking) {
      const double azimuth = std::atan2(eye.axis[i].x, -eye.axis[i].z);
      modulation += 4 * (result.at(i) - 0.5) * std::cos(cycles * azimuth) /
                    static_cast<double>(looking.size() * seeds);
    }
  }
  return modulation;
}

double law(Kernel kernel, double cycles_per_width) {
  if (kernel == Kernel::gaussian) return std::exp(-3.5597 * cycles_per_width * cycles_per_width);
  const double x = pi * cycles_per_width;
  return 2 * std::cyl_bessel_j(1.0, x) / x;
}

// Rows along the horizon, 3 degrees apart, of 4 degrees acceptance; with others of 14 degrees
// between them, which many of the rays then start at, and with textures from coarser levels. The
// laws are those of a plane: 0.0004 less of a period at 2 degrees from the horizon is 0.0003 of
// modulation, as are the tails left out. A pillbox ends sharply: how many rays it holds varies, and
// those near its rim come in greater company, so that it is noisier, and biased by 0.015 at 2
// samples and 0.002 at 8. Where textures are read from coarser levels 0.008 is added
// (physics/surface/footprint.h).
TEST(SharedRaysRender, GratingsFollowEachKernelsLaw) {
  for (const bool with_wide : {false, true}) {
    std::vector<Vec3d> axes;
    std::vector<std::size_t> looking;
    for (int row = -4; row <= 4; ++row)
      for (int column = 0; column < 120; ++column) {
        if (row == 0) looking.push_back(axes.size());
        axes.push_back(from_azimuth_elevation((3 * column - 180) * degree, 3 * row * degree));
      }
    const std::size_t narrow = axes.size();
    for (int column = 0; with_wide && column < 120; ++column)
      axes.push_back(from_azimuth_elevation((3 * column + 1) * degree, 1 * degree));
    Eye eye = make_eye(axes, 4 * degree);
    for (std::size_t i = narrow; i < eye.size(); ++i)
      eye.acceptance_angle_rad[i] = static_cast<float>(14 * degree);
    for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox})
      for (const int cycles : {22, 45, 68}) {
        const double alone = kernel == Kernel::gaussian ? 0.001 : 0.005;
        RenderSettings settings = shared(kernel == Kernel::gaussian ? 8 : 32, 0, kernel);
        settings.footprints = with_wide;
        EXPECT_NEAR(measured_modulation(eye, looking, settings, cycles),
                    law(kernel, cycles * 4 / 360.0), with_wide ? 0.01 : alone)
            << name_of(kernel) << ' ' << cycles << " cycles" << (with_wide ? ", wide ones" : "");
      }
  }
}

// --- Nodal points.
TEST(SharedRaysRender, FocalOffsetsMoveTheStartBack) {
  const Eye centre = all_round();
  Eye outside = centre;
  for (std::size_t i = 0; i < outside.size(); ++i) {
    outside.position_m[i] = outside.axis[i] * 0.001f;
    outside.focal_offset_m[i] = 0.001f;
  }
  const Result a = render(clutter(), centre, shared(8)), b = render(clutter(), outside, shared(8));
  // The same rays but for 1e-10 m, so that one in a million hits another triangle.
  int other = 0;
  for (std::size_t i = 0; i < a.response.size(); ++i)
    other += std::fabs(a.response[i] - b.response[i]) > 1e-5f ? 1 : 0;
  EXPECT_LE(other, 3);
}

// A ray starts at the ommatidium that looks its way, so on an eye of radius R things at a distance
// d from its surface are seen as from the centre: by an acceptance function (1 + R/d) times as
// wide. An edge is then seen wrong by up to max(u phi(u)) R/d = 0.242 R/d.
TEST(SharedRaysRender, ParallaxWidensTheFieldOfWhatIsNear) {
  const double radius = 0.0015;
  std::vector<Vec3d> axes;
  for (const Vec3d axis : sphere_directions(2400))
    if (axis.z < -0.5) axes.push_back(axis);
  Eye eye = make_eye(axes, 12 * degree);
  for (std::size_t i = 0; i < eye.size(); ++i)
    eye.position_m[i] = eye.axis[i] * static_cast<float>(radius);
  // Facets are 4 degrees, 0.11 mm apart: a wall with an edge 20 of them away, and 10 and 100 times
  // as far.
  const double facet = radius * std::sqrt(4 * pi / 2400);
  for (const double facets : {20.0, 200.0, 2000.0}) {
    const double distance = facets * facet;
    Scene scene;
    add_quad(scene, {100 * distance, 0, -radius - distance}, {100 * distance, 0, 0},
             {0, 100 * distance, 0}, add_color(scene, {1, 1, 1}));
    const std::vector<double> exact = truth(scene, eye, shared(1));
    std::vector<double> mean(exact.size());
    constexpr int seeds = 8;
    for (int seed = 0; seed < seeds; ++seed) {
      const Result r = render(scene, eye, shared(64, static_cast<std::uint64_t>(seed)));
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += r.response[i] / seeds;
    }
    double most = 0;
    for (std::size_t i = 0; i < mean.size(); ++i)
      if (eye.axis[i / rgb_bands].z < -0.8)
        most = std::max(most, std::fabs(mean[i] - exact[i]));
    const double bound = 0.242 * radius / distance;
    // The largest of 500 with noise of 0.0006 left.
    EXPECT_LT(most, bound + 0.002);
    if (facets < 1000) {
      EXPECT_GT(most, 0.5 * bound);
    }
  }
}

// --- The same bits.

TEST(SharedRaysRender, SameBitsForAnyThreadsAndPieces) {
  const Scene scene = random_scene(4);
  const std::vector<Mat4> poses = turning_poses(17);
  RenderSettings settings = shared(3);
  settings.threads = 1;
  const Renderer one = make_renderer(scene, mixed_eye(), settings);
  const Result expected = render(one, poses, true);
  const std::vector<float> plain = render(one, poses).response;
  for (const int threads : {2, 7}) {
    settings.threads = threads;
    const Renderer more = make_renderer(scene, mixed_eye(), settings);
    const Result result = render(more, poses, true);
    EXPECT_TRUE(same_bits(result.response, expected.response)) << threads;
    EXPECT_TRUE(same_bits(result.standard_error, expected.standard_error)) << threads;
    std::vector<float> pieces;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      const Result piece = render(more, std::span(poses).subspan(p, 1), false, p);
      pieces.insert(pieces.end(), piece.response.begin(), piece.response.end());
    }
    EXPECT_TRUE(same_bits(pieces, plain)) << threads;
  }
}

// Calls from several threads take up each other's work while they wait; they must not take each
// other's room, nor a lock that is held.
TEST(SharedRaysRender, SameBitsFromSeveralCallersAtOnce) {
  const std::vector<Mat4> poses = turning_poses(6);
  RenderSettings settings = shared(2);
  settings.threads = 3;
  const Scene scene = random_scene(5);
  const Renderer alone = make_renderer(scene, all_round(), settings);
  const Result expected = render(alone, poses), with_error = render(alone, poses, true);
  for (int round = 0; round < 10; ++round) {
    const Renderer renderer(alone, all_round(), settings);
    std::array<Result, 6> results;
    std::vector<std::thread> callers;
    for (std::size_t k = 0; k < results.size(); ++k)
      callers.emplace_back([&, k] {
        for (std::size_t p = 0; p < poses.size(); ++p) {
          const std::size_t count = k < 3 ? 1 : poses.size();
          results[k] = render(renderer, std::span(poses).subspan(k < 3 ? p : 0, count), k % 3 == 2,
                              k < 3 ? p : 0);
        }
      });
    for (std::thread& caller : callers) caller.join();
    for (std::size_t k = 0; k < results.size(); ++k) {
      const std::vector<float>& all = (k % 3 == 2 ? with_error : expected).response;
      const auto size = static_cast<std::ptrdiff_t>(results[k].response.size());
      EXPECT_TRUE(same_bits(results[k].response, {all.end() - size, all.end()})) << k;
    }
  }
}

TEST(SharedRaysRender, CountsTheRaysOfEachResponse) {
  const Eye eye = all_round();
  const Renderer renderer = make_renderer(clutter(), eye, shared(4));
  EXPECT_NEAR(static_cast<double>(renderer.rays_per_frame()) / (4.0 * 250), 1, 0.1);
  const std::vector<Mat4> poses(2);
  std::vector<float> responses(2 * eye.size() * rgb_bands), errors(responses.size());
  std::vector<std::int32_t> rays(2 * eye.size(), -1);
  RenderCall call;
  call.rays = rays;
  renderer.render(poses, responses, call);
  const std::vector<char> sharing = renderer.shared_ommatidia();
  EXPECT_EQ(std::count(sharing.begin(), sharing.end(), 1), 250);
  const std::vector<char> none = Renderer(renderer, eye, RenderSettings{}).shared_ommatidia();
  EXPECT_EQ(std::count(none.begin(), none.end(), 0), 250);
  double one_set = 0;
  for (const std::int32_t n : rays) {
    EXPECT_GT(n, 4 * 4);  // its own and those of at least its six neighbours in part
    one_set += n;
  }
  call.standard_error = errors;
  renderer.render(poses, responses, call);
  double all_sets = 0;
  for (const std::int32_t n : rays) all_sets += n;
  EXPECT_NEAR(all_sets / one_set, error_scrambles, 0.1);
}

// --- What is refused.
std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SharedRaysRender, RefusesWhatItCannotDo) {
  const Eye eye = all_round();
  const auto refused = [&](const RenderSettings& settings) {
    return refusal([&] { make_renderer(clutter(), eye, settings); });
  };
  EXPECT_EQ(refused(shared(8, 0, Kernel::compoundray)).rfind("sampling: Shared, not with", 0), 0u);
  RenderSettings random = shared(8);
  random.points = Points::random;
  EXPECT_EQ(refused(random), "sampling: Shared, not with random points");
  for (const int samples : {0, max_shared_samples + 1})
    EXPECT_EQ(refused(shared(samples)),
              "sampling: Shared expects 1 to 256 samples, found " + std::to_string(samples));
  EXPECT_EQ(refused(shared(max_shared_samples)), "");
  const Renderer renderer = make_renderer(clutter(), eye, shared(1));
  std::vector<float> responses(eye.size() * rgb_bands), rays(responses.size());
  RenderCall call;
  call.ray_radiance = rays;
  const Mat4 pose;
  EXPECT_EQ(refusal([&] {
              renderer.render(std::span(&pose, 1), responses, call);
            }).rfind("ray_radiance:", 0),
            0u);
}

}  // namespace
}  // namespace omma::test
