// Gaussian splats in memory: sizes, numbers and transforms that the physics trusts.
#include "model/splat_check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "model/pose_check.h"
#include "model/scene_place.h"
#include "omma/error.h"

namespace omma {
namespace {

// Whitened offsets, and their squares, stay in single precision: splats may be this small and
// large, and lie this far away.
constexpr float least_scale_m = 1e-12f, most_scale_m = 1e6f, most_position_m = 1e6f;
// As large as splats may then be, boxes around them stay in single precision.
constexpr double most_stretched = 1e12;
// A colour of 1 is full scale.
constexpr float most_harmonic = 1e4f, most_white = 1e9f;
constexpr double least_band_nm = 100, most_band_nm = 10000;
// Quaternions are turns to about single precision.
constexpr double off_unit = 1e-4;

bool within(Vec3 v, float most) {
  return std::fabs(v.x) <= most && std::fabs(v.y) <= most && std::fabs(v.z) <= most;
}

void check_size(std::size_t size, std::size_t expected, const std::string& place,
                const char* what) {
  if (size != expected)
    throw Error(place + ": has " + std::to_string(size) + " " + what + ", expected " +
                std::to_string(expected));
}

void check_splat(const SplatCloud& cloud, std::size_t i, const std::string& place) {
  const auto refuse = [&](const char* what) {
    throw Error(place + ": splat " + std::to_string(i) + ": " + what);
  };
  if (!within(cloud.positions[i], most_position_m))
    refuse("expected a position within 1e6 m, of finite numbers");
  const Vec3 s = cloud.scales[i];
  if (!(std::min({s.x, s.y, s.z}) >= least_scale_m && std::max({s.x, s.y, s.z}) <= most_scale_m))
    refuse("expected scales from 1e-12 to 1e6 m");
  const Vec4 q = cloud.rotations[i];
  const double square = static_cast<double>(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!(std::fabs(square - 1) <= 2 * off_unit)) refuse("expected a rotation of length 1");
  if (!(cloud.opacities[i] >= 0 && cloud.opacities[i] <= 1))
    refuse("expected an opacity from 0 to 1");
}

void check_bands(const SplatCloud& cloud, const std::string& place) {
  if (cloud.bands_nm.empty()) return;
  const std::size_t count = cloud.bands_nm.size();
  if (count < 3 || count > most_splat_channels)
    throw Error(place + ": expected 3 to " + std::to_string(most_splat_channels) +
                " channels, found bands_nm of " + std::to_string(count));
  for (std::size_t c = 0; c < count; ++c) {
    const auto [from_nm, to_nm] = cloud.bands_nm[c];
    if (!(from_nm >= least_band_nm && to_nm > from_nm && to_nm <= most_band_nm))
      throw Error(place + ": bands_nm " + std::to_string(c) +
                  ": expected a band from 100 to 10,000 nm, its lower end first");
  }
}

void check_cloud(const SplatCloud& cloud, const std::string& place) {
  const std::size_t count = cloud.positions.size();
  check_size(cloud.scales.size(), count, place, "scales");
  check_size(cloud.rotations.size(), count, place, "rotations");
  check_size(cloud.opacities.size(), count, place, "opacities");
  if (cloud.terms != 1 && cloud.terms != 4 && cloud.terms != 9 && cloud.terms != 16)
    throw Error(place + ": expected harmonics of 1, 4, 9 or 16 terms (degree 0 to 3), found " +
                std::to_string(cloud.terms));
  check_bands(cloud, place);
  const std::size_t channels = channels_of(cloud);
  const std::size_t numbers = channels * static_cast<std::size_t>(cloud.terms);
  check_size(cloud.harmonics.size(), numbers * count, place, "numbers of harmonics");
  for (std::size_t i = 0; i < count; ++i) check_splat(cloud, i, place);
  for (std::size_t i = 0; i < cloud.harmonics.size(); ++i)
    if (!(std::fabs(cloud.harmonics[i]) <= most_harmonic))
      throw Error(place + ": splat " + std::to_string(i / numbers) +
                  ": expected harmonics of at most 1e4, of finite numbers");
  check_size(cloud.white.size(), channels, place, "numbers of white");
  for (const float w : cloud.white)
    if (!(w > 0 && w <= most_white))
      throw Error(place + ": expected a white above 0 of at most 1e9");
  const Mat4& t = cloud.world_from_splats;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c)
      if (!std::isfinite(t.m[r][c])) throw Error(place + ": world_from_splats is not finite");
  if (t.m[3][0] != 0 || t.m[3][1] != 0 || t.m[3][2] != 0 || t.m[3][3] != 1)
    throw Error(place + ": the bottom row of world_from_splats is not 0 0 0 1");
  if (!(most_stretch(t) <= most_stretched))
    throw Error(place + ": world_from_splats stretches by more than 1e12");
  const double det = std::fabs(determinant(t));
  if (!(det > least_determinant && det < 1 / least_determinant))
    throw Error(place + ": world_from_splats cannot be inverted");
  if (is_too_far(placed_box(vertex_bounds(cloud.positions), t), {}))
    throw Error(place + ": world_from_splats puts splats more than 1e12 m away");
}

}  // namespace

void check_splats(const Scene& scene) {
  for (std::size_t i = 0; i < scene.splats.size(); ++i) {
    const SplatCloud& cloud = scene.splats[i];
    const std::string place = (scene.path.empty() ? "scene" : scene.path) + ": splats " +
                              std::to_string(i) +
                              (cloud.name.empty() ? "" : " \"" + cloud.name + "\"");
    check_cloud(cloud, place);
    const SplatCloud& first = scene.splats.front();
    if (cloud.color_space != first.color_space || cloud.white != first.white ||
        cloud.bands_nm != first.bands_nm)
      throw Error(place +
                  ": expected the colour space, bands and white of the other splats of the scene, "
                  "as all are composited in one; found others");
  }
}

}  // namespace omma
