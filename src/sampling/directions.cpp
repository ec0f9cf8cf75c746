// Builds the direction tables: Owen-scrambled Sobol points, through the normal quantile per axis
// (which keeps their strata compact), moved apart where they are few, through the exact warp of
// each acceptance angle.
#include "sampling/directions.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "optics/acceptance_hash.h"
#include "optics/footprint_width.h"
#include "physics/sampling/hash.h"
#include "physics/sampling/low_discrepancy.h"
#include "sampling/even_points.h"
#include "sampling/sampling_choice.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// So many patterns that twice as many would lower no error by 1 %; the tables of one acceptance
// angle fit a core's second-level cache.
constexpr std::size_t points_per_warp = 4096;
constexpr int most_patterns = 1024;
// Bounds of all tables together: 100 MB, and some tenths of a second to make their points. With
// fewer patterns than scrambles no tables are made.
constexpr std::size_t most_points = std::size_t(1) << 23;
constexpr std::size_t most_scrambled_points = std::size_t(1) << 19;
constexpr int least_patterns = error_scrambles;

int choose_pattern_count(int samples, std::size_t warps) {
  const std::size_t n = static_cast<std::size_t>(samples);
  const std::size_t most =
      std::min(most_points / (n * std::max<std::size_t>(warps, 1)), most_scrambled_points / n);
  const std::size_t wanted = std::max<std::size_t>(points_per_warp / n, 2 * least_patterns);
  std::size_t patterns = most_patterns;
  while (patterns > 1 && (patterns > wanted || patterns > most)) patterns /= 2;
  return patterns >= least_patterns ? static_cast<int>(patterns) : 0;
}

// Sorts a pattern along a Morton curve, so that each 16 consecutive directions are near each other
// and make a coherent packet.
void sort_into_packets(std::vector<Vec3d>& normals) {
  const auto morton = [](const Vec3d& p) {
    const auto cell = [](double v) {
      return static_cast<std::uint32_t>(std::clamp(0.5 * std::erfc(-v * std::sqrt(0.5)), 0.0, 1.0) *
                                        65535.0);
    };
    std::uint32_t code = 0;
    for (int bit = 0; bit < 16; ++bit)
      code |= ((cell(p.x) >> bit) & 1u) << (2 * bit) | ((cell(p.y) >> bit) & 1u) << (2 * bit + 1);
    return code;
  };
  std::vector<std::pair<std::uint32_t, Vec3d>> keyed;
  keyed.reserve(normals.size());
  for (const Vec3d& p : normals) keyed.emplace_back(morton(p), p);
  std::stable_sort(keyed.begin(), keyed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < keyed.size(); ++i) normals[i] = keyed[i].second;
}

// Above this number of widths nearby ones share a warp, so that tables stay in the cache: one for
// each step of width_step, scaled to each width (with 6,374 widths 1.5 times as fast, and made in a
// tenth of the time). Scaling sines by k in place of angles changes S by at most a factor 1 + 0.92
// |k^2 - 1| theta^2 (theta/width)^2, where k is within half a step of 1: 1e-4 at theta = width for
// the widest that are scaled.
//
// S of a lens is a function of sines, which scale as lambda/D. The angle of its rhabdom over
// lambda/D is rounded to steps too, so that its width is exact to half a step.
constexpr std::size_t most_exact_widths = 64;
constexpr double width_step = 0.0025;
constexpr double widest_scaled_rad = 0.2;

bool is_lens(const Acceptance& a) {
  return a.kernel == Kernel::airy ||
         (a.kernel == Kernel::lens_rhabdom && a.model != RhabdomModel::snyder);
}

// Rounds widths to steps, where there are many: replaces each acceptance by that of its step and
// returns how many times as wide each was. Empty, and nothing changed, where there are few widths.
std::vector<float> use_width_levels(std::vector<Acceptance>& acceptances) {
  const auto scales = [](const Acceptance& a) {
    return is_lens(a) || (a.kernel <= Kernel::compoundray && is_round(a) && a.width_rad > 0 &&
                          a.width_rad <= widest_scaled_rad);
  };
  std::unordered_set<double> widths;
  for (const Acceptance& a : acceptances)
    if (scales(a)) widths.insert(is_lens(a) ? a.facet_diameter_m : a.width_rad);
  if (widths.size() <= most_exact_widths) return {};
  std::vector<float> scale(acceptances.size(), 1.0f);
  for (std::size_t i = 0; i < acceptances.size(); ++i) {
    Acceptance& a = acceptances[i];
    if (!scales(a)) continue;
    if (is_lens(a)) {
      const Acceptance level = lens_level(a, width_step);
      scale[i] = static_cast<float>(level.facet_diameter_m / a.facet_diameter_m);
      a = level;
      continue;
    }
    const double level = std::exp(width_step * std::round(std::log(a.width_rad) / width_step));
    scale[i] = static_cast<float>(a.width_rad / level);
    a.width_rad = level;
    a.minor_width_rad = 0;
  }
  return scale;
}

// Which patterns of which warps are to be made, [warp * patterns + pattern]: all, or those that are
// used in frame 0 (replicates.h).
std::vector<std::size_t> patterns_to_make(const DirectionTables& tables,
                                          const std::vector<std::int32_t>& eye_sizes,
                                          bool of_frame_0) {
  const auto patterns = static_cast<std::size_t>(tables.patterns);
  std::vector<std::uint8_t> used(tables.warps.size() * patterns, of_frame_0 ? 0 : 1);
  const std::uint64_t pose = pose_hash(tables.seed, 0);
  const std::vector<std::int32_t> number = numbers_in_eyes(tables.warp_of.size(), eye_sizes);
  for (std::size_t i = 0; i < number.size(); ++i) {
    const std::uint32_t hash = ommatidium_hash(pose, static_cast<std::uint32_t>(number[i]));
    for (std::uint32_t scramble = 0; scramble < error_scrambles; ++scramble)
      used[tables.warp_of[i] * patterns + ((hash + scramble) & (patterns - 1))] = 1;
  }
  std::vector<std::size_t> made;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i] != 0) made.push_back(i);
  return made;
}

// The scrambled points of all patterns.
std::vector<std::vector<Vec3d>> scrambled_points(std::uint64_t seed, std::size_t patterns,
                                                 std::size_t n) {
  std::vector<std::vector<Vec3d>> normals(patterns, std::vector<Vec3d>(n));
  parallel_for(std::size_t{0}, patterns, [&](std::size_t k) {
    const std::uint64_t scramble = hash_combine(mix_bits(seed), k);
    for (std::size_t j = 0; j < n; ++j)
      normals[k][j] = scrambled_normals(static_cast<std::uint32_t>(j), scramble);
  });
  move_apart(normals, seed);
  parallel_for(std::size_t{0}, patterns, [&](std::size_t k) { sort_into_packets(normals[k]); });
  return normals;
}

// Points moved apart have the normal's radii but lie along some directions more than others: only a
// random turn leaves no bias. Estimates of a round sensitivity turn their directions about the axis
// (replicates.h); of any other the points of each pattern are turned before they are warped.
double turn_of_pattern_rad(std::uint64_t seed, std::size_t pattern) {
  constexpr std::uint64_t of_turns = 0x7475726e73;
  return 2 * pi * unit_interval(hash_combine(mix_bits(seed ^ of_turns), pattern));
}

std::vector<Acceptance> rendered_acceptances(const Eye& eye, const RenderSettings& settings) {
  std::vector<Acceptance> all;
  all.reserve(eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) all.push_back(rendered_acceptance(eye, settings, i));
  return all;
}

}  // namespace

std::vector<std::int32_t> numbers_in_eyes(std::size_t ommatidia,
                                          const std::vector<std::int32_t>& eye_sizes) {
  std::vector<std::int32_t> number;
  number.reserve(ommatidia);
  for (const std::int32_t size : eye_sizes)
    for (std::int32_t i = 0; i < size; ++i) number.push_back(i);
  for (std::size_t i = number.size(); i < ommatidia; ++i)
    number.push_back(static_cast<std::int32_t>(i));
  return number;
}

Acceptance rendered_acceptance(const Eye& eye, const RenderSettings& settings, std::size_t i) {
  if (!settings.kernel) return acceptance_at(eye, i);
  Acceptance acceptance;
  acceptance.kernel = *settings.kernel;
  acceptance.width_rad = eye.acceptance_angle_rad[i];
  return acceptance;
}

DirectionTables make_direction_tables(const Eye& eye, const RenderSettings& settings, int samples,
                                      const DirectionTables* known_tables, bool of_frame_0) {
  DirectionTables tables;
  tables.samples = samples;
  tables.points = settings.points;
  tables.seed = settings.seed;

  // One warp per distinct acceptance, or per level of their widths.
  std::vector<Acceptance> acceptances = rendered_acceptances(eye, settings);
  if (!shares_rays(settings.sampling)) tables.scale_of = use_width_levels(acceptances);
  std::unordered_map<Acceptance, std::uint32_t, AcceptanceHash> known;
  std::vector<Acceptance> distinct;
  for (const Acceptance& acceptance : acceptances) {
    const auto [found, is_new] =
        known.try_emplace(acceptance, static_cast<std::uint32_t>(distinct.size()));
    if (is_new) distinct.push_back(acceptance);
    tables.warp_of.push_back(found->second);
  }
  tables.warps.resize(distinct.size());
  std::unordered_map<Acceptance, const AcceptanceWarp*, AcceptanceHash> made;
  if (known_tables != nullptr)
    for (const AcceptanceWarp& warp : known_tables->warps) made[warp.acceptance] = &warp;
  tables.warp_cache =
      known_tables != nullptr ? known_tables->warp_cache : std::make_shared<WarpCache>();
  parallel_for(std::size_t{0}, distinct.size(), [&](std::size_t i) {
    const auto found = made.find(distinct[i]);
    tables.warps[i] = found != made.end() ? *found->second : tables.warp_cache->get(distinct[i]);
  });

  for (const AcceptanceWarp& warp : tables.warps) {
    tables.warp_views.push_back(view(warp));
    const double width_rad =
        settings.footprints ? footprint_width_rad(warp.sensitivity, samples) : 0;
    tables.footprint_rad.push_back(static_cast<float>(width_rad));
    tables.fixed_turn.push_back(warp.round ? -1 : static_cast<std::int32_t>(turn_count));
  }

  for (std::size_t i = 0; i < turn_count; ++i) {
    const double angle = 2 * pi * (static_cast<double>(i) + 0.5) / turn_count;
    tables.turns.push_back(
        {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))});
  }
  tables.turns.push_back({1, 0});
  if (settings.points == Points::random) {
    tables.polar = make_polar_tables(tables.warps);
    return tables;
  }
  tables.patterns = choose_pattern_count(samples, distinct.size());
  if (tables.patterns == 0) return tables;

  // The scrambled points are shared by all warps; the directions are not.
  const std::size_t n = static_cast<std::size_t>(samples);
  const std::size_t patterns = static_cast<std::size_t>(tables.patterns);
  const bool same_points = known_tables != nullptr && known_tables->normals != nullptr &&
                           known_tables->seed == settings.seed &&
                           known_tables->samples == samples &&
                           known_tables->patterns == tables.patterns;
  tables.normals = same_points ? known_tables->normals
                               : std::make_shared<const std::vector<std::vector<Vec3d>>>(
                                     scrambled_points(settings.seed, patterns, n));
  const std::vector<std::vector<Vec3d>>& normals = *tables.normals;
  const std::vector<std::size_t> to_make = patterns_to_make(tables, settings.eye_sizes, of_frame_0);
  tables.local.resize(distinct.size() * patterns * 3 * n);
  parallel_for(std::size_t{0}, to_make.size(), [&](std::size_t k) {
    const std::size_t i = to_make[k];
    const AcceptanceWarpView& warp = tables.warp_views[i / patterns];
    const double turn_rad =
        tables.fixed_turn[i / patterns] < 0 ? 0 : turn_of_pattern_rad(settings.seed, i % patterns);
    const double cosine = std::cos(turn_rad), sine = std::sin(turn_rad);
    float* out = tables.local.data() + i * 3 * n;
    for (std::size_t j = 0; j < n; ++j) {
      const Vec3d& unturned = normals[i % patterns][j];
      const Vec3d p = {unturned.x * cosine - unturned.y * sine,
                       unturned.x * sine + unturned.y * cosine, 0};
      const Vec3 d = to_float(sample_acceptance(warp, p.x, p.y));
      out[j] = d.x;
      out[n + j] = d.y;
      out[2 * n + j] = d.z;
    }
  });
  return tables;
}

DirectionsView view(const DirectionTables& t) {
  return {t.samples,
          t.samples,
          0,
          0,
          t.points == Points::random,
          t.seed,
          t.patterns,
          t.local.data(),
          t.turns.data(),
          t.fixed_turn.data(),
          t.footprint_rad.data(),
          t.warp_views.data(),
          view(t.polar),
          static_cast<std::int32_t>(t.footprint_rad.size()),
          t.version};
}

}  // namespace omma
