// Frames between which things move: each pose is rendered as a still world, one after the other,
// without going back to the caller in between.
#include <algorithm>

#include "model/animation.h"
#include "render_poses.h"
#include "render_state.h"
#include "render_truth.h"
#include "threads/parallel.h"

namespace omma {
namespace {

constexpr double tell_every_s = 0.1;

// What each pose has of an output for all; empty where there is none.
template <typename T>
std::span<T> of_pose(std::span<T> all, std::size_t pose, std::size_t poses) {
  const std::size_t each = all.size() / poses;
  return all.subspan(pose * each, each);
}

template <typename T>
void check_divides(const char* name, std::span<T> output, std::size_t poses) {
  if (poses != 0 && output.size() % poses == 0) return;
  if (output.empty()) return;
  throw Error(std::string(name) + ": expected as many values for each of " +
              std::to_string(poses) + " poses, found " + std::to_string(output.size()) +
              " in all");
}

// Where all is to be at a pose.
Moves moves_of(const BuiltScene& built, const RenderCall& call, std::span<const int> animations,
               std::size_t pose, std::size_t poses) {
  Moves moves;
  if (!animations.empty()) moves = moves_at(built, animations, call.times_s[pose]);
  if (!moves.instances.empty() && !call.instances.empty()) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < moves.instances.size(); ++k) {
      if (std::find(call.instances.begin(), call.instances.end(), moves.instances[k]) !=
          call.instances.end())
        continue;
      moves.instances[kept] = moves.instances[k];
      moves.world_from_node[kept++] = moves.world_from_node[k];
    }
    moves.instances.resize(kept);
    moves.world_from_node.resize(kept);
  }
  const std::span<const Mat4> given = of_pose(call.world_from_node, pose, poses);
  moves.instances.insert(moves.instances.begin(), call.instances.begin(), call.instances.end());
  moves.world_from_node.insert(moves.world_from_node.begin(), given.begin(), given.end());
  return moves;
}

// The head's poses, for frames that last: each is rendered by itself and told what was before.
struct HeadKeys {
  double longest_s = -1;  // that a frame looks back; below 0 frames are instants
  std::vector<Mat4> world_from_head;
  std::vector<double> times_s;
  std::size_t past = 0;

  HeadKeys(const RenderSettings& settings, const RenderCall& call, std::span<const Mat4> poses) {
    if (settings.delays_s.empty()) return;
    if (call.times_s.size() != poses.size() ||
        call.past_times_s.size() != call.past_world_from_head.size())
      throw Error("times_s: expected one for each of " + std::to_string(poses.size()) +
                  " poses, found " + std::to_string(call.times_s.size()));
    longest_s = settings.delays_s.back();
    past = call.past_times_s.size();
    world_from_head.assign(call.past_world_from_head.begin(), call.past_world_from_head.end());
    world_from_head.insert(world_from_head.end(), poses.begin(), poses.end());
    times_s.assign(call.past_times_s.begin(), call.past_times_s.end());
    times_s.insert(times_s.end(), call.times_s.begin(), call.times_s.end());
  }

  void set_past(std::size_t pose, RenderCall& one) const {
    one.times_s = {};
    if (longest_s < 0) return;
    const std::size_t own = past + pose;
    std::size_t first = own;
    while (first > 0 && times_s[first] > times_s[own] - longest_s) --first;
    one.times_s = std::span(times_s).subspan(own, 1);
    one.past_times_s = std::span(times_s).subspan(first, own - first);
    one.past_world_from_head = std::span(world_from_head).subspan(first, own - first);
  }
};

// Tells the caller how much of all poses is done, a few times a second.
class PoseProgress {
 public:
  PoseProgress(const Progress& tell, std::size_t poses) : tell_(tell), poses_(poses) {}

  void reach(std::size_t pose, double part) {
    if (!tell_ || (seconds_since(last_) < tell_every_s && pose + 1 < poses_)) return;
    last_ = Clock::now();
    if (!tell_((static_cast<double>(pose) + part) / static_cast<double>(poses_)))
      throw Cancelled();
  }

 private:
  const Progress& tell_;
  std::size_t poses_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace

void render_moving(const Renderer::State& s, std::span<const Mat4> world_from_head,
                   std::span<float> responses, const RenderCall& call) {
  const std::size_t poses = world_from_head.size(), things = call.instances.size();
  if (call.world_from_node.size() != poses * things)
    throw Error("transforms: expected " + std::to_string(things) + " for each of " +
                std::to_string(poses) + " poses, found " +
                std::to_string(call.world_from_node.size()) + " in all");
  if (!call.times_s.empty() && call.times_s.size() != poses)
    throw Error("times_s: expected one for each of " + std::to_string(poses) + " poses, found " +
                std::to_string(call.times_s.size()));
  check_divides("responses", responses, poses);
  check_divides("standard_error", call.standard_error, poses);
  check_divides("rays", call.rays, poses);
  check_divides("ray_radiance", call.ray_radiance, poses);
  if (poses == 0) return;
  BuiltScene& built = *s.world.state().built;
  if (!checked_truth(call.truth, built, poses, s.eye.size()).tasks.empty())
    throw Error("truth: not where things move from pose to pose");
  const Moving moving(built, "render");
  traced_poses(world_from_head, s.eye_arrays, built.placement.origin_m);  // all checked beforehand
  const std::vector<int> animations =
      is_animated(s, call) ? chosen_animations(*built.scene, call.animations) : std::vector<int>();

  const HeadKeys keys(s.settings, call, world_from_head);

  PoseProgress told(call.progress, poses);
  const auto at_pose = [&](std::size_t pose, const auto& work) {
    try {
      work();
    } catch (const Error& problem) {
      throw Error("poses[" + std::to_string(pose) + "]: " + problem.what());
    }
  };
  Moves before;
  at_pose(0, [&] {
    Moves first = moves_of(built, call, animations, 0, poses);
    before = moves_back(built, first);
    make_moves(built, std::move(first), call.progress);
  });
  const auto render_at = [&](std::size_t pose) {
    RenderCall one = call;
    one.instances = {};
    one.world_from_node = {};
    keys.set_past(pose, one);
    one.standard_error = of_pose(call.standard_error, pose, poses);
    one.rays = of_pose(call.rays, pose, poses);
    one.ray_radiance = of_pose(call.ray_radiance, pose, poses);
    if (call.first_pose) one.first_pose = *call.first_pose + pose;
    if (call.progress)
      one.progress = [&](double part) {
        told.reach(pose, part);
        return true;
      };
    render_still(s, world_from_head.subspan(pose, 1), of_pose(responses, pose, poses), one);
  };
  try {
    for (std::size_t pose = 0; pose < poses; ++pose) {
      if (pose > 0)
        at_pose(pose,
                [&] { make_moves(built, moves_of(built, call, animations, pose, poses), {}); });
      render_at(pose);
    }
  } catch (...) {
    const TakingPart whatever_was_cancelled(nullptr);
    make_moves(built, std::move(before), {});
    throw;
  }
  make_moves(built, std::move(before), {});
}

}  // namespace omma
