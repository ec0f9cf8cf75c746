// The same inputs and seed give the same bits, however the work is cut up; other seeds, poses and
// ommatidia give other samples.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "test_scenes.h"

namespace omma::test {
namespace {

// An odd number of ommatidia, positions and angles that differ.
Eye varied_eye(int ommatidia) {
  Eye eye = make_eye(sphere_directions(ommatidia), 10 * degree);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    eye.acceptance_angle_rad[i] = static_cast<float>((3 + static_cast<double>(i % 7)) * degree);
    eye.position_m[i] = eye.axis[i] * 0.05f;
  }
  return eye;
}

class Determinism : public testing::TestWithParam<Points> {};

TEST_P(Determinism, AnyNumberOfThreads) {
  const Scene scene = random_scene(4);
  const std::vector<Mat4> poses = turning_poses(5);
  for (const int samples : {1, 7, 16, 100}) {
    const auto with_threads = [&](int threads) {
      return render(
          make_renderer(scene, varied_eye(331), {Fixed{samples}, 9, {}, GetParam(), threads}),
          poses, true);
    };
    const Result one = with_threads(1);
    for (const int threads : {2, 7}) {
      const Result more = with_threads(threads);
      EXPECT_TRUE(same_bits(one.response, more.response)) << threads << " threads";
      EXPECT_TRUE(same_bits(one.standard_error, more.standard_error)) << threads << " threads";
    }
  }
}

TEST_P(Determinism, PosesInPieces) {
  const std::vector<Mat4> poses = turning_poses(7);
  RenderSettings settings{Fixed{16}, 9, {}, GetParam()};
  settings.noise = Noise::new_every_frame;
  const Renderer renderer = make_renderer(random_scene(5), varied_eye(101), settings);
  const Result whole = render(renderer, poses);
  std::vector<float> pieces;
  std::size_t first = 0;
  for (const std::size_t count : {2u, 1u, 4u}) {
    const Result piece = render(renderer, std::span(poses).subspan(first, count), false, first);
    pieces.insert(pieces.end(), piece.response.begin(), piece.response.end());
    first += count;
  }
  EXPECT_TRUE(same_bits(whole.response, pieces));
}

// Samples belong to (seed, pose, ommatidium): another of any gives other responses almost wherever
// the scene varies.
TEST_P(Determinism, SeedsPosesAndOmmatidiaDiffer) {
  const Scene scene = random_scene(6);
  const std::vector<Mat4> poses(2);
  Eye eye = make_eye(normalize(Vec3d{0.3, 0.2, -1}), 60 * degree, 400);
  const auto with_seed = [&](std::uint64_t seed) {
    RenderSettings settings{Fixed{16}, seed, {}, GetParam()};
    settings.noise = Noise::new_every_frame;
    return render(make_renderer(scene, eye, settings), poses).response;
  };
  const std::vector<float> a = with_seed(1), b = with_seed(2), again = with_seed(1);
  EXPECT_TRUE(same_bits(a, again));
  const std::size_t pose_size = a.size() / 2;
  int same_seed = 0, same_pose = 0, same_neighbour = 0;
  for (std::size_t i = 0; i + rgb_bands < pose_size; i += rgb_bands) {
    same_seed += a[i] == b[i] ? 1 : 0;
    same_pose += a[i] == a[pose_size + i] ? 1 : 0;
    same_neighbour += a[i] == a[i + rgb_bands] ? 1 : 0;
  }
  EXPECT_LT(same_seed, 8);
  EXPECT_LT(same_pose, 8);
  EXPECT_LT(same_neighbour, 8);
}

// An ommatidium's samples do not depend on who else is in the eye, where its acceptance angle stays
// one of theirs.
TEST_P(Determinism, FirstOmmatidiaOfAnEyeAreTheSameAlone) {
  const Scene scene = random_scene(7);
  const Eye whole = varied_eye(203);
  std::vector<std::int64_t> first(50);
  std::iota(first.begin(), first.end(), 0);
  const Eye part = take_ommatidia(whole, first);
  const RenderSettings settings{Fixed{16}, 3, {}, GetParam()};
  Result all = render(scene, whole, settings);
  all.response.resize(50 * rgb_bands);
  EXPECT_TRUE(same_bits(all.response, render(scene, part, settings).response));
}

INSTANTIATE_TEST_SUITE_P(Samplings, Determinism,
                         testing::Values(Points::low_discrepancy, Points::random),
                         [](const auto& parameter) { return name_of(parameter.param); });

std::uint64_t fnv1a(const std::vector<float>& values) {
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const float value : values) {
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001B3u;
  }
  return hash;
}

// Colours are whole eighths, so that sums are exact and the last bits of a hit's place, which
// differ between vector instruction sets, do not show. This hash changes when sampling or the rules
// of shading do: say so in CHANGELOG.md and put the new one here.
TEST(Golden, FlatTriangles) {
  const Result result = render(flat_triangles(31, 60), make_eye(sphere_directions(97), 8 * degree),
                               {Fixed{16}, 12345});
  EXPECT_EQ(fnv1a(result.response), 0x9626E2F7E8A2DAEDu);
}

}  // namespace
}  // namespace omma::test
