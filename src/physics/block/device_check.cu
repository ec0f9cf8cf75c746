// Compiles the physics as device code: the hot loop in one lane, with the search of our own
// hierarchy. Nothing runs this; it keeps what is written once good for both host and device.
#include "physics/block/thread.h"
#include "physics/block/weigh.h"
#include "physics/light/near_light.h"
#include "physics/light/sun_map.h"
#include "physics/surface/footprint.h"
#include "physics/surface/scatter.h"
#include "physics/surface/scene_search.h"

namespace omma {

// A launch of blocks: threads of a block of the grid are ommatidia of a task. `bytes`: of a
// thread's memory.
__global__ void device_check(FrameView frame, const BlockTask* tasks, BvhView bvh,
                             std::byte* memory, std::size_t bytes) {
  const BlockTask& task = tasks[blockIdx.x];
  const int i = static_cast<int>(threadIdx.x);
  if (i >= task.count) return;
  const BlockMemory& own =
      lay_out_thread(memory + (blockIdx.x * blockDim.x + threadIdx.x) * bytes, frame);
  SceneSearch<OneLane> search{frame.scene, &bvh, own.visits};
  render_ommatidium(BlockRun<SceneSearch<OneLane>>{frame, task, search, own}, i);
}

// The same to an error: a round, or what comes behind the last.
__global__ void device_check_error(FrameView frame, BlockTask task, BvhView bvh, Round round,
                                   std::byte* memory) {
  const int i = static_cast<int>(threadIdx.x);
  Scratch of_block{memory};
  const ErrorMemory known = lay_out_error(of_block, frame);
  BlockMemory& own = lay_out_thread(memory + of_block.used, frame);
  share_error(frame, known, i, own);
  SceneSearch<OneLane> search{frame.scene, &bvh, own.visits};
  const BlockRun<SceneSearch<OneLane>> run{frame, task, search, own};
  begin_error(frame, task, known);
  trace_round_of_ommatidium(run, round, i);
  if (choose_rounds(frame, task, known) == 0) end_error_of_ommatidium(run, i);
}

__global__ void device_check_weights(SharedWeights shared, const float* radiance,
                                     float* responses) {
  weigh_rays<Lanes<weight_group, 1>>(shared, radiance, 3, 0, 1, responses);
}

__global__ void device_check_acceptance(AcceptanceWarpView warp, double* out) {
  const SensitivityView& s = warp.sensitivity;
  out[0] = acceptance_pdf(warp, 0.1, 0.2) + eval_polar_density(s, 0.1, 0.2) +
           footprint_width_rad(widest_footprint(s.kernel, 1) * s.width_rad, s.width_rad, 16);
}

// A direction in which a surface scatters, and what comes from there.
__global__ void device_check_scatter(const ScatterSurface<float>* surfaces, Vec2 u,
                                     Mueller3<float>* paths) {
  const ScatterPoint<float> point = make_scatter_point(surfaces[threadIdx.x]);
  float weight[lobe_count];
  lobe_weights(point, {0.5f, 0.5f, 0.5f, 0.5f}, weight);
  const LobeChoice<float> choice = choose_lobe(weight, u.x);
  const Vector3<float> w = sample_scatter(choice.lobe, point, u.x, u.y);
  const ScatterValue<float> value = eval_scatter(point, w);
  const Vector3<float> s = reflection_axis(point.direction, w, point.tangent);
  paths[threadIdx.x] = paths[threadIdx.x] * frame_turn(point.tangent, point.bitangent, s) *
                       (value.dielectric * (1.0f / pdf_scatter(choice.lobe, value)));
}

// A ray that leaves what another met, and what is in its way.
__global__ void device_check_leaving(SceneView scene, BvhView bvh, Packet<OneLane>* packets,
                                     std::byte* memory, unsigned* occluded_rays) {
  Packet<OneLane>& packet = packets[threadIdx.x];
  const auto all = LaneMask<OneLane>::all();
  Scratch scratch{memory};
  const SceneSearch<OneLane> search{&scene, &bvh, lay_out_visits(scratch)};
  search.closest(all, packet.rays, nullptr);
  Hits<OneLane> hits;
  find_hits<OneLane>(search.placed(), packet, hits);
  HitGeometry<OneLane> geometry;
  eval_geometry<OneLane>(scene, packet.rays, hits, geometry);
  leave_surfaces<OneLane>(geometry, geometry.normal, packet.rays);
  packet.rays.t_far_m[0] = INFINITY;
  occluded_rays[threadIdx.x] = search.occluded(all, packet.rays).bits;
}

// How much of the sun is seen from where a ray met something.
__global__ void device_check_sun_map(SunMapView map, const HitGeometry<OneLane>* hits,
                                     float* visible) {
  float seen[1];
  eval_sun_map(map, hits[threadIdx.x], seen);
  visible[threadIdx.x] = seen[0];
}

// Towards something that shines, and what comes from there.
__global__ void device_check_light(SceneView scene, Vec3 position, float* out) {
  const LightSample sample = sample_near_light(scene, position, 0.1f, 0.2f, 0.3f);
  eval_light_sample(scene, sample, 3, out, 1, scene.bands);
  out[0] += met_light_pdf(scene, sample.index, sample.triangle, position, sample.direction,
                          sample.distance_m);
}

// The same of light from afar.
__global__ void device_check_far(LightView light, const float* u, float* out) {
  const auto all = LaneMask<OneLane>::all();
  float direction[3][1];
  SkyLookups<OneLane> on_sky;
  sample_far<OneLane>(light, u, u + 1, all, direction);
  find_far<OneLane>(light, direction, all, on_sky);
  eval_sky_lanes<OneLane>(light, {direction, on_sky, all, all, false}, 3, out);
  add_disc_light<OneLane>(light, direction, all, nullptr, out);
  float pdf = 0;
  find_far_pdf<OneLane>(light, direction, on_sky, all, &pdf);
  out[0] += pdf;
}

}  // namespace omma
