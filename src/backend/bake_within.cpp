// Variation within cells from the squares of differences between neighbours: products of what two
// independent halves of a bake have of a difference have no noise in their mean.
#include "backend/bake_within.h"

#include <algorithm>
#include <array>

#include "physics/path/baked.h"
#include "threads/parallel.h"

namespace omma {
namespace {

constexpr std::size_t neighbours = 3;  // as many as a triangle has
// Cells lie in a group in the order of their triangles: neighbours are not farther apart in it.
constexpr std::int64_t window = 128;
// The variance within a triangle over the mean square of differences to its three neighbours: 0.25
// of an even slope. Of a sharp edge, whose variogram grows as the distance, it is 0.32: points of a
// triangle of side 1 are 0.365 apart in the mean, its middle and those of its neighbours 0.577.
constexpr double within_of_difference = 0.32;
// Light of a cell is taken for no less than this fraction of its group's: it may be lost in noise.
constexpr double least_light = 1.0 / 16;

// Places in the group of those nearest to place m, and how many there are.
struct Nearest {
  std::array<std::int64_t, neighbours> at;
  std::size_t count = 0;
};

Nearest find_nearest(const BakeGroups& groups, std::size_t g, std::int64_t m) {
  Nearest found;
  std::array<float, neighbours> squares;
  const Vec3 middle = groups.middle[static_cast<std::size_t>(m)];
  const std::int64_t from = std::max(groups.first[g], m - window),
                     to = std::min(groups.first[g + 1], m + window + 1);
  for (std::int64_t other = from; other < to; ++other) {
    if (other == m) continue;
    const Vec3 apart = groups.middle[static_cast<std::size_t>(other)] - middle;
    const float square = dot(apart, apart);
    if (found.count == neighbours && square >= squares[neighbours - 1]) continue;
    if (found.count < neighbours) ++found.count;
    std::size_t at = found.count - 1;
    for (; at > 0 && squares[at - 1] > square; --at) {
      squares[at] = squares[at - 1];
      found.at[at] = found.at[at - 1];
    }
    squares[at] = square;
    found.at[at] = other;
  }
  return found;
}

}  // namespace

std::vector<float> find_within(const BakeGroups& groups, int bands,
                               const BakedLine* const (&half)[2]) {
  const auto light = [&](std::size_t h, std::int64_t place, int b) {
    const std::int64_t side = groups.side[static_cast<std::size_t>(place)];
    return static_cast<double>(decode_baked(half[h]->values[side * bands + b]));
  };
  constexpr float unknown = -1;
  std::vector<float> within(groups.side.size(), unknown);
  parallel_ranges<std::size_t>(0, groups.count(), 256, [&](std::size_t from, std::size_t to) {
    std::vector<double> mean(static_cast<std::size_t>(bands));
    for (std::size_t g = from; g < to; ++g) {
      const std::int64_t first = groups.first[g], end = groups.first[g + 1];
      for (int b = 0; b < bands; ++b) {
        double sum = 0;
        for (std::int64_t m = first; m < end; ++m) sum += light(0, m, b) + light(1, m, b);
        mean[static_cast<std::size_t>(b)] = sum / static_cast<double>(2 * (end - first));
      }
      for (std::int64_t m = first; m < end; ++m) {
        const Nearest nearest = find_nearest(groups, g, m);
        double squares = 0;
        int count = 0;
        for (int b = 0; b < bands; ++b) {
          const double whole = mean[static_cast<std::size_t>(b)];
          if (!(whole > 0)) continue;
          const double one = light(0, m, b), other = light(1, m, b);
          const double own = std::max((one + other) / 2, least_light * whole);
          for (std::size_t k = 0; k < nearest.count; ++k, ++count)
            squares += (one - light(0, nearest.at[k], b)) * (other - light(1, nearest.at[k], b)) /
                       (own * own);
        }
        if (count > 0)
          within[static_cast<std::size_t>(m)] =
              static_cast<float>(std::max(0.0, within_of_difference * squares / count));
      }
    }
  });
  std::vector<float> known;
  for (const float one : within)
    if (one != unknown) known.push_back(one);
  float median = 0;
  if (!known.empty()) {
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    median = *middle;
  }
  std::replace(within.begin(), within.end(), unknown, median);
  return within;
}

}  // namespace omma
