// Renders in which each ommatidium has rays of its own, of a world that stands still meanwhile: a
// block of ommatidia at one pose is a task, tasks of many poses are a launch.
#include <algorithm>
#include <bit>
#include <cmath>

#include "render/render_motion.h"
#include "render/render_state.h"
#include "render/render_truth.h"
#include "sampling/sampling_choice.h"
#include "threads/parallel.h"
#include "world/traced_poses.h"

namespace omma {
namespace {

// Radiance is at most 1e15, and sums of it stay in single precision.
constexpr double most_output_weight = 1e6;

// Tasks of a launch: enough to keep all threads busy, few enough to lie in the cache.
constexpr std::size_t tasks_of_launch = 4096;

void check_output(const char* name, std::span<float> output, std::size_t expected) {
  if (output.size() != expected)
    throw Error(std::string(name) + ": expected room for " + std::to_string(expected) +
                " values (pose x ommatidium x band), found " + std::to_string(output.size()));
}

Outputs make_outputs(const RenderCall& call, const SceneView& view) {
  const std::span<const double> output_from_band = call.output_from_band;
  const int components = view.polarized ? 3 : 1, bands = view.bands * components;
  if (call.stokes && !view.polarized)
    throw Error("stokes: expected a world that is polarised, found one that is not");
  if (call.stokes && !output_from_band.empty())
    throw Error("stokes: not together with output_from_band, whose rows say what is asked for");
  if (output_from_band.empty()) return {call.stokes ? bands : view.bands, {}};
  const auto row = static_cast<std::size_t>(bands);
  if (output_from_band.size() % row != 0)
    throw Error("output_from_band: expected rows of " + std::to_string(bands) +
                " weights (output x band), found " + std::to_string(output_from_band.size()) +
                " in all");
  if (output_from_band.size() / row > most_bands)
    throw Error("output_from_band: expected at most " + std::to_string(most_bands) +
                " rows (output x band), found " + std::to_string(output_from_band.size() / row));
  Outputs outputs{static_cast<int>(output_from_band.size() / row), {}};
  for (const double weight : output_from_band) {
    if (!(std::fabs(weight) <= most_output_weight))
      throw Error("output_from_band: expected weights of at most " +
                  std::to_string(most_output_weight) + ", found " + std::to_string(weight));
    outputs.from_band.push_back(static_cast<float>(weight));
  }
  return outputs;
}

// How a call is cut into blocks: some 512 rays each, but no more than fit its sums. `some`: where
// the directions of a part are kept.
Blocks cut_into_blocks(const Renderer::State& s, const RenderCall& call, const Outputs& outputs,
                       const TimePart& part, DirectionsView& some) {
  Blocks blocks{{s.view(), &s.eye_view, s.direction_views.data()},
                &s.built(),
                static_cast<int>(s.eye.size())};
  FrameView& frame = blocks.frame;
  frame.outputs = outputs.count;
  frame.radiance_unit = s.world.state().radiance_unit;
  if (!outputs.from_band.empty()) frame.output_from_band = outputs.from_band.data();
  if (part.count > 1) {
    some = s.direction_views.front();
    some.samples = samples_in(part, first_samples(s.settings.sampling));
    some.part = part.index;
    some.part_bits = std::countr_zero(static_cast<unsigned>(part.count));
    frame.directions = &some;
  }
  const auto* to_error = std::get_if<ToError>(&s.settings.sampling);
  if (to_error != nullptr) {
    frame.rounds = static_cast<int>(s.directions.size());
    frame.error = to_error->error;
    frame.relative_error = to_error->relative_error;
    frame.most_samples = to_error->most;
    frame.nearest = s.nearest.data();
    // Neighbours are heard within a block, so that it is large whatever the least number of rays.
    blocks.per_block = ommatidia_that_hear(s.eye.size());
    return blocks;
  }
  if (!call.standard_error.empty()) frame.scrambles = error_scrambles;
  blocks.per_block = std::clamp(block_rays / (frame.directions->samples * frame.scrambles), 1,
                                std::min(most_per_block, block_capacity / frame.scrambles));
  return blocks;
}

std::size_t count_poses(std::size_t given, std::size_t eyes) {
  if (given % eyes != 0)
    throw Error("poses: expected one for each of " + std::to_string(eyes) + " eyes, found " +
                std::to_string(given));
  return given / eyes;
}

std::vector<EyeSpan> cut_by_eyes(const std::vector<EyeSpan>& eyes, int per_block) {
  const auto most = static_cast<std::size_t>(per_block);
  std::vector<EyeSpan> blocks;
  for (const EyeSpan& eye : eyes)
    for (std::size_t k = 0; k < eye.count; k += most)
      blocks.push_back({eye.first + k, std::min(most, eye.count - k), eye.eye});
  return blocks;
}

}  // namespace

void render_still(const Renderer::State& s, std::span<const Mat4> world_from_head,
                  std::span<float> responses, const RenderCall& call, const TimePart& part) {
  const std::vector<EyeSpan>& eyes = s.eyes;
  const std::size_t ommatidia = s.eye.size();
  const std::size_t poses = count_poses(world_from_head.size(), eyes.size());
  const Outputs outputs = make_outputs(call, *s.view());
  const std::size_t pose_size = ommatidia * static_cast<std::size_t>(outputs.count);
  check_output("responses", responses, poses * pose_size);
  if (!call.standard_error.empty())
    check_output("standard_error", call.standard_error, poses * pose_size);
  if (!call.rays.empty() && call.rays.size() != poses * ommatidia)
    throw Error("rays: expected room for " + std::to_string(poses * ommatidia) +
                " values (pose x ommatidium), found " + std::to_string(call.rays.size()));
  const auto* to_error = std::get_if<ToError>(&s.settings.sampling);
  const int samples = first_samples(s.settings.sampling);
  const std::size_t rays_size = pose_size * static_cast<std::size_t>(samples);
  const auto check_of_rays = [&](const char* name, std::span<const float> output,
                                 std::size_t expected, const char* axes) {
    if (output.empty()) return;
    const std::string start = std::string(name) + ": ";
    if (!call.standard_error.empty()) throw Error(start + "not together with standard_error");
    if (!std::holds_alternative<Fixed>(s.settings.sampling))
      throw Error(start + "only where every ommatidium has its own, equally many rays");
    if (output.size() != expected)
      throw Error(start + "expected room for " + std::to_string(expected) + " values (" + axes +
                  "), found " + std::to_string(output.size()));
  };
  check_of_rays("ray_radiance", call.ray_radiance, poses * rays_size,
                "pose x ommatidium x sample x band");
  static_assert(beside_rows == 1 + axis_moments);
  check_of_rays("beside_rays", call.beside_rays, poses * beside_rows * pose_size,
                "pose x ommatidium x row x band");
  std::fill(call.beside_rays.begin(), call.beside_rays.end(), 0.0f);
  const std::vector<Mat4> traced =
      traced_poses(world_from_head, s.eye_arrays, s.built().placement.origin_m);
  const Truth truth = checked_truth(call.truth, s.built(), poses, ommatidia);
  if (!truth.tasks.empty() && shares_rays(s.settings.sampling))
    throw Error("truth: not where rays are shared, which start at other ommatidia (Shared)");
  const std::uint64_t first_frame = call.first_pose || s.settings.noise == Noise::frozen
                                        ? call.first_pose.value_or(0)
                                        : s.frames.fetch_add(poses);

  if (shares_rays(s.settings.sampling)) return render_shared(s, traced, responses, call, outputs);
  const HeadPath path = head_path(
      s.settings, call,
      traced_poses(call.past_world_from_head, s.eye_arrays, s.built().placement.origin_m), traced);
  DirectionsView some;
  Blocks blocks = cut_into_blocks(s, call, outputs, part, some);
  if (!truth.tasks.empty()) blocks.frame.truth = &truth.view;
  blocks.frame.beside_moments = !call.beside_rays.empty();
  const int rays_each = blocks.frame.directions->samples * blocks.frame.scrambles;
  if (to_error == nullptr) std::fill(call.rays.begin(), call.rays.end(), rays_each);

  if (!s.settings.eye_sizes.empty()) {
    if (!truth.tasks.empty()) throw Error("eye_sizes: no ground truth of the eyes of a population");
    blocks.of_eyes = cut_by_eyes(eyes, blocks.per_block);
  }
  const std::size_t blocks_per_pose = blocks.count();
  std::vector<BlockTask> tasks;
  std::vector<FrameMotion> motions;  // of the poses of a launch
  const auto launch = [&](std::size_t begin, std::size_t end) {
    const std::size_t first_pose = begin / blocks_per_pose;
    motions.resize((end - 1) / blocks_per_pose + 1 - first_pose);
    if (!path.keys.empty())
      parallel_for(std::size_t{0}, motions.size(),
                   [&](std::size_t k) { set_motion(path, first_pose + k, part, motions[k]); });
    tasks.resize(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t p = i / blocks_per_pose;
      BlockTask& task = tasks[i - begin];
      const std::size_t e = blocks.eye_of(i % blocks_per_pose);
      task = make_task(blocks, i % blocks_per_pose, traced[p * eyes.size() + e],
                       s.frame_of(p, first_frame));
      task.sees = seen_at(call, p);
      task.motion = motion_of(motions[p - first_pose]);
      const auto begin_of = [&](auto output, std::size_t of_pose) {
        return output.data() + p * of_pose;
      };
      task.responses = begin_of(responses, pose_size);
      if (!call.standard_error.empty())
        task.standard_error = begin_of(call.standard_error, pose_size);
      if (!call.rays.empty()) task.rays = begin_of(call.rays, ommatidia);
      if (!call.ray_radiance.empty()) task.ray_radiance = begin_of(call.ray_radiance, rays_size);
      if (!call.beside_rays.empty())
        task.beside_rays = begin_of(call.beside_rays, beside_rows * pose_size);
      if (!truth.tasks.empty()) task.truth = &truth.tasks[p];
    }
    trace_tasks(blocks, tasks);
  };
  const int most_rays = to_error != nullptr ? to_error->most : rays_each;
  run_in_stretches(poses * blocks_per_pose, static_cast<double>(most_rays) * blocks.per_block,
                   s.threads.threads, call.progress, [&](std::size_t begin, std::size_t end) {
                     run_in_arena(*s.threads.arena, [&] {
                       for (std::size_t i = begin; i < end; i += tasks_of_launch)
                         launch(i, std::min(end, i + tasks_of_launch));
                     });
                   });
}

BlockTask make_task(const Blocks& blocks, std::size_t block, const Mat4& world_from_head,
                    std::uint64_t pose) {
  BlockTask task;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c)
      task.world_from_head[r][c] = static_cast<float>(world_from_head.m[r][c]);
  task.pose = pose;
  const EyeSpan span = blocks.at(block);
  task.first = static_cast<std::int32_t>(span.first);
  task.count = static_cast<std::int32_t>(span.count);
  return task;
}

void trace_tasks(const Blocks& blocks, std::span<const BlockTask> tasks) {
  blocks.built->launches.render(blocks.frame, tasks, blocks.built->acceleration.tracer.get());
}

void run_in_stretches(std::size_t tasks, double rays_per_task, int threads,
                      const std::function<bool(double)>& progress,
                      const std::function<void(std::size_t, std::size_t)>& run) {
  std::size_t stretch =
      static_cast<std::size_t>(std::max(static_cast<double>(threads), 2.5e5 / rays_per_task));
  constexpr double rays_to_watch = 2e5;  // along paths in many bands some seconds
  const auto fraction = [&](std::size_t finished) {
    return static_cast<double>(finished) / static_cast<double>(tasks);
  };
  if (!progress) stretch = tasks;
  for (std::size_t done = 0; done < tasks;) {
    const auto start = Clock::now();
    const std::size_t end = std::min(tasks, done + stretch);
    // Where a single task may take seconds its caller watches, to cancel it.
    if (progress && rays_per_task > rays_to_watch)
      run_watched([&](double) { return progress(fraction(done)); },
                  [&](WorkState&) { run(done, end); });
    else
      run(done, end);
    const double rate = static_cast<double>(end - done) / std::max(seconds_since(start), 1e-6);
    stretch = static_cast<std::size_t>(std::max(1.0, 0.2 * rate));
    done = end;
    if (progress && !progress(fraction(done))) throw Cancelled();
  }
}

}  // namespace omma
