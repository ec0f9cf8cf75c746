// Paths of a bake: from cells of surfaces and from probes in the air, through a world that is lit by
// paths, or by what a first pass has baked.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/bake_owners.h"
#include "backend/lit_data.h"
#include "omma/bake.h"
#include "omma/world.h"
#include "physics/views/gather_task.h"
#include "world/world_state.h"

namespace omma {

// What light is gathered for by one launch.
struct GatherList {
  std::vector<Receiver> receivers;     // of one task behind those of another
  std::vector<std::uint16_t*> values;  // [receiver], codes of BakedLight, by band
  std::vector<GatherTask> tasks;       // with counts of receivers and paths

  // Adds a receiver to the last task, or where that has other paths or is full to a new one.
  void add(const Receiver& receiver, int paths, std::uint16_t* to);
};

// The scene that paths go through. Refers to the world and to what is read.
struct GatherWorld {
  SceneView by_paths, view;
  BakedReading reading;
  std::vector<char> moves;  // nothing does while it is baked
  EyeView eye = {};
  DirectionsView directions = {};
  FrameView frame = {};
  const BuiltScene& built;
  float per_unit;  // of what is kept

  // `plan`: its cells, probes and unit; `read`: light of its cells, or null: all by paths.
  GatherWorld(const World& world, const BakedLight& plan, const BakedLine* read);
  GatherWorld(const GatherWorld&) = delete;

  // Into the list's values; false where one is too large for its code.
  bool gather(GatherList& list) const;
};

// What paths from cells need besides.
struct CellPaths {
  const CellOwners& owners;
  const Scene& scene;
  const Placement& placement;
  const SceneView& view;
  std::uint32_t hash;                         // of a pass and half
  int paths = 0;                              // for each side, or
  const std::uint16_t* paths_of_side = nullptr;  // [cell][side]
};

// The cells from `first` on, before `end`, into `values` [cell][side][band] of these; false where a
// value is too large for its code.
bool gather_cells(const GatherWorld& world, const CellPaths& of, std::int32_t first,
                  std::int32_t end, std::uint16_t* values);

// A grid of probes about a box in the traced frame, of a number that goes with that of cells.
void lay_out_probes(BakedLight& baked, const Bounds& box);
// All of them, into `baked.probe_values`.
bool gather_probes(const GatherWorld& world, BakedLight& baked, std::uint32_t hash);

}  // namespace omma
