// What a thread of a graphics card runs, in one lane, by the emulated backend (emulated/device.h):
// the bits of the portable backend, and little memory; and a function that only such threads call,
// the density of a sample.
#include <gtest/gtest.h>

#include <cmath>

#include "emulated/emulated_backend.h"
#include "lit_squares.h"
#include "omma/bake.h"
#include "optics/acceptance_warp.h"
#include "physics/sampling/acceptance_sampling.h"
#include "test_scenes.h"
#include "world_tests.h"

namespace omma::test {
namespace {

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

// A lit world in sixteen bands. Stacks are those of a processor's code: a flight of a path 3 kB,
// the loop over replicates 2, what the search has still to visit 1.
TEST(OneLane, IsSmallEnoughForAThreadOfACard) {
  WorldSettings settings;
  Lighting lighting = lighting_of(1);
  lighting.light.bands = narrow_bands(16);
  lighting.light.sky =
      made_sky(4, 2, 1, 16, [](int half, int, int, int, int) { return half == 0 ? 1.0 : 0.2; });
  settings.lighting = lighting;
  settings.backend = "emulated";
  const World world(std::make_shared<const Scene>(squares()), settings);
  const Eye eye = make_eye(sphere_directions(60), 12 * degree);
  take_device_use();
  for (const Sampling& sampling : std::vector<Sampling>{Fixed{24}, ToError{0.05, 4}}) {
    std::vector<float> responses(eye.size() * 16);
    const Mat4 pose;
    Renderer(world, eye, {.sampling = sampling}).render({&pose, 1}, responses);
  }
  const DeviceUse used = take_device_use();
  EXPECT_LT(used.memory, 16384u);
  EXPECT_LT(used.stack, 9216u);
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
