// Rendering to an error: a block of ommatidia estimates, chooses and traces its further rounds of
// rays by itself.
#pragma once

#include "physics/block/trace_replicates.h"
#include "physics/block/truth_sums.h"

namespace omma {

// The variance of output o of an ommatidium's response, in radiance units, that comes of the cells
// of baked light which its `rays` met; 0 in other worlds.
OMMA_HD double cell_variance(const FrameView& frame, const BlockMemory& memory, int ommatidium,
                             int o, double rays) {
  if (memory.paths.cell_errors == nullptr) return 0;
  const int bands = frame.scene->bands, components = frame.scene->polarized ? 3 : 1;
  const float* sums = memory.paths.cell_errors + std::ptrdiff_t{ommatidium} * bands * error_signs;
  // What is baked is unpolarised: it is in I alone.
  if (frame.output_from_band == nullptr && o >= bands) return 0;
  double squares = 0;
  for (int k = 0; k < error_signs; ++k) {
    double sum = 0;
    if (frame.output_from_band == nullptr) {
      sum = static_cast<double>(sums[o * error_signs + k]);
    } else {
      const float* row = frame.output_from_band + std::ptrdiff_t{o} * components * bands;
      for (int b = 0; b < bands; ++b)
        sum += static_cast<double>(row[b] * sums[b * error_signs + k]);
    }
    squares += sum * sum;
  }
  return squares / (error_signs * rays * rays);
}

OMMA_HD void clear_cell_errors(const FrameView& frame, const BlockTask& task,
                               const BlockMemory& memory) {
  if (memory.paths.cell_errors == nullptr) return;
  const std::ptrdiff_t all = std::ptrdiff_t{task.count} * frame.scene->bands * error_signs;
  for (std::ptrdiff_t i = 0; i < all; ++i) memory.paths.cell_errors[i] = 0;
}

// Where the ommatidia of a block stand on the way to an error; the rest is in BlockMemory: sums
// over all rays so far, all_squares, roughness and unseen.
struct WayToError {
  double roots[block_capacity];       // sum over the rounds of the square roots of their rays
  std::int32_t rays[block_capacity];  // so far
  std::int32_t next[block_capacity];  // round to come, index into the directions; -1 for none
};

// Of the squares of pairs in even patterns: measured, the pairs alone give 1.45 times the true
// error in clutter (the bundled meadow) and 2.2 to 2.9 times at edges; with this 1.25, and 1.9 to
// 2.5. With 0.6 more than one in a hundred are beyond twice the error on a fine checkerboard.
inline constexpr double even_credit = 0.75;

// n even rays can all miss what covers a fraction of up to about 1/n of a field, and are then off
// by that fraction of its contrast. Measured, 0.4 leaves some 1 in 1,000 beyond twice the error in
// arenas, this 1 in 2,000, for 5 % to 10 % more rays.
inline constexpr float overlooked = 0.6f;

// What the standard error of each ommatidium rests on, from the rays so far.
//
// Half the squared difference of two samples that are neighbours in the pattern estimates the
// variance of each around their mean, so the squares of the pairs of n random rays sum up to n^2
// times the variance of their mean. Even patterns do better than their pairs: they get credit for
// a part of it (even_credit). Where edges are seen their variance falls with the power -3/2 of n,
// so squares grow with the root of n: their ratio, the roughness, is what rounds of different size
// have in common.
//
// Few rays may miss all that varies, and then an ommatidium would stop by luck. So it listens to
// those that look nearest to where it looks: it takes the mean of their roughness where its own is
// less, and it takes for possible that what makes their responses differ lies within its own field,
// unseen by its rays.
OMMA_HD void estimate(const FrameView& frame, const BlockTask& task, const WayToError& way,
                      const BlockMemory& memory) {
  const std::uint8_t* nearest = frame.nearest + std::int64_t{task.first} * listened_to;
  const double error = frame.error / frame.radiance_unit;
  for (int o = 0; o < frame.outputs; ++o) {
    const int row = o * padded_capacity;
    // Q and U may be 0 where I is not: they are measured by I.
    const int of_light = frame.output_from_band == nullptr ? o % frame.scene->bands : o;
    float own[block_capacity], response[block_capacity], size[block_capacity];
    for (int i = 0; i < task.count; ++i) {
      own[i] = static_cast<float>(memory.all_squares[row + i] / way.roots[i]);
      response[i] = static_cast<float>(memory.sums[row + i] / way.rays[i]);
      // Where errors are relative, so is what an ommatidium hears of its neighbours' roughness.
      const double light = memory.sums[of_light * padded_capacity + i] / way.rays[i];
      const auto square = static_cast<float>(light * light);
      size[i] = frame.relative_error > 0 && square > 0 ? square : 1.0f;
      const double relative = frame.relative_error * fabs(light);
      const double wanted = relative > error ? relative : error;
      memory.wanted[row + i] = wanted * wanted;
    }
    for (int i = 0; i < task.count; ++i) {
      float sum = own[i] / size[i], least = response[i], most = response[i];
      for (int k = 0; k < listened_to; ++k) {
        const int other = nearest[i * listened_to + k];
        sum += own[other] / size[other];
        least = response[other] < least ? response[other] : least;
        most = response[other] > most ? response[other] : most;
      }
      const float mean = size[i] * sum / static_cast<float>(listened_to + 1);
      memory.roughness[row + i] = own[i] > mean ? own[i] : mean;
      memory.unseen[row + i] = overlooked * (most - least);
      memory.of_cells[row + i] = cell_variance(frame, memory, i, o, way.rays[i]);
    }
  }
}

// The square of the standard error of output o of ommatidium i, times that of its number of rays,
// whose `roots` are as in WayToError.
OMMA_HD double scaled_variance(const BlockMemory& memory, int i, int o, double roots) {
  const double unseen = memory.unseen[o * padded_capacity + i];
  return memory.roughness[o * padded_capacity + i] * roots + unseen * unseen;
}

// Whether the standard errors would be small enough with so many rays; all in radiance units. More
// rays do not change what cells of baked light err by: rays make up for at least half of the
// variance that is asked for, and where cells err by more than the other half, the error stays
// above.
OMMA_HD bool reaches_error(const FrameView& frame, const BlockMemory& memory, int i, double rays,
                           double roots) {
  for (int o = 0; o < frame.outputs; ++o) {
    const double all = memory.wanted[o * padded_capacity + i];
    const double left = all - memory.of_cells[o * padded_capacity + i];
    const double for_rays = left > 0.5 * all ? left : 0.5 * all;
    if (scaled_variance(memory, i, o, roots) > for_rays * rays * rays) return false;
  }
  return true;
}

// The smallest round that should reach the error, or the largest that is left; -1 where none is
// needed, or none left.
OMMA_HD int choose_round(const FrameView& frame, const WayToError& way, const BlockMemory& memory,
                         int i) {
  const double rays = way.rays[i];
  if (reaches_error(frame, memory, i, rays, way.roots[i])) return -1;
  int round = -1;
  for (int k = 0; k < frame.rounds; ++k) {
    const double more = frame.directions[k].samples;
    if (rays + more > frame.most_samples) break;
    round = k;
    if (reaches_error(frame, memory, i, rays + more, way.roots[i] + sqrt(more))) break;
  }
  return round;
}

OMMA_HD void clear(double* sums, int outputs, int replicates) {
  for (int o = 0; o < outputs; ++o)
    for (int u = 0; u < replicates; ++u) sums[o * padded_capacity + u] = 0;
}

// One round of the ommatidia for which it comes next.
template <typename L, typename Search>
OMMA_HD void trace_round(const BlockRun<Search>& run, int k, int scramble, WayToError& way) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  const DirectionsView& directions = frame.directions[k];
  const int most = directions.samples < L::count ? block_rays / directions.samples : block_capacity;
  std::int32_t member[padded_capacity], ordinal[padded_capacity];
  for (int i = 0; i < task.count;) {
    int count = 0;
    for (; i < task.count && count < most; ++i) {
      if (way.next[i] != k) continue;
      member[count] = i;
      ordinal[count++] = task.first + i;
    }
    if (count == 0) return;
    clear(memory.round_sums, frame.outputs, count);
    clear(memory.round_squares, frame.outputs, count);
    if (frame.truth != nullptr) clear(*frame.truth, memory.truth_round_sums, count);
    const ReplicateList list{scramble == 0 ? nullptr : ordinal, scramble, 1, count};
    trace_replicates<L>(run, directions, list,
                        {memory.round_sums, memory.round_squares, memory.truth_round_sums});
    // Choices on the way of a path are not as even as the directions that they begin with.
    const bool is_even = !directions.random && frame.scene->light == nullptr;
    const double credit = is_even ? even_credit : 1.0;
    for (int u = 0; u < count; ++u) {
      way.rays[member[u]] += directions.samples;
      way.roots[member[u]] += sqrt(static_cast<double>(directions.samples));
      for (int o = 0; o < frame.outputs; ++o) {
        const int from = o * padded_capacity + u, to = o * padded_capacity + member[u];
        memory.sums[to] += memory.round_sums[from];
        memory.all_squares[to] += credit * memory.round_squares[from];
      }
      if (frame.truth != nullptr)
        add_truth(*frame.truth, memory.truth_round_sums, u, memory.truth_sums, member[u]);
    }
  }
}

template <typename L, typename Search>
OMMA_HD void render_to_error(const BlockRun<Search>& run) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  WayToError way;
  clear(memory.sums, frame.outputs, task.count);
  clear(memory.all_squares, frame.outputs, task.count);
  clear_cell_errors(frame, task, memory);
  if (frame.truth != nullptr) clear(*frame.truth, memory.truth_sums, task.count);
  for (int i = 0; i < task.count; ++i) way.roots[i] = way.rays[i] = way.next[i] = 0;
  int rounds = 1;  // of these some are to come
  for (int scramble = 0; rounds > 0; ++scramble) {
    for (int k = 0; k < rounds; ++k) trace_round<L>(run, k, scramble, way);
    rounds = 0;
    estimate(frame, task, way, memory);
    for (int i = 0; i < task.count; ++i) {
      way.next[i] = choose_round(frame, way, memory, i);
      if (way.next[i] >= rounds) rounds = way.next[i] + 1;
    }
  }
  const bool sees_more = sees_beside_rays(frame);
  if (sees_more) eval_beside_rays<L>(frame, task, {nullptr, 0, 1, task.count}, run.search, memory);
  for (int i = 0; i < task.count; ++i) {
    const auto ommatidium = static_cast<std::int64_t>(frame.eye->ommatidium[task.first + i]);
    if (task.rays != nullptr) task.rays[ommatidium] = way.rays[i];
    if (frame.truth != nullptr) reduce_truth(frame, task, memory.truth_sums, i, 1, way.rays[i]);
    for (int o = 0; o < frame.outputs; ++o) {
      const std::int64_t out = ommatidium * frame.outputs + o;
      const double rays = way.rays[i];
      double response = memory.sums[o * padded_capacity + i] / rays;
      double variance = scaled_variance(memory, i, o, way.roots[i]) / (rays * rays) +
                        memory.of_cells[o * padded_capacity + i];
      if (sees_more) {
        response += memory.beside[o * padded_capacity + i];
        variance += memory.beside_variance[o * padded_capacity + i];
      }
      task.responses[out] = static_cast<float>(response * frame.radiance_unit);
      if (task.standard_error != nullptr)
        task.standard_error[out] = static_cast<float>(sqrt(variance) * frame.radiance_unit);
    }
  }
}

}  // namespace omma
