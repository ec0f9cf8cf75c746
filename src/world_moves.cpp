// Moving things: checked, placed, and the top scene of what moves brought up to date; where
// something moves for the first time, the rest is built without it.
#include <algorithm>
#include <cstdio>

#include "model/pose_check.h"
#include "omma/world.h"
#include "threads/parallel.h"
#include "world_state.h"

namespace omma {
namespace {

Bounds box_of(const BuiltScene& built, std::size_t instance, const Mat4& world_from_mesh) {
  return placed_box(
      built.box_of_mesh[static_cast<std::size_t>(built.scene->instances[instance].mesh)],
      world_from_mesh);
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

// Takes the steps; what was before is in them afterwards, so that doing it again undoes it.
void exchange(Placement& placement, std::vector<Step>& steps) {
  for (Step& step : steps) {
    const auto i = static_cast<std::size_t>(step.instance);
    std::swap(placement.world_from_mesh[i], step.world_from_mesh);
    std::swap(placement.moves[i], step.moves);
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

void move_in_top_scene(BuiltScene& built, const std::vector<Step>& steps) {
  std::vector<int> instances;
  for (const Step& step : steps) {
    instances.push_back(step.instance);
    place_frame(built, static_cast<std::size_t>(step.instance));
  }
  run_in_arena(*built.threads.arena,
               [&] { built.backend->move(built.acceleration, instances, built.placement); });
}

// While it lives things are being moved, and nothing is rendered.
class Moving {
 public:
  explicit Moving(BuiltScene& built) : built_(built) {
    int none = 0;
    if (built_.renders.compare_exchange_strong(none, -1)) return;
    throw Error(std::string("set_transforms: expected a world at rest, found one in which ") +
                (none < 0 ? "something is being moved" : "something is being rendered") +
                ", by another thread or further up in this one; move things between frames");
  }
  Moving(const Moving&) = delete;
  Moving& operator=(const Moving&) = delete;
  ~Moving() { built_.renders = 0; }

 private:
  BuiltScene& built_;
};

}  // namespace

Acceleration built_as_placed(const BuiltScene& built, WorkState& work) {
  return built.backend->build(*built.scene, built.shading->view, built.placement, &work);
}

void take_acceleration(BuiltScene& built, Acceleration acceleration) {
  std::vector<int> moving;
  Bounds still;
  for (std::size_t i = 0; i < built.placement.moves.size(); ++i)
    if (built.placement.moves[i])
      moving.push_back(static_cast<int>(i));
    else
      still = box_around(still, box_of(built, i, built.placement.world_from_mesh[i]));
  built.frames.resize(12 * built.placement.moves.size());
  for (std::size_t i = 0; i < built.placement.moves.size(); ++i) place_frame(built, i);
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
  if (threads_are_gone())
    throw Error(
        "set_transforms: nothing can be moved here: this process was forked from one that had used "
        "its threads, which this needs. Start processes with 'spawn' or 'forkserver'");
  const Moving moving(built);
  std::vector<Step> steps = checked_steps(built, instances, world_from_node);
  if (steps.empty()) return;

  Placement& placement = built.placement;
  const Vec3d origin = placement.origin_m;
  const double half_size = placement.half_size_m;
  exchange(placement, steps);
  const bool newly =
      std::any_of(steps.begin(), steps.end(), [](const Step& s) { return !s.moves; });
  bool built_anew = newly;
  try {
    Bounds box = newly ? Bounds{} : box_around_all(built);
    for (std::size_t i = 0; newly && i < placement.moves.size(); ++i)
      box = box_around(box, box_of(built, i, placement.world_from_mesh[i]));
    placement.half_size_m = omma::half_size_m(box);
    // The origin stays as long as it is not far away, so that what moves along does not have all
    // built again and again.
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
      move_in_top_scene(built, steps);
    }
  } catch (...) {
    exchange(placement, steps);
    placement.origin_m = origin;
    placement.half_size_m = half_size;
    const TakingPart whatever_was_cancelled(nullptr);
    if (!built_anew) move_in_top_scene(built, steps);
    throw;
  }
}

}  // namespace omma
