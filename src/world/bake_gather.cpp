// Packets of paths put together from cells and probes.
#include "world/bake_gather.h"

#include <algorithm>
#include <cmath>

#include "backend/bake_cells.h"
#include "physics/path/baked.h"
#include "physics/sampling/hash.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Probes along the longest side of the scene, and those of all sides together: few where there are
// few cells, so that they never take most of the time.
constexpr int probes_along = 48;
constexpr std::int64_t least_probes = 512, most_probes = 16384, cells_of_probe = 8;
constexpr int paths_of_probe = 64;
constexpr std::int32_t probes_of_list = 16;

Receiver receiver_of(const CellPaths& of, const CellOwner& owner, std::int32_t cell, bool is_back) {
  Receiver receiver;
  receiver.instance = static_cast<std::int32_t>(owner.instance);
  receiver.mesh = of.scene.instances[owner.instance].mesh;
  receiver.triangle = owner.triangle;
  receiver.is_back = is_back;
  const std::int32_t k = divisions_of(owner.count);
  corners_of_cell(k, owner.within, receiver.uv);
  // So far, as what is farther hides all points of a cell about alike.
  receiver.reach_m = static_cast<float>(longest_edge_m(of.scene, of.placement, owner.instance,
                                                       static_cast<std::size_t>(owner.triangle)) /
                                        k);
  receiver.hash = mix_bits_32(mix_bits_32(static_cast<std::uint32_t>(cell) + of.hash) +
                              static_cast<std::uint32_t>(is_back));
  return receiver;
}

// In the traced frame, where the frame that it was traced in first has its origin at
// `first_origin`.
Vec3 probe_position(const BakedLight& baked, std::int32_t probe, const float* first_origin) {
  const std::int32_t node[3] = {probe % baked.probes[0], probe / baked.probes[0] % baked.probes[1],
                                probe / baked.probes[0] / baked.probes[1]};
  float at[3];
  for (int a = 0; a < 3; ++a)
    at[a] = baked.probe_origin_m[a] + static_cast<float>(node[a]) * baked.probe_spacing_m[a] +
            first_origin[a];
  return {at[0], at[1], at[2]};
}

constexpr Vec3 probe_directions[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                      {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

}  // namespace

GatherWorld::GatherWorld(const World& world, const BakedLight& plan, const BakedLine* read)
    : by_paths(world.state().view),
      moves(plan.first_cell.size(), 0),
      built(*world.state().built),
      per_unit(static_cast<float>(world.state().radiance_unit / plan.unit)) {
  by_paths.polarized = false;
  view = by_paths;
  if (read != nullptr) {
    read_baked(plan, *world.state().lit->light,
               {built.frames.data(), built.first_origin_m, built.first_origin_now_m, moves.data()},
               reading);
    reading.view.values = read->values;
    view.baked = &reading.view;
    view.light = &reading.left_out;
  }
  frame.scene = &view;
  frame.eye = &eye;
  frame.directions = &directions;
  frame.outputs = view.bands;
}

void GatherList::add(const Receiver& receiver, int paths, std::uint16_t* to) {
  // A packet holds all paths of a task that has several receivers.
  if (tasks.empty() || tasks.back().paths != paths ||
      (tasks.back().count + 1) * paths > packet_rays)
    tasks.push_back({nullptr, 0, paths, nullptr, nullptr});
  ++tasks.back().count;
  receivers.push_back(receiver);
  values.push_back(to);
}

bool GatherWorld::gather(GatherList& list) const {
  const auto bands = static_cast<std::size_t>(view.bands);
  std::vector<double> mean(list.receivers.size() * bands);
  std::size_t first = 0;  // receiver
  for (GatherTask& task : list.tasks) {
    task.receivers = list.receivers.data() + first;
    task.shining = &by_paths;
    task.mean = mean.data() + first * bands;
    first += static_cast<std::size_t>(task.count);
  }
  // Isolated: a thread that waits for its list would begin another.
  run_isolated([&] { built.launches.gather(frame, list.tasks, built.acceleration.tracer.get()); });
  bool has_room = true;
  for (std::size_t k = 0; k < list.receivers.size(); ++k)
    for (std::size_t b = 0; b < bands; ++b) {
      const float value = static_cast<float>(mean[k * bands + b]) * per_unit;
      has_room = has_room && value <= largest_baked;
      list.values[k][b] = encode_baked(value);
    }
  return has_room;
}

bool gather_cells(const GatherWorld& world, const CellPaths& of, std::int32_t first,
                  std::int32_t end, std::uint16_t* values) {
  GatherList list;
  for (std::int32_t cell = first; cell < end; ++cell) {
    const CellOwner owner = of.owners(cell);
    const BakedSides sides = baked_sides(of.view, of.scene.instances[owner.instance].mesh);
    for (const bool is_back : {false, true}) {
      if (is_back ? !sides.back : !sides.front) continue;
      const std::size_t side = 2 * static_cast<std::size_t>(cell) + (is_back ? 1 : 0);
      list.add(receiver_of(of, owner, cell, is_back),
               of.paths_of_side != nullptr ? of.paths_of_side[side] : of.paths,
               values + (side - 2 * static_cast<std::size_t>(first)) *
                            static_cast<std::size_t>(world.view.bands));
    }
  }
  return world.gather(list);
}

void lay_out_probes(BakedLight& baked, const Bounds& box) {
  const double low[3] = {box.lower.x, box.lower.y, box.lower.z};
  const double high[3] = {box.upper.x, box.upper.y, box.upper.z};
  double longest = 0;
  for (int a = 0; a < 3; ++a) longest = std::max(longest, high[a] - low[a]);
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
  baked.probe_values.resize(6 * static_cast<std::size_t>(baked.bands * baked.probes[0]) *
                            static_cast<std::size_t>(baked.probes[1]) *
                            static_cast<std::size_t>(baked.probes[2]));
}

bool gather_probes(const GatherWorld& world, BakedLight& baked, std::uint32_t hash) {
  const auto bands = static_cast<std::size_t>(baked.bands);
  std::atomic<bool> has_room{true};
  const std::int32_t probes = baked.probes[0] * baked.probes[1] * baked.probes[2];
  parallel_ranges(
      std::int32_t{0}, probes, probes_of_list, [&](std::int32_t first, std::int32_t end) {
        GatherList list;
        for (std::int32_t probe = first; probe < end; ++probe)
          for (std::size_t d = 0; d < 6; ++d) {
            Receiver receiver;
            receiver.position = probe_position(baked, probe, world.built.first_origin_now_m);
            receiver.normal = probe_directions[d];
            receiver.hash = mix_bits_32(mix_bits_32(static_cast<std::uint32_t>(probe) + hash) +
                                        static_cast<std::uint32_t>(d));
            list.add(receiver, paths_of_probe,
                     baked.probe_values.data() + (6 * static_cast<std::size_t>(probe) + d) * bands);
          }
        if (!world.gather(list)) has_room = false;
      });
  return has_room;
}

}  // namespace omma
