// The hot loop: rays of a block, packet by packet traced and shaded, into sums and responses.
// Nothing is allocated.
//
// This file is compiled once per instruction set (OMMA_ISA names the namespace). It calls nothing
// out of line that other files share, so that no code for a newer processor can leak into them.
#include "backend/embree/block.h"

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

// Adds what lanes [first, end) brought to one unit's sums, always in the same order.
__attribute__((always_inline)) inline void add_lanes(const PacketLight& light, int first, int end,
                                                     Sums& sums, int unit) {
  for (int c = 0; c < channel_count; ++c) {
    using Quad = float __attribute__((vector_size(16)));
    alignas(64) float x[lanes];
    for (int l = 0; l < lanes; l += lane_width) {
      const Ints lane = lane_numbers() + l;
      store(x + l, lane >= first && lane < end ? load<Floats>(light.channel[c] + l)
                                               : broadcast<Floats>(0.0f));
    }
    const Quad quad =
        (load<Quad>(x) + load<Quad>(x + 8)) + (load<Quad>(x + 4) + load<Quad>(x + 12));
    sums[c][unit] += (quad[0] + quad[1]) + (quad[2] + quad[3]);
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

// Traces and shades units, into their sums.
void trace_units(const BlockContext& context, const BlockTask& task, const DirectionTables& tables,
                 const UnitList& list, Sums& sums) {
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
      add_lanes(packet.light, 0, in_first < place.filled ? in_first : place.filled, sums,
                place.unit);
      if (in_first < place.filled)
        add_lanes(packet.light, in_first, place.filled, sums, place.unit + 1);
    }
    if (task.ray_radiance != nullptr) keep_rays(context, task, place, packet);
  });
  if (!is_short) return;
  for (int u = 0; u < list.count; u += lane_width)
    for (int c = 0; c < channel_count; ++c) {
      const Ints first = (lane_numbers() + u) * tables.samples;
      Floats sum = gather(rays.channel[c], first);
      for (int k = 1; k < tables.samples; ++k) sum += gather(rays.channel[c], first + k);
      using Doubles = double __attribute__((vector_size(8 * lane_width)));
      const Doubles wide = __builtin_convertvector(sum, Doubles);
      __builtin_memcpy(sums[c] + u, &wide, sizeof wide);
    }
}

// Responses from the sums of a block: the mean over all scrambles.
void reduce(const BlockContext& context, const BlockTask& task, const Sums& sums) {
  const int scrambles = context.scrambles;
  const double share = 1.0 / (static_cast<double>(context.directions->samples) * scrambles);
  float means[channel_count][block_capacity];
  for (int c = 0; c < channel_count; ++c)
    for (int i = 0; i < task.count; ++i) {
      double sum = sums[c][i * scrambles];
      for (int r = 1; r < scrambles; ++r) sum += sums[c][i * scrambles + r];
      means[c][i] = static_cast<float>(sum * share);
    }
  const std::int32_t* ommatidium = context.eye->ommatidium.data() + task.first;
  for (int i = 0; i < task.count; ++i) {
    float* out = task.responses + std::int64_t{ommatidium[i]} * channel_count;
    for (int c = 0; c < channel_count; ++c) out[c] = means[c][i];
  }
}

// Standard errors of the responses, from the spread of the scrambles.
void reduce_errors(const BlockContext& context, const BlockTask& task, const Sums& sums) {
  const double samples = context.directions->samples;
  const int scrambles = context.scrambles;
  for (int i = 0; i < task.count; ++i) {
    const std::int64_t ommatidium = context.eye->ommatidium.data()[task.first + i];
    for (int c = 0; c < channel_count; ++c) {
      double mean = 0, squares = 0;
      for (int r = 0; r < scrambles; ++r) mean += sums[c][i * scrambles + r] / samples;
      mean /= scrambles;
      for (int r = 0; r < scrambles; ++r) {
        const double d = sums[c][i * scrambles + r] / samples - mean;
        squares += d * d;
      }
      task.standard_error[ommatidium * channel_count + c] =
          static_cast<float>(sqrt(squares / (scrambles * (scrambles - 1.0))));
    }
  }
}

}  // namespace

void render_block(const BlockContext& context, const BlockTask& task) {
  const DenormalsAreZero denormals_are_zero;
  const UnitList all{nullptr, 0, context.scrambles, task.count * context.scrambles};
  Sums sums;
  for (auto& channel : sums)
    for (int u = 0; u < all.count; ++u) channel[u] = 0;
  trace_units(context, task, *context.directions, all, sums);
  reduce(context, task, sums);
  if (task.standard_error != nullptr) reduce_errors(context, task, sums);
}

void prepare_block(const BlockContext& context, const BlockTask& task, RTCRayHit16* packets) {
  const UnitList all{nullptr, 0, context.scrambles, task.count * context.scrambles};
  Units units;
  make_units(context, task, *context.directions, all, units);
  Packet packet;
  clear(packet);
  for_each_packet(*context.directions, units, all.count, packet, [&](const PacketPlace&) {
    prepare(packet.rays);
    *packets++ = packet.rays;
  });
}

}  // namespace omma::OMMA_ISA
