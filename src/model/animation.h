// Where the nodes of a rig are at a time: glTF 2.0's animations (section 3.11 and appendix C).
#pragma once

#include <span>
#include <vector>

#include "omma/rig.h"

namespace omma {

// A rig at a moment.
struct RigPose {
  std::vector<Mat4> world_from_node;         // [node]
  std::vector<std::vector<double>> weights;  // [node][morph target]
};

// The animations that are asked for, by their indices; none: all. Throws omma::Error where there is
// no such animation, or where two of them move the same part of a node.
std::vector<int> chosen_animations(const Scene& scene, std::span<const int> asked);

// The rig at a time, s, in those animations; what they do not move is as the file has it.
RigPose eval_rig(const Rig& rig, std::span<const int> animations, double time_s);

// The value of a channel at a time, [component], a rotation as a unit quaternion.
std::vector<double> eval_channel(const AnimationChannel& channel, double time_s);

// Nodes that any animation moves: those whose transform it changes, and all that hang from them.
std::vector<char> nodes_that_move(const Rig& rig);

// Whether any animation changes a deformation's shape: moves its bones, or blends it.
bool is_animated(const Rig& rig, const Deformation& deformation,
                 const std::vector<char>& node_moves);

}  // namespace omma
