// Where the rays of a render look: the directions that Renderer::render takes, for whoever weighs
// their radiance anew.
#include <algorithm>
#include <string>
#include <vector>

#include "backend/portable/portable_backend.h"
#include "physics/rays/replicates.h"
#include "render/render_state.h"
#include "sampling/sampling_choice.h"
#include "threads/parallel.h"
#include "world/traced_poses.h"

namespace omma {
namespace {

// Packets run through the samples of one ommatidium and on into those of the next.
void copy_directions(const std::vector<RayPacket<packet_rays>>& packets, const BlockTask& task,
                     const EyeView& eye, int samples, float* directions) {
  for (int k = 0; k < task.count * samples; ++k) {
    const RayPacket<packet_rays>& packet = packets[static_cast<std::size_t>(k / packet_rays)];
    const std::int64_t ommatidium = eye.ommatidium[task.first + k / samples];
    float* const to = directions + 3 * (ommatidium * samples + k % samples);
    for (int a = 0; a < 3; ++a) to[a] = packet.direction[a][k % packet_rays];
  }
}

}  // namespace

void Renderer::ray_directions(std::span<const Mat4> world_from_head, std::uint64_t first_pose,
                              std::span<float> directions) const {
  const State& s = *state_;
  if (!std::holds_alternative<Fixed>(s.settings.sampling))
    throw Error("ray_directions: only where every ommatidium has its own, equally many rays");
  if (!s.settings.eye_sizes.empty()) throw Error("ray_directions: not of a population");
  const int samples = first_samples(s.settings.sampling);
  const std::size_t of_pose = 3 * s.eye.size() * static_cast<std::size_t>(samples);
  if (directions.size() != world_from_head.size() * of_pose)
    throw Error(
        "ray_directions: expected room for " + std::to_string(world_from_head.size() * of_pose) +
        " values (pose x ommatidium x sample x 3), found " + std::to_string(directions.size()));
  const std::vector<Mat4> traced =
      traced_poses(world_from_head, s.eye_arrays, s.built().placement.origin_m);
  Blocks blocks{{s.view(), &s.eye_view, s.direction_views.data()},
                &s.built(),
                static_cast<int>(s.eye.size())};
  blocks.per_block = std::clamp(block_rays / samples, 1, most_per_block);
  const BlockFunctions functions = portable_block_functions();
  run_in_arena(*s.threads.arena, [&] {
    parallel_for(std::size_t{0}, traced.size() * blocks.count(), [&](std::size_t i) {
      const std::size_t p = i / blocks.count();
      const BlockTask task =
          make_task(blocks, i % blocks.count(), traced[p], s.frame_of(p, first_pose));
      std::vector<RayPacket<packet_rays>> packets(
          static_cast<std::size_t>((task.count * samples + packet_rays - 1) / packet_rays));
      functions.prepare(blocks.frame, task, packets.data());
      copy_directions(packets, task, s.eye_view, samples, directions.data() + p * of_pose);
    });
  });
}

}  // namespace omma
