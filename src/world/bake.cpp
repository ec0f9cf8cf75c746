// Baking in passes, each in two halves with independent random numbers, whose difference is noise
// (backend/bake_groups.h). The first pass estimates the noise. Where light enters by small
// openings, as into rooms, later passes end their paths on the light of the pass before (final
// gathering); elsewhere a second pass has more paths where there is more noise, and counts alone: a
// mean with the paths that decided on how many others there are would be biased low.
#include "omma/bake.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "backend/bake_cells.h"
#include "backend/bake_groups.h"
#include "omma/error.h"
#include "physics/path/baked.h"
#include "physics/sampling/hash.h"
#include "threads/parallel.h"
#include "world/bake_gather.h"

namespace omma {
namespace {

constexpr int most_paths = 65536;
// Paths of both halves for a side of a cell, in the mean, where none are asked for; small scenes have
// so many for all sides together.
constexpr double paths_of_side = 12, paths_of_small_scenes = 1 << 26;
// One of so many paths goes to the first pass.
constexpr double paths_of_first = 6;
constexpr int most_first = 32;
// Final gathering is used where light enters by small openings, as into rooms, so that paths vary
// much: where the relative variance of one path exceeds this at a tenth of the cells. With few
// paths per side the variance is not known, and gathering would read noise.
constexpr double variance_in_rooms = 16, least_to_gather = 96;
// Variance of a path that ends on what is baked over that of one that goes all the way, about.
constexpr double variance_of_second = 0.5;
constexpr std::int32_t cells_of_chunk = 256;
constexpr std::uint32_t hash_of_cells = 0x63656c6cu, hash_of_probes = 0x70726f62u;

// A value of 1 of what is kept, over the light's usual brightness; where a scene turns out to be
// brighter, so much more is tried.
constexpr double first_unit = 0x1p12, more_unit = 0x1p9;

void check(const World& world, const BakeSettings& settings) {
  if (!world.settings().lighting)
    throw Error("baked light: expected a world with a light, found one without");
  expect_no_splats(*world.state().built->scene);
  if (world.settings().lighting->baked != nullptr)
    throw Error("baked light: expected a world that is lit by paths, found one with baked light");
  if (world.settings().lighting->depth != 0)
    throw Error("depth: expected 0, as many scatterings as it takes, of light that is baked; found " +
                std::to_string(world.settings().lighting->depth));
  if (!(settings.cell_m >= 0) || !std::isfinite(settings.cell_m))
    throw Error("cell_m: expected a size in m, or 0 for one that is chosen, found " +
                std::to_string(settings.cell_m));
  if (settings.paths < 0 || settings.paths > most_paths || settings.paths % packet_rays != 0)
    throw Error("paths: expected a multiple of " + std::to_string(packet_rays) + " up to " +
                std::to_string(most_paths) + ", or 0 for as many as noise asks for; found " +
                std::to_string(settings.paths));
}

// The box of the scene as it lies in the traced frame.
Bounds traced_box(const BuiltScene& built) {
  Bounds box;
  const std::vector<bool> is_in_reach = instances_in_reach(*built.scene, built.placement);
  for (std::size_t i = 0; i < built.scene->instances.size(); ++i) {
    if (!is_in_reach[i]) continue;
    const Bounds& own = built.box_of_mesh[static_cast<std::size_t>(built.scene->instances[i].mesh)];
    if (own.empty) continue;
    Mat4 placed = built.placement.world_from_mesh[i];
    const Vec3d origin = built.placement.origin_m;
    placed.m[0][3] -= origin.x, placed.m[1][3] -= origin.y, placed.m[2][3] -= origin.z;
    const Bounds one = placed_box(own, placed);
    box = box.empty ? one : box_around(box, one);
  }
  return box;
}

// The cells of a world, without light.
BakedLight lay_out(const World& world, const BakeSettings& settings) {
  const BuiltScene& built = *world.state().built;
  const Tracing tracing{built.launches.closest, built.acceleration.tracer.get()};
  BakeCells cells = divide_into_cells(tracing, *built.scene, built.placement,
                                      static_cast<std::size_t>(world.bands()), settings);
  BakedLight plan;
  plan.bands = world.bands();
  plan.cell_m = cells.cell_m;
  plan.by_probes = cells.by_probes;
  plan.cells = static_cast<std::int32_t>(cells.cells);
  plan.first_cell = std::move(cells.first_cell);
  plan.cell_of_triangle = std::move(cells.cell_of_triangle);
  lay_out_probes(plan, traced_box(built));
  for (int a = 0; a < 3; ++a) plan.probe_origin_m[a] -= built.first_origin_now_m[a];
  return plan;
}

std::size_t lines_of(const BakedLight& plan) {
  const std::size_t per_line = sizeof(BakedLine) / sizeof(std::uint16_t);
  return (2 * static_cast<std::size_t>(plan.bands) * static_cast<std::size_t>(plan.cells) + per_line - 1) /
         per_line;
}

std::int32_t chunks_of(const BakedLight& plan) {
  return (plan.cells + cells_of_chunk - 1) / cells_of_chunk;
}

// How many paths all halves and sides have together, and each side of a half in the first pass.
struct PathPlan {
  double all = 0;
  int first = 1;
};

PathPlan plan_paths(const BakeSettings& settings, std::size_t sides) {
  const auto many = static_cast<double>(std::max<std::size_t>(sides, 1));
  if (settings.paths > 0) return {settings.paths * many, settings.paths / 4};
  PathPlan plan{std::max(paths_of_side * many, paths_of_small_scenes), 1};
  while (plan.first < most_first && 4.0 * plan.first * paths_of_first * many <= plan.all) plan.first *= 2;
  return plan;
}

// The last pass, and the share of the work that lies before each and behind the last.
std::vector<double> work_of_passes(const PathPlan& plan, double sides, bool gathers) {
  const double first = std::min(0.9, 2.0 * plan.first * sides / std::max(plan.all, 1.0));
  if (!gathers) return {0, first, 1};
  return {0, first, first + (1 - first) / 4, 1};
}

// Both halves of one pass, of chunks that are not finished; false where something was too bright.
bool run_pass(const World& world, const BakedLight& plan, const CellPaths& paths,
              UnfinishedBake& state, const WorkPart& work) {
  const std::int32_t chunks = chunks_of(plan);
  const std::size_t to = state.pass % 2 == 1 ? 0 : 2;  // pairs of halves take turns
  std::atomic<bool> has_room{true};
  std::atomic<std::int32_t> finished{0};
  for (std::int32_t h = 0; h < 2; ++h) {
    const auto half = static_cast<std::size_t>(h);
    auto& lines = state.lines[to + half];
    if (lines.empty()) continue;
    const bool is_gathered = state.gathers && state.pass > 1;
    const GatherWorld gathered(world, plan, is_gathered ? state.lines[2 - to + half].data() : nullptr);
    CellPaths own = paths;
    own.hash = mix_bits_32(paths.hash + static_cast<std::uint32_t>(2 * state.pass + h));
    parallel_for<std::int32_t>(0, chunks, [&](std::int32_t chunk) {
      std::uint8_t& done = state.done[static_cast<std::size_t>(h * chunks + chunk)];
      if (done == 0) {
        const std::int32_t first = chunk * cells_of_chunk;
        if (!gather_cells(gathered, own, first, std::min(plan.cells, first + cells_of_chunk),
                          lines.front().values + 2 * static_cast<std::ptrdiff_t>(first) * plan.bands))
          has_room = false;
        done = 1;
      }
      work.reach(static_cast<double>(++finished) / (2.0 * chunks));
    });
  }
  return has_room;
}

void begin_pass(UnfinishedBake& state, const BakedLight& plan) {
  ++state.pass;
  state.done.assign(2 * static_cast<std::size_t>(chunks_of(plan)), 0);
  const std::size_t to = state.pass % 2 == 1 ? 0 : 2;
  for (std::size_t half = 0; half < 2; ++half) state.lines[to + half].assign(lines_of(plan), {});
}

// Whether what is finished is of such cells.
bool is_of(const UnfinishedBake& state, const BakedLight& plan, const BakeGroups& groups) {
  bool is = state.done.size() == 2 * static_cast<std::size_t>(chunks_of(plan));
  for (std::size_t k = 0; k < (state.pass > 1 ? 4u : 2u); ++k)
    is = is && state.lines[k].size() == lines_of(plan);
  return is && (state.pass < 2 || state.paths_of_group.size() == groups.count());
}

// [cell][side], of what is chosen by group.
std::vector<std::uint16_t> by_side(const BakeGroups& groups, const std::vector<std::uint16_t>& of_group,
                                   std::int32_t cells) {
  std::vector<std::uint16_t> of_side(2 * static_cast<std::size_t>(cells), 0);
  for (std::size_t g = 0; g < groups.count(); ++g)
    for (std::int64_t m = groups.first[g]; m < groups.first[g + 1]; ++m)
      of_side[static_cast<std::size_t>(groups.side[static_cast<std::size_t>(m)])] = of_group[g];
  return of_side;
}

// The variance of a path, over the square of the light, that a tenth of lit cells exceed.
double variance_of_path(const BakeGroups& groups, const std::vector<GroupNoise>& noise, int paths) {
  std::vector<std::pair<double, std::int64_t>> own;  // of lit groups, cells
  std::int64_t all = 0;
  for (std::size_t g = 0; g < groups.count(); ++g)
    if (noise[g].is_lit) {
      own.emplace_back(2 * paths * noise[g].own, groups.members(g));
      all += groups.members(g);
    }
  std::sort(own.begin(), own.end());
  std::int64_t below = 0;
  for (const auto& [variance, members] : own)
    if ((below += members) * 10 >= 9 * all) return variance;
  return 0;
}

// Paths for each side of a half in the pass that comes after the state's.
std::vector<std::uint16_t> paths_of_next(const BakeSettings& settings, const BakeGroups& groups,
                                         const std::vector<GroupNoise>& noise, const PathPlan& plan,
                                         const UnfinishedBake& state) {
  if (settings.paths > 0) {
    const int own = state.gathers ? settings.paths / 2 : settings.paths / 2 - plan.first;
    return std::vector<std::uint16_t>(groups.count(), static_cast<std::uint16_t>(own));
  }
  std::vector<double> of_path;
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const double before = state.pass > 1 ? state.paths_of_group[g]
                                         : plan.first * (state.gathers ? variance_of_second : 1.0);
    of_path.push_back(2 * noise[g].own * before);
  }
  const double share = !state.gathers ? 1.0 : state.pass == 1 ? 0.25 : 0.75;
  return share_paths(groups, of_path, share * plan.all);
}

// Both passes of cells that have as many paths as were asked for, into the second's halves.
void put_together(const std::vector<std::uint16_t>& later, int first_paths, int bands,
                  UnfinishedBake& state) {
  parallel_ranges<std::size_t>(0, later.size(), 4096, [&](std::size_t from, std::size_t to) {
    for (std::size_t side = from; side < to; ++side) {
      const float first = static_cast<float>(first_paths),
                  all = first + static_cast<float>(later[side]);
      for (std::size_t half = 0; half < 2; ++half) {
        const std::uint16_t* const before = state.lines[half].front().values;
        std::uint16_t* const both = state.lines[2 + half].front().values;
        for (int b = 0; b < bands; ++b) {
          const std::size_t at = side * static_cast<std::size_t>(bands) + static_cast<std::size_t>(b);
          const float share = first / all;
          both[at] = encode_baked(share * decode_baked(before[at]) +
                                  (1 - share) * decode_baked(both[at]));
        }
      }
    }
  });
}

// All cells and probes of `baked`, which has no light yet; false where something was too bright for
// its unit.
bool bake_all(const World& world, const BakeSettings& settings, BakedLight& baked,
              UnfinishedBake& state, WorkState& work) {
  const BuiltScene& built = *world.state().built;
  const SceneView& view = world.state().view;
  const CellOwners owners(baked, *built.scene);
  const std::uint32_t seed = mix_bits_32(settings.seed);
  const GatherWorld by_paths(world, baked, nullptr);
  if (!gather_probes(by_paths, baked, hash_of_probes + seed)) return false;
  baked.lines.resize(lines_of(baked));
  if (baked.cells == 0) return true;
  const BakeGroups groups = group_cells(baked, owners, view, *built.scene, built.placement);
  const auto sides = static_cast<double>(groups.side.size());
  const PathPlan plan = plan_paths(settings, groups.side.size());
  CellPaths of{owners, *built.scene, built.placement, view, hash_of_cells + seed, plan.first, nullptr};
  if (!is_of(state, baked, groups)) state.pass = 0;
  if (state.pass == 0) begin_pass(state, baked);
  for (;;) {
    std::vector<std::uint16_t> of_side;
    if (state.pass > 1) {
      of_side = by_side(groups, state.paths_of_group, baked.cells);
      of.paths_of_side = of_side.data();
    }
    const std::vector<double> shares = work_of_passes(plan, sides, state.gathers);
    const auto pass = static_cast<std::size_t>(state.pass);
    if (!run_pass(world, baked, of, state, WorkPart{&work, shares[pass - 1], shares[pass]}))
      return false;
    const std::size_t to = state.pass % 2 == 1 ? 0 : 2;
    const int last = settings.paths > 0 || !state.gathers ? 2 : 3;
    const bool is_last = state.pass == last;
    if (is_last) state.pass = 0;  // what is left takes a moment, and changes what is kept
    const bool adds_up = settings.paths > 0 && !state.gathers;
    if (is_last && adds_up) put_together(of_side, plan.first, baked.bands, state);
    const BakedLine* const halves[2] = {state.lines[to].data(), state.lines[to + 1].data()};
    const std::vector<GroupNoise> noise = find_noise(groups, baked.bands, halves);
    if (is_last) {
      share_mean(groups, noise, halves, baked);
      double all = 0;
      for (const std::uint16_t one : of_side)
        all += one > 0 ? 2.0 * (one + (adds_up ? plan.first : 0)) : 0.0;
      baked.paths = all / sides;
      return true;
    }
    if (state.pass == 1)
      state.gathers = plan.all >= least_to_gather * sides &&
                      variance_of_path(groups, noise, plan.first) > variance_in_rooms;
    state.paths_of_group = paths_of_next(settings, groups, noise, plan, state);
    begin_pass(state, baked);
  }
}

}  // namespace

std::size_t BakedLight::bytes() const {
  std::size_t sum = lines.size() * sizeof(BakedLine) + errors.size() * sizeof(CellError) +
                    probe_values.size() * 2 + first_cell.size() * 4;
  for (const std::vector<std::int32_t>& first : cell_of_triangle) sum += first.size() * 4;
  return sum;
}

BakedLight bake_light(const World& world, const BakeSettings& settings,
                      const std::function<bool(double)>& progress, UnfinishedBake* unfinished) {
  check(world, settings);
  const Rendering unmoved(world);
  const BuiltScene& built = *world.state().built;
  const auto start = Clock::now();
  UnfinishedBake own;
  UnfinishedBake& state = unfinished != nullptr ? *unfinished : own;
  const double seconds_before = state.seconds;
  BakedLight baked;
  const auto bake = [&](WorkState& work) {
    baked = lay_out(world, settings);
    baked.unit = state.unit > 0 ? state.unit : world.state().radiance_unit * first_unit;
    for (;;) {
      state.unit = baked.unit;
      if (bake_all(world, settings, baked, state, work)) return;
      state = {};
      baked.unit *= more_unit;
    }
  };
  run_watched(progress, [&](WorkState& work) {
    try {
      run_in_arena(*built.threads.arena, [&] { bake(work); });
    } catch (...) {
      state.share = state.pass > 0 ? work.fraction.load() : 0;
      state.seconds = seconds_before + seconds_since(start);
      throw;
    }
  });
  baked.seconds = seconds_before + seconds_since(start);
  return baked;
}

BakeCost bake_cost(const World& world, const BakeSettings& settings) {
  check(world, settings);
  const Rendering unmoved(world);
  const BuiltScene& built = *world.state().built;
  BakeCost cost;
  run_in_arena(*built.threads.arena, [&] {
    BakedLight plan = lay_out(world, settings);
    plan.unit = world.state().radiance_unit * first_unit;
    cost.cells = plan.cells;
    cost.by_probes = plan.by_probes;
    cost.bytes = lines_of(plan) * sizeof(BakedLine) +
                 2 * static_cast<std::size_t>(plan.cells) * sizeof(CellError);
    if (plan.cells == 0) return;
    const CellOwners owners(plan, *built.scene);
    const GatherWorld by_paths(world, plan, nullptr);
    const CellPaths of{owners, *built.scene, built.placement, world.state().view, hash_of_cells,
                       packet_rays, nullptr};
    // Cells all over the scene.
    constexpr std::int32_t tried = 4096;
    const std::int32_t step = std::max(1, plan.cells / tried);
    const auto gather = [&](std::int32_t cell) {
      std::uint16_t values[2 * most_bands];
      gather_cells(by_paths, of, cell, cell + 1, values);
    };
    gather(0);  // not timed: a card's kernel is compiled when it is first used
    const auto start = Clock::now();
    const std::int32_t count = (plan.cells + step - 1) / step;
    parallel_for<std::int32_t>(0, count, [&](std::int32_t k) { gather(k * step); });
    const double path_s = seconds_since(start) / (2.0 * packet_rays * count);
    const auto sides = 2.0 * static_cast<double>(plan.cells);
    cost.seconds = path_s * plan_paths(settings, static_cast<std::size_t>(sides)).all;
  });
  return cost;
}

}  // namespace omma
