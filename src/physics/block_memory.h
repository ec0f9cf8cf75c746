// What a thread needs of memory while it renders a block of ommatidia: numbers by band or output,
// whose count is known at run time only. One piece of memory holds all, at places aligned for
// vectors.
#pragma once

#include <cstddef>

#include "physics/units.h"

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

// What has a number for each output of each unit is [output][unit_room].
struct BlockMemory {
  // [component][band][lane] of one packet. Component 0 is the radiance; those of a Stokes vector
  // stand behind it where polarisation is traced, which is nowhere yet.
  float* radiance = nullptr;
  float* output = nullptr;      // [output][lane] of one packet; the radiance itself without a matrix
  float* squares = nullptr;     // [output][lane] of one packet, see pair_squares
  float* short_rays = nullptr;  // [output][short_room], see add_short_units
  double* sums = nullptr;       // over the rays of each unit
  // Rendering to an error: sums of a round, squares of a round and of all; see estimate.
  double *round_sums = nullptr, *round_squares = nullptr, *all_squares = nullptr;
  float *roughness = nullptr, *unseen = nullptr;
};

// Rays of units that are shorter than a packet, and what vector loops read behind them: up to a
// packet's width of units, each up to 15 rays long.
inline constexpr int short_room = block_rays + 16 + 16 * 16;

OMMA_HD BlockMemory lay_out(Room& room, int bands, const FrameView& frame, int lanes) {
  const auto outputs = static_cast<std::size_t>(frame.outputs);
  const auto packet = static_cast<std::size_t>(lanes);
  const std::size_t units = outputs * unit_room;
  BlockMemory memory;
  memory.radiance = room.take<float>(static_cast<std::size_t>(bands) * packet);
  memory.output = frame.output_from_band == nullptr ? memory.radiance
                                                    : room.take<float>(outputs * packet);
  memory.short_rays = room.take<float>(outputs * short_room);
  memory.sums = room.take<double>(units);
  if (frame.error > 0) {
    memory.squares = room.take<float>(outputs * packet);
    memory.round_sums = room.take<double>(units);
    memory.round_squares = room.take<double>(units);
    memory.all_squares = room.take<double>(units);
    memory.roughness = room.take<float>(units);
    memory.unseen = room.take<float>(units);
  }
  return memory;
}

}  // namespace omma
