// Packets traced, shaded and summed up over the samples of each unit. Included by block.cpp alone,
// once per instruction set.
#pragma once

#include "backend/embree/packet_light.h"
#include "backend/embree/packet_rays.h"

namespace omma::OMMA_ISA {
namespace {

// Radiance of single rays, where units are shorter than a packet: summed when the block is done.
struct ShortUnits {
  alignas(64) float channel[channel_count][block_rays + lanes];
};

// Radiance summed over the samples of each unit.
using Sums = double[channel_count][unit_room];

__attribute__((always_inline)) inline void store_wide(double* p, Floats x) {
  using Doubles = double __attribute__((vector_size(8 * lane_width)));
  const Doubles wide = __builtin_convertvector(x, Doubles);
  __builtin_memcpy(p, &wide, sizeof wide);
}

// Always in the same order.
__attribute__((always_inline)) inline float sum_lanes(const float (&x)[lanes]) {
  using Quad = float __attribute__((vector_size(16)));
  const Quad quad = (load<Quad>(x) + load<Quad>(x + 8)) + (load<Quad>(x + 4) + load<Quad>(x + 12));
  return (quad[0] + quad[1]) + (quad[2] + quad[3]);
}

// Adds what lanes [first, end) brought to one unit's sums.
__attribute__((always_inline)) inline void add_lanes(const PacketLight& light, int first, int end,
                                                     Sums& sums, int unit) {
  for (int c = 0; c < channel_count; ++c) {
    if (end - first == lanes) {
      sums[c][unit] += static_cast<double>(sum_lanes(light.channel[c]));
      continue;
    }
    alignas(64) float x[lanes];
    for (int l = 0; l < lanes; l += lane_width) {
      const Ints lane = lane_numbers() + l;
      store(x + l, lane >= first && lane < end ? load<Floats>(light.channel[c] + l)
                                               : broadcast<Floats>(0.0f));
    }
    sums[c][unit] += static_cast<double>(sum_lanes(x));
  }
}

// What each single ray brought, where the caller asks; there is one scramble then.
void keep_rays(const BlockContext& context, const BlockTask& task, const PacketPlace& place,
               const Packet& packet) {
  const int samples = context.directions->samples;
  int unit = place.unit, sample = place.sample;
  for (int l = 0; l < place.filled; ++l) {
    const std::size_t ommatidium =
        static_cast<std::size_t>(context.eye->ommatidium.data()[task.first + unit]);
    float* out = task.ray_radiance + (ommatidium * static_cast<std::size_t>(samples) +
                                      static_cast<std::size_t>(sample)) *
                                         channel_count;
    for (int c = 0; c < channel_count; ++c) out[c] = packet.light.channel[c][l];
    if (++sample < samples) continue;
    sample = 0;
    ++unit;
  }
}

// Sums over units that are shorter than a packet, each lane one of them.
void add_short_units(int samples, int units, const ShortUnits& rays, Sums& sums, Sums* squares) {
  for (int u = 0; u < units; u += lane_width)
    for (int c = 0; c < channel_count; ++c) {
      const Ints first = (lane_numbers() + u) * samples;
      Floats sum = gather(rays.channel[c], first);
      for (int k = 1; k < samples; ++k) sum += gather(rays.channel[c], first + k);
      store_wide(sums[c] + u, sum);
      if (squares == nullptr) continue;
      Floats square = broadcast<Floats>(0.0f);
      for (int k = 0; k < samples; k += 2) {
        const Floats d =
            gather(rays.channel[c], first + k) - gather(rays.channel[c], first + k + 1);
        square += d * d;
      }
      store_wide((*squares)[c] + u, square);
    }
}

// What add_lanes makes of this is the sum of the squared differences of pairs of samples, which are
// neighbours in the pattern.
__attribute__((always_inline)) inline PacketLight pair_squares(const PacketLight& light) {
  PacketLight squares;
  for (int c = 0; c < channel_count; ++c)
    for (int l = 0; l < lanes; l += lane_width) {
      const Floats x = load<Floats>(light.channel[c] + l);
      const Floats d = x - pick(light.channel[c] + l, lane_numbers() ^ 1);
      store(squares.channel[c] + l, d * d * 0.5f);
    }
  return squares;
}

// Traces and shades units, into their sums; `squares`, where given, takes those of the differences
// between pairs of samples.
void trace_units(const BlockContext& context, const BlockTask& task, const DirectionTables& tables,
                 const UnitList& list, Sums& sums, Sums* squares = nullptr) {
  Units units;
  make_units(context, task, tables, list, units);
  const bool is_short = tables.samples < lanes;
  ShortUnits rays;
  int traced = 0;
  IntersectArguments arguments;
  Packet packet;
  clear(packet);
  for_each_packet(tables, units, list.count, packet, [&](const PacketPlace& place) {
    alignas(64) int valid[lanes];
    for (int l = 0; l < lanes; ++l) valid[l] = l < place.filled ? -1 : 0;
    if (context.scene->has_blend)
      shade_blended(context, packet, valid, arguments);
    else
      shade_opaque(context, packet, valid, arguments);
    if (is_short) {
      for (int c = 0; c < channel_count; ++c)
        __builtin_memcpy(rays.channel[c] + traced, packet.light.channel[c],
                         sizeof packet.light.channel[c]);
      traced += lanes;
    } else {
      const int left = tables.samples - place.sample, in_first = left < lanes ? left : lanes;
      const int end = in_first < place.filled ? in_first : place.filled;
      const auto add = [&](const PacketLight& light, Sums& to) {
        add_lanes(light, 0, end, to, place.unit);
        if (end < place.filled) add_lanes(light, end, place.filled, to, place.unit + 1);
      };
      add(packet.light, sums);
      if (squares != nullptr) add(pair_squares(packet.light), *squares);
    }
    if (task.ray_radiance != nullptr) keep_rays(context, task, place, packet);
  });
  if (is_short) add_short_units(tables.samples, list.count, rays, sums, squares);
}

}  // namespace
}  // namespace omma::OMMA_ISA
