// What a thread needs of memory while it renders a block of ommatidia: numbers by band or output,
// whose count is known at run time only. One piece of memory holds all, at places aligned for
// vectors.
#pragma once

#include <cstddef>

#include "physics/rays/units.h"
#include "physics/views/light_view.h"
#include "physics/views/path_memory.h"

namespace omma {

// Gives out places one behind the other; without memory it only counts.
struct Room {
  std::byte* begin = nullptr;
  std::size_t used = 0;  // bytes

  template <typename T>
  OMMA_HD T* take(std::size_t count) {
    constexpr std::size_t alignment = 64;
    T* place = begin == nullptr ? nullptr : reinterpret_cast<T*>(begin + used);
    used += (count * sizeof(T) + alignment - 1) / alignment * alignment;
    return place;
  }
};

// Of the ground truth (truth_sums.h), over the rays of each unit.
struct TruthSums {
  double* rows = nullptr;          // [row][unit_room], see TruthRows
  float* nearest_m = nullptr;      // [unit_room]
  std::int32_t* shares = nullptr;  // [unit][group], rays
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
inline constexpr int disc_replicates = 8;

// Directions in which a unit sees something small and bright (aimed_rays.h).
struct AimCone {
  Vec3 direction;                   // unit
  float chord_2 = 0, solid_sr = 0;  // of its rim, as of DiscView; its solid angle
  float most = 0;                   // bound on what it adds to the response
};
inline constexpr int most_cones = 8;

// What has a number for each output of each unit is [output][unit_room].
struct BlockMemory {
  // [component][band][lane] of one packet, where worlds are lit of block_rays of them one behind
  // the other. Component 0 is the radiance; in a polarised world Q and U stand behind it.
  float* radiance = nullptr;
  PathMemory paths;
  float* output = nullptr;   // [output][lane] of one packet; the radiance itself without a matrix
  float* squares = nullptr;  // [output][lane] of one packet, see pair_squares
  float* short_rays = nullptr;  // [output][short_room], see add_short_units
  double* sums = nullptr;       // over the rays of each unit
  // Rendering to an error: sums of a round, squares of a round and of all; see estimate.
  double *round_sums = nullptr, *round_squares = nullptr, *all_squares = nullptr;
  float *roughness = nullptr, *unseen = nullptr;
  double* of_cells = nullptr;  // variance that comes of cells of baked light
  double* wanted = nullptr;    // variance that is asked for
  // Where ground truth is asked for: [row][lane] of a packet, [row][short_room], sums over all rays
  // and over those of a round.
  float *truth = nullptr, *short_truth = nullptr;
  TruthSums truth_sums, truth_round_sums;
  // In lit worlds: what units see of discs of the sky and of what they aim at (eye_discs.h,
  // aimed_rays.h) besides their rays, and the square of its error.
  double *beside = nullptr, *beside_variance = nullptr;
  // Of one unit, on a disc: sums [disc_replicates][band]; its light and error, [2][band].
  double *disc_all = nullptr, *disc_seen = nullptr, *disc_light = nullptr;
  // Cones that units aim at, [unit][most_cones], how many, [unit]; sums of one,
  // [disc_replicates][output].
  AimCone* cones = nullptr;
  std::int32_t* cone_count = nullptr;
  double* aimed = nullptr;
};

// Rays of units that are shorter than a packet, and what vector loops read behind them: up to a
// packet's width of units, each up to 15 rays long.
inline constexpr int short_room = block_rays + 16 + 16 * 16;

// Whether standard errors have a part that is baked light's.
OMMA_HD bool has_cell_errors(const FrameView& frame) {
  const BakedView* baked = frame.scene->baked;
  return baked != nullptr && baked->errors != nullptr && (frame.most_samples > 0 || frame.scrambles > 1);
}

OMMA_HD BlockMemory lay_out(Room& room, const FrameView& frame, int lanes) {
  const auto outputs = static_cast<std::size_t>(frame.outputs);
  const auto packet = static_cast<std::size_t>(lanes);
  const std::size_t units = outputs * unit_room;
  BlockMemory memory;
  const SceneView& scene = *frame.scene;
  const std::size_t one = static_cast<std::size_t>(scene.bands) * packet;
  const std::size_t components = scene.polarized ? 3 : 1;
  const std::size_t packets = scene.light == nullptr ? 1 : block_rays / packet;
  memory.radiance = room.take<float>(components * one * packets);
  if (scene.light != nullptr) {
    PathMemory& paths = memory.paths;
    // As WaitingPaths has room.
    paths.waiting = room.take<float>(3 * one);
    paths.waiting_for_last = room.take<float>(3 * one);
    for (SpectraMemory* spectra : {static_cast<SpectraMemory*>(&paths), &paths.shadow})
      for (float** values : {&spectra->throughput, &spectra->reflectance, &spectra->transmittance,
                             &spectra->emission, &spectra->tint})
        *values = room.take<float>(one);
    paths.light = room.take<float>(components * one);
    paths.found = room.take<float>(components * one);
    paths.front = room.take<float>(one);
    paths.back = room.take<float>(one);
  }
  memory.output =
      frame.output_from_band == nullptr ? memory.radiance : room.take<float>(outputs * packet);
  memory.short_rays = room.take<float>(outputs * short_room);
  memory.sums = room.take<double>(units);
  if (frame.most_samples > 0) {
    memory.squares = room.take<float>(outputs * packet);
    memory.round_sums = room.take<double>(units);
    memory.round_squares = room.take<double>(units);
    memory.all_squares = room.take<double>(units);
    memory.roughness = room.take<float>(units);
    memory.unseen = room.take<float>(units);
    memory.of_cells = room.take<double>(units);
    memory.wanted = room.take<double>(units);
  }
  if (scene.light != nullptr) {
    const auto bands = static_cast<std::size_t>(scene.bands);
    memory.beside = room.take<double>(units);
    memory.beside_variance = room.take<double>(units);
    if (scene.light->aim_count > 0) {
      memory.cones = room.take<AimCone>(std::size_t{unit_room} * most_cones);
      memory.cone_count = room.take<std::int32_t>(unit_room);
      memory.aimed = room.take<double>(disc_replicates * outputs);
    }
    memory.disc_all = room.take<double>(disc_replicates * bands);
    memory.disc_seen = room.take<double>(disc_replicates * bands);
    memory.disc_light = room.take<double>(2 * bands);
  }
  if (has_cell_errors(frame))
    memory.paths.cell_errors =
        room.take<float>(static_cast<std::size_t>(most_per_block) *
                         static_cast<std::size_t>(scene.bands) * error_signs);
  if (frame.truth != nullptr) {
    const auto rows = static_cast<std::size_t>(rows_of(*frame.truth).count);
    memory.truth = room.take<float>(rows * packet);
    memory.short_truth = room.take<float>(rows * short_room);
    for (TruthSums* sums : {&memory.truth_sums, &memory.truth_round_sums}) {
      sums->rows = room.take<double>(rows * unit_room);
      sums->nearest_m = room.take<float>(unit_room);
      sums->shares =
          room.take<std::int32_t>(static_cast<std::size_t>(frame.truth->shares) * unit_room);
      if (frame.most_samples == 0) break;
    }
  }
  return memory;
}

}  // namespace omma
