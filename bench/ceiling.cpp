// How close the whole render comes to what Embree can trace, in one run and on the same rays: the
// ceiling is rtcIntersect16, coherent, on prepared packets; the render adds directions, shading and
// reduction. Frames of both take turns, so that a disturbance meets both.
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

#include "backend/denormals.h"
#include "backend/embree/embree_backend.h"
#include "backend/embree/embree_search.h"
#include "backend/eye_arrays.h"
#include "backend/shading_data.h"
#include "physics/rays/replicates.h"
#include "scenes.h"

namespace omma::bench {
namespace {

// What a Renderer holds inside, and its blocks at one pose.
struct Prepared {
  std::unique_ptr<ShadingData> shading;
  Placement placement;
  Acceleration acceleration;
  DirectionTables directions;
  DirectionsView directions_view;
  EyeArrays eye;
  EyeView eye_view;
  std::vector<BlockTask> tasks;
};

void prepare_rays(Prepared& p, const Setup& setup, int samples) {
  p.directions = make_direction_tables(setup.eye, {}, samples);
  p.directions_view = view(p.directions);
  p.eye = make_eye_arrays(setup.eye, p.directions);
  p.eye_view = view(p.eye);
  p.tasks.clear();
  const int per_block = std::clamp(block_rays / samples, 1, block_capacity);
  const int ommatidia = static_cast<int>(setup.eye.size());
  for (int first = 0; first < ommatidia; first += per_block) {
    BlockTask task;
    const Vec3d o = p.placement.origin_m;
    const double origin[3] = {o.x, o.y, o.z};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        task.world_from_head[r][c] =
            static_cast<float>(setup.poses.front().m[r][c] - (c == 3 ? origin[r] : 0));
    task.first = first;
    task.count = std::min(per_block, ommatidia - first);
    p.tasks.push_back(task);
  }
}

// Tracing alone, timed block by block on packets just prepared, which are in the cache as they are
// in the render; the frame's time is the sum over all blocks shared by the threads.
double trace_seconds(const Prepared& p, int samples, const BlockFunctions& block) {
  const FrameView frame{&p.shading->view, &p.eye_view, &p.directions_view};
  std::atomic<std::int64_t> traced_ns{0};
  oneapi::tbb::parallel_for(std::size_t{0}, p.tasks.size(), [&](std::size_t t) {
    const BlockTask& task = p.tasks[t];
    thread_local std::vector<RayPacket<packet_rays>> packets;
    packets.resize(static_cast<std::size_t>((task.count * samples + 15) / 16));
    block.prepare(frame, task, packets.data());
    const DenormalsAreZero denormals_are_zero;
    using L = Lanes<packet_rays, lane_width>;
    EmbreeSearch<L> search{static_cast<const EmbreeTracer*>(p.acceleration.tracer.get()), {}};
    const auto start = Clock::now();
    for (RayPacket<packet_rays>& rays : packets) search.closest(LaneMask<L>::all(), rays, nullptr);
    traced_ns += std::chrono::nanoseconds(Clock::now() - start).count();
  });
  return 1e-9 * static_cast<double>(traced_ns) / oneapi::tbb::info::default_concurrency();
}

}  // namespace

void ceiling(bool quick) {
  const std::vector<int> counts =
      quick ? std::vector{1, 16} : std::vector{1, 2, 4, 8, 16, 32, 64, 256};
  const double least_s = quick ? 0.02 : 1.2;
  std::vector<Setup> setups;
  if (have_data("the ceiling in natural-standin-sky")) setups.push_back(meadow());
  setups.push_back(bundled());
  setups.push_back(bundled_opaque());
  setups.push_back(hills(quick ? 100 : 708));
  std::printf("scene,triangles,ommatidia,rays,ceiling_mrays_per_s,render_mrays_per_s\n");
  for (const Setup& setup : setups) {
    Prepared p;
    p.shading = make_shading_data(*setup.scene);
    p.placement = placement_of(*setup.scene);
    p.acceleration =
        embree_backend().build(*setup.scene, p.shading->view, p.placement, {}, nullptr);
    const Renderer built(setup.scene, setup.eye);
    std::vector<float> responses(setup.eye.size() * rgb_bands);
    const BlockFunctions block = embree_block_functions();
    for (int samples : counts) {
      const Renderer renderer(built, setup.eye, {.sampling = Fixed{samples}});
      prepare_rays(p, setup, samples);
      double trace_s = 1e9;
      double render_s = 1e9;
      const auto start = Clock::now();
      for (int i = 0; i < 3 || seconds_since(start) < least_s; ++i) {
        trace_s = std::min(trace_s, trace_seconds(p, samples, block));
        const auto before = Clock::now();
        renderer.render(setup.poses, responses);
        render_s = std::min(render_s, seconds_since(before));
      }
      const double mrays = 1e-6 * static_cast<double>(setup.eye.size()) * samples;
      std::printf("%s,%llu,%zu,%d,%.2f,%.2f\n", setup.name.c_str(),
                  static_cast<unsigned long long>(triangle_count(*setup.scene)), setup.eye.size(),
                  samples, mrays / trace_s, mrays / render_s);
      std::fflush(stdout);
    }
  }
}

}  // namespace omma::bench
