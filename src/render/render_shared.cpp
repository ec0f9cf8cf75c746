// Rendering with rays that neighbouring ommatidia share (sampling/shared_rays.h): a frame traces
// the rays of the eye, then weighs them into responses.
#include <algorithm>
#include <cmath>

#include "render/render_state.h"
#include "threads/parallel.h"
#include "threads/thread_memory.h"

namespace omma {
namespace {

constexpr std::size_t rows_per_task = 256;

// This thread's buffer of so many floats, reused by all frames. A forked process takes other
// memory, as its parent may have been changing the renderer's.
float* buffer_for_rays(const Renderer::State& s, std::size_t values) {
  if (threads_are_gone())
    return reinterpret_cast<float*>(
        thread_memory(ThreadBuffer::shared_rays, values * sizeof(float)));
  std::vector<float>& own = s.radiance[thread_in_arena()];
  own.resize(values);
  return own.data();
}

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

// A frame with one set of rays; `parallel` where the threads are not busy with other poses.
void render_frame(const Renderer::State& s, int pattern, const Mat4& world_from_head,
                  const SeenMasks& sees, const Outputs& outputs, bool parallel, float* responses) {
  const SharedSet& set = shared_set(s, pattern);
  const Blocks blocks =
      blocks_of(s, set.eye_view, set.directions_view, set.rays.rays.size(), outputs);
  const Blocks of_eye = blocks_of(s, s.eye_view, s.direction_views.front(), s.eye.size(), outputs);
  // [ray][output]
  float* const traced =
      buffer_for_rays(s, set.rays.rays.size() * static_cast<std::size_t>(outputs.count));
  const auto trace = [&](std::size_t block) {
    BlockTask task = make_task(blocks, block, world_from_head, 0);  // rays are fixed to the head
    task.sees = sees;
    task.responses = traced;
    trace_task(blocks, task);
  };
  const std::size_t rows = s.eye.size(), row_tasks = (rows + rows_per_task - 1) / rows_per_task;
  const auto weigh = [&](std::size_t i) {
    s.built().functions.weigh(
        omma::view(set.rays), traced, outputs.count, static_cast<std::int64_t>(i * rows_per_task),
        static_cast<std::int64_t>(std::min(rows, (i + 1) * rows_per_task)), responses);
  };
  const std::size_t disc_tasks =
      s.view()->light != nullptr && s.view()->light->disc_count > 0 ? of_eye.count() : 0;
  const auto add_discs = [&](std::size_t block) {
    BlockTask task = make_task(of_eye, block, world_from_head, static_cast<std::uint64_t>(pattern));
    task.sees = sees;
    task.responses = responses;
    s.built().functions.discs(of_eye.frame, task, s.built().acceleration.tracer.get(),
                              thread_memory(ThreadBuffer::block, block_memory_bytes(of_eye.frame)));
  };
  if (parallel) {
    // Isolated: a waiting thread must not take up a frame of another call, which would use the same
    // buffer.
    run_isolated([&] {
      parallel_for(std::size_t{0}, blocks.count(), trace);
      parallel_for(std::size_t{0}, row_tasks, weigh);
      parallel_for(std::size_t{0}, disc_tasks, add_discs);
    });
  } else {
    for (std::size_t i = 0; i < blocks.count(); ++i) trace(i);
    for (std::size_t i = 0; i < row_tasks; ++i) weigh(i);
    for (std::size_t i = 0; i < disc_tasks; ++i) add_discs(i);
  }
}

// The mean of all sets, and its standard error from their spread.
void render_with_error(const Renderer::State& s, const Mat4& world_from_head, const SeenMasks& sees,
                       const Outputs& outputs, bool parallel, float* responses, float* errors) {
  const std::size_t size = s.eye.size() * static_cast<std::size_t>(outputs.count);
  std::vector<double> sum(size), squares(size);
  for (int pattern = 0; pattern < error_scrambles; ++pattern) {
    render_frame(s, pattern, world_from_head, sees, outputs, parallel, responses);
    for (std::size_t i = 0; i < size; ++i) {
      const double x = static_cast<double>(responses[i]);
      sum[i] += x;
      squares[i] += x * x;
    }
  }
  constexpr double n = error_scrambles;
  for (std::size_t i = 0; i < size; ++i) {
    const double mean = sum[i] / n;
    responses[i] = static_cast<float>(mean);
    errors[i] =
        static_cast<float>(std::sqrt(std::max(0.0, squares[i] / n - mean * mean) / (n - 1)));
  }
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
  const std::size_t pose_size = s.eye.size() * static_cast<std::size_t>(outputs.count);
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
  std::vector<std::int32_t> counts(call.rays.empty() ? 0 : s.eye.size(), 0);
  for (int pattern = 0; pattern < patterns; ++pattern) {
    const SharedRays& shared = shared_set(s, pattern).rays;
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] += static_cast<std::int32_t>(std::count_if(
          shared.weight.begin() + shared.first[i], shared.weight.begin() + shared.first[i + 1],
          [](float w) { return w > 0; }));
  }
  const auto frame = [&](std::size_t p, bool parallel) {
    float* out = responses.data() + p * pose_size;
    const SeenMasks sees = seen_at(call, p);
    std::copy(counts.begin(), counts.end(),
              call.rays.begin() + static_cast<std::ptrdiff_t>(p * counts.size()));
    if (with_error)
      render_with_error(s, world_from_head[p], sees, outputs, parallel, out,
                        call.standard_error.data() + p * pose_size);
    else
      render_frame(s, 0, world_from_head[p], sees, outputs, parallel, out);
  };
  const double rays = static_cast<double>(shared_set(s, 0).rays.rays.size()) * patterns;
  run_in_stretches(world_from_head.size(), rays, 1, call.progress,
                   [&](std::size_t begin, std::size_t end) {
                     run_in_arena(*s.threads.arena, [&] {
                       if (end - begin >= 2 * static_cast<std::size_t>(s.threads.threads))
                         parallel_for(begin, end, [&](std::size_t p) { frame(p, false); });
                       else
                         for (std::size_t p = begin; p < end; ++p) frame(p, true);
                     });
                   });
}

}  // namespace omma
