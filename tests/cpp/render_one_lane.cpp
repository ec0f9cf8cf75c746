// What a thread of a graphics card runs, in one lane, by the emulated backend (emulated/device.h):
// the bits of the portable backend, and little memory; and a function that only such threads call,
// the density of a sample.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "emulated/emulated_backend.h"
#include "lit_squares.h"
#include "omma/bake.h"
#include "optics/acceptance_warp.h"
#include "physics/sampling/acceptance_sampling.h"
#include "test_scenes.h"
#include "world/world_state.h"
#include "world_tests.h"

namespace omma::test {
namespace {

// A block that rays bend into and out of, and what it absorbs, before all else on one side.
void add_block_of_glass(Scene& scene, double absorption_per_m) {
  Material glass;
  glass.roughness = 0;
  glass.transmission = 1;
  glass.thickness_m = 1;
  glass.absorption_per_m = {{400, 700}, {absorption_per_m, 2 * absorption_per_m}};
  Mesh block = cube_seen_from_inside(0.1, add_material(scene, glass));
  for (auto& triangle : block.triangles) std::swap(triangle[1], triangle[2]);
  add_instance(scene, add_mesh(scene, block), translation({-0.3, 0, -0.25}));
}

// Frames of a world as two backends render them.
struct Case {
  const char* name;
  Scene scene;
  WorldSettings world;
  RenderSettings renderer;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const int samples : {1, 5, 16, 24, 40}) {
    Case one{"unlit", random_scene(static_cast<std::uint64_t>(samples)), {}, {}};
    one.renderer.sampling = Fixed{samples};
    all.push_back(std::move(one));
  }
  all.push_back({"to an error", random_scene(2), {}, {.sampling = ToError{0.02, 4}}});
  all.push_back({"shared", random_scene(3), {}, {.sampling = Shared{4}}});
  for (const int components : {1, 3})
    for (const int samples : {5, 24}) {
      WorldSettings lit;
      lit.lighting = lighting_of(components);
      all.push_back({"lit", squares(), lit, {.sampling = Fixed{samples}}});
      all.push_back({"lit, to an error", squares(), lit, {.sampling = ToError{0.02, 4}}});
      Scene glassy = squares();
      add_block_of_glass(glassy, 0.2);
      all.push_back({"lit, with glass", glassy, lit, {.sampling = Fixed{samples}}});
    }
  return all;
}

Result by_backend(const Case& of, const char* backend, bool with_error) {
  WorldSettings settings = of.world;
  settings.backend = backend;
  const World world(std::make_shared<const Scene>(of.scene), settings);
  const Renderer renderer(world, make_eye(sphere_directions(150), 12 * degree), of.renderer);
  Result result;
  const auto size = 150 * static_cast<std::size_t>(world.bands());
  result.response.resize(size);
  RenderCall call;
  if (with_error) {
    result.standard_error.resize(size);
    call.standard_error = result.standard_error;
  }
  const Mat4 pose;
  renderer.render({&pose, 1}, result.response, call);
  return result;
}

// `most`: how far they may differ, 0: not a bit.
void expect_same(const std::vector<float>& packets, const std::vector<float>& lane, double most) {
  ASSERT_EQ(packets.size(), lane.size());
  double differ = 0;
  for (std::size_t i = 0; i < packets.size(); ++i)
    differ = std::max(differ, std::fabs(double{packets[i]} - double{lane[i]}));
  EXPECT_LE(differ, most);
}

TEST(OneLane, HasTheBitsOfPackets) {
  for (const Case& of : cases())
    for (const bool with_error : {false, true}) {
      SCOPED_TRACE(std::string(of.name) + (with_error ? ", with errors" : ""));
      const Result packets = by_backend(of, "portable", with_error);
      const Result lane = by_backend(of, "emulated", with_error);
      // Packets of which no path brings polarisation multiply less (bringing_polarisation), which
      // rounds in another way.
      const bool is_polarized = of.world.lighting && of.world.lighting->polarized;
      const double most = is_polarized ? 1e-7 : 0;
      expect_same(packets.response, lane.response, most);
      expect_same(packets.standard_error, lane.standard_error, most);
    }
}

// A lit world in sixteen bands that asks for as much as one can: what lets light through, something
// small that shines and is aimed at, a disc. Baked light is looked up besides.
World demanding_world(bool is_polarized, bool is_baked) {
  Scene scene = squares();
  scene.materials[0].alpha_mode = AlphaMode::blend;
  scene.materials[0].base_color.w = 0.5f;
  Material shining;
  shining.emissive = {1, 1, 1};
  shining.double_sided = true;
  add_instance(scene, add_mesh(scene, quad({0, 1, -2}, {0.05, 0, 0}, {0, 0.05, 0},
                                           add_material(scene, shining))));
  // Not baked, which takes minutes; so dark that no rounds are spent on the sun in it.
  if (!is_baked) add_block_of_glass(scene, 200);
  WorldSettings settings;
  Lighting lighting = lighting_of(is_polarized ? 3 : 1);
  lighting.light.emission_cd_m2 = 1e6;
  lighting.light.bands = narrow_bands(16);
  lighting.light.sky =
      made_sky(4, 2, is_polarized ? 3 : 1, 16, [](int half, int, int, int component, int) {
        return (component == 0 ? 1.0 : 0.3) * (half == 0 ? 1.0 : 0.2);
      });
  Disc sun;
  sun.direction = {0, 0.6f, 0.8f};
  sun.angular_radius_rad = 0.005;
  sun.radiance.assign(16, 2e4);
  lighting.light.discs.push_back(sun);
  settings.lighting = lighting;
  settings.backend = "emulated";
  const auto shared = std::make_shared<const Scene>(scene);
  World world(shared, settings);
  if (!is_baked) return world;
  lighting.baked = std::make_shared<const BakedLight>(bake_light(world, {.paths = 16}));
  return world.with_lighting(lighting);
}

// With all of ground truth; stacks are those of a processor's code.
TEST(OneLane, IsSmallEnoughForAThreadOfACard) {
  const Eye eye = make_eye(sphere_directions(60), 12 * degree);
  for (const bool is_polarized : {false, true})
    for (const bool is_baked : {false, true}) {
      const World world = demanding_world(is_polarized, is_baked);
      EXPECT_GT(world.state().view.light->aim_count, 0);
      for (const Sampling& sampling : std::vector<Sampling>{Fixed{24}, ToError{0.05, 4}})
        for (const bool with_error : {false, true}) {
          SCOPED_TRACE(std::string(is_polarized ? "polarised" : "unpolarised") +
                       (is_baked ? ", baked" : "") + (with_error ? ", with errors" : ""));
          const Renderer renderer(world, eye, {.sampling = sampling});
          const std::size_t size = eye.size();
          std::vector<float> responses(size * 16 * (is_polarized ? 3 : 1));
          std::vector<float> errors(responses.size());
          std::vector<float> distance(size), flow(2 * size);
          std::vector<double> position(3 * size);
          RenderCall call;
          call.stokes = is_polarized;
          if (with_error) call.standard_error = errors;
          call.truth.distance_m = distance;
          call.truth.position_m = position;
          call.truth.flow_rotation = flow;
          take_device_use();
          const Mat4 pose;
          renderer.render({&pose, 1}, responses, call);
          const DeviceUse used = take_device_use();
          EXPECT_LT(used.memory, 16384u);
          EXPECT_LT(used.stack, 4096u);
        }
    }
}

// Midpoint rule in theta; exact to 1e-5 with 100,000 cells where the density is smooth, and the
// edge of the pillbox falls into one cell.
TEST(OneLane, DensityOfSamplesIntegratesToOne) {
  constexpr int cells = 100'000;
  for (const Kernel kernel : {Kernel::gaussian, Kernel::pillbox, Kernel::compoundray})
    for (const double degrees : {2.6, 60.0, 360.0}) {
      Acceptance acceptance;
      acceptance.kernel = kernel;
      acceptance.width_rad = degrees * degree;
      const AcceptanceWarp warp = make_acceptance_warp(acceptance);
      const double end = std::min(pi, 5 * degrees * degree), width = end / cells;
      double integral = 0;
      for (int i = 0; i < cells; ++i) {
        const double theta = (i + 0.5) * width;
        integral += acceptance_pdf(view(warp), theta, 0) * 2 * pi * std::sin(theta) * width;
      }
      EXPECT_NEAR(integral, 1.0, 1e-4) << name_of(kernel) << ' ' << degrees;
    }
}

}  // namespace
}  // namespace omma::test
