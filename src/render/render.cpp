// The main path: a world and an eye become a Renderer, poses become responses. What comes in is
// checked, what all frames share is built once; then each call is cut into blocks of neighbouring
// ommatidia (render_still.cpp). What happens inside a block is physics/block/block.h.
#include "omma/render.h"

#include <algorithm>
#include <cmath>

#include "omma/rig.h"
#include "render/render_state.h"
#include "sampling/sampling_choice.h"
#include "threads/arena.h"
#include "threads/parallel.h"

namespace omma {
namespace {

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
        "sampling: ToError expects an error above 0, a radiance, or a relative one, up to 1; "
        "found " +
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

// Whether the sizes of a population's eyes are those of its ommatidia, and it can be rendered.
static void check_population(const Eye& eye, const RenderSettings& settings) {
  if (settings.eye_sizes.empty()) return;
  std::int64_t sum = 0;
  for (const std::int32_t size : settings.eye_sizes) {
    if (size < 1)
      throw Error("eye_sizes: expected at least one ommatidium in each eye, found " +
                  std::to_string(size));
    sum += size;
  }
  if (sum != static_cast<std::int64_t>(eye.size()))
    throw Error("eye_sizes: expected " + std::to_string(eye.size()) + " ommatidia in all, found " +
                std::to_string(sum));
  if (!std::holds_alternative<Fixed>(settings.sampling))
    throw Error("sampling: expected Fixed for the eyes of a population");
  if (!settings.delays_s.empty())
    throw Error("delays_s: expected frames that do not last for the eyes of a population");
}

static std::vector<EyeSpan> spans_of_eyes(std::size_t ommatidia,
                                          const std::vector<std::int32_t>& eye_sizes) {
  if (eye_sizes.empty()) return {{0, ommatidia, 0}};
  std::vector<EyeSpan> eyes;
  std::size_t first = 0;
  for (const std::int32_t size : eye_sizes) {
    eyes.push_back({first, static_cast<std::size_t>(size), eyes.size()});
    first += static_cast<std::size_t>(size);
  }
  return eyes;
}

// Of all ommatidia, as find_acceptances has it of some.
static float least_acceptance(const EyeView& eye, const DirectionsView& directions,
                              std::size_t ommatidia) {
  float least = INFINITY;
  for (std::size_t i = 0; i < ommatidia; ++i)
    least = std::min(least, acceptance_sr(directions.warps[eye.warp[i]], eye.scale[i]));
  return least;
}

Renderer::State::State(World seen, Eye its_eye, RenderSettings its_settings, const State* known)
    : world(std::move(seen)),
      eye(std::move(its_eye)),
      settings(std::move(its_settings)),
      threads(settings.threads) {
  check_sharing(eye, settings);
  check_population(eye, settings);
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
    const auto known_of_round = [&](std::size_t round) -> const DirectionTables* {
      if (known != nullptr && round < known->directions.size()) return &known->directions[round];
      return directions.empty() ? nullptr : &directions.front();
    };
    directions.push_back(
        make_direction_tables(eye, settings, first, known_of_round(0), of_frame_0));
    for (int samples = 2 * first; target != nullptr && samples <= target->most; samples *= 2)
      directions.push_back(
          make_direction_tables(eye, settings, samples, known_of_round(directions.size())));
    eye_arrays = make_eye_arrays(eye, directions.front(), settings.eye_sizes);
    eye_view = omma::view(eye_arrays);
    eyes = spans_of_eyes(eye.size(), settings.eye_sizes);
    for (const DirectionTables& tables : directions) direction_views.push_back(omma::view(tables));
    least_acceptance_sr = least_acceptance(eye_view, direction_views.front(), eye.size());
    if (target != nullptr) nearest = nearest_in_blocks(eye_arrays, ommatidia_that_hear(eye.size()));
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
                                   same_world.state_.get());
}

Renderer::Renderer(const Renderer& same_eye, World world)
    : state_(std::make_unique<State>(std::move(world), same_eye.state_->eye,
                                     same_eye.state_->settings, same_eye.state_.get())) {}

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
      !call.unseen_at.empty() || is_animated(*state_, call)) {
    if (!state_->settings.eye_sizes.empty())
      throw Error("eye_sizes: expected a world that stands still for a population");
    return render_moving(*state_, world_from_head, responses, call);
  }
  const Rendering rendering(state_->world);
  render_still(*state_, world_from_head, responses, call);
}

bool is_animated(const Renderer::State& s, const RenderCall& call) {
  if (call.times_s.empty()) return false;
  // With delays they may be the head's alone.
  const Rig* const rig = s.world.scene().rig.get();
  return s.settings.delays_s.empty() || (rig != nullptr && !rig->animations.empty());
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
