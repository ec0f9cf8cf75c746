// What a thread needs of memory while it renders a block of ommatidia: numbers by band or output,
// whose count is known at run time only. One piece of memory holds all, at places aligned for
// vectors.
#pragma once

#include <cstddef>

#include "physics/path/flight.h"
#include "physics/rays/hits.h"
#include "physics/rays/replicates.h"
#include "physics/search/traverse.h"
#include "physics/views/light_view.h"
#include "physics/views/path_memory.h"
#include "physics/views/truth_view.h"

namespace omma {

// A bump allocator: arrays one behind the other; without memory it only counts.
struct Scratch {
  std::byte* begin = nullptr;
  std::size_t used = 0;  // bytes

  template <typename T>
  OMMA_HD T* take(std::size_t count) {
    constexpr std::size_t alignment = 64;
    T* at = begin == nullptr ? nullptr : reinterpret_cast<T*>(begin + used);
    used += (count * sizeof(T) + alignment - 1) / alignment * alignment;
    return at;
  }
};

// Of the ground truth (truth_sums.h), over the rays of each replicate.
struct TruthSums {
  int stride = 0;
  double* rows = nullptr;          // [row][stride], see TruthRows
  float* nearest_m = nullptr;      // [stride]
  std::int32_t* shares = nullptr;  // [replicate][group], rays
};

// Where the numbers of a ray lie among those that are summed up: its first three are whether it met
// anything, how far away, and the inverse of that.
struct TruthRows {
  int places, flow, sources, count;
};

OMMA_HD TruthRows rows_of(const TruthView& truth) {
  const int flow = truth.places ? 9 : 3;
  const int sources = truth.flow ? flow + 6 : flow;
  return {3, flow, sources, truth.sources ? sources + 2 : sources};
}

// Parts of the points on a disc, each all over it: the spread of how much of it they find open is
// the error (eye_discs.h). Together they are more even than apart, so that it is rather too large.
inline constexpr int disc_batches = 8;

// What is small and bright in a replicate's view, which it aims at (aims_in_view.h).
struct AimsInView {
  std::uint32_t bits[most_aims / 32];  // which of LightView::aims
  std::int32_t count = 0;
  float light = 0;  // bound on what they add to the response together
};

// Rendering to an error: what is known of the ommatidia of a block. What has a number for each
// output is [output][most_per_block], all else [most_per_block].
struct ErrorMemory {
  double *sums = nullptr, *squares = nullptr;  // over all rays so far; see estimate
  float *roughness = nullptr, *unseen = nullptr;
  double* of_cells = nullptr;       // variance that comes of cells of baked light
  double* wanted = nullptr;         // variance that is asked for
  double* roots = nullptr;          // sum over the rounds of the square roots of their rays
  std::int32_t* rays = nullptr;     // so far
  std::int32_t* next = nullptr;     // round to come, index into the directions; -1 for none
  std::int32_t* members = nullptr;  // list_members
  float* cell_errors = nullptr;     // as of PathMemory
  TruthSums truth;
};

// Something large that a function works on: in packets on the stack, in one lane, whose stack is
// small, in memory of the thread.
template <typename L, typename T>
struct InMemory {
  T own;
  template <typename Memory>
  OMMA_HD T& in(Memory*) {
    return own;
  }
};
template <typename T>
struct InMemory<Lanes<1, 1>, T> {
  OMMA_HD T& in(T* memory) { return *memory; }
};

// What has a number for each output of each replicate is [output][stride].
struct BlockMemory {
  int stride = 0;  // in packets padded_replicates, in one lane the scrambles of an ommatidium
  // [component][band][lane] of one packet, where worlds are lit of packets_at_once of them one
  // behind the other. Component 0 is the radiance; in a polarised world Q and U stand behind it.
  float* radiance = nullptr;
  PathMemory paths;
  float* output = nullptr;    // [output][lane] of one packet; the radiance itself without a matrix
  float* pairs = nullptr;     // [output][summed_rays], see pair_squares
  float* unsummed = nullptr;  // [output][unsummed_rays], see RaySums
  double* sums = nullptr;     // over the rays of each replicate
  double* square_sums = nullptr;  // the same of squares, where an error is to be reached
  // Where ground truth is asked for: [row][lane] of a packet, [row][unsummed_rays], sums.
  float *truth = nullptr, *unsummed_truth = nullptr;
  TruthSums truth_sums;
  ErrorMemory error;  // in packets; one lane is given its block's
  // In lit worlds: what a replicate sees of discs of the sky and of what it aims at (eye_discs.h,
  // aimed_rays.h) besides its rays, and the square of its error, [output].
  double *beside = nullptr, *beside_variance = nullptr;
  // Of the same replicate how much its rays bring (take_sizes), and the square of its error where
  // an error is to be reached, [output of discs].
  double *by_rays = nullptr, *by_rays_variance = nullptr;
  // Of one replicate, on a disc: sums [disc_batches][band]; its light and error, [2][band]; bounds
  // on what the whole of one adds, [band].
  double *disc_all = nullptr, *disc_seen = nullptr, *disc_light = nullptr, *disc_bound = nullptr;
  // Where moments of what is seen beside rays are asked for, [axis_moments] of them: of a
  // replicate, [moment][output]; of it on discs and of sums over points of one, [moment][band]; of
  // a cone, [moment][output].
  double *beside_moments = nullptr, *disc_moments = nullptr, *disc_all_moments = nullptr,
         *disc_seen_moments = nullptr, *aimed_moments = nullptr;
  // What replicates aim at, [replicate]; sums over the rays to one aim, [disc_batches][output].
  AimsInView* in_view = nullptr;
  double* aimed = nullptr;
  // In one lane: what InMemory is for, and what its search has still to visit.
  Replicates<Lanes<1, 1>>* replicates = nullptr;
  Packet<Lanes<1, 1>>* packet = nullptr;
  FirstHits<Lanes<1, 1>>* met = nullptr;
  Visits<1> visits;
};

// Rays that are summed up at once.
inline constexpr int summed_rays = 16;

// Rays that wait to be summed up: in packets those of replicates that are shorter than a packet,
// and what vector loops read behind them, up to a packet's width of replicates, each up to 15 rays
// long.
OMMA_HD constexpr int unsummed_rays(int lanes) {
  return lanes > 1 ? block_rays + 16 + 16 * 16 : summed_rays;
}

// Packets of a block whose paths are followed together in lit worlds.
OMMA_HD constexpr int packets_at_once(int lanes) {
  return lanes > 1 ? block_rays / lanes : 1;
}

// Whether standard errors have a part that is baked light's.
OMMA_HD bool has_cell_errors(const FrameView& frame) {
  const BakedView* baked = frame.scene->baked;
  return baked != nullptr && baked->errors != nullptr &&
         (frame.most_samples > 0 || frame.scrambles > 1);
}

OMMA_HD TruthSums lay_out_truth(Scratch& scratch, const TruthView& truth, int stride) {
  const auto replicates = static_cast<std::size_t>(stride);
  TruthSums sums;
  sums.stride = stride;
  sums.rows = scratch.take<double>(static_cast<std::size_t>(rows_of(truth).count) * replicates);
  sums.nearest_m = scratch.take<float>(replicates);
  sums.shares = scratch.take<std::int32_t>(static_cast<std::size_t>(truth.shares) * replicates);
  return sums;
}

OMMA_HD float* lay_out_cell_errors(Scratch& scratch, const FrameView& frame, int ommatidia) {
  return scratch.take<float>(static_cast<std::size_t>(ommatidia * cell_error_count(*frame.scene)));
}

// Of a frame that is rendered to an error.
OMMA_HD ErrorMemory lay_out_error(Scratch& scratch, const FrameView& frame) {
  constexpr std::size_t ommatidia = most_per_block;
  const std::size_t outputs = static_cast<std::size_t>(frame.outputs) * ommatidia;
  ErrorMemory error;
  for (double** values : {&error.sums, &error.squares, &error.of_cells, &error.wanted})
    *values = scratch.take<double>(outputs);
  error.roughness = scratch.take<float>(outputs);
  error.unseen = scratch.take<float>(outputs);
  error.roots = scratch.take<double>(ommatidia);
  error.rays = scratch.take<std::int32_t>(ommatidia);
  error.next = scratch.take<std::int32_t>(ommatidia);
  error.members = scratch.take<std::int32_t>(ommatidia);
  if (has_cell_errors(frame))
    error.cell_errors = lay_out_cell_errors(scratch, frame, most_per_block);
  if (frame.truth != nullptr) error.truth = lay_out_truth(scratch, *frame.truth, most_per_block);
  return error;
}

// What rays remember of the surfaces that they have passed. Numbers of a lane lie together, as what
// is taken apart is 64 bytes at least.
OMMA_HD void lay_out_passed(Scratch& scratch, int lanes, SpectraMemory& rays) {
  const auto count = static_cast<std::size_t>(lanes);
  rays.passed.count = scratch.take<std::int32_t>(4 * count);
  if (rays.passed.count != nullptr) {
    rays.media.material = rays.passed.count + count;
    rays.media.came = rays.passed.count + 2 * count;
    rays.media.from_m = reinterpret_cast<float*>(rays.passed.count + 3 * count);
  }
  rays.passed.surface = scratch.take<PassedSurface>(count * PassedSurfaces::capacity);
}

OMMA_HD Visits<1> lay_out_visits(Scratch& scratch) {
  return {scratch.take<Visit<1>>(stack_capacity(most_tree_depth)),
          scratch.take<Visit<1>>(stack_capacity(most_top_depth))};
}

// Outputs that light of discs, which is unpolarised, is in: the first ones.
OMMA_HD int outputs_of_discs(const FrameView& frame) {
  return frame.output_from_band == nullptr ? frame.scene->bands : frame.outputs;
}

// What replicates see besides their rays, in lit worlds. Discs are done with before rays are aimed.
OMMA_HD void lay_out_beside(Scratch& scratch, const FrameView& frame, BlockMemory& memory) {
  const auto outputs = static_cast<std::size_t>(frame.outputs);
  const auto bands = static_cast<std::size_t>(frame.scene->bands);
  memory.beside = scratch.take<double>(outputs);
  memory.beside_variance = scratch.take<double>(outputs);
  if (frame.beside_moments) memory.beside_moments = scratch.take<double>(axis_moments * outputs);
  Scratch discs = scratch;
  if (frame.beside_moments)
    for (double** const moments :
         {&memory.disc_moments, &memory.disc_all_moments, &memory.disc_seen_moments})
      *moments = discs.take<double>(axis_moments * bands);
  for (double** const values : {&memory.by_rays, &memory.by_rays_variance})
    *values = discs.take<double>(static_cast<std::size_t>(outputs_of_discs(frame)));
  memory.disc_all = discs.take<double>(disc_batches * bands);
  memory.disc_seen = discs.take<double>(disc_batches * bands);
  memory.disc_light = discs.take<double>(2 * bands);
  memory.disc_bound = discs.take<double>(bands);
  if (frame.scene->light->aim_count > 0) {
    memory.aimed = scratch.take<double>(disc_batches * outputs);
    if (frame.beside_moments) memory.aimed_moments = scratch.take<double>(axis_moments * outputs);
  }
  scratch.used = discs.used > scratch.used ? discs.used : scratch.used;
}

// What a thread needs that goes through packets of so many lanes.
OMMA_HD BlockMemory lay_out(Scratch& scratch, const FrameView& frame, int lanes) {
  const auto outputs = static_cast<std::size_t>(frame.outputs);
  const auto packet = static_cast<std::size_t>(lanes);
  const auto unsummed = static_cast<std::size_t>(unsummed_rays(lanes));
  BlockMemory memory;
  memory.stride = lanes > 1 ? padded_replicates(lanes) : frame.scrambles;
  const std::size_t replicates = outputs * static_cast<std::size_t>(memory.stride);
  const SceneView& scene = *frame.scene;
  const std::size_t one = static_cast<std::size_t>(scene.bands) * packet;
  const std::size_t components = scene.polarized ? 3 : 1;
  const auto packets =
      scene.light == nullptr ? 1 : static_cast<std::size_t>(packets_at_once(lanes));
  memory.radiance = scratch.take<float>(components * one * packets);
  if (lets_through(scene)) {
    lay_out_passed(scratch, lanes, memory.paths);
    if (scene.light != nullptr) lay_out_passed(scratch, lanes, memory.paths.shadow);
  }
  if (scene.light != nullptr) {
    PathMemory& paths = memory.paths;
    // As WaitingPaths has scratch, which one lane has no need of.
    const bool by_band = mirrors_by_band(scene);
    if (lanes > 1) {
      const std::size_t rows = by_band ? 10 : 1;
      paths.waiting = scratch.take<float>(3 * rows * one);
      paths.waiting_for_last = scratch.take<float>(3 * rows * one);
    }
    if (by_band) paths.mueller = scratch.take<float>(9 * one);
    for (SpectraMemory* spectra : {static_cast<SpectraMemory*>(&paths), &paths.shadow})
      for (float** values : {&spectra->throughput, &spectra->reflectance, &spectra->transmittance,
                             &spectra->emission, &spectra->tint})
        *values = scratch.take<float>(one);
    paths.light = scratch.take<float>(components * one);
    paths.found = scratch.take<float>(components * one);
    paths.front = scratch.take<float>(one);
    paths.back = scratch.take<float>(one);
  }
  memory.output =
      frame.output_from_band == nullptr ? memory.radiance : scratch.take<float>(outputs * packet);
  const bool to_error = frame.most_samples > 0;
  memory.sums = scratch.take<double>(replicates);
  if (to_error) memory.square_sums = scratch.take<double>(replicates);
  if (scene.light != nullptr && scene.light->aim_count > 0)
    memory.in_view = scratch.take<AimsInView>(static_cast<std::size_t>(padded_replicates(lanes)));
  if (frame.truth != nullptr)
    memory.truth_sums = lay_out_truth(scratch, *frame.truth, memory.stride);
  if (to_error && lanes > 1) memory.error = lay_out_error(scratch, frame);
  if (to_error)
    memory.paths.cell_errors = memory.error.cell_errors;
  else if (has_cell_errors(frame))
    memory.paths.cell_errors = lay_out_cell_errors(scratch, frame, lanes > 1 ? most_per_block : 1);
  if (lanes == 1) {
    memory.replicates = scratch.take<Replicates<Lanes<1, 1>>>(1);
    memory.packet = scratch.take<Packet<Lanes<1, 1>>>(1);
    if (frame.truth != nullptr) memory.met = scratch.take<FirstHits<Lanes<1, 1>>>(1);
    memory.visits = lay_out_visits(scratch);
  }
  // What is seen besides rays is looked at when those that wait to be summed up are gone.
  Scratch beside = scratch;
  if (scene.light != nullptr) lay_out_beside(beside, frame, memory);
  memory.unsummed = scratch.take<float>(outputs * unsummed);
  if (to_error) memory.pairs = scratch.take<float>(outputs * summed_rays);
  if (frame.truth != nullptr) {
    const auto rows = static_cast<std::size_t>(rows_of(*frame.truth).count);
    memory.truth = scratch.take<float>(rows * packet);
    memory.unsummed_truth = scratch.take<float>(rows * unsummed);
  }
  scratch.used = beside.used > scratch.used ? beside.used : scratch.used;
  return memory;
}

}  // namespace omma
