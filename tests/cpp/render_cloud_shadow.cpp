// Shadows of clouds: light of a disc by exp(-depth / sin e) of the layer above, on the ground, in a
// mirror and for the eye itself, wherever that is.
#include <gtest/gtest.h>

#include <cmath>

#include "light_maps.h"
#include "world_tests.h"

namespace omma::test {
namespace {

constexpr double azimuth_rad = 1.2, elevation_rad = 0.7;
// Single precision at places of kilometres, in nodes of 50 m, with depths of some.
constexpr double rounding = 2e-4;

CloudShadow layer(Vec3d at = {}) {
  return {4, 3, 50, at.y + 800, at.x + 10, at.z - 20,
          {0, 0.5f, 3, 0.25f, 1, 0, 0, 2, 0.75f, 0.1f, 0.3f, 4}};
}

// What the layer leaves of the disc at a place, in double precision.
double open(const CloudShadow& clouds, Vec3d place) {
  const Vec3d towards = direction_of(azimuth_rad, elevation_rad);
  const double way = (clouds.height_m - place.y) / towards.y;
  if (way <= 0) return 1;
  const double column = (place.x + way * towards.x - clouds.first_x_m) / clouds.spacing_m;
  const double row = (place.z + way * towards.z - clouds.first_z_m) / clouds.spacing_m;
  const auto at = [&](double r, double c) {
    const auto node = [](double u, int count) {
      return static_cast<std::size_t>(((static_cast<long>(u) % count) + count) % count);
    };
    return static_cast<double>(
        clouds.optical_depth[node(r, clouds.rows) * static_cast<std::size_t>(clouds.columns) +
                             node(c, clouds.columns)]);
  };
  const double r = std::floor(row), c = std::floor(column), v = row - r, u = column - c;
  const double depth = (1 - v) * ((1 - u) * at(r, c) + u * at(r, c + 1)) +
                       v * ((1 - u) * at(r + 1, c) + u * at(r + 1, c + 1));
  return std::exp(-depth / towards.y);
}

World ground_below(const CloudShadow* clouds, const Material& material, Vec3d middle = {}) {
  Scene scene;
  scene.materials = {material};
  Mesh mesh;
  mesh.material = 0;
  mesh.positions = {{-3000, 0, 3000}, {3000, 0, 3000}, {3000, 0, -3000}, {-3000, 0, -3000}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.meshes = {mesh};
  Instance instance;
  instance.mesh = 0;
  instance.world_from_mesh = translation(middle);
  scene.instances = {instance};
  Lighting lighting;
  lighting.light.bands = narrow_bands(3);
  Disc sun;
  sun.direction = to_float(direction_of(azimuth_rad, elevation_rad));
  sun.angular_radius_rad = 0.005;
  sun.radiance = {1e4, 2e4, 3e4};
  lighting.light.discs = {sun};
  if (clouds != nullptr) lighting.light.cloud_shadow = std::make_shared<CloudShadow>(*clouds);
  return World(std::make_shared<const Scene>(std::move(scene)),
               {.backend = backend_under_test, .lighting = lighting});
}

std::vector<Mat4> poses_at(Vec3d middle) {
  std::vector<Mat4> poses;
  for (const double height : {2.0, 900.0})
    for (const Vec3d place : {Vec3d{}, {37, 0, 11}, {-212, 0, 480}, {1700, 0, -1333}})
      poses.push_back(translation(middle + place + Vec3d{0, height, 0}));
  return poses;
}

// By pose and band, over what the same eye sees without clouds; `shaded` is where that light falls.
template <typename Shaded>
void expect_shade(const Eye& eye, const Material& material, double tolerance, const Shaded& shaded,
                  Vec3d middle = {}) {
  const CloudShadow clouds = layer(middle);
  const std::vector<Mat4> poses = poses_at(middle);
  const auto seen_by = [&](const CloudShadow* layer) {
    const World world = ground_below(layer, material, middle);
    return render(Renderer(world, eye, {.sampling = Fixed{16}}), poses).response;
  };
  const std::vector<float> shade = seen_by(&clouds), clear = seen_by(nullptr);
  for (std::size_t p = 0; p < poses.size(); ++p) {
    const double expected = open(clouds, shaded(transform_point(poses[p], {})));
    for (std::size_t b = 0; b < 3; ++b) {
      const std::size_t k = 3 * p + b;
      ASSERT_GT(clear[k], 0);
      EXPECT_NEAR(static_cast<double>(shade[k] / clear[k]), expected, tolerance)
          << "pose " << p << ", band " << b;
    }
  }
}

Material matt() {
  Material material;
  material.specular = 0;
  return material;
}

TEST(CloudShadow, LiesOnTheGround) {
  const Eye down = make_eye(Vec3d{0, -1, 0}, 0);
  for (const Vec3d middle : {Vec3d{}, Vec3d{4e5, 120, -3e5}})
    expect_shade(down, matt(), rounding, [&](Vec3d p) { return Vec3d{p.x, middle.y, p.z}; },
                 middle);
}

// By rays that an ommatidium sends, and where the disc is asked for.
TEST(CloudShadow, FallsOnTheEye) {
  for (const double acceptance_rad : {0.0, 0.03})
    expect_shade(make_eye(direction_of(azimuth_rad, elevation_rad), acceptance_rad), matt(),
                 rounding, [](Vec3d p) { return p; });
}

TEST(CloudShadow, FallsOnAMirror) {
  Material mirror = matt();
  mirror.metallic = 1;
  mirror.roughness = 0;
  const Vec3d sun = direction_of(azimuth_rad, elevation_rad), towards{sun.x, -sun.y, sun.z};
  // The spot is some centimetres across, or from 900 m up some metres, of nodes 50 m apart.
  expect_shade(make_eye(towards, 0.005), mirror, 0.02, [&](Vec3d p) {
    const double way = p.y / -towards.y;
    return Vec3d{p.x + way * towards.x, 0, p.z + way * towards.z};
  });
}

}  // namespace
}  // namespace omma::test
