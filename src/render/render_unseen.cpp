// Sets the mask bits of instances that groups of poses do not see (RayPacket::mask).
#include "render/render_unseen.h"

#include <algorithm>
#include <string>

#include "physics/views/ray_packet.h"

namespace omma {

void check_unseen(const BuiltScene& built, const RenderCall& call, std::size_t poses) {
  const std::size_t groups = call.unseen.size();
  if (groups > most_unseen)
    throw Error("unseen: expected at most " + std::to_string(most_unseen) + " groups, found " +
                std::to_string(groups));
  if (call.unseen_at.size() != (groups == 0 ? 0 : poses))
    throw Error("unseen_at: expected a group, or -1, for each of " +
                std::to_string(groups == 0 ? 0 : poses) + " poses, found " +
                std::to_string(call.unseen_at.size()));
  for (const int group : call.unseen_at)
    if (group < -1 || group >= static_cast<int>(groups))
      throw Error("unseen_at: expected -1 to " + std::to_string(groups - 1) + ", found " +
                  std::to_string(group));
  for (const std::vector<int>& things : call.unseen)
    for (const int thing : things)
      if (thing < 0 || static_cast<std::size_t>(thing) >= built.things.count())
        throw Error("unseen: expected indices of the world's " +
                    std::to_string(built.things.count()) + " things, found " +
                    std::to_string(thing));
}

UnseenMarks::UnseenMarks(BuiltScene& built, const RenderCall& call)
    : seen_by_(built.placement.seen_by) {
  if (call.unseen.empty()) return;
  seen_by_.assign(built.placement.world_from_mesh.size(), all_seen);
  const auto instances_of = [&](int thing) {
    const auto t = static_cast<std::size_t>(thing);
    const auto first = static_cast<std::size_t>(built.things.first[t]);
    return std::span(built.things.instance)
        .subspan(first, static_cast<std::size_t>(built.things.first[t + 1]) - first);
  };
  for (std::size_t group = 0; group < call.unseen.size(); ++group)
    for (const int thing : call.unseen[group])
      for (const int instance : instances_of(thing))
        seen_by_[static_cast<std::size_t>(instance)] &= ~(1u << group);
}

void add_unseen(const BuiltScene& built, const RenderCall& call, Moves& moves) {
  for (const std::vector<int>& things : call.unseen)
    for (const int thing : things) {
      if (std::find(moves.instances.begin(), moves.instances.end(), thing) != moves.instances.end())
        continue;
      moves.instances.push_back(thing);
      moves.world_from_node.push_back(
          built.placement
              .world_from_mesh[first_instance(built, static_cast<std::size_t>(thing))]);
    }
}

}  // namespace omma
