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

// What each single ray brought, where the caller asks; there is one scramble then.
void keep_rays(const BlockContext& context, const BlockTask& task, const Packet& packet) {
  for (int r = 0; r < packet.run_count; ++r) {
    const Run run = packet.runs[r];
    const std::size_t ommatidium = context.eye->ommatidium.data()[task.first + run.unit];
    const std::size_t first = ommatidium * static_cast<std::size_t>(context.directions->samples) +
                              static_cast<std::size_t>(run.sample);
    float* out = task.ray_radiance + first * channel_count;
    for (int l = 0; l < run.count; ++l)
      for (int c = 0; c < channel_count; ++c) *out++ = packet.light.channel[c][run.first + l];
  }
}

// Traces and shades what the packet holds and adds it to the sums of its estimates, always in the
// same order.
void trace_and_add(const BlockContext& context, const BlockTask& task, Packet& packet,
                   double (*sums)[channel_count], IntersectArguments& arguments) {
  alignas(64) static constexpr int all[lanes] = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                 -1, -1, -1, -1, -1, -1, -1, -1};
  alignas(64) int some[lanes];
  const int* valid = all;
  if (packet.filled < lanes) {
    for (int l = 0; l < lanes; ++l) some[l] = l < packet.filled ? -1 : 0;
    valid = some;
  }
  if (context.scene->has_blend)
    shade_blended(context, packet, valid, arguments);
  else
    shade_opaque(context, packet, valid, arguments);
  for (int r = 0; r < packet.run_count; ++r) {
    const Run run = packet.runs[r];
    for (int c = 0; c < channel_count; ++c) {
      const float* x = packet.light.channel[c] + run.first;
      float sum = 0;
      if (run.count == lanes) {
        using Quad = float __attribute__((vector_size(16)));
        const Quad quad =
            (load<Quad>(x) + load<Quad>(x + 8)) + (load<Quad>(x + 4) + load<Quad>(x + 12));
        sum = (quad[0] + quad[1]) + (quad[2] + quad[3]);
      } else {
        for (int l = 0; l < run.count; ++l) sum += x[l];
      }
      sums[run.unit][c] += sum;
    }
  }
  if (task.ray_radiance != nullptr) keep_rays(context, task, packet);
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
  double sums[block_capacity][channel_count];
  for (int u = 0; u < task.count * context.scrambles; ++u)
    for (double& sum : sums[u]) sum = 0;
  IntersectArguments arguments;
  for_each_packet(context, task,
                  [&](Packet& packet) { trace_and_add(context, task, packet, sums, arguments); });
  reduce(context, task, sums);
}

void prepare_block(const BlockContext& context, const BlockTask& task, RTCRayHit16* packets) {
  for_each_packet(context, task, [&](Packet& packet) {
    prepare(packet.rays);
    *packets++ = packet.rays;
  });
}

}  // namespace omma::OMMA_ISA
