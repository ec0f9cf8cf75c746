// Moving things: checked, placed, and the top scene of what moves brought up to date; where
// something moves for the first time, the rest is built without it.
#include <algorithm>
#include <cstdio>
#include <numeric>

#include "model/new_version.h"
#include "model/pose_check.h"
#include "omma/world.h"
#include "threads/parallel.h"
#include "world/world_state.h"

namespace omma {
namespace {

Bounds box_of(const BuiltScene& built, std::size_t instance, const Mat4& world_from_mesh) {
  return placed_box(
      built.box_of_mesh[static_cast<std::size_t>(built.scene->instances[instance].mesh)],
      world_from_mesh);
}

// Around splats, which do not move.
Bounds splat_box(const BuiltScene& built) {
  return built.splats != nullptr ? built.splats->box : Bounds{};
}

// Around all as it is placed; `still_box` where that has not changed.
Bounds box_around_all(const BuiltScene& built) {
  Bounds box = built.still_box;
  for (const int i : built.moving) {
    const auto instance = static_cast<std::size_t>(i);
    box = box_around(box, box_of(built, instance, built.placement.world_from_mesh[instance]));
  }
  return box;
}

// What is wrong with a transform that is to place a thing; "" where nothing is.
std::string transform_fault(const BuiltScene& built, std::size_t thing, const Mat4& t) {
  std::string fault = pose_fault(t);
  if (!fault.empty()) return fault;
  char text[120];
  const double det = std::fabs(determinant(t));
  if (!(det > least_determinant && det < 1 / least_determinant)) {
    std::snprintf(text, sizeof text,
                  "expected a determinant whose magnitude is from %.0e to %.0e, found %.3g",
                  least_determinant, 1 / least_determinant, det);
    return text;
  }
  for (int k = built.things.first[thing]; k < built.things.first[thing + 1]; ++k) {
    const int instance = built.things.instance[static_cast<std::size_t>(k)];
    if (!is_too_far(box_of(built, static_cast<std::size_t>(instance), t), built.placement.origin_m))
      continue;
    std::snprintf(text, sizeof text, "expected all of it within %.0e m, where it can be seen",
                  most_geometry_m);
    return text;
  }
  return "";
}

// Where an instance of the scene is to be, and whether it counts as moved.
struct Step {
  int instance;
  Mat4 world_from_mesh;
  char moves = 1;
};

std::vector<Step> checked_steps(const BuiltScene& built, std::span<const int> instances,
                                std::span<const Mat4> world_from_node) {
  std::vector<char> seen(built.things.count(), 0);
  std::vector<Step> steps;
  for (std::size_t k = 0; k < instances.size(); ++k) {
    const auto which = [&] { return "instances[" + std::to_string(k) + "]"; };
    const auto thing = static_cast<std::size_t>(instances[k]);  // what is below 0 is large
    if (thing >= seen.size())
      throw Error(which() + ": expected an index into the " + std::to_string(seen.size()) +
                  " instances of the world, found " + std::to_string(instances[k]));
    if (seen[thing]++) throw Error(which() + ": " + std::to_string(thing) + " is there twice");
    const std::string fault = transform_fault(built, thing, world_from_node[k]);
    if (!fault.empty())
      throw Error("transforms[" + std::to_string(k) + "], of \"" + name_of(built, thing) +
                  "\": " + fault);
    for (int part = built.things.first[thing]; part < built.things.first[thing + 1]; ++part)
      steps.push_back({built.things.instance[static_cast<std::size_t>(part)], world_from_node[k]});
  }
  return steps;
}

// What shape a mesh is to have, and the box around it.
struct Reshape {
  std::size_t mesh;
  Shape shape;
  Bounds box;
};

// Takes the steps; what was before is in them afterwards, so that doing it again undoes it.
void exchange(BuiltScene& built, std::vector<Step>& steps, std::vector<Reshape>& reshapes) {
  Placement& placement = built.placement;
  built.versions.placed = new_version();
  for (Step& step : steps) {
    const auto i = static_cast<std::size_t>(step.instance);
    std::swap(placement.world_from_mesh[i], step.world_from_mesh);
    std::swap(placement.moves[i], step.moves);
  }
  for (Reshape& reshape : reshapes) {
    std::swap(placement.shapes[reshape.mesh], reshape.shape);
    std::swap(built.box_of_mesh[reshape.mesh], reshape.box);
  }
  if (!reshapes.empty()) follow_shapes(built);
}

bool is_shaped(const BuiltScene& built, std::size_t mesh) {
  return !built.placement.shapes[mesh].positions.empty();
}

// Meshes that are placed somewhere, and steps for their instances, which count as moved from now on.
std::vector<Reshape> checked_reshapes(const BuiltScene& built, Moves& moves,
                                      std::vector<Step>& steps) {
  std::vector<Reshape> reshapes;
  std::vector<char> newly(moves.meshes.empty() ? 0 : built.scene->meshes.size(), 0);
  bool any_newly = false;
  for (std::size_t k = 0; k < moves.meshes.size(); ++k) {
    const auto mesh = static_cast<std::size_t>(moves.meshes[k]);
    Shape& shape = moves.shapes[k];
    if (built.box_of_mesh[mesh].empty) continue;  // nobody sees it
    newly[mesh] = !is_shaped(built, mesh);
    any_newly = any_newly || newly[mesh];
    const Bounds box = vertex_bounds(shape.positions);
    reshapes.push_back({mesh, std::move(shape), box});
  }
  if (!any_newly) return reshapes;
  std::vector<char> steps_already(built.scene->instances.size(), 0);
  for (const Step& step : steps) steps_already[static_cast<std::size_t>(step.instance)] = 1;
  for (std::size_t i = 0; i < steps_already.size(); ++i)
    if (newly[static_cast<std::size_t>(built.scene->instances[i].mesh)] && !steps_already[i])
      steps.push_back({static_cast<int>(i), built.placement.world_from_mesh[i]});
  return reshapes;
}

// Of meshes that have another shape now.
void check_reach(const BuiltScene& built, const std::vector<Reshape>& reshapes) {
  for (const Reshape& reshape : reshapes)
    for (std::size_t i = 0; i < built.scene->instances.size(); ++i) {
      const Instance& instance = built.scene->instances[i];
      if (static_cast<std::size_t>(instance.mesh) != reshape.mesh) continue;
      if (is_too_far(box_of(built, i, built.placement.world_from_mesh[i]),
                     built.placement.origin_m))
        throw Error("mesh " + std::to_string(reshape.mesh) + ", of \"" + instance.name +
                    "\": expected all of it within 1e12 m, where it can be seen");
    }
}

void place_frame(BuiltScene& built, std::size_t instance) {
  Mat4 t = built.placement.world_from_mesh[instance];
  t.m[0][3] -= built.placement.origin_m.x;
  t.m[1][3] -= built.placement.origin_m.y;
  t.m[2][3] -= built.placement.origin_m.z;
  float* frame = built.frames.data() + 12 * instance;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) *frame++ = static_cast<float>(t.m[r][c]);
}

void move_in_top_scene(BuiltScene& built, const std::vector<Step>& steps,
                       const std::vector<Reshape>& reshapes) {
  std::vector<int> instances, meshes;
  for (const Reshape& reshape : reshapes) meshes.push_back(static_cast<int>(reshape.mesh));
  for (const Step& step : steps) {
    instances.push_back(step.instance);
    place_frame(built, static_cast<std::size_t>(step.instance));
  }
  follow_places(built, instances);
  built.versions.placed = new_version();
  run_in_arena(*built.threads.arena,
               [&] { built.backend->move(built.acceleration, instances, meshes, built.placement); });
}

}  // namespace

Moving::Moving(BuiltScene& built, const char* doing) : built_(built) {
  if (threads_are_gone())
    throw Error(
        std::string(doing) +
        ": nothing can be moved here: this process was forked from one that had used its threads, "
        "which this needs. Start processes with 'spawn' or 'forkserver'");
  int renders = 0;
  if (built_.renders.compare_exchange_strong(renders, -1)) return;
  throw Error(std::string(doing) + ": expected a world at rest, found one in which " +
              (renders < 0 ? "something is being moved" : "something is being rendered") +
              ", by another thread or further up in this one; move things between frames");
}

Moving::~Moving() {
  built_.renders = 0;
}

Acceleration built_as_placed(const BuiltScene& built, WorkState& work) {
  return built.backend->build(*built.scene, built.shading->view, built.placement, built.devices,
                              &work);
}

void take_acceleration(BuiltScene& built, Acceleration acceleration) {
  std::vector<int> moving;
  Bounds still = splat_box(built);
  for (std::size_t i = 0; i < built.placement.moves.size(); ++i)
    if (built.placement.moves[i])
      moving.push_back(static_cast<int>(i));
    else
      still = box_around(still, box_of(built, i, built.placement.world_from_mesh[i]));
  built.versions.placed = new_version();
  built.frames.resize(12 * built.placement.moves.size());
  std::vector<int> all(built.placement.moves.size());
  std::iota(all.begin(), all.end(), 0);
  for (const int i : all) place_frame(built, static_cast<std::size_t>(i));
  follow_places(built, all);
  const Vec3d shift = built.first_origin_m - built.placement.origin_m;
  built.first_origin_now_m[0] = static_cast<float>(shift.x);
  built.first_origin_now_m[1] = static_cast<float>(shift.y);
  built.first_origin_now_m[2] = static_cast<float>(shift.z);
  built.moving = std::move(moving);
  built.still_box = still;
  built.acceleration = std::move(acceleration);
}

void World::set_transforms(std::span<const int> instances, std::span<const Mat4> world_from_node,
                           const std::function<bool(double)>& progress) {
  BuiltScene& built = *state_->built;
  if (instances.size() != world_from_node.size())
    throw Error("transforms: expected one for each of " + std::to_string(instances.size()) +
                " instances, found " + std::to_string(world_from_node.size()));
  const Moving moving(built, "set_transforms");
  make_moves(built,
             {{instances.begin(), instances.end()},
              {world_from_node.begin(), world_from_node.end()},
              {},
              {}},
             progress);
}

Moves moves_back(const BuiltScene& built, const Moves& moves) {
  Moves back;
  for (const int instance : moves.instances) {
    const auto thing = static_cast<std::size_t>(instance);
    if (thing >= built.things.count()) continue;  // making the moves says what is wrong
    back.instances.push_back(instance);
    back.world_from_node.push_back(built.placement.world_from_mesh[first_instance(built, thing)]);
  }
  back.meshes = moves.meshes;
  for (const int index : moves.meshes) {
    const auto mesh = static_cast<std::size_t>(index);
    if (is_shaped(built, mesh)) {
      back.shapes.push_back(built.placement.shapes[mesh]);
      continue;
    }
    Shape& shape = back.shapes.emplace_back();
    shape.positions = built.scene->meshes[mesh].positions;
    shape.normals = built.scene->meshes[mesh].normals;
  }
  return back;
}

void make_moves(BuiltScene& built, Moves moves, const Progress& progress) {
  std::vector<Step> steps = checked_steps(built, moves.instances, moves.world_from_node);
  std::vector<Reshape> reshapes = checked_reshapes(built, moves, steps);
  if (steps.empty() && reshapes.empty()) return;

  Placement& placement = built.placement;
  const Vec3d origin = placement.origin_m;
  const double half_size = placement.half_size_m;
  exchange(built, steps, reshapes);
  const bool newly =
      std::any_of(steps.begin(), steps.end(), [](const Step& s) { return !s.moves; }) ||
      std::any_of(reshapes.begin(), reshapes.end(),
                  [](const Reshape& r) { return r.shape.positions.empty(); });
  bool built_anew = newly;
  try {
    check_reach(built, reshapes);
    Bounds box = newly ? splat_box(built) : box_around_all(built);
    for (std::size_t i = 0; newly && i < placement.moves.size(); ++i)
      box = box_around(box, box_of(built, i, placement.world_from_mesh[i]));
    placement.half_size_m = omma::half_size_m(box);
    // The origin is kept until it is far away, so that one thing that moves away does not rebuild
    // all each time.
    const Vec3d shift = origin_near({box.lower - origin, box.upper - origin, box.empty});
    if (shift.x != 0 || shift.y != 0 || shift.z != 0) {
      placement.origin_m = origin_near(box);
      built_anew = true;
    }
    if (built_anew) {
      Acceleration acceleration;
      run_watched(progress, [&](WorkState& work) {
        run_in_arena(*built.threads.arena, [&] { acceleration = built_as_placed(built, work); });
      });
      take_acceleration(built, std::move(acceleration));
    } else {
      move_in_top_scene(built, steps, reshapes);
    }
  } catch (...) {
    exchange(built, steps, reshapes);
    placement.origin_m = origin;
    placement.half_size_m = half_size;
    const TakingPart whatever_was_cancelled(nullptr);
    if (!built_anew) move_in_top_scene(built, steps, reshapes);
    throw;
  }
}

}  // namespace omma
