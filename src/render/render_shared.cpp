// Rendering with rays that neighbouring ommatidia share (sampling/shared_rays.h): a launch traces
// the rays of some frames, the next weighs them into responses, a third adds discs of the sky.
#include <algorithm>
#include <cmath>
#include <memory>

#include "render/render_state.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Radiance of the frames of a launch, for each thread: it is weighed while it lies in the cache.
constexpr std::size_t floats_of_thread = 1u << 18;
constexpr std::size_t values_of_task = 4096;  // by one thread at once

// What all frames of a call have in common.
struct SharedCall {
  const Renderer::State& s;
  std::span<const Mat4> world_from_head;
  const RenderCall& call;
  const Outputs& outputs;

  std::size_t pose_size() const { return s.eye.size() * static_cast<std::size_t>(outputs.count); }
};

struct Poses {
  std::size_t first, end;
};

// Blocks of some ommatidia: of those that stand for shared rays, or of the eye itself.
Blocks blocks_of(const Renderer::State& s, const EyeView& eye, const DirectionsView& directions,
                 std::size_t ommatidia, const Outputs& outputs) {
  Blocks blocks{
      {s.view(), &eye, &directions}, &s.built(), static_cast<int>(ommatidia), most_per_block};
  blocks.frame.outputs = outputs.count;
  blocks.frame.radiance_unit = s.world.state().radiance_unit;
  if (!outputs.from_band.empty()) blocks.frame.output_from_band = outputs.from_band.data();
  // A ray counts for several ommatidia, so that all count the same discs by their rays.
  blocks.frame.acceptance_sr = s.least_acceptance_sr;
  return blocks;
}

// Tasks of all blocks at some poses, into responses [pose][ommatidium or ray][output].
std::vector<BlockTask> tasks_of(const SharedCall& of, const Blocks& blocks, Poses poses,
                                std::uint64_t frame, float* responses) {
  const std::size_t size =
      static_cast<std::size_t>(blocks.ommatidia) * static_cast<std::size_t>(blocks.frame.outputs);
  std::vector<BlockTask> tasks;
  tasks.reserve((poses.end - poses.first) * blocks.count());
  for (std::size_t p = poses.first; p < poses.end; ++p)
    for (std::size_t block = 0; block < blocks.count(); ++block) {
      BlockTask& task = tasks.emplace_back(make_task(blocks, block, of.world_from_head[p], frame));
      task.sees = seen_at(of.call, p);
      task.responses = responses + (p - poses.first) * size;
    }
  return tasks;
}

// Frames with one set of rays; `radiance` [pose][ray][output].
void render_frames(const SharedCall& of, int pattern, Poses poses, float* radiance,
                   float* responses) {
  const Renderer::State& s = of.s;
  const SharedSet& set = shared_set(s, pattern);
  const std::size_t rays = set.rays.rays.size();
  const auto frame = static_cast<std::uint64_t>(pattern);
  const Blocks blocks = blocks_of(s, set.eye_view, set.directions_view, rays, of.outputs);
  trace_tasks(blocks, tasks_of(of, blocks, poses, 0, radiance));  // rays are fixed to the head

  std::vector<WeighTask> weighed;
  for (std::size_t k = 0; k < poses.end - poses.first; ++k)
    weighed.push_back({radiance + k * rays * static_cast<std::size_t>(of.outputs.count),
                       responses + k * of.pose_size()});
  s.built().launches.weigh(omma::view(set.rays), of.outputs.count, weighed);

  if (s.view()->light == nullptr || s.view()->light->disc_count == 0) return;
  const Blocks of_eye =
      blocks_of(s, s.eye_view, s.direction_views.front(), s.eye.size(), of.outputs);
  s.built().launches.discs(of_eye.frame, tasks_of(of, of_eye, poses, frame, responses),
                           s.built().acceleration.tracer.get());
}

// The mean of all sets, and its standard error from their spread.
void render_with_error(const SharedCall& of, Poses poses, float* radiance, float* responses,
                       float* errors) {
  const std::size_t size = of.pose_size() * (poses.end - poses.first);
  std::vector<double> sum(size), squares(size);
  const auto for_each_value = [&](const auto& body) {
    parallel_ranges(std::size_t{0}, size, values_of_task, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  };
  for (int pattern = 0; pattern < error_scrambles; ++pattern) {
    render_frames(of, pattern, poses, radiance, responses);
    for_each_value([&](std::size_t i) {
      const double x = static_cast<double>(responses[i]);
      sum[i] += x;
      squares[i] += x * x;
    });
  }
  constexpr double n = error_scrambles;
  for_each_value([&](std::size_t i) {
    const double mean = sum[i] / n;
    responses[i] = static_cast<float>(mean);
    errors[i] =
        static_cast<float>(std::sqrt(std::max(0.0, squares[i] / n - mean * mean) / (n - 1)));
  });
}

}  // namespace

const SharedSet& shared_set(const Renderer::State& state, int pattern) {
  return state.shared[static_cast<std::size_t>(pattern)].get([&] {
    SharedSet made;
    made.rays = make_shared_rays(state.eye, state.directions.front(), pattern);
    made.directions = make_ray_tables(state.directions.front(), made.rays);
    made.arrays = make_eye_arrays(made.rays.rays, made.directions);
    made.directions_view = omma::view(made.directions);
    made.eye_view = omma::view(made.arrays);
    return made;
  });
}

void render_shared(const Renderer::State& s, std::span<const Mat4> world_from_head,
                   std::span<float> responses, const RenderCall& call, const Outputs& outputs) {
  const SharedCall of{s, world_from_head, call, outputs};
  const bool with_error = !call.standard_error.empty();
  const int patterns = with_error ? error_scrambles : 1;
  // The sets are there from the first time on; until then nothing of the render is finished.
  const auto prepare = [&] {
    run_in_arena(*s.threads.arena, [&] {
      for (int pattern = 0; pattern < patterns; ++pattern) shared_set(s, pattern);
    });
  };
  if (call.progress)
    run_watched([&](double) { return call.progress(0); }, [&](WorkState&) { prepare(); });
  else
    prepare();
  std::size_t most_rays = 0;  // of a set
  std::vector<std::int32_t> counts(call.rays.empty() ? 0 : s.eye.size(), 0);
  for (int pattern = 0; pattern < patterns; ++pattern) {
    const SharedRays& shared = shared_set(s, pattern).rays;
    most_rays = std::max(most_rays, shared.rays.size());
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] += static_cast<std::int32_t>(std::count_if(
          shared.weight.begin() + shared.first[i], shared.weight.begin() + shared.first[i + 1],
          [](float w) { return w > 0; }));
  }
  for (std::size_t p = 0; p < world_from_head.size() && !counts.empty(); ++p)
    std::copy(counts.begin(), counts.end(),
              call.rays.begin() + static_cast<std::ptrdiff_t>(p * counts.size()));

  const std::size_t floats = most_rays * static_cast<std::size_t>(outputs.count);
  const std::size_t poses_of_launch =
      std::clamp<std::size_t>(floats_of_thread * static_cast<std::size_t>(s.threads.threads) /
                                  std::max<std::size_t>(floats, 1),
                              1, std::max<std::size_t>(world_from_head.size(), 1));
  const std::unique_ptr<float[]> radiance(new float[floats * poses_of_launch]);
  const auto launch = [&](Poses poses) {
    float* const out = responses.data() + poses.first * of.pose_size();
    if (with_error)
      render_with_error(of, poses, radiance.get(), out,
                        call.standard_error.data() + poses.first * of.pose_size());
    else
      render_frames(of, 0, poses, radiance.get(), out);
  };
  run_in_stretches(world_from_head.size(), static_cast<double>(most_rays) * patterns, 1,
                   call.progress, [&](std::size_t begin, std::size_t end) {
                     run_in_arena(*s.threads.arena, [&] {
                       for (std::size_t p = begin; p < end; p += poses_of_launch)
                         launch({p, std::min(end, p + poses_of_launch)});
                     });
                   });
}

}  // namespace omma
