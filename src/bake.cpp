// Baking: the cells of a scene, both sides of each, and probes in the air about them, on all threads.
#include "omma/bake.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "backend/bake_cells.h"
#include "model/text.h"
#include "omma/world.h"
#include "physics/baked.h"
#include "physics/hash.h"
#include "threads/parallel.h"
#include "threads/thread_memory.h"
#include "world_state.h"

namespace omma {
namespace {

constexpr int most_paths = 65536;
// Probes along the longest side of the scene, and those of all sides together: few where there are
// few cells, so that they never take most of the time.
constexpr int probes_along = 48;
constexpr std::int64_t least_probes = 512, most_probes = 16384, cells_of_probe = 8;
constexpr int paths_of_probe = 64;
constexpr std::uint32_t hash_of_cells = 0x63656c6cu, hash_of_probes = 0x70726f62u;

// A value of 1 of what is kept, over the light's usual brightness; where a scene turns out to be
// brighter, so much more is tried.
constexpr double first_unit = 0x1p12, more_unit = 0x1p9;

struct Gathering {
  const BuiltScene& built;
  SceneView view;
  EyeView eye = {};
  DirectionsView directions = {};
  FrameView frame = {};
  std::size_t bands;
  float per_unit;  // of what is kept
  std::atomic<bool>& is_too_bright;

  Gathering(const World& world, float kept_per_unit, std::atomic<bool>& too_bright)
      : built(*world.state().built),
        view(world.state().view),
        bands(static_cast<std::size_t>(view.bands)),
        per_unit(kept_per_unit),
        is_too_bright(too_bright) {
    view.polarized = false;
    frame.scene = &view;
    frame.eye = &eye;
    frame.directions = &directions;
    frame.outputs = view.bands;
  }
  Gathering(const Gathering&) = delete;

  // Into `values` [band].
  void operator()(const GatherPlace& place, std::uint16_t* values) const {
    double mean[most_bands];
    built.functions.gather(frame, place, built.acceleration.tracer.get(),
                           thread_memory(ThreadRoom::block, block_memory_bytes(frame)), mean);
    for (std::size_t b = 0; b < bands; ++b) {
      const float value = static_cast<float>(mean[b]) * per_unit;
      if (value > largest_baked) is_too_bright = true;
      values[b] = encode_baked(value);
    }
  }
};

// What of a material's sides is ever looked up.
struct Sides {
  bool front = true, back = true;
};

Sides sides_of(const SceneView& view, std::int32_t mesh) {
  const std::int32_t material = view.meshes[mesh].material;
  const bool through = view.scatter[material].transmittance != nullptr;
  return {true, view.materials[material].double_sided || through};
}

// Which triangle of which instance a cell belongs to.
struct CellOwner {
  std::size_t instance = 0;
  std::int32_t triangle = 0, within = 0, count = 1;  // its number within the triangle, and of how many
};

struct CellOwners {
  const BakedLight& baked;
  const Scene& scene;
  std::vector<std::pair<std::int32_t, std::size_t>> first;  // cell, instance; where cells begin

  CellOwners(const BakedLight& light, const Scene& of) : baked(light), scene(of) {
    for (std::size_t i = 0; i < baked.first_cell.size(); ++i)
      if (baked.first_cell[i] >= 0) first.emplace_back(baked.first_cell[i], i);
  }
  CellOwner operator()(std::int32_t cell) const {
    const auto after = std::upper_bound(
        first.begin(), first.end(), cell,
        [](std::int32_t value, const auto& entry) { return value < entry.first; });
    CellOwner owner;
    owner.instance = std::prev(after)->second;
    const std::int32_t left = cell - std::prev(after)->first;
    const auto mesh = static_cast<std::size_t>(scene.instances[owner.instance].mesh);
    const std::vector<std::int32_t>& cells = baked.cell_of_triangle[mesh];
    owner.triangle = left;
    if (cells.empty()) return owner;
    const auto next = std::upper_bound(cells.begin(), cells.end(), left);
    owner.triangle = static_cast<std::int32_t>(next - cells.begin()) - 1;
    owner.within = left - *std::prev(next);
    owner.count = *next - *std::prev(next);
    return owner;
  }
};

void gather_cell(const Gathering& gather, const CellOwners& owners, std::int32_t cell,
                 std::uint16_t* values) {
  const CellOwner owner = owners(cell);
  GatherPlace place;
  place.instance = static_cast<std::int32_t>(owner.instance);
  place.mesh = owners.scene.instances[owner.instance].mesh;
  place.triangle = owner.triangle;
  place.paths = owners.baked.paths;
  const std::int32_t k = divisions_of(owner.count);
  corners_of_cell(k, owner.within, place.uv);
  // So far, as what is farther hides all points of a cell about alike.
  place.reach_m = static_cast<float>(
      longest_edge_m(owners.scene, gather.built.placement, owner.instance,
                     static_cast<std::size_t>(owner.triangle)) / k);
  const Sides sides = sides_of(gather.view, place.mesh);
  for (int side = 0; side < 2; ++side) {
    if (side == 0 ? !sides.front : !sides.back) continue;
    place.is_back = side == 1;
    place.hash = mix_bits_32(mix_bits_32(static_cast<std::uint32_t>(cell) + hash_of_cells) +
                             static_cast<std::uint32_t>(side));
    gather(place, values + static_cast<std::size_t>(side) * gather.bands);
  }
}

void lay_out_probes(BakedLight& baked, const Bounds& box) {
  const double low[3] = {box.lower.x, box.lower.y, box.lower.z};
  const double high[3] = {box.upper.x, box.upper.y, box.upper.z};
  double longest = 0;
  for (int a = 0; a < 3; ++a)
    longest = std::max(longest, high[a] - low[a]);
  if (!(longest > 0)) longest = 1;
  double spacing = longest / (probes_along - 1);
  const std::int64_t most =
      std::clamp<std::int64_t>(baked.cells / cells_of_probe, least_probes, most_probes);
  std::int64_t all;
  do {
    all = 1;
    for (int a = 0; a < 3; ++a) {
      const double extent = std::max(0.0, high[a] - low[a]);
      baked.probes[a] = 2 + static_cast<std::int32_t>(extent / spacing);
      all *= baked.probes[a];
    }
    spacing *= 1.1;
  } while (all > most);
  for (int a = 0; a < 3; ++a) {
    const double extent = std::max(0.0, high[a] - low[a]);
    const double step = extent > 0 ? extent / (baked.probes[a] - 1) : longest / (probes_along - 1);
    baked.probe_spacing_m[a] = static_cast<float>(step);
    baked.probe_origin_m[a] = static_cast<float>(low[a]);
  }
}

// In the traced frame, where the frame that it was traced in first has its origin at `first_origin`.
Vec3 probe_position(const BakedLight& baked, std::int32_t x, std::int32_t y, std::int32_t z,
                    const float* first_origin) {
  const std::int32_t node[3] = {x, y, z};
  float at[3];
  for (int a = 0; a < 3; ++a)
    at[a] = baked.probe_origin_m[a] + static_cast<float>(node[a]) * baked.probe_spacing_m[a] +
            first_origin[a];
  return {at[0], at[1], at[2]};
}

constexpr Vec3 probe_directions[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                      {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

void check(const World& world, const BakeSettings& settings) {
  if (!world.settings().lighting)
    throw Error("baked light: expected a world with a light, found one without");
  if (world.settings().lighting->baked != nullptr)
    throw Error("baked light: expected a world that is lit by paths, found one with baked light");
  if (world.settings().lighting->depth != 0)
    throw Error("depth: expected 0, as many scatterings as it takes, of light that is baked; found " +
                std::to_string(world.settings().lighting->depth));
  if (!(settings.cell_m >= 0) || !std::isfinite(settings.cell_m))
    throw Error("cell_m: expected a size in m, or 0 for one that is chosen, found " +
                std::to_string(settings.cell_m));
  if (settings.paths < packet_rays || settings.paths > most_paths || settings.paths % packet_rays != 0)
    throw Error("paths: expected a multiple of " + std::to_string(packet_rays) + " up to " +
                std::to_string(most_paths) + ", found " + std::to_string(settings.paths));
}

// The box of the scene as it lies in the traced frame.
Bounds traced_box(const BuiltScene& built) {
  Bounds box;
  for (std::size_t i = 0; i < built.scene->instances.size(); ++i) {
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

// All cells and probes of `baked`, which says how many; false where something was too bright for its
// unit.
bool gather_all(const World& world, BakedLight& baked, WorkState& work) {
  const double radiance_unit = world.state().radiance_unit;
  std::atomic<bool> too_bright{false};
  const Gathering gather(world, static_cast<float>(radiance_unit / baked.unit), too_bright);
  const CellOwners owners(baked, *gather.built.scene);
  const std::size_t per_cell = 2 * gather.bands;
  const std::int32_t probes = baked.probes[0] * baked.probes[1] * baked.probes[2];
  // In paths, as far as is known beforehand.
  const double all = 2.0 * baked.cells * baked.paths + 6.0 * probes * paths_of_probe;
  std::atomic<std::int64_t> done{0};
  const auto finish = [&](std::int64_t paths) {
    work.reach(static_cast<double>(done += paths) / all);
  };
  std::fill(baked.lines.begin(), baked.lines.end(), BakedLine{});
  auto* const values = baked.lines.empty() ? nullptr : baked.lines.front().values;
  parallel_ranges<std::int32_t>(0, baked.cells, 16, [&](std::int32_t first, std::int32_t last) {
    for (std::int32_t cell = first; cell < last; ++cell) {
      check_cancelled();
      gather_cell(gather, owners, cell, values + per_cell * static_cast<std::size_t>(cell));
      finish(2 * baked.paths);
    }
  });
  parallel_for<std::int32_t>(0, probes, [&](std::int32_t probe) {
    const std::int32_t x = probe % baked.probes[0], y = probe / baked.probes[0] % baked.probes[1],
                       z = probe / baked.probes[0] / baked.probes[1];
    for (std::size_t d = 0; d < 6; ++d) {
      GatherPlace place;
      place.position = probe_position(baked, x, y, z, gather.built.first_origin_now_m);
      place.normal = probe_directions[d];
      place.hash = mix_bits_32(mix_bits_32(static_cast<std::uint32_t>(probe) + hash_of_probes) +
                               static_cast<std::uint32_t>(d));
      place.paths = paths_of_probe;
      gather(place, baked.probe_values.data() + (6 * static_cast<std::size_t>(probe) + d) * gather.bands);
    }
    finish(6 * paths_of_probe);
  });
  return !too_bright;
}

}  // namespace

std::size_t BakedLight::bytes() const {
  std::size_t sum = lines.size() * sizeof(BakedLine) + probe_values.size() * 2 + first_cell.size() * 4;
  for (const std::vector<std::int32_t>& first : cell_of_triangle) sum += first.size() * 4;
  return sum;
}

BakedLight bake_light(const World& world, const BakeSettings& settings,
                      const std::function<bool(double)>& progress) {
  check(world, settings);
  const Rendering unmoved(world);
  const BuiltScene& built = *world.state().built;
  const auto start = Clock::now();
  const auto bands = static_cast<std::size_t>(world.bands());
  BakedLight baked;
  const auto bake = [&](WorkState& work) {
    const Tracing tracing{built.functions.closest, built.acceleration.tracer.get()};
    BakeCells plan =
        divide_into_cells(tracing, *built.scene, built.placement, bands, settings);
    baked.bands = world.bands();
    baked.cell_m = plan.cell_m;
    baked.paths = settings.paths;
    baked.by_probes = plan.by_probes;
    baked.cells = static_cast<std::int32_t>(plan.cells);
    baked.first_cell = std::move(plan.first_cell);
    baked.cell_of_triangle = std::move(plan.cell_of_triangle);
    const std::size_t per_line = sizeof(BakedLine) / 2;
    const std::size_t numbers = 2 * bands * static_cast<std::size_t>(baked.cells);
    baked.lines.resize((numbers + per_line - 1) / per_line);
    lay_out_probes(baked, traced_box(built));
    for (int a = 0; a < 3; ++a) baked.probe_origin_m[a] -= built.first_origin_now_m[a];
    baked.probe_values.resize(6 * bands * static_cast<std::size_t>(baked.probes[0]) *
                              static_cast<std::size_t>(baked.probes[1]) *
                              static_cast<std::size_t>(baked.probes[2]));
    baked.unit = world.state().radiance_unit * first_unit;
    while (!gather_all(world, baked, work)) baked.unit *= more_unit;
  };
  run_watched(progress,
              [&](WorkState& work) { run_in_arena(*built.threads.arena, [&] { bake(work); }); });
  baked.seconds = seconds_since(start);
  return baked;
}

void check_baked_light(const BakedLight& baked, const Scene& scene, int expected_bands) {
  const auto fail = [](const std::string& what) { throw Error("baked light: expected " + what); };
  const auto bands = static_cast<std::size_t>(baked.bands);
  if (baked.bands != expected_bands)
    fail(std::to_string(expected_bands) + " bands, as the world has, found " +
         std::to_string(baked.bands));
  if (!(baked.unit > 0) || !std::isfinite(baked.unit)) fail("a unit above 0");
  if (baked.first_cell.size() != scene.instances.size() ||
      baked.cell_of_triangle.size() != scene.meshes.size())
    fail(std::to_string(scene.instances.size()) + " instances of " +
         std::to_string(scene.meshes.size()) + " meshes, as the scene has, found " +
         std::to_string(baked.first_cell.size()) + " of " +
         std::to_string(baked.cell_of_triangle.size()));
  if (baked.cells < 0 ||
      baked.lines.size() * (sizeof(BakedLine) / 2) < 2 * bands * static_cast<std::size_t>(baked.cells))
    fail("values of all its " + std::to_string(baked.cells) + " cells");
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const std::vector<std::int32_t>& first = baked.cell_of_triangle[m];
    if (first.empty()) continue;
    if (first.size() != scene.meshes[m].triangles.size() + 1 || first.front() != 0)
      fail("the cells of each triangle of meshes[" + std::to_string(m) + "]");
    for (std::size_t t = 0; t + 1 < first.size(); ++t) {
      const std::int64_t count = std::int64_t{first[t + 1]} - first[t];
      if (count < 1 || count != std::int64_t{divisions_of(first[t + 1] - first[t])} *
                                    divisions_of(first[t + 1] - first[t]))
        fail("a square number of cells of each triangle of meshes[" + std::to_string(m) + "]");
    }
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (baked.first_cell[i] < 0) continue;
    const auto m = static_cast<std::size_t>(scene.instances[i].mesh);
    const std::vector<std::int32_t>& first = baked.cell_of_triangle[m];
    const std::int64_t count = first.empty()
                                   ? static_cast<std::int64_t>(scene.meshes[m].triangles.size())
                                   : first.back();
    if (baked.first_cell[i] + count > baked.cells)
      fail("cells of instances[" + std::to_string(i) + "] among its " + std::to_string(baked.cells));
  }
  std::size_t probes = 1;
  for (int a = 0; a < 3; ++a) {
    if (baked.probes[a] < 2 || baked.probes[a] > 65536 || !(baked.probe_spacing_m[a] > 0) ||
        !std::isfinite(baked.probe_spacing_m[a]) || !std::isfinite(baked.probe_origin_m[a]))
      fail("two probes or more along each side");
    probes *= static_cast<std::size_t>(baked.probes[a]);
  }
  if (baked.probe_values.size() != 6 * bands * probes) fail("values of all its probes");
}

}  // namespace omma
