// Frames between which things move: runs of poses at which all things are still are each rendered
// as a still world. A frame that lasts while things move is rendered by time intervals.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "model/animation.h"
#include "render/render_motion.h"
#include "render/render_state.h"
#include "render/render_truth.h"
#include "render/render_unseen.h"
#include "threads/parallel.h"
#include "world/traced_poses.h"

namespace omma {
namespace {

constexpr double tell_every_s = 0.1;

// Poses from one to before another.
struct Stretch {
  std::size_t begin, end;
};

// The slice of an output that belongs to some of the poses; empty where the output is.
template <typename T>
std::span<T> of_poses(std::span<T> all, Stretch part, std::size_t poses) {
  const std::size_t each = all.size() / poses;
  return all.subspan(part.begin * each, (part.end - part.begin) * each);
}
template <typename T>
std::span<T> of_pose(std::span<T> all, std::size_t pose, std::size_t poses) {
  return of_poses(all, {pose, pose + 1}, poses);
}

// The ground truth of a call, sliced to some of its poses.
TruthCall truth_of_poses(const TruthCall& all, Stretch part, std::size_t poses) {
  TruthCall some = all;
  for (std::span<float> TruthCall::*const output :
       {&TruthCall::distance_m, &TruthCall::nearest_m, &TruthCall::inverse_distance_per_m,
        &TruthCall::source_distance_m, &TruthCall::met, &TruthCall::normal, &TruthCall::shares,
        &TruthCall::flow_rotation, &TruthCall::flow_translation, &TruthCall::flow_objects})
    some.*output = of_poses(all.*output, part, poses);
  some.position_m = of_poses(all.position_m, part, poses);
  some.head = of_poses(all.head, part, poses);
  some.objects = of_poses(all.objects, part, poses);
  return some;
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

// Whether all things are at the same transforms at two poses.
bool lies_alike(const RenderCall& call, bool is_animated, std::size_t a, std::size_t b,
                std::size_t poses) {
  if (is_animated && call.times_s[a] != call.times_s[b]) return false;
  const std::span<const Mat4> first = of_pose(call.world_from_node, a, poses);
  return first.empty() || std::memcmp(first.data(), of_pose(call.world_from_node, b, poses).data(),
                                      first.size_bytes()) == 0;
}

// Keys of the head's path: a frame that lasts is rendered by itself, and needs those before it.
struct HeadKeys {
  double longest_s = -1;  // that a frame looks back; below 0 frames are instants
  std::vector<Mat4> world_from_head;
  std::vector<double> times_s;
  std::size_t past = 0;

  // The earliest key that the frame of a pose sees anything of.
  std::size_t first_seen(std::size_t pose) const {
    const std::size_t own = past + pose;
    std::size_t first = own;
    while (first > 0 && times_s[first] > times_s[own] - longest_s) --first;
    return first;
  }

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
    const std::size_t own = past + pose, first = first_seen(pose);
    one.times_s = std::span(times_s).subspan(own, 1);
    one.past_times_s = std::span(times_s).subspan(first, own - first);
    one.past_world_from_head = std::span(world_from_head).subspan(first, own - first);
  }
};

// Transforms of the call's things at a key; before the first pose those that the call gives for the
// past, or else those of the first pose.
std::span<const Mat4> things_at(const RenderCall& call, const HeadKeys& keys, std::size_t key,
                                std::size_t poses) {
  if (key >= keys.past) return of_pose(call.world_from_node, key - keys.past, poses);
  if (!call.past_world_from_node.empty())
    return of_pose(call.past_world_from_node, key, keys.past);
  return of_pose(call.world_from_node, 0, poses);
}

// Whether anything moves while the frame of a pose lasts.
bool moves_within(const RenderCall& call, const HeadKeys& keys, bool is_animated, std::size_t pose,
                  std::size_t poses) {
  if (keys.longest_s <= 0) return false;
  if (is_animated) return true;
  const std::span<const Mat4> now = things_at(call, keys, keys.past + pose, poses);
  for (std::size_t key = keys.first_seen(pose); key < keys.past + pose; ++key) {
    const std::span<const Mat4> then = things_at(call, keys, key, poses);
    if (!std::equal(then.begin(), then.end(), now.begin(), now.end())) return true;
  }
  return false;
}

// Moves to where all things are at a delay before the frame of a pose: between keys positions are
// linear and rotations even, before the first key all stand.
Moves moves_before(const BuiltScene& built, const RenderCall& call, const HeadKeys& keys,
                   std::span<const int> animations, std::size_t pose, std::size_t poses,
                   double delay_s) {
  const std::size_t own = keys.past + pose;
  const double time_s = keys.times_s[own] - delay_s;
  std::size_t next = keys.first_seen(pose);
  while (next < own && keys.times_s[next] <= time_s) ++next;
  const std::size_t before = next == 0 ? 0 : next - 1;
  const double step_s = keys.times_s[next] - keys.times_s[before];
  const double part = step_s > 0 ? std::max(0.0, (time_s - keys.times_s[before]) / step_s) : 0;
  const std::span<const Mat4> from = things_at(call, keys, before, poses),
                              to = things_at(call, keys, next, poses);
  std::vector<Mat4> between(from.size());
  for (std::size_t k = 0; k < between.size(); ++k)
    between[k] = transform_between(from[k], to[k], part);
  RenderCall then;
  then.instances = call.instances;
  then.world_from_node = between;
  then.times_s = std::span(&time_s, 1);
  return moves_of(built, then, animations, 0, 1);
}

// Responses, errors and rays of parts of a frame, each of which has its own count of rays.
class PartSums {
 public:
  PartSums(std::span<float> responses, const RenderCall& one)
      : responses_(responses),
        errors_(one.standard_error),
        rays_(one.rays),
        sum_(responses.size()),
        squares_(errors_.size()),
        some_(responses.size()),
        some_errors_(errors_.size()),
        some_rays_(rays_.size()),
        all_rays_(rays_.size()) {}

  // Where a part is rendered to.
  std::span<float> responses() { return some_; }
  void take_outputs(RenderCall& one) {
    one.standard_error = some_errors_;
    one.rays = some_rays_;
  }

  void add(double weight) {
    for (std::size_t i = 0; i < sum_.size(); ++i)
      sum_[i] += weight * static_cast<double>(some_[i]);
    for (std::size_t i = 0; i < squares_.size(); ++i) {
      const double error = weight * static_cast<double>(some_errors_[i]);
      squares_[i] += error * error;
    }
    for (std::size_t i = 0; i < all_rays_.size(); ++i) all_rays_[i] += some_rays_[i];
  }
  void finish() {
    for (std::size_t i = 0; i < sum_.size(); ++i) responses_[i] = static_cast<float>(sum_[i]);
    for (std::size_t i = 0; i < squares_.size(); ++i)
      errors_[i] = static_cast<float>(std::sqrt(squares_[i]));
    std::copy(all_rays_.begin(), all_rays_.end(), rays_.begin());
  }

 private:
  std::span<float> responses_, errors_;
  std::span<std::int32_t> rays_;
  std::vector<double> sum_, squares_;
  std::vector<float> some_, some_errors_;
  std::vector<std::int32_t> some_rays_, all_rays_;
};

// Tells the caller how much of all poses is done, a few times a second.
class PoseProgress {
 public:
  PoseProgress(const Progress& tell, std::size_t poses) : tell_(tell), poses_(poses) {}

  // A part of a stretch of poses.
  void reach(Stretch stretch, double part) {
    if (!tell_ || (seconds_since(last_) < tell_every_s && stretch.end < poses_)) return;
    last_ = Clock::now();
    const double done = static_cast<double>(stretch.begin) +
                        part * static_cast<double>(stretch.end - stretch.begin);
    if (!tell_(done / static_cast<double>(poses_))) throw Cancelled();
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
  check_divides("beside_rays", call.beside_rays, poses);
  if (!call.past_world_from_node.empty() &&
      call.past_world_from_node.size() != call.past_times_s.size() * things)
    throw Error("past transforms: expected " + std::to_string(things) + " for each of " +
                std::to_string(call.past_times_s.size()) + " poses before the first, found " +
                std::to_string(call.past_world_from_node.size()) + " in all");
  BuiltScene& built = *s.world.state().built;
  check_unseen(built, call, poses);
  if (poses == 0) return;
  const Moving moving(built, "render");
  // All of it, before anything is rendered.
  const bool with_truth = !checked_truth(call.truth, built, poses, s.eye.size()).tasks.empty();
  traced_poses(world_from_head, s.eye_arrays, built.placement.origin_m);  // all checked beforehand
  const std::vector<int> animations =
      is_animated(s, call) ? chosen_animations(*built.scene, call.animations) : std::vector<int>();
  const HeadKeys keys(s.settings, call, world_from_head);
  const bool lasts = keys.longest_s >= 0;

  PoseProgress told(call.progress, poses);
  const auto at_pose = [&](std::size_t pose, const auto& work) {
    try {
      work();
    } catch (const Error& problem) {
      throw Error("poses[" + std::to_string(pose) + "]: " + problem.what());
    }
  };
  UnseenMarks marks(built, call);
  Moves before;
  const auto back = [&] {
    marks.remove();
    make_moves(built, std::move(before), {});
  };
  try {
    at_pose(0, [&] {
      Moves first = moves_of(built, call, animations, 0, poses);
      add_unseen(built, call, first);
      before = moves_back(built, first);
      make_moves(built, std::move(first), call.progress);
    });
  } catch (...) {
    const TakingPart whatever_was_cancelled(nullptr);
    if (call.unseen.empty()) throw;
    back();
    throw;
  }
  const auto* const fixed = std::get_if<Fixed>(&s.settings.sampling);
  const std::uint64_t first_frame =
      call.first_pose || s.settings.noise == Noise::frozen ? call.first_pose.value_or(0)
                                                           : s.frames.fetch_add(poses);
  const auto call_of = [&](Stretch stretch) {
    RenderCall one = call;
    one.instances = {};
    one.world_from_node = {};
    keys.set_past(stretch.begin, one);
    one.standard_error = of_poses(call.standard_error, stretch, poses);
    one.rays = of_poses(call.rays, stretch, poses);
    one.ray_radiance = of_poses(call.ray_radiance, stretch, poses);
    one.beside_rays = of_poses(call.beside_rays, stretch, poses);
    one.unseen_at = of_poses(call.unseen_at, stretch, poses);
    one.truth = truth_of_poses(call.truth, stretch, poses);
    one.first_pose = first_frame + stretch.begin;
    return one;
  };
  const auto tell = [&](RenderCall& one, Stretch stretch, const TimePart& part) {
    if (!call.progress) return;
    one.progress = [&told, stretch, part](double done) {
      told.reach(stretch, (part.index + done) / part.count);
      return true;
    };
  };
  const auto render_at = [&](Stretch stretch) {
    RenderCall one = call_of(stretch);
    tell(one, stretch, {});
    render_still(s, world_from_head.subspan(stretch.begin, stretch.end - stretch.begin),
                 of_poses(responses, stretch, poses), one);
  };
  const auto render_in_parts = [&](std::size_t pose) {
    if (fixed == nullptr)
      throw Error("sampling: expected Fixed where things move while frames last, found ToError");
    for (const auto& [name, output] :
         {std::pair{"ray_radiance", call.ray_radiance}, std::pair{"beside_rays", call.beside_rays}})
      if (!output.empty())
        throw Error(std::string(name) + ": not where things move while frames last");
    if (with_truth) throw Error("truth: not where things move while frames last");
    const Stretch stretch{pose, pose + 1};
    RenderCall one = call_of(stretch);
    PartSums sums(of_poses(responses, stretch, poses), one);
    sums.take_outputs(one);
    const int parts = parts_for(fixed->samples);
    for (int k = 0; k < parts; ++k) {
      const TimePart part = time_part(k, parts, s.settings.delays_s);
      const double delay_s = delay_of(part, s.settings.delays_s);
      at_pose(pose, [&] {
        make_moves(built, moves_before(built, call, keys, animations, pose, poses, delay_s), {});
      });
      tell(one, stretch, part);
      render_still(s, world_from_head.subspan(pose, 1), sums.responses(), one, part);
      sums.add(part.size);
    }
    sums.finish();
  };
  try {
    for (Stretch stretch{0, 0}; stretch.begin < poses; stretch.begin = stretch.end) {
      const std::size_t first = stretch.begin;
      stretch.end = first + 1;
      if (lasts && moves_within(call, keys, !animations.empty(), first, poses)) {
        render_in_parts(first);
        continue;
      }
      while (!lasts && stretch.end < poses &&
             lies_alike(call, !animations.empty(), first, stretch.end, poses))
        ++stretch.end;
      if (first > 0)
        at_pose(first,
                [&] { make_moves(built, moves_of(built, call, animations, first, poses), {}); });
      render_at(stretch);
    }
  } catch (...) {
    const TakingPart whatever_was_cancelled(nullptr);
    back();
    throw;
  }
  back();
}

}  // namespace omma
