// What a Renderer holds, and what its ways of rendering have in common: render_still.cpp (each
// ommatidium its own rays) and render_shared.cpp (rays shared by neighbours).
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <vector>

#include "backend/backend.h"
#include "backend/eye_arrays.h"
#include "omma/render.h"
#include "render/render_motion.h"
#include "sampling/directions.h"
#include "sampling/shared_rays.h"
#include "threads/arena.h"
#include "threads/made_once.h"
#include "world/world_state.h"

namespace omma {

// Rays that neighbouring ommatidia share, ready to be traced.
struct SharedSet {
  SharedRays rays;
  DirectionTables directions;
  EyeArrays arrays;
  DirectionsView directions_view;
  EyeView eye_view;
};

// Ommatidia of an eye, one behind the other.
struct EyeSpan {
  std::size_t first, count;
  std::size_t eye;  // of a population
};

struct Renderer::State {
  World world;
  Eye eye;
  RenderSettings settings;
  BuildTimes times;
  ThreadArena threads;

  std::vector<DirectionTables> directions;  // [round]
  EyeArrays eye_arrays;
  std::vector<DirectionsView> direction_views;  // [round]
  EyeView eye_view;
  std::vector<EyeSpan> eyes;          // of a population, or the one that there is
  float least_acceptance_sr = 0;      // of the eye's; find_acceptances
  std::vector<std::uint8_t> nearest;  // nearest_in_blocks, where there is an error to reach

  // Rays shared by neighbours: the first set is used at all poses, the others for standard errors.
  mutable std::array<MadeOnce<SharedSet>, error_scrambles> shared;

  mutable std::atomic<std::uint64_t> frames = 0;  // rendered so far, with Noise::new_every_frame

  // Checks both. Direction tables take over from `known` what they have in common.
  State(World seen, Eye its_eye, RenderSettings its_settings, const State* known);

  const BuiltScene& built() const { return *world.state().built; }
  const SceneView* view() const { return &world.state().view; }
  // The frame number that random numbers are hashed from: 0 with frozen noise.
  std::uint64_t frame_of(std::size_t pose, std::uint64_t first) const {
    return settings.noise == Noise::frozen ? 0 : first + pose;
  }
};

// One frame's tracing as tasks of neighbouring ommatidia.
struct Blocks {
  FrameView frame;
  const BuiltScene* built = nullptr;
  int ommatidia = 0, per_block = 1;
  std::vector<EyeSpan> of_eyes = {};  // of a population, whose eyes have blocks of their own

  std::size_t count() const {
    if (!of_eyes.empty()) return of_eyes.size();
    return (static_cast<std::size_t>(ommatidia) + static_cast<std::size_t>(per_block) - 1) /
           static_cast<std::size_t>(per_block);
  }
  EyeSpan at(std::size_t block) const {
    if (!of_eyes.empty()) return of_eyes[block];
    const std::size_t first = block * static_cast<std::size_t>(per_block);
    return {
        first,
        std::min(static_cast<std::size_t>(per_block), static_cast<std::size_t>(ommatidia) - first),
        0};
  }
  std::size_t eye_of(std::size_t block) const { return of_eyes.empty() ? 0 : of_eyes[block].eye; }
};

// Task `block` of a frame; the caller adds where results go.
BlockTask make_task(const Blocks& blocks, std::size_t block, const Mat4& world_from_head,
                    std::uint64_t pose);

// Traces tasks, on the threads of the arena.
void trace_tasks(const Blocks& blocks, std::span<const BlockTask> tasks);

// Outputs of a call: the bands themselves, or linear combinations of them.
struct Outputs {
  int count = 0;
  std::vector<float> from_band;  // [output][band], empty for the bands
};

// Runs run(begin, end) over all tasks in pieces of about a fifth of a second, so that the caller
// hears of progress and can cancel. Short renders are one piece; the first piece is short enough
// for the slowest scenes, but at least a task for each thread. Without `progress` all is one piece.
void run_in_stretches(std::size_t tasks, double rays_per_task, int threads,
                      const std::function<bool(double)>& progress,
                      const std::function<void(std::size_t, std::size_t)>& run);

// The set of shared rays number `pattern`, made if it is not there yet.
const SharedSet& shared_set(const Renderer::State& state, int pattern);

// Renderer::render of a world that stands still meanwhile: its caller sees to that. Of frames that
// last also a part alone.
void render_still(const Renderer::State& state, std::span<const Mat4> world_from_head,
                  std::span<float> responses, const RenderCall& call, const TimePart& part = {});

// The mask of a pose's rays (RayPacket::mask): each group has a bit, which instances that it does
// not see lack.
inline SeenMasks seen_at(const RenderCall& call, std::size_t pose) {
  if (call.unseen_at.empty() || call.unseen_at[pose] < 0) return {};
  const std::uint32_t own = 1u << call.unseen_at[pose];
  return {own, call.unseen_by_light ? own : all_seen};
}

// Whether the call's times say where things are that animations move.
bool is_animated(const Renderer::State& state, const RenderCall& call);

// Renderer::render where things move from pose to pose (render_moving.cpp).
void render_moving(const Renderer::State& state, std::span<const Mat4> world_from_head,
                   std::span<float> responses, const RenderCall& call);

// Renderer::render with Shared, arguments checked.
void render_shared(const Renderer::State& state, std::span<const Mat4> world_from_head,
                   std::span<float> responses, const RenderCall& call, const Outputs& outputs);

}  // namespace omma
