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

// Adds what lanes [first, end) brought to one unit's sums, always in the same order.
__attribute__((always_inline)) inline void add_lanes(const PacketLight& light, int first, int end,
                                                     double (&sums)[channel_count]) {
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
    sums[c] += (quad[0] + quad[1]) + (quad[2] + quad[3]);
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
                 const UnitList& list, double (*sums)[channel_count]) {
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
      add_lanes(packet.light, 0, in_first < place.filled ? in_first : place.filled,
                sums[place.unit]);
      if (in_first < place.filled)
        add_lanes(packet.light, in_first, place.filled, sums[place.unit + 1]);
    }
    if (task.ray_radiance != nullptr) keep_rays(context, task, place, packet);
  });
  if (!is_short) return;
  for (int u = 0; u < list.count; u += lane_width)
    for (int c = 0; c < channel_count; ++c) {
      const Ints first = (lane_numbers() + u) * tables.samples;
      Floats sum = gather(rays.channel[c], first);
      for (int k = 1; k < tables.samples; ++k) sum += gather(rays.channel[c], first + k);
      for (int l = 0; l < lane_width && u + l < list.count; ++l) sums[u + l][c] = sum[l];
    }
}

// Responses from the sums of a block: the mean over all scrambles and, where asked for, its
// standard error from their spread.
void reduce(const BlockContext& context, const BlockTask& task,
            const double (*sums)[channel_count]) {
  const double samples = context.directions->samples;
  const int scrambles = context.scrambles;
  for (int i = 0; i < task.count; ++i) {
    const std::size_t out =
        static_cast<std::size_t>(context.eye->ommatidium.data()[task.first + i]) * channel_count;
    for (int c = 0; c < channel_count; ++c) {
      double mean = 0;
      for (int r = 0; r < scrambles; ++r) mean += sums[i * scrambles + r][c];
      mean /= samples * scrambles;
      task.responses[out + static_cast<std::size_t>(c)] = static_cast<float>(mean);
      if (task.standard_error == nullptr) continue;
      double squares = 0;
      for (int r = 0; r < scrambles; ++r) {
        const double d = sums[i * scrambles + r][c] / samples - mean;
        squares += d * d;
      }
      task.standard_error[out + static_cast<std::size_t>(c)] =
          static_cast<float>(sqrt(squares / (scrambles * (scrambles - 1.0))));
    }
  }
}

}  // namespace

void render_block(const BlockContext& context, const BlockTask& task) {
  const DenormalsAreZero denormals_are_zero;
  const UnitList all{nullptr, 0, context.scrambles, task.count * context.scrambles};
  double sums[block_capacity][channel_count];
  for (int u = 0; u < all.count; ++u)
    for (double& sum : sums[u]) sum = 0;
  trace_units(context, task, *context.directions, all, sums);
  reduce(context, task, sums);
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
