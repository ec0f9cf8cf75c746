// What a thread needs of memory while it renders a block of ommatidia: numbers by band or output,
// whose count is known at run time only. One piece of memory holds all, at places aligned for
// vectors.
#pragma once

#include <cstddef>

#include "physics/rays/replicates.h"
#include "physics/views/light_view.h"
#include "physics/views/path_memory.h"

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
  double* rows = nullptr;          // [row][padded_capacity], see TruthRows
  float* nearest_m = nullptr;      // [padded_capacity]
  std::int32_t* shares = nullptr;  // [replicate][group], rays
};

// Where the numbers of a ray lie among those that are summed up: its first three are whether it met
// anything, how far away, and the inverse of that.
struct TruthRows {
  int places, flow, count;
};

OMMA_HD TruthRows rows_of(const TruthView& truth) {
  const int flow = truth.places ? 9 : 3;
  return {3, flow, truth.flow ? flow + 6 : flow};
}

// Parts of the points on a disc, each all over it: the spread of how much of it they find open is
// the error (eye_discs.h). Together they are more even than apart, so that it is rather too large.
inline constexpr int disc_batches = 8;

// Directions in which a replicate sees something small and bright (aimed_rays.h).
struct AimCone {
  Vec3 direction;                   // unit
  float chord_2 = 0, solid_sr = 0;  // of its rim, as of DiscView; its solid angle
  float most = 0;                   // bound on what it adds to the response
};
inline constexpr int most_cones = 8;

// What has a number for each output of each replicate is [output][padded_capacity].
struct BlockMemory {
  // [component][band][lane] of one packet, where worlds are lit of block_rays of them one behind
  // the other. Component 0 is the radiance; in a polarised world Q and U stand behind it.
  float* radiance = nullptr;
  PathMemory paths;
  float* output = nullptr;   // [output][lane] of one packet; the radiance itself without a matrix
  float* squares = nullptr;  // [output][lane] of one packet, see pair_squares
  float* short_rays = nullptr;  // [output][short_capacity], see add_short_replicates
  double* sums = nullptr;       // over the rays of each replicate
  // Rendering to an error: sums of a round, squares of a round and of all; see estimate.
  double *round_sums = nullptr, *round_squares = nullptr, *all_squares = nullptr;
  float *roughness = nullptr, *unseen = nullptr;
  double* of_cells = nullptr;  // variance that comes of cells of baked light
  double* wanted = nullptr;    // variance that is asked for
  // Where ground truth is asked for: [row][lane] of a packet, [row][short_capacity], sums over all
  // rays and over those of a round.
  float *truth = nullptr, *short_truth = nullptr;
  TruthSums truth_sums, truth_round_sums;
  // In lit worlds: what replicates see of discs of the sky and of what they aim at (eye_discs.h,
  // aimed_rays.h) besides their rays, and the square of its error.
  double *beside = nullptr, *beside_variance = nullptr;
  // Of one replicate, on a disc: sums [disc_batches][band]; its light and error, [2][band].
  double *disc_all = nullptr, *disc_seen = nullptr, *disc_light = nullptr;
  // Cones that replicates aim at, [replicate][most_cones], how many, [replicate]; sums of one,
  // [disc_batches][output].
  AimCone* cones = nullptr;
  std::int32_t* cone_count = nullptr;
  double* aimed = nullptr;
};

// Rays of replicates that are shorter than a packet, and what vector loops read behind them: up to
// a packet's width of replicates, each up to 15 rays long.
inline constexpr int short_capacity = block_rays + 16 + 16 * 16;

// Whether standard errors have a part that is baked light's.
OMMA_HD bool has_cell_errors(const FrameView& frame) {
  const BakedView* baked = frame.scene->baked;
  return baked != nullptr && baked->errors != nullptr &&
         (frame.most_samples > 0 || frame.scrambles > 1);
}

OMMA_HD BlockMemory lay_out(Scratch& scratch, const FrameView& frame, int lanes) {
  const auto outputs = static_cast<std::size_t>(frame.outputs);
  const auto packet = static_cast<std::size_t>(lanes);
  const std::size_t replicates = outputs * padded_capacity;
  BlockMemory memory;
  const SceneView& scene = *frame.scene;
  const std::size_t one = static_cast<std::size_t>(scene.bands) * packet;
  const std::size_t components = scene.polarized ? 3 : 1;
  const std::size_t packets = scene.light == nullptr ? 1 : block_rays / packet;
  memory.radiance = scratch.take<float>(components * one * packets);
  if (scene.light != nullptr) {
    PathMemory& paths = memory.paths;
    // As WaitingPaths has scratch.
    paths.waiting = scratch.take<float>(3 * one);
    paths.waiting_for_last = scratch.take<float>(3 * one);
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
  memory.short_rays = scratch.take<float>(outputs * short_capacity);
  memory.sums = scratch.take<double>(replicates);
  if (frame.most_samples > 0) {
    memory.squares = scratch.take<float>(outputs * packet);
    memory.round_sums = scratch.take<double>(replicates);
    memory.round_squares = scratch.take<double>(replicates);
    memory.all_squares = scratch.take<double>(replicates);
    memory.roughness = scratch.take<float>(replicates);
    memory.unseen = scratch.take<float>(replicates);
    memory.of_cells = scratch.take<double>(replicates);
    memory.wanted = scratch.take<double>(replicates);
  }
  if (scene.light != nullptr) {
    const auto bands = static_cast<std::size_t>(scene.bands);
    memory.beside = scratch.take<double>(replicates);
    memory.beside_variance = scratch.take<double>(replicates);
    if (scene.light->aim_count > 0) {
      memory.cones = scratch.take<AimCone>(std::size_t{padded_capacity} * most_cones);
      memory.cone_count = scratch.take<std::int32_t>(padded_capacity);
      memory.aimed = scratch.take<double>(disc_batches * outputs);
    }
    memory.disc_all = scratch.take<double>(disc_batches * bands);
    memory.disc_seen = scratch.take<double>(disc_batches * bands);
    memory.disc_light = scratch.take<double>(2 * bands);
  }
  if (has_cell_errors(frame))
    memory.paths.cell_errors =
        scratch.take<float>(static_cast<std::size_t>(most_per_block) *
                            static_cast<std::size_t>(scene.bands) * error_signs);
  if (frame.truth != nullptr) {
    const auto rows = static_cast<std::size_t>(rows_of(*frame.truth).count);
    memory.truth = scratch.take<float>(rows * packet);
    memory.short_truth = scratch.take<float>(rows * short_capacity);
    for (TruthSums* sums : {&memory.truth_sums, &memory.truth_round_sums}) {
      sums->rows = scratch.take<double>(rows * padded_capacity);
      sums->nearest_m = scratch.take<float>(padded_capacity);
      sums->shares = scratch.take<std::int32_t>(static_cast<std::size_t>(frame.truth->shares) *
                                                padded_capacity);
      if (frame.most_samples == 0) break;
    }
  }
  return memory;
}

}  // namespace omma
