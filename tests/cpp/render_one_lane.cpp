// The hot loop in one lane, as a thread of a graphics card runs it, against the packets that a
// processor runs; and a function that only such threads call: the density of a sample.
#include <gtest/gtest.h>

#include "backend/block_functions.h"
#include "backend/denormals.h"
#include "physics/block/block.h"
#include "backend/embree/embree_backend.h"
#include "backend/embree/embree_builds.h"
#include "backend/embree/embree_search.h"
#include "backend/eye_arrays.h"
#include "backend/shading_data.h"
#include "optics/acceptance_warp.h"
#include "sampling/sampling_choice.h"
#include "test_scenes.h"
#include "threads/thread_memory.h"

namespace omma::test {
namespace {

// Embree asked about one ray at a time.
struct SingleRays {
  using One = Lanes<1, 1>;
  using All = Lanes<16, 1>;
  EmbreeSearch<All> search;

  void closest(LaneMask<One> lanes, RayPacket<1>& rays, const PassedSurfaces<1>* passed,
               Spread spread = Spread::together) {
    RayPacket<16> packet{};
    PassedSurfaces<16> packet_passed;
    copy_lane<16, 1>(packet, rays);
    if (passed != nullptr) {
      packet_passed.count[0] = passed->count[0];
      std::copy_n(passed->surface[0], passed->count[0], packet_passed.surface[0]);
    }
    search.closest(LaneMask<All>{lanes.bits}, packet, passed == nullptr ? nullptr : &packet_passed,
                   spread);
    copy_lane<1, 16>(rays, packet);
  }
  LaneMask<One> occluded(LaneMask<One> lanes, const RayPacket<1>& rays) {
    RayPacket<16> packet{};
    copy_lane<16, 1>(packet, rays);
    return {search.occluded(LaneMask<All>{lanes.bits}, packet).bits};
  }
  const PlacedMesh* placed() const { return search.placed(); }

  template <int to, int from>
  static void copy_lane(RayPacket<to>& target, const RayPacket<from>& source) {
    for (int r = 0; r < 3; ++r) {
      target.origin[r][0] = source.origin[r][0];
      target.direction[r][0] = source.direction[r][0];
    }
    target.t_near_m[0] = source.t_near_m[0];
    target.t_far_m[0] = source.t_far_m[0];
    target.mask[0] = source.mask[0];
    target.u[0] = source.u[0];
    target.v[0] = source.v[0];
    target.triangle[0] = source.triangle[0];
    target.geometry[0] = source.geometry[0];
    target.instance[0] = source.instance[0];
  }
};

// Everything that a block is rendered from.
struct BlockSetup {
  Scene scene;
  std::unique_ptr<ShadingData> shading;
  BackgroundData background;
  SceneView view;
  Acceleration acceleration;
  Eye eye;
  std::vector<DirectionTables> directions;
  std::vector<DirectionsView> direction_views;
  EyeArrays arrays;
  EyeView eye_view;
  std::vector<std::uint8_t> nearest;
  FrameView frame;

  BlockSetup(std::uint64_t seed, const Sampling& sampling) : scene(random_scene(seed)) {
    shading = make_shading_data(scene);
    background = make_background_data(scene.background);
    view = shading->view;
    view.background = background.view;
    acceleration = embree_backend().build(scene, shading->view, placement_of(scene), nullptr);
    eye = make_eye(sphere_directions(40), 12 * degree);
    const auto* target = std::get_if<ToError>(&sampling);
    const std::size_t rounds = target != nullptr ? 4 : 1;
    for (int samples = first_samples(sampling); directions.size() < rounds; samples *= 2) {
      directions.push_back(make_direction_tables(eye, {}, samples));
      direction_views.push_back(omma::view(directions.back()));
    }
    arrays = make_eye_arrays(eye, directions.front());
    eye_view = omma::view(arrays);
    nearest = nearest_in_blocks(arrays, most_per_block);
    frame.scene = &view;
    frame.eye = &eye_view;
    frame.directions = direction_views.data();
    frame.rounds = static_cast<int>(directions.size());
    if (target != nullptr) frame.error = target->error;
    frame.most_samples = 4 * directions.back().samples;
    frame.nearest = nearest.data();
  }
  BlockSetup(const BlockSetup&) = delete;
  BlockSetup& operator=(const BlockSetup&) = delete;
};

struct Output {
  std::vector<float> responses, errors, radiance;
  std::vector<std::int32_t> rays;
};

// `run`: with a frame, a task and the search's tracer.
template <typename Run>
Output run_block(const BlockSetup& setup, const Run& run) {
  const std::size_t size = setup.eye.size() * rgb_bands;
  Output out{std::vector<float>(size), std::vector<float>(size),
             std::vector<float>(size * static_cast<std::size_t>(setup.directions[0].samples)),
             std::vector<std::int32_t>(setup.eye.size())};
  BlockTask task;
  for (int i = 0; i < 3; ++i) task.world_from_head[i][i] = 1;
  task.count = static_cast<int>(setup.eye.size());
  task.responses = out.responses.data();
  if (setup.frame.most_samples > 0) {
    task.standard_error = out.errors.data();
    task.rays = out.rays.data();
  } else {
    task.ray_radiance = out.radiance.data();
  }
  run(setup.frame, task, setup.acceleration.tracer.get());
  return out;
}

Output in_packets(const BlockSetup& setup) {
  return run_block(setup, [](const FrameView& frame, const BlockTask& task, const void* tracer) {
    plain::embree_block().render(frame, task, tracer, thread_memory(block_memory_bytes(frame)));
  });
}

Output in_one_lane(const BlockSetup& setup) {
  return run_block(setup, [](const FrameView& frame, const BlockTask& task, const void* tracer) {
    const DenormalsAreZero denormals_are_zero;
    SingleRays search{{static_cast<const EmbreeTracer*>(tracer), {}}};
    Scratch scratch{thread_memory(block_memory_bytes(frame))};
    render_block<Lanes<1, 1>>(frame, task, search, lay_out(scratch, frame, 1));
  });
}

// Radiance of single rays is the same to the bit, through layers that let light through too; sums
// are taken in another order.
TEST(OneLane, SeesWhatPacketsSee) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u})
    for (const int samples : {1, 5, 16, 21}) {
      const BlockSetup setup(seed, Fixed{samples});
      const Output packets = in_packets(setup), single = in_one_lane(setup);
      EXPECT_EQ(packets.radiance, single.radiance) << seed << ' ' << samples;
      for (std::size_t i = 0; i < packets.responses.size(); ++i)
        EXPECT_NEAR(packets.responses[i], single.responses[i], 2e-6);
    }
}

// Rounds of rays, chosen by estimates that rest on pairs of them.
TEST(OneLane, ReachesAnErrorAsPacketsDo) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const BlockSetup setup(seed, ToError{0.02, 4});
    const Output packets = in_packets(setup), single = in_one_lane(setup);
    EXPECT_EQ(packets.rays, single.rays);
    for (std::size_t i = 0; i < packets.responses.size(); ++i) {
      EXPECT_NEAR(packets.responses[i], single.responses[i], 2e-6);
      EXPECT_NEAR(packets.errors[i], single.errors[i], 1e-5);
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
