// Rendering to an error: a block of ommatidia estimates, chooses and traces its further rounds of
// rays by itself. Each step is one of its ommatidia's alone, or one of the block's, so that threads
// of a graphics card can share them.
#pragma once

#include "physics/block/trace_replicates.h"
#include "physics/block/truth_sums.h"

namespace omma {

// The variance of output o of a response, in radiance units, that comes of the cells of baked light
// which the `rays` of its ommatidium met, [component][band][sign]; 0 in other worlds, where
// it is null.
OMMA_HD double cell_variance(const FrameView& frame, const float* cell_errors, int o, double rays) {
  if (cell_errors == nullptr) return 0;
  const int inputs = frame.scene->bands * (frame.scene->polarized ? 3 : 1);
  const int signs = error_signs(*frame.scene);
  double squares = 0;
  for (int k = 0; k < signs; ++k) {
    double sum = 0;
    if (frame.output_from_band == nullptr) {
      sum = static_cast<double>(cell_errors[o * signs + k]);
    } else {
      const float* row = frame.output_from_band + std::ptrdiff_t{o} * inputs;
      for (int i = 0; i < inputs; ++i)
        sum += static_cast<double>(row[i] * cell_errors[i * signs + k]);
    }
    squares += sum * sum;
  }
  return squares / (signs * rays * rays);
}

// Those of one ommatidium, of those of several.
OMMA_HD float* cell_errors_of(const FrameView& frame, float* cell_errors, int ommatidium) {
  if (cell_errors == nullptr) return nullptr;
  return cell_errors + ommatidium * cell_error_count(*frame.scene);
}

OMMA_HD void clear_cell_errors(const FrameView& frame, float* cell_errors, int ommatidia) {
  if (cell_errors == nullptr) return;
  const std::ptrdiff_t all = ommatidia * cell_error_count(*frame.scene);
  for (std::ptrdiff_t i = 0; i < all; ++i) cell_errors[i] = 0;
}

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
OMMA_HD void estimate(const FrameView& frame, const BlockTask& task, const ErrorMemory& known) {
  const std::uint8_t* nearest = frame.nearest + std::int64_t{task.first} * listened_to;
  const double error = frame.error / frame.radiance_unit;
  for (int o = 0; o < frame.outputs; ++o) {
    const int row = o * most_per_block;
    // Q and U may be 0 where I is not: they are measured by I.
    const int of_light = frame.output_from_band == nullptr ? o % frame.scene->bands : o;
    float own[most_per_block], response[most_per_block], size[most_per_block];
    for (int i = 0; i < task.count; ++i) {
      own[i] = static_cast<float>(known.squares[row + i] / known.roots[i]);
      response[i] = static_cast<float>(known.sums[row + i] / known.rays[i]);
      // Where errors are relative, so is what an ommatidium hears of its neighbours' roughness.
      const double light = known.sums[of_light * most_per_block + i] / known.rays[i];
      const auto square = static_cast<float>(light * light);
      size[i] = frame.relative_error > 0 && square > 0 ? square : 1.0f;
      const double relative = frame.relative_error * fabs(light);
      const double wanted = relative > error ? relative : error;
      known.wanted[row + i] = wanted * wanted;
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
      known.roughness[row + i] = own[i] > mean ? own[i] : mean;
      known.unseen[row + i] = overlooked * (most - least);
      known.of_cells[row + i] =
          cell_variance(frame, cell_errors_of(frame, known.cell_errors, i), o, known.rays[i]);
    }
  }
}

// The square of the standard error of output o of ommatidium i, times that of its number of rays,
// whose `roots` are as in ErrorMemory.
OMMA_HD double scaled_variance(const ErrorMemory& known, int i, int o, double roots) {
  const double unseen = known.unseen[o * most_per_block + i];
  return known.roughness[o * most_per_block + i] * roots + unseen * unseen;
}

// Whether the standard errors would be small enough with so many rays; all in radiance units. More
// rays do not change what cells of baked light err by: rays make up for at least half of the
// variance that is asked for, and where cells err by more than the other half, the error stays
// above.
OMMA_HD bool reaches_error(const FrameView& frame, const ErrorMemory& known, int i, double rays,
                           double roots) {
  for (int o = 0; o < frame.outputs; ++o) {
    const double all = known.wanted[o * most_per_block + i];
    const double left = all - known.of_cells[o * most_per_block + i];
    const double for_rays = left > 0.5 * all ? left : 0.5 * all;
    if (scaled_variance(known, i, o, roots) > for_rays * rays * rays) return false;
  }
  return true;
}

// So many rays that saw nothing are believed: what they missed fills less than a thousandth.
inline constexpr double believed_dark = 4096;

// Whether ommatidium i may by chance have seen nothing at all where there is light. A response of 0
// has no relative error, and one that is wrong would be reached at once: it holds only once all
// that are heard, who then have seen nothing either, have together had enough rays.
OMMA_HD bool may_have_missed(const FrameView& frame, const BlockTask& task,
                             const ErrorMemory& known, int i, double rays) {
  if (frame.error > 0) return false;
  for (int o = 0; o < frame.outputs; ++o)
    if (known.sums[o * most_per_block + i] != 0) return false;
  const int others = task.count - 1 < listened_to ? task.count - 1 : listened_to;
  return rays * (others + 1) < fmin(believed_dark, frame.most_samples);
}

// The smallest round that should reach the error, or the largest that is left; -1 where none is
// needed, or none left.
OMMA_HD int choose_round(const FrameView& frame, const BlockTask& task, const ErrorMemory& known,
                         int i) {
  const auto is_enough = [&](double rays, double roots) {
    return reaches_error(frame, known, i, rays, roots) &&
           !may_have_missed(frame, task, known, i, rays);
  };
  const double rays = known.rays[i];
  if (is_enough(rays, known.roots[i])) return -1;
  int round = -1;
  for (int k = 0; k < frame.rounds; ++k) {
    const double more = frame.directions[k].samples;
    if (rays + more > frame.most_samples) break;
    round = k;
    if (is_enough(rays + more, known.roots[i] + sqrt(more))) break;
  }
  return round;
}

// Before any ray of a block: its first round comes next for all.
OMMA_HD void begin_error(const FrameView& frame, const BlockTask& task, const ErrorMemory& known) {
  clear({known.sums, frame.outputs, most_per_block}, task.count);
  clear({known.squares, frame.outputs, most_per_block}, task.count);
  clear_cell_errors(frame, known.cell_errors, task.count);
  if (frame.truth != nullptr) clear(*frame.truth, known.truth, task.count);
  for (int i = 0; i < task.count; ++i) known.roots[i] = known.rays[i] = known.next[i] = 0;
}

// What comes next for each ommatidium of a block, by all rays so far; returns how many rounds there
// are of which some are to come.
OMMA_HD int choose_rounds(const FrameView& frame, const BlockTask& task, const ErrorMemory& known) {
  estimate(frame, task, known);
  int rounds = 0;
  for (int i = 0; i < task.count; ++i) {
    known.next[i] = choose_round(frame, task, known, i);
    if (known.next[i] >= rounds) rounds = known.next[i] + 1;
  }
  return rounds;
}

// Those of a block who have one of so many rounds to come, the shortest first, so that neighbours
// do about the same; returns how many they are.
OMMA_HD int list_members(const BlockTask& task, const ErrorMemory& known, int rounds) {
  int count = 0;
  for (int k = 0; k < rounds; ++k)
    for (int i = 0; i < task.count; ++i)
      if (known.next[i] == k) known.members[count++] = i;
  return count;
}

// A round of rays, of those directions, under a scramble.
struct Round {
  int directions, scramble;
};

// One round of some ommatidia of the block, whose numbers in it are `members`.
template <typename L, typename Search>
OMMA_HD void trace_members(const BlockRun<Search>& run, const Round& round,
                           const std::int32_t* members, int count) {
  const FrameView& frame = run.frame;
  const BlockMemory& memory = run.memory;
  const ErrorMemory& known = memory.error;
  const DirectionsView& directions = frame.directions[round.directions];
  std::int32_t ordinal[L::count > 1 ? most_per_block : 1];
  for (int u = 0; u < count; ++u) ordinal[u] = run.task.first + members[u];
  trace_replicates<L>(run, directions, {ordinal, round.scramble, 1, count});
  // Choices on the way of a path are not as even as the directions that they begin with.
  const bool is_even = !directions.random && frame.scene->light == nullptr;
  const double credit = is_even ? even_credit : 1.0;
  for (int u = 0; u < count; ++u) {
    const int i = members[u];
    known.rays[i] += directions.samples;
    known.roots[i] += sqrt(static_cast<double>(directions.samples));
    for (int o = 0; o < frame.outputs; ++o) {
      const int from = o * memory.stride + u, to = o * most_per_block + i;
      known.sums[to] += memory.sums[from];
      known.squares[to] += credit * memory.square_sums[from];
    }
    if (frame.truth != nullptr) add_truth(*frame.truth, memory.truth_sums, u, known.truth, i);
  }
}

// What the rays of ommatidium i of the block bring in output o.
OMMA_HD ByRays by_rays_of(const ErrorMemory& known, int i, int o) {
  const double rays = known.rays[i];
  return {known.sums[o * most_per_block + i] / rays,
          scaled_variance(known, i, o, known.roots[i]) / (rays * rays) +
              known.of_cells[o * most_per_block + i]};
}

// The response of ommatidium i of the block, which has no round to come; what it sees beside its
// rays is in memory.beside.
OMMA_HD void end_ommatidium(const FrameView& frame, const BlockTask& task,
                            const BlockMemory& memory, int i) {
  const ErrorMemory& known = memory.error;
  const std::int32_t ordinal = task.first + i;
  const auto ommatidium = static_cast<std::int64_t>(frame.eye->ommatidium[ordinal]);
  if (task.rays != nullptr) task.rays[ommatidium] = known.rays[i];
  if (frame.truth != nullptr)
    reduce_truth(frame, task, known.truth, {ordinal, i, 1, known.rays[i]});
  for (int o = 0; o < frame.outputs; ++o) {
    const std::int64_t out = ommatidium * frame.outputs + o;
    auto [response, variance] = by_rays_of(known, i, o);
    if (sees_beside_rays(frame)) {
      response += memory.beside[o];
      variance += memory.beside_variance[o];
    }
    task.responses[out] = static_cast<float>(response * frame.radiance_unit);
    if (task.standard_error != nullptr)
      task.standard_error[out] = static_cast<float>(sqrt(variance) * frame.radiance_unit);
  }
}

// The responses of ommatidia of a list, under one scramble, that follow each other from number
// `first` of the block on.
template <typename L, typename Search>
OMMA_HD void end_ommatidia(const BlockRun<Search>& run, const ReplicateList& list, int first) {
  const auto give = [&](int u, int o) { return by_rays_of(run.memory.error, first + u, o); };
  const auto end = [&](int u) { end_ommatidium(run.frame, run.task, run.memory, first + u); };
  if (sees_beside_rays(run.frame))
    return eval_beside_rays<L>(run.frame, run.task, list, run.search, run.memory,
                               BesideCalls{give, end});
  for (int u = 0; u < list.count; ++u) end(u);
}

template <typename L, typename Search>
OMMA_HD void render_to_error(const BlockRun<Search>& run) {
  const FrameView& frame = run.frame;
  const BlockTask& task = run.task;
  const BlockMemory& memory = run.memory;
  const ErrorMemory& known = memory.error;
  begin_error(frame, task, known);
  int rounds = 1;
  for (int scramble = 0; rounds > 0; ++scramble) {
    for (int k = 0; k < rounds; ++k) {
      std::int32_t members[most_per_block];
      // Of replicates that are shorter than a packet no more than wait to be summed up.
      const int samples = frame.directions[k].samples;
      const int most = samples < summed_rays ? block_rays / samples : most_per_block;
      for (int i = 0; i < task.count;) {
        int count = 0;
        for (; i < task.count && count < most; ++i)
          if (known.next[i] == k) members[count++] = i;
        if (count > 0) trace_members<L>(run, {k, scramble}, members, count);
      }
    }
    rounds = choose_rounds(frame, task, known);
  }
  end_ommatidia<L>(run, {nullptr, 0, 1, task.count}, 0);
}

}  // namespace omma
