// Eyes whose ommatidia differ: each is rendered with its own sensitivity, turned as its up vector
// says, from all over its aperture.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "omma/error.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

Acceptance of_kernel(Kernel kernel) {
  Acceptance acceptance;
  acceptance.kernel = kernel;
  acceptance.width_rad = 0.05;
  acceptance.facet_diameter_m = 20e-6;
  acceptance.wavelength_nm = 500;
  acceptance.focal_length_m = 50e-6;
  acceptance.rhabdom_diameter_m = 1.9e-6;
  if (kernel == Kernel::table) {
    auto table = std::make_shared<SensitivityTable>();
    table->right_rad = {0, 0.02, 0.04};
    table->sensitivity = {1, 0.6, 0};
    acceptance.table = table;
  }
  return acceptance;
}

Acceptance ellipse(double major_angle_rad) {
  Acceptance acceptance;
  acceptance.width_rad = 0.4;
  acceptance.minor_width_rad = 0.05;
  acceptance.major_angle_rad = major_angle_rad;
  return acceptance;
}

std::vector<Acceptance> all_kinds() {
  std::vector<Acceptance> all;
  for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox, Kernel::compoundray, Kernel::airy,
                              Kernel::lens_rhabdom, Kernel::table})
    all.push_back(of_kernel(kernel));
  all.push_back(ellipse(0.7));
  return all;
}

Eye eye_of(const std::vector<Acceptance>& acceptances) {
  Eye eye = make_eye({0.3, 0.1, -1}, 0, acceptances.size());
  eye.acceptances = acceptances;
  eye.acceptance_of.clear();
  for (std::size_t i = 0; i < acceptances.size(); ++i)
    eye.acceptance_of.push_back(static_cast<std::int32_t>(i));
  return eye;
}

// The same ommatidia, all with one of the sensitivities: ommatidium k is the same in both.
TEST(MixedEyes, EachOmmatidiumIsRenderedAsInAnEyeOfItsKind) {
  const Scene scene = flat_triangles(3, 300);
  const std::vector<Acceptance> kinds = all_kinds();
  for (const Points points : {Points::low_discrepancy, Points::random})
    for (const int samples : {1, 16, 50}) {
      RenderSettings settings;
      settings.sampling = Fixed{samples};
      settings.points = points;
      const std::vector<Mat4> poses = turning_poses(2);
      const Renderer mixed = make_renderer(scene, eye_of(kinds), settings);
      const std::vector<float> together = render(mixed, poses).response;
      for (std::size_t k = 0; k < kinds.size(); ++k) {
        // Random directions come from tables of a whole eye: where some are not round, those of
        // round ones have their azimuths counted from elsewhere.
        if (points == Points::random && is_round(kinds[k])) continue;
        const Eye same = eye_of(std::vector<Acceptance>(kinds.size(), kinds[k]));
        const std::vector<float> alone =
            render(make_renderer(scene, same, settings), poses).response;
        for (std::size_t p = 0; p < poses.size(); ++p)
          for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t at = (p * kinds.size() + k) * 3 + c;
            EXPECT_EQ(together[at], alone[at]) << k << ' ' << samples << ' ' << name_of(points);
          }
      }
    }
}

TEST(MixedEyes, AKernelInTheSettingsIsForAll) {
  const Scene scene = flat_triangles(4, 300);
  const Eye mixed = eye_of(all_kinds());
  RenderSettings settings;
  settings.kernel = Kernel::pillbox;
  const Renderer renderer = make_renderer(scene, mixed, settings);
  Eye plain = renderer.eye();  // whose acceptance angles are the mean widths
  plain.acceptances.clear();
  plain.acceptance_of.clear();
  const Mat4 pose;
  EXPECT_TRUE(same_bits(render(renderer, std::span(&pose, 1)).response,
                        render(scene, plain, settings).response));
  settings.kernel = Kernel::airy;
  EXPECT_THROW(make_renderer(scene, mixed, settings), Error);
}

// White to the right of the axis's vertical plane x = tan(edge), black to its left.
Background half_white(double edge_rad) {
  return image_background(make_image(4096, 8, [&](int column, int) -> Vec4 {
    const double azimuth = ((column + 0.5) / 4096 - 0.5) * 2 * pi;
    return azimuth > edge_rad ? Vec4{1, 1, 1, 1} : Vec4{0, 0, 0, 1};
  }));
}

// Seen across, a Gaussian's response to an edge at distance x is erfc(x / (sqrt 2 sigma)) / 2 with
// the sigma of that direction; to 1 % for the sphere (the widths are small) and for the image's
// columns of 0.09 degrees. With the major axis up, as the up vector has it, the edge is seen
// through the minor axis.
TEST(EllipticalAcceptance, TurnsWithTheUpVector) {
  const double sigma_major = 0.4 * 0.42466, sigma_minor = 0.05 * 0.42466, x = 0.03;
  const auto expected = [&](double sigma) { return 0.5 * std::erfc(x / (std::sqrt(2) * sigma)); };
  Scene scene;
  scene.background = half_white(x);
  RenderSettings settings;
  settings.sampling = Fixed{1 << 14};
  settings.footprints = false;
  const auto response = [&](double major_angle_rad, Vec3 up) {
    Eye eye = make_eye({0, 0, -1}, 0);
    eye.acceptances = {ellipse(major_angle_rad)};
    eye.acceptance_of = {0};
    eye.up = {up};
    return render(scene, eye, settings).response[0];
  };
  EXPECT_NEAR(response(0, {0, 1, 0}), expected(sigma_minor), 0.004);
  EXPECT_NEAR(response(pi / 2, {0, 1, 0}), expected(sigma_major), 0.004);
  EXPECT_NEAR(response(0, {1, 0, 0}), expected(sigma_major), 0.004);
  // Half way, the spread across the edge is the root of the mean of the squares.
  const double between = std::sqrt((sigma_major * sigma_major + sigma_minor * sigma_minor) / 2);
  EXPECT_NEAR(response(pi / 4, {0, 1, 0}), expected(between), 0.004);
}

// An ellipse leaning to the right sees more of a wedge up right than of one up left; mirrored in
// the middle plane it is the other way round.
TEST(EllipticalAcceptance, LeansToTheRightOfUp) {
  Scene scene;
  scene.background = image_background(make_image(2048, 1024, [](int column, int row) -> Vec4 {
    const double right = (column + 0.5) / 2048 - 0.5, up = 0.25 - (row + 0.5) / 2048;
    return right > 0 && up > 0   ? Vec4{1, 0, 0, 1}
           : right < 0 && up > 0 ? Vec4{0, 1, 0, 1}
                                 : Vec4{0, 0, 0, 1};
  }));
  Eye eye = make_eye({0, 0, -1}, 0);
  eye.acceptances = {ellipse(pi / 4)};
  eye.acceptance_of = {0};
  RenderSettings settings;
  settings.sampling = Fixed{4096};
  const std::vector<float> response = render(scene, eye, settings).response;
  EXPECT_GT(response[0], 0.4f);
  EXPECT_LT(response[1], 0.1f);
  PlacedEye placed{eye, {}};
  placed.head_from_eye.m[0][0] = -1;
  const std::vector<float> mirrored =
      render(scene, merge_eyes(std::span(&placed, 1)), settings).response;
  EXPECT_LT(mirrored[0], 0.1f);
  EXPECT_GT(mirrored[1], 0.4f);
}

// With more than 64 widths, nearby ones share a warp that is scaled; the patterns are the same, so
// all that differs from an exact warp is S, by under 1e-4 (sampling/directions.cpp). The surround's
// frequency is such that a width wrong by 0.1 % would change the response by 3e-4 or more at the
// middle widths.
TEST(ManyWidths, AreAsIfEachHadItsOwnWarp) {
  constexpr int count = 300;
  Scene scene;
  scene.background = image_background(make_image(4096, 16, [](int column, int) -> Vec4 {
    const double azimuth = ((column + 0.5) / 4096 - 0.5) * 2 * pi;
    const float bright = static_cast<float>(0.5 + 0.5 * std::cos(12 * azimuth));
    return {bright, bright, bright, 1};
  }));
  Eye eye = make_eye({0, 0, -1}, 0, count);
  for (std::size_t i = 0; i < count; ++i)
    eye.acceptance_angle_rad[i] = static_cast<float>(0.02 + 0.16 * static_cast<double>(i) / count);
  for (const Points points : {Points::low_discrepancy, Points::random}) {
    RenderSettings settings;
    settings.sampling = Fixed{64};
    settings.footprints = false;
    settings.points = points;
    const std::vector<float> together = render(scene, eye, settings).response;
    double worst = 0, mean_change = 0;
    for (std::size_t i = 0; i < count; i += 7) {
      Eye same = eye;
      same.acceptance_angle_rad.assign(count, eye.acceptance_angle_rad[i]);
      const float alone = render(scene, same, settings).response[3 * i];
      worst = std::max(worst, std::fabs(static_cast<double>(together[3 * i]) - alone));
      for (float& angle : same.acceptance_angle_rad) angle *= 1.001f;
      const float wider = render(scene, same, settings).response[3 * i];
      mean_change += std::fabs(static_cast<double>(wider) - alone) / (count / 7 + 1);
    }
    EXPECT_LT(worst, 3e-5) << name_of(points);
    EXPECT_GT(mean_change, 1e-4) << name_of(points);  // the test can see a wrong scale
  }
}

// A bright wall whose edge, seen straight ahead, runs at x across an aperture of radius 1 m: what
// is seen of it is the share of the disc beyond the edge, (acos(x) - x sqrt(1 - x^2)) / pi. The
// lattice of points on the disc leaves an error of about samples^-0.75.
TEST(Aperture, RaysStartAllOverTheDisc) {
  Scene scene;
  const int white = add_color(scene, {1, 1, 1});
  const double x = 0.35;
  add_quad(scene, {x + 10, 0, -5}, {10, 0, 0}, {0, 10, 0}, white);
  Eye eye = make_eye({0, 0, -1}, 0, 3);
  eye.aperture_diameter_m = {2, 0, 1};
  eye.position_m[1] = {static_cast<float>(x) + 0.01f, 0, 0};
  const double seen = (std::acos(x) - x * std::sqrt(1 - x * x)) / pi;
  const double seen_half = (std::acos(2 * x) - 2 * x * std::sqrt(1 - 4 * x * x)) / pi;
  for (const Points points : {Points::low_discrepancy, Points::random}) {
    RenderSettings settings;
    settings.sampling = Fixed{4096};
    settings.points = points;
    const Result result = render(scene, eye, settings);
    EXPECT_NEAR(result.response[0], seen, 0.01) << name_of(points);
    EXPECT_EQ(result.response[3], 1);
    EXPECT_NEAR(result.response[6], seen_half, 0.01) << name_of(points);
    // A pose that scales the eye scales its aperture.
    const Mat4 larger = scaling({2, 2, 2});
    const Result scaled = render(make_renderer(scene, eye, settings), std::span(&larger, 1));
    EXPECT_NEAR(scaled.response[6], seen, 0.01) << name_of(points);
  }
}

// Where in the disc a ray starts has nothing to do with where it looks: a wall near by, half of it
// white, is seen through a wide aperture as the mean over all starting points of what each sees.
TEST(Aperture, StartsAndDirectionsAreIndependent) {
  Scene scene;
  const int white = add_color(scene, {1, 1, 1});
  add_quad(scene, {5.1, 0, -1}, {5, 0, 0}, {0, 10, 0}, white);  // from x = 0.1 on, 1 m ahead
  Eye eye = make_eye({0, 0, -1}, 0.3, 64);
  eye.aperture_diameter_m.assign(64, 0.4f);
  RenderSettings settings;
  settings.sampling = Fixed{1024};
  double mean = 0;
  const std::vector<float> response = render(scene, eye, settings).response;
  for (std::size_t i = 0; i < 64; ++i) mean += response[3 * i] / 64.0;
  // The same by brute force: starts on a fine grid of the disc, directions on a fine grid of
  // angles.
  double sum = 0, weights = 0;
  for (int i = 0; i < 60; ++i) {
    const double start = (i + 0.5) / 60 * 0.4 - 0.2;
    const double across = std::sqrt(0.04 - start * start);  // of the disc's chord
    for (int j = -400; j <= 400; ++j)
      for (int k = -100; k <= 100; k += 4) {
        const double right = j * 0.001, up = k * 0.006;
        const double theta = std::acos(std::cos(up) * std::cos(right));
        const double weight =
            across * std::exp(-4 * std::log(2) * theta * theta / 0.09) * std::cos(up);
        weights += weight;
        if (start + std::tan(right) > 0.1) sum += weight;
      }
  }
  EXPECT_NEAR(mean, sum / weights, 0.003);
}

TEST(SharedRays, RefuseWhatNeighboursCannotShare) {
  const Scene scene = flat_triangles(3, 30);
  RenderSettings settings;
  settings.sampling = Shared{};
  const auto message = [&](const Eye& eye) -> std::string {
    try {
      make_renderer(scene, eye, settings);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(eye_of({ellipse(0)})).find("not round"), std::string::npos);
  EXPECT_NE(message(eye_of({of_kernel(Kernel::compoundray)})).find("compoundray"),
            std::string::npos);
  Eye wide = make_eye({0, 0, -1}, 0.1);
  wide.aperture_diameter_m = {1e-3f};
  EXPECT_NE(message(wide).find("aperture"), std::string::npos);
  EXPECT_EQ(message(eye_of({of_kernel(Kernel::lens_rhabdom), of_kernel(Kernel::table)})), "");
}

}  // namespace
}  // namespace omma::test
