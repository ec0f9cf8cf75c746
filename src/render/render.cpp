// The main path: a world and an eye become a Renderer, poses become responses. Read top to bottom:
// check what comes in, build once, then per call one parallel loop over poses and blocks of
// neighbouring ommatidia. What happens inside a block is physics/block/block.h.
#include "omma/render.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "omma/rig.h"
#include "render/render_motion.h"
#include "render/render_state.h"
#include "render/render_truth.h"
#include "sampling/sampling_choice.h"
#include "threads/arena.h"
#include "threads/parallel.h"
#include "threads/thread_memory.h"
#include "world/traced_poses.h"

namespace omma {
namespace {

// Radiance is at most 1e15, and sums of it stay in single precision.
constexpr double most_output_weight = 1e6;

void check_samples(const std::string& sampling, int samples, int most) {
  if (samples < 1 || samples > most)
    throw Error("sampling: " + sampling + " expects 1 to " + std::to_string(most) +
                " samples, found " + std::to_string(samples));
}

void check_to_error(const ToError& s) {
  const bool is_error = std::isfinite(s.error) && s.error >= 0;
  const bool is_share = s.relative_error >= 0 && s.relative_error <= 1;
  if (!is_error || !is_share || (s.error == 0 && s.relative_error == 0))
    throw Error(
        "sampling: ToError expects an error above 0, a radiance, or a relative one, up to 1; found " +
        std::to_string(s.error) + " and " + std::to_string(s.relative_error));
  if (s.least < 4 || s.least > max_samples || (s.least & (s.least - 1)) != 0)
    throw Error("sampling: ToError expects a power of two from 4 to " +
                std::to_string(max_samples) + " as the least rays, found " +
                std::to_string(s.least));
  if (s.most < s.least || s.most > max_samples)
    throw Error("sampling: ToError expects " + std::to_string(s.least) + " (the least) to " +
                std::to_string(max_samples) + " as the most rays, found " + std::to_string(s.most));
}

void check_settings(const RenderSettings& s) {
  if (const auto* fixed = std::get_if<Fixed>(&s.sampling))
    check_samples("Fixed", fixed->samples, max_samples);
  if (const auto* target = std::get_if<ToError>(&s.sampling)) check_to_error(*target);
  if (const auto* shared = std::get_if<Shared>(&s.sampling)) {
    check_samples("Shared", shared->samples, max_shared_samples);
    if (s.points == Points::random) throw Error("sampling: Shared, not with random points");
    if (s.noise != Noise::frozen)
      throw Error("noise: expected frozen where rays are shared, which are fixed to the head");
  }
  if (s.kernel && *s.kernel > Kernel::compoundray)
    throw Error(
        "kernel: expected gaussian, pillbox or compoundray, which an acceptance angle says "
        "all of; others belong to the eye");
  for (std::size_t k = 0; k < s.delays_s.size(); ++k)
    if (s.delays_s.size() < 2 || !std::isfinite(s.delays_s[k]) ||
        s.delays_s[k] < (k == 0 ? 0.0 : s.delays_s[k - 1]))
      throw Error("delays_s: expected two or more growing delays from 0 on, found " +
                  std::to_string(s.delays_s[k]) + " as number " + std::to_string(k));
  if (!s.delays_s.empty() && shares_rays(s.sampling))
    throw Error(
        "sampling: Shared, not with an impulse response: rays of one delay would be shared");
  check_threads(s.threads);
}

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

}  // namespace

// What neighbours cannot share rays with.
static void check_sharing(const Eye& eye, const RenderSettings& settings) {
  if (!shares_rays(settings.sampling)) return;
  std::size_t lenses = 0;
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const auto refuse = [&](const char* what) {
      throw Error(std::string("sampling: Shared, not with ") + what + ", as ommatidium " +
                  std::to_string(i) + " has");
    };
    const Acceptance acceptance = rendered_acceptance(eye, settings, i);
    if (acceptance.kernel == Kernel::compoundray)
      refuse("the kernel compoundray, which is infinite at its axis");
    if (!is_round(acceptance)) refuse("a sensitivity that is not round");
    if (eye.aperture_diameter_m[i] > 0) refuse("an aperture");
    lenses += acceptance.kernel == Kernel::airy || acceptance.kernel == Kernel::lens_rhabdom;
  }
  // Among others they have their own rays; alone nothing would come of what was asked for.
  if (lenses > 0 && lenses == eye.size())
    throw Error(
        "sampling: Shared, not where all ommatidia have the kernels airy and lens_rhabdom, whose "
        "dark rings go on to the side");
}

// Of all ommatidia, as find_acceptances has it of some.
static float least_acceptance(const EyeView& eye, const DirectionsView& directions,
                              std::size_t ommatidia) {
  float least = INFINITY;
  for (std::size_t i = 0; i < ommatidia; ++i)
    least = std::min(least, acceptance_sr(directions.warps[eye.warp[i]], eye.scale[i]));
  return least;
}

Renderer::State::State(World seen, Eye its_eye, RenderSettings its_settings,
                       const DirectionTables* known)
    : world(std::move(seen)),
      eye(std::move(its_eye)),
      settings(std::move(its_settings)),
      threads(settings.threads),
      radiance(static_cast<std::size_t>(threads.threads)) {
  check_sharing(eye, settings);
  if (shares_rays(settings.sampling) && world.state().view.polarized)
    throw Error(
        "sampling: Shared, not in a polarised world: a ray that several ommatidia share has no one "
        "reference axis for its polarisation");
  if (settings.background) world = world.with_background(*settings.background);
  settings.background.reset();
  run_in_arena(*threads.arena, [&] {
    const auto start = Clock::now();
    const int first = first_samples(settings.sampling);
    const auto* target = std::get_if<ToError>(&settings.sampling);
    const bool of_frame_0 =
        settings.noise == Noise::frozen && std::holds_alternative<Fixed>(settings.sampling);
    directions.push_back(make_direction_tables(eye, settings, first, known, of_frame_0));
    for (int samples = 2 * first; target != nullptr && samples <= target->most; samples *= 2)
      directions.push_back(make_direction_tables(eye, settings, samples, &directions.front()));
    eye_arrays = make_eye_arrays(eye, directions.front());
    eye_view = omma::view(eye_arrays);
    for (const DirectionTables& tables : directions) direction_views.push_back(omma::view(tables));
    least_acceptance_sr = least_acceptance(eye_view, direction_views.front(), eye.size());
    if (target != nullptr) nearest = nearest_in_blocks(eye_arrays, most_per_block);
    if (shares_rays(settings.sampling)) shared_set(*this, 0);
    times.directions_s = seconds_since(start);
  });
}

Renderer::Renderer(World world, Eye eye, RenderSettings settings) {
  check_settings(settings);
  validate_eye(eye);
  state_ = std::make_unique<State>(std::move(world), std::move(eye), std::move(settings), nullptr);
}

Renderer::Renderer(const Renderer& same_world, Eye eye, RenderSettings settings) {
  check_settings(settings);
  validate_eye(eye);
  state_ = std::make_unique<State>(same_world.state_->world, std::move(eye), std::move(settings),
                                   &same_world.state_->directions.front());
}

Renderer::Renderer(const Renderer& same_eye, World world)
    : state_(std::make_unique<State>(std::move(world), same_eye.state_->eye,
                                     same_eye.state_->settings,
                                     &same_eye.state_->directions.front())) {}

Renderer::Renderer(std::shared_ptr<const Scene> scene, Eye eye, RenderSettings settings,
                   const std::function<bool(double)>& progress) {
  check_settings(settings);
  validate_eye(eye);
  WorldSettings of_world;
  of_world.threads = settings.threads;
  of_world.background = std::move(settings.background);
  World world(std::move(scene), std::move(of_world), progress);
  settings.background.reset();
  const auto finished = [&](double) { return progress(1); };
  run_watched(progress ? finished : Progress(), [&](WorkState&) {
    state_ =
        std::make_unique<State>(std::move(world), std::move(eye), std::move(settings), nullptr);
  });
  state_->times.scene_s = state_->world.build_times().scene_s;
  state_->times.acceleration_s = state_->world.build_times().acceleration_s;
}

void Renderer::render(std::span<const Mat4> world_from_head, std::span<float> responses,
                      const RenderCall& call) const {
  if (!call.instances.empty() || !call.world_from_node.empty() || !call.unseen.empty() ||
      !call.unseen_at.empty() || is_animated(*state_, call))
    return render_moving(*state_, world_from_head, responses, call);
  const Rendering rendering(state_->world);
  render_still(*state_, world_from_head, responses, call);
}

bool is_animated(const Renderer::State& s, const RenderCall& call) {
  if (call.times_s.empty()) return false;
  // With delays they may be the head's alone.
  const Rig* const rig = s.world.scene().rig.get();
  return s.settings.delays_s.empty() || (rig != nullptr && !rig->animations.empty());
}

void render_still(const Renderer::State& s, std::span<const Mat4> world_from_head,
                  std::span<float> responses, const RenderCall& call, const TimePart& part) {
  const std::size_t ommatidia = s.eye.size(), poses = world_from_head.size();
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
  if (!call.ray_radiance.empty()) {
    if (!call.standard_error.empty()) throw Error("ray_radiance: not together with standard_error");
    if (!std::holds_alternative<Fixed>(s.settings.sampling))
      throw Error("ray_radiance: only where every ommatidium has its own, equally many rays");
    if (call.ray_radiance.size() != poses * rays_size)
      throw Error("ray_radiance: expected room for " + std::to_string(poses * rays_size) +
                  " values (pose x ommatidium x sample x band), found " +
                  std::to_string(call.ray_radiance.size()));
  }
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
  std::vector<FrameMotion> motions(static_cast<std::size_t>(s.threads.threads));

  // One block of ommatidia at one pose is a task: some 512 rays, but no more than fit its sums.
  Blocks blocks{
      {s.view(), &s.eye_view, s.direction_views.data()}, &s.built(), static_cast<int>(ommatidia)};
  FrameView& frame = blocks.frame;
  frame.outputs = outputs.count;
  frame.radiance_unit = s.world.state().radiance_unit;
  if (!outputs.from_band.empty()) frame.output_from_band = outputs.from_band.data();
  if (!truth.tasks.empty()) frame.truth = &truth.view;
  DirectionsView some = s.direction_views.front();
  if (part.count > 1) {
    some.samples = samples_in(part, samples);
    some.part = part.index;
    some.part_bits = std::countr_zero(static_cast<unsigned>(part.count));
    frame.directions = &some;
  }
  if (to_error != nullptr) {
    frame.rounds = static_cast<int>(s.directions.size());
    frame.error = to_error->error;
    frame.relative_error = to_error->relative_error;
    frame.most_samples = to_error->most;
    frame.nearest = s.nearest.data();
  } else if (!call.standard_error.empty()) {
    frame.scrambles = error_scrambles;
  }
  const int rays_each = frame.directions->samples * frame.scrambles;
  blocks.per_block = std::clamp(block_rays / rays_each, 1,
                                std::min(most_per_block, block_capacity / frame.scrambles));
  // Neighbours are heard within a block, so that it is large whatever the least number of rays.
  if (to_error != nullptr)
    blocks.per_block = most_per_block;
  else
    std::fill(call.rays.begin(), call.rays.end(), rays_each);
  const std::size_t blocks_per_pose = blocks.count();
  const auto run_task = [&](std::size_t index) {
    const std::size_t p = index / blocks_per_pose;
    BlockTask task =
        make_task(blocks, index % blocks_per_pose, traced[p], s.frame_of(p, first_frame));
    task.sees = seen_at(call, p);
    task.motion = motion_of(path, p, part, motions[thread_in_arena()]);
    task.responses = responses.data() + p * pose_size;
    if (!call.standard_error.empty())
      task.standard_error = call.standard_error.data() + p * pose_size;
    if (!call.rays.empty()) task.rays = call.rays.data() + p * ommatidia;
    if (!call.ray_radiance.empty()) task.ray_radiance = call.ray_radiance.data() + p * rays_size;
    if (!truth.tasks.empty()) task.truth = &truth.tasks[p];
    trace_task(blocks, task);
  };
  const int most_rays = to_error != nullptr ? to_error->most : rays_each;
  run_in_stretches(poses * blocks_per_pose, static_cast<double>(most_rays) * blocks.per_block,
                   s.threads.threads, call.progress, [&](std::size_t begin, std::size_t end) {
                     run_in_arena(*s.threads.arena, [&] { parallel_for(begin, end, run_task); });
                   });
}

BlockTask make_task(const Blocks& blocks, std::size_t block, const Mat4& world_from_head,
                    std::uint64_t pose) {
  BlockTask task;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c)
      task.world_from_head[r][c] = static_cast<float>(world_from_head.m[r][c]);
  task.pose = pose;
  task.first = static_cast<int>(block) * blocks.per_block;
  task.count = std::min(blocks.per_block, blocks.ommatidia - task.first);
  return task;
}

void trace_task(const Blocks& blocks, const BlockTask& task) {
  blocks.built->functions.render(
      blocks.frame, task, blocks.built->acceleration.tracer.get(),
      thread_memory(ThreadBuffer::block, block_memory_bytes(blocks.frame)));
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

Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

const World& Renderer::world() const {
  return state_->world;
}
const Scene& Renderer::scene() const {
  return state_->world.scene();
}
const Eye& Renderer::eye() const {
  return state_->eye;
}
const RenderSettings& Renderer::settings() const {
  return state_->settings;
}
const BuildTimes& Renderer::build_times() const {
  return state_->times;
}
std::size_t Renderer::rays_per_frame() const {
  const Sampling& sampling = state_->settings.sampling;
  if (shares_rays(sampling)) return shared_set(*state_, 0).rays.rays.size();
  return state_->eye.size() * static_cast<std::size_t>(first_samples(sampling));
}
std::vector<char> Renderer::shared_ommatidia() const {
  if (!shares_rays(state_->settings.sampling)) return std::vector<char>(state_->eye.size(), 0);
  return shared_set(*state_, 0).rays.is_shared;
}
std::string Renderer::precision_warning(std::span<const Mat4> world_from_head) const {
  return state_->world.precision_warning(world_from_head);
}
int Renderer::threads() const {
  return state_->threads.threads;
}
std::string Renderer::backend() const {
  return state_->world.backend();
}

}  // namespace omma
