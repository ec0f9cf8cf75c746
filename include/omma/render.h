// The renderer: a world and an eye in, the response of every ommatidium out.
//
//   R[p,i,b] = integral of S_i(w) L_b(x_i, w) dw / integral of S_i(w) dw
//
// S_i is the angular sensitivity around the axis of ommatidium i, L_b the radiance arriving at its
// nodal point in band b. A surround of radiance 1 gives 1. Linear, never clipped.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "omma/error.h"
#include "omma/eye.h"
#include "omma/kernel.h"
#include "omma/scene.h"
#include "omma/truth.h"
#include "omma/world.h"

namespace omma {

inline constexpr int max_samples = 1 << 20;
inline constexpr int max_shared_samples = 256;

// As many rays for every ommatidium.
struct Fixed {
  int samples = 16;  // rays per ommatidium and scramble, 1 to max_samples

  bool operator==(const Fixed&) const = default;
};

// Rays go on in rounds, to the ommatidia that need them, until the estimated standard error of each
// response is at most `error`, or at most `relative_error` times the response, whichever is larger,
// or an ommatidium has had `most` rays. At least one of both is above 0. Q and U of polarised light
// are measured by I.
struct ToError {
  double error = 0;           // radiance; 1 is full scale
  int least = 8;              // rays of the first round, a power of two from 4 on
  int most = 4096;            // least to max_samples
  double relative_error = 0;  // up to 1

  bool operator==(const ToError&) const = default;
};

// Neighbouring ommatidia share rays: about `samples` per ommatidium in all, but each uses those of
// its neighbours too, through their nodal points. Far less error for the same rays; surfaces at a
// distance d are seen with an acceptance angle 1 + R/d times as wide on an eye of radius R. Not
// with random points, apertures, or sensitivities that are not round or `compoundray`, nor where
// rays or weights would be too many (2^23 rays, 2^27 weights).
struct Shared {
  int samples = 16;  // 1 to max_shared_samples

  bool operator==(const Shared&) const = default;
};

using Sampling = std::variant<Fixed, ToError, Shared>;

// A value that an option can have, and what it is called where options are set by name.
template <typename Value>
struct NamedValue {
  const char* name;
  Value value;
};

// Where in its angular sensitivity an ommatidium's rays go.
enum class Points : std::uint8_t {
  low_discrepancy,  // scrambled Sobol points moved apart, another set per pose and ommatidium
  random,           // independent pseudo-random samples
};
inline constexpr NamedValue<Points> points_names[] = {{"low_discrepancy", Points::low_discrepancy},
                                                      {"random", Points::random}};

// Each estimate takes one of many patterns of rays, so responses have noise; this says which.
enum class Noise : std::uint8_t {
  // One pattern for each ommatidium, fixed to the head and the same at all poses: a still eye in a
  // still world sees nothing move.
  frozen,
  // Another pattern for every frame that is rendered: means over frames come ever nearer to the
  // truth, and what stands still flickers.
  new_every_frame,
};
inline constexpr NamedValue<Noise> noise_names[] = {{"frozen", Noise::frozen},
                                                    {"new_every_frame", Noise::new_every_frame}};

// RenderSettings::kernel
inline constexpr NamedValue<std::optional<Kernel>> kernel_names[] = {
    {"own", std::nullopt},
    {"gaussian", Kernel::gaussian},
    {"pillbox", Kernel::pillbox},
    {"compoundray", Kernel::compoundray}};

struct RenderSettings {
  Sampling sampling = Fixed{};
  std::uint64_t seed = 0;
  // None: each ommatidium's own angular sensitivity. Else all have this one (gaussian, pillbox or
  // compoundray), as wide as their acceptance angles.
  std::optional<Kernel> kernel = std::nullopt;
  Points points = Points::low_discrepancy;
  int threads = 0;                                      // 0: one per hardware thread
  std::optional<Background> background = std::nullopt;  // instead of the world's own
  // Rays read textures averaged over their part of the solid angle: less noise, and the acceptance
  // function's modulation transfer stays within 0.01.
  bool footprints = true;
  Noise noise = Noise::frozen;  // only frozen with Shared, whose rays are fixed to the head
  // Of a population: how many ommatidia each of its eyes has, which stand one eye behind the other.
  // Each eye is rendered as if it were alone, at poses of its own: poses are [pose][eye]. Only with
  // Fixed rays, while nothing moves. Empty: all ommatidia are of one head.
  std::vector<std::int32_t> eye_sizes = {};
  // What photoreceptors make of time: how long before a frame light falls on them that counts in
  // it, s, as quantiles at equal steps of probability, from the least to the greatest. Each ray
  // draws a delay and is sent from where the head was then. Empty: frames are instants.
  std::vector<double> delays_s = {};
};

// Calls f(name, option) for each option that can be set by name, as from Python, and where its
// values have names f(name, option, their names). A new option is a member above and a line here.
template <typename Settings, typename F>  // RenderSettings, const or not
void for_each_option(Settings& settings, F&& f) {
  f("seed", settings.seed);
  f("kernel", settings.kernel, kernel_names);
  f("points", settings.points, points_names);
  f("threads", settings.threads);
  f("footprints", settings.footprints);
  f("noise", settings.noise, noise_names);
}

// Scrambles that a standard error is computed from: with one asked for, every ommatidium gets this
// many independent estimates of `samples` rays; the response is their mean.
inline constexpr int error_scrambles = 8;

inline constexpr std::size_t most_unseen = 31;
inline constexpr std::size_t beside_rows = 5;  // of RenderCall::beside_rays

struct RenderCall {
  // With Noise::new_every_frame, the number of the first pose's frame, for renders done piece by
  // piece. None: frames are counted on by the renderer, from 0, in the order of the calls.
  std::optional<std::uint64_t> first_pose = std::nullopt;
  std::span<float> standard_error;  // [pose, ommatidium, band], or empty for none
  // [pose, ommatidium], rays that each response comes from, or empty; where rays are shared, each
  // counts for all that use it.
  std::span<std::int32_t> rays;
  // Of a polarised world: Q and U of the bands stand behind their I, [.., component x band].
  bool stokes = false;
  // Where not empty, responses are mixtures of the bands, one for each row: [output, band], or in a
  // polarised world [output, component, band]. What was [.., band] everywhere else is then
  // [.., output], and errors are those of the mixtures.
  std::span<const double> output_from_band;
  // Radiance that each single ray brought, [pose, ommatidium, sample, band], or empty for none.
  // Not together with standard_error.
  std::span<float> ray_radiance;
  // What responses have besides those rays, as they leave it out: discs of the sky and what
  // ommatidia aim at; and its moments about the axis a, ∫ S L times θ² and times (θ/sin θ)
  // (d − (d·a) a), three rows, d the direction in the world and θ its angle from a. [pose,
  // ommatidium, row, band], or empty for none. Where ray_radiance may be asked for.
  std::span<float> beside_rays;
  TruthCall truth;  // from the same rays; neither with Shared nor where things move
  // What moves from pose to pose, as World::set_transforms has it: [thing], and where each is at
  // each pose, [pose][thing]. Afterwards it is where it was before; meanwhile nothing else of this
  // world is rendered. Errors are also those of set_transforms.
  std::span<const int> instances;
  std::span<const Mat4> world_from_node;
  // Groups of things that rays do not meet on their way from the eye, as an animal's own body,
  // [group], things; and whose rays each pose has, [pose], a group or -1, which meets all. At most
  // most_unseen groups. Light has what a group does not see, in shadows and in mirrors, unless
  // `unseen_by_light`; what was baked, and a sun's shadow map, have it as it was then.
  std::span<const std::vector<int>> unseen;
  std::span<const int> unseen_at;
  bool unseen_by_light = false;
  // When each pose is, [pose], s. What the scene's animations move is where it is then, as
  // World::set_time has it; things that are among `instances` go where those say. With delays times
  // grow: between poses the head and things move on a straight way and turn evenly (slerp), before
  // the first they stood still. The head moves for each ray by itself; where things move while a
  // frame lasts, its rays see them at one of up to 32 times (with Fixed alone), and standard errors
  // are as of so many independent parts, which is too much rather than too little.
  std::span<const double> times_s;
  std::span<const int> animations;
  // With delays: poses before the first, for frames that are rendered piece by piece, when they
  // were, and where things were then, [past pose][thing], or empty where they were as at the first
  // pose.
  std::span<const Mat4> past_world_from_head;
  std::span<const Mat4> past_world_from_node;
  std::span<const double> past_times_s;
  // Called from the calling thread several times a second with the finished fraction (0 to 1);
  // false cancels the render, which then throws omma::Cancelled.
  std::function<bool(double)> progress;
};

// Seconds spent when the renderer was made; those of the world are 0 where that was there already.
struct BuildTimes {
  double scene_s = 0;         // shading data
  double acceleration_s = 0;  // acceleration structure
  double directions_s = 0;    // direction tables
};

class Renderer {
 public:
  struct State;  // src/render/render_state.h

  // An eye in a world, which it shares: what moves there has moved for this eye too. Makes the
  // direction tables; throws omma::Error.
  Renderer(World world, Eye eye, RenderSettings settings = {});
  // Makes a world of the scene first, with these threads and background; `progress` is told of that
  // and can end it (world.h).
  Renderer(std::shared_ptr<const Scene> scene, Eye eye, RenderSettings settings = {},
           const std::function<bool(double)>& progress = {});
  // Another eye, or other settings, in the world of a renderer: what both need is taken from there.
  // Lives on when `same_world` is gone.
  Renderer(const Renderer& same_world, Eye eye, RenderSettings settings = {});
  // The same eye and settings in another world.
  Renderer(const Renderer& same_eye, World world);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  // Responses [pose, ommatidium, band], linear float32, for poses `world_from_head`, which of a
  // population are [pose, eye]. Safe to call from several threads. The same inputs and seed give
  // the same bits whatever the number of threads. Throws omma::Error on an output of the wrong
  // size, a pose that is not invertible or starts rays over 1e18 m from the scene, and while things
  // are being moved in the world; omma::Cancelled when the progress callback says so.
  void render(std::span<const Mat4> world_from_head, std::span<float> responses,
              const RenderCall& call = {}) const;

  // Where the rays look whose radiance is RenderCall::ray_radiance of as many poses from frame
  // `first_pose` on: unit, in the world, [pose, ommatidium, sample, x y z]. Of heads that rest
  // while a frame lasts. Throws as render does.
  void ray_directions(std::span<const Mat4> world_from_head, std::uint64_t first_pose,
                      std::span<float> directions) const;

  // A scene is traced in single precision relative to an origin near it, so that it may lie
  // anywhere; but in one of many kilometres, or from very far, rays and surfaces are placed less
  // exactly. A sentence that says how exactly at the worst of these poses, where that matters; else
  // "".
  std::string precision_warning(std::span<const Mat4> world_from_head) const;

  const World& world() const;
  const Scene& scene() const;
  const Eye& eye() const;
  const RenderSettings& settings() const;
  const BuildTimes& build_times() const;
  // That a render uses: as many as were asked for, at most those that oneTBB allows.
  int threads() const;
  // Rays that a frame takes without a standard error; with an error to reach, at least.
  std::size_t rays_per_frame() const;
  // [ommatidium], 1 where its rays count for its neighbours too (with Shared) and theirs for it.
  // Those have their own that would gain nothing, and those that cannot: an acceptance angle of 0,
  // `airy` and `lens_rhabdom`, fields too narrow for a lattice over the sphere.
  std::vector<char> shared_ommatidia() const;
  std::string backend() const;  // e.g. "embree 3.13.5"

 private:
  std::unique_ptr<State> state_;
};

}  // namespace omma
