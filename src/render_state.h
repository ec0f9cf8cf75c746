// What a Renderer holds, and the parallel loops that its ways of rendering have in common:
// render.cpp (each ommatidium its own rays) and render_shared.cpp (rays shared by neighbours).
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "backend/backend.h"
#include "backend/eye_arrays.h"
#include "backend/shading_data.h"
#include "model/long_work.h"
#include "omma/render.h"
#include "sampling/directions.h"
#include "sampling/shared_rays.h"
#include "threads/made_once.h"

namespace omma {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// What depends on the scene alone, shared by all renderers of it.
struct BuiltScene {
  std::shared_ptr<const Scene> scene;
  std::unique_ptr<ShadingData> shading;
  BlockFunctions functions;
  Acceleration acceleration;
};

// A background ready to be looked at; it may be a large image, so renderers share it.
struct BuiltBackground {
  Background given;     // the data refer to its image
  BackgroundData data;  // of `given`, or of the scene's own
};

// Rays that neighbouring ommatidia share, ready to be traced.
struct SharedSet {
  SharedRays rays;
  DirectionTables directions;
  EyeArrays arrays;
  DirectionsView directions_view;
  EyeView eye_view;
};

struct Renderer::State {
  std::shared_ptr<const BuiltScene> built;
  std::shared_ptr<const BuiltBackground> background;
  Eye eye;
  RenderSettings settings;
  BuildTimes times;
  int threads = 1;

  std::unique_ptr<oneapi::tbb::task_arena> arena;

  SceneView view;                           // of the built scene, with this background
  std::vector<DirectionTables> directions;  // [round]
  EyeArrays eye_arrays;
  std::vector<DirectionsView> direction_views;  // [round]
  EyeView eye_view;
  std::vector<std::uint8_t> nearest;  // nearest_in_blocks, where there is an error to reach

  // Rays shared by neighbours: the first set is used at all poses, the others for standard errors.
  mutable std::array<MadeOnce<SharedSet>, error_scrambles> shared;

  // In a process without threads (threads_are_gone) what has to do with them is left where it is.
  ~State();

  static void prepare_threads(State& s, const RenderSettings& settings);
  static void prepare_eye(State& s, Eye eye, RenderSettings settings,
                          const DirectionTables* known = nullptr);
};

// One frame's tracing as tasks of neighbouring ommatidia.
struct Blocks {
  FrameView frame;
  const BuiltScene* built = nullptr;
  int ommatidia = 0, per_block = 1;

  std::size_t count() const {
    return (static_cast<std::size_t>(ommatidia) + static_cast<std::size_t>(per_block) - 1) /
           static_cast<std::size_t>(per_block);
  }
};

// Task `block` of a frame; the caller adds where results go.
BlockTask make_task(const Blocks& blocks, std::size_t block, const Mat4& world_from_head,
                    std::uint64_t pose);

// Traces a task, on this thread.
void trace_task(const Blocks& blocks, const BlockTask& task);

// What the call's responses are made of: the bands themselves, or a mixture of them for each output.
struct Outputs {
  int count = 0;
  std::vector<float> from_band;  // [output][band], empty for the bands
};

// Runs run(begin, end) over all tasks in stretches of about a fifth of a second, so that the caller
// hears of progress and can cancel; short renders are one stretch, and the first is short enough
// for the slowest scenes, but a task for each thread. Nobody to tell: all is one stretch.
void run_in_stretches(std::size_t tasks, double rays_per_task, int threads,
                      const std::function<bool(double)>& progress,
                      const std::function<void(std::size_t, std::size_t)>& run);

// The set of shared rays number `pattern`, made if it is not there yet.
const SharedSet& shared_set(const Renderer::State& state, int pattern);

// Renderer::render with settings.share_rays, arguments checked.
void render_shared(const Renderer::State& state, std::span<const Mat4> world_from_head,
                   std::span<float> responses, const RenderCall& call, const Outputs& outputs);

}  // namespace omma
