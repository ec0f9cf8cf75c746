// The hot loop: rays of a block, packet by packet traced and shaded, into sums and responses.
// Nothing is allocated.
//
// This file is compiled once per instruction set (OMMA_ISA names the namespace). It calls nothing
// out of line that other files share, so that no code for a newer processor can leak into them.
#include "backend/embree/block.h"

#include "backend/embree/packet_sums.h"

namespace omma::OMMA_ISA {
namespace {

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

void clear(Sums& sums, int count) {
  for (auto& channel : sums)
    for (int u = 0; u < count; ++u) channel[u] = 0;
}

// Where the ommatidia of a block stand on the way to an error.
struct Progress {
  Sums sums, squares;                 // over all rays so far; see estimate
  double roots[block_capacity];       // sum over the rounds of the square roots of their rays
  std::int32_t rays[block_capacity];  // so far
  std::int32_t next[block_capacity];  // round to come, index into the tables; -1 for none
  float roughness[channel_count][block_capacity];  // see estimate
  float unseen[channel_count][block_capacity];     // see estimate
};

// Of the squares of pairs in even patterns: measured, the pairs alone give 1.45 times the true
// error in clutter (the bundled meadow) and 2.2 to 2.9 times at edges; with this 1.25, and 1.9 to
// 2.5. With 0.6 more than one in a hundred are beyond twice the error on a fine checkerboard.
constexpr double even_share = 0.75;

// n even rays can all miss what covers a share of up to about 1/n of a field, and are then off by
// that share of its contrast. Measured, 0.4 leaves some 1 in 1,000 beyond twice the error in
// arenas, this 1 in 2,000, for 5 % to 10 % more rays.
constexpr float overlooked = 0.6f;

// What the standard error of each ommatidium rests on, from the rays so far.
//
// Half the squared difference of two samples that are neighbours in the pattern estimates the
// variance of each around their mean, so the squares of the pairs of n random rays sum up to n^2
// times the variance of their mean. Even patterns do better than their pairs: they get credit for
// a part of it (even_share). Where edges are seen their variance falls with the power -3/2 of n, so
// squares grow with the root of n: their ratio, the roughness, is what rounds of different size
// have in common.
//
// Few rays may miss all that varies, and then an ommatidium would stop by luck. So it listens to
// those that look nearest to where it looks: it takes the mean of their roughness where its own is
// less, and it takes for possible that what makes their responses differ lies within its own field,
// unseen by its rays.
void estimate(const BlockContext& context, const BlockTask& task, Progress& progress) {
  const std::uint8_t* nearest = context.nearest + std::int64_t{task.first} * listened_to;
  for (int c = 0; c < channel_count; ++c) {
    float own[block_capacity], response[block_capacity];
    for (int i = 0; i < task.count; ++i) {
      own[i] = static_cast<float>(progress.squares[c][i] / progress.roots[i]);
      response[i] = static_cast<float>(progress.sums[c][i] / progress.rays[i]);
    }
    for (int i = 0; i < task.count; ++i) {
      float sum = own[i], least = response[i], most = response[i];
      for (int k = 0; k < listened_to; ++k) {
        const int other = nearest[i * listened_to + k];
        sum += own[other];
        least = response[other] < least ? response[other] : least;
        most = response[other] > most ? response[other] : most;
      }
      const float mean = sum / static_cast<float>(listened_to + 1);
      progress.roughness[c][i] = own[i] > mean ? own[i] : mean;
      progress.unseen[c][i] = overlooked * (most - least);
    }
  }
}

// The square of the standard error of a response, times that of its number of rays, whose `roots`
// are as in Progress.
double scaled_variance(const Progress& progress, int i, int c, double roots) {
  const double unseen = progress.unseen[c][i];
  return progress.roughness[c][i] * roots + unseen * unseen;
}

// The smallest round that should reach the error, or the largest that is left; -1 where none is
// needed, or none left.
int choose_round(const BlockContext& context, const Progress& progress, int i) {
  const auto reaches = [&](double rays, double roots) {
    for (int c = 0; c < channel_count; ++c)
      if (scaled_variance(progress, i, c, roots) > context.error * context.error * rays * rays)
        return false;
    return true;
  };
  const double rays = progress.rays[i];
  if (reaches(rays, progress.roots[i])) return -1;
  int round = -1;
  for (int k = 0; k < context.rounds; ++k) {
    const double more = context.directions[k].samples;
    if (rays + more > context.most_samples) break;
    round = k;
    if (reaches(rays + more, progress.roots[i] + sqrt(more))) break;
  }
  return round;
}

// One round of the ommatidia for which it comes next.
void trace_round(const BlockContext& context, const BlockTask& task, int k, int scramble,
                 Progress& progress) {
  const DirectionTables& tables = context.directions[k];
  const int most = tables.samples < lanes ? block_rays / tables.samples : block_capacity;
  std::int32_t member[block_capacity + lanes], ordinal[block_capacity + lanes];
  for (int i = 0; i < task.count;) {
    int count = 0;
    for (; i < task.count && count < most; ++i) {
      if (progress.next[i] != k) continue;
      member[count] = i;
      ordinal[count++] = task.first + i;
    }
    if (count == 0) return;
    Sums sums, squares;
    clear(sums, count);
    clear(squares, count);
    const UnitList list{scramble == 0 ? nullptr : ordinal, scramble, 1, count};
    trace_units(context, task, tables, list, sums, &squares);
    const double share = tables.sampling == Sampling::low_discrepancy ? even_share : 1.0;
    for (int u = 0; u < count; ++u) {
      progress.rays[member[u]] += tables.samples;
      progress.roots[member[u]] += sqrt(static_cast<double>(tables.samples));
      for (int c = 0; c < channel_count; ++c) {
        progress.sums[c][member[u]] += sums[c][u];
        progress.squares[c][member[u]] += share * squares[c][u];
      }
    }
  }
}

void render_to_error(const BlockContext& context, const BlockTask& task) {
  Progress progress;
  clear(progress.sums, task.count);
  clear(progress.squares, task.count);
  for (int i = 0; i < task.count; ++i) progress.roots[i] = progress.rays[i] = progress.next[i] = 0;
  trace_round(context, task, 0, 0, progress);
  for (int scramble = 1;; ++scramble) {
    bool any = false;
    estimate(context, task, progress);
    for (int i = 0; i < task.count; ++i) {
      progress.next[i] = choose_round(context, progress, i);
      any = any || progress.next[i] >= 0;
    }
    if (!any) break;
    for (int k = 0; k < context.rounds; ++k) trace_round(context, task, k, scramble, progress);
  }
  for (int i = 0; i < task.count; ++i) {
    const std::int64_t ommatidium = context.eye->ommatidium.data()[task.first + i];
    if (task.rays != nullptr) task.rays[ommatidium] = progress.rays[i];
    for (int c = 0; c < channel_count; ++c) {
      const std::int64_t out = ommatidium * channel_count + c;
      task.responses[out] = static_cast<float>(progress.sums[c][i] / progress.rays[i]);
      if (task.standard_error != nullptr)
        task.standard_error[out] = static_cast<float>(
            sqrt(scaled_variance(progress, i, c, progress.roots[i])) / progress.rays[i]);
    }
  }
}

}  // namespace

void render_block(const BlockContext& context, const BlockTask& task) {
  const DenormalsAreZero denormals_are_zero;
  if (context.error > 0) return render_to_error(context, task);
  const UnitList all{nullptr, 0, context.scrambles, task.count * context.scrambles};
  Sums sums;
  clear(sums, all.count);
  trace_units(context, task, *context.directions, all, sums);
  reduce(context, task, sums);
  if (task.standard_error != nullptr) reduce_errors(context, task, sums);
}

// In sixteen running sums whatever the width of the lanes, so that the bits are the same.
void weigh_rays(const SharedRays& shared, const float* radiance, std::int64_t first,
                std::int64_t end, float* responses) {
  const DenormalsAreZero denormals_are_zero;
  static_assert(weight_group == lanes && channel_count == 3);
  for (std::int64_t i = first; i < end; ++i) {
    PacketLight light;
    for (int l = 0; l < lanes; l += lane_width) {
      Floats sums[channel_count] = {};
      for (std::int64_t k = shared.first.data()[i] + l; k < shared.first.data()[i + 1];
           k += lanes) {
        const Ints ray = load<Ints>(shared.ray.data() + k) * channel_count;
        const Floats weight = load<Floats>(shared.weight.data() + k);
        for (int c = 0; c < channel_count; ++c) sums[c] += weight * gather(radiance + c, ray);
      }
      for (int c = 0; c < channel_count; ++c) store(light.channel[c] + l, sums[c]);
    }
    for (int c = 0; c < channel_count; ++c)
      responses[i * channel_count + c] = static_cast<float>(sum_lanes(light.channel[c]));
  }
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
