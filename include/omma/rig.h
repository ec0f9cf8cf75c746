// How things of a scene move and change their shape in time, as glTF's animations say: nodes,
// animations that move them, and meshes that are bent by bones (skins) and blended between shapes
// (morph targets). A scene that stands still has none of it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "omma/scene.h"
#include "omma/vec.h"

namespace omma {

// At most so many bones bend a vertex.
inline constexpr int most_influences = 8;

// A node that moves, or that something which moves hangs from.
struct RigNode {
  std::string name;
  int parent = -1;     // index into Rig::nodes, before this one; -1: the world
  int file_node = -1;  // index in the file: it places the instances of that `node`; -1: none
  int camera = -1;     // index into Scene::cameras of the one that it carries, -1 for none
  // parent_from_node: a matrix, or translation * rotation * scale, of which animations change parts.
  bool has_matrix = false;
  Mat4 matrix;
  std::array<double, 3> translation_m{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};  // unit quaternion x, y, z, w
  std::array<double, 3> scale{1, 1, 1};
  std::vector<double> weights;  // of the morph targets of its mesh, where it has any
  bool operator==(const RigNode&) const = default;
};

enum class AnimatedPart : std::uint8_t { translation, rotation, scale, weights };
enum class Interpolation : std::uint8_t { linear, step, cubic_spline };

// One part of a node over time: before the first key as at the first, after the last as at the last.
struct AnimationChannel {
  int node = -1;  // index into Rig::nodes
  AnimatedPart part = AnimatedPart::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times_s;  // [key], growing
  // [key][component]; of cubic splines [key][tangent in, value, tangent out][component].
  std::vector<double> values;
  bool operator==(const AnimationChannel&) const = default;
};

struct Animation {
  std::string name;
  double duration_s = 0;  // its last key
  std::vector<AnimationChannel> channels;
  bool operator==(const Animation&) const = default;
};

// Bones of a skin.
struct Skin {
  std::string name;
  std::vector<int> joints;                // [joint], indices into Rig::nodes
  std::vector<Mat4> joint_from_mesh;      // [joint], the inverse bind matrices
  bool operator==(const Skin&) const = default;
};

// A shape that a mesh is blended towards.
struct MorphTarget {
  std::vector<Vec3> positions;  // [vertex], m, to be added to the mesh's own, or empty
  std::vector<Vec3> normals;    // the same of normals
  bool operator==(const MorphTarget&) const = default;
};

// A mesh that changes its shape; no other instance has it. In the scene it has the shape in which
// the file shows it.
struct Deformation {
  int mesh = -1;                        // index into Scene::meshes
  std::vector<Vec3> positions;          // [vertex], m, before it is blended and bent
  std::vector<Vec3> normals;            // [vertex], or empty
  int node = -1;                        // index into Rig::nodes, whose weights `targets` have
  std::vector<MorphTarget> targets;
  int skin = -1;                        // index into Rig::skins, -1 for none
  int influences = 0;                   // of bones on a vertex: 4 or 8
  std::vector<std::uint16_t> joints;    // [vertex][influence], indices of the skin's joints
  std::vector<float> weights;           // [vertex][influence], which sum to 1
  Mat4 mesh_from_world;                 // where it is bent by a skin: of the instance, at rest
  bool operator==(const Deformation&) const = default;
};

struct Rig {
  std::vector<RigNode> nodes;  // parents before children
  std::vector<Skin> skins;
  std::vector<Deformation> deformations;
  std::vector<Animation> animations;
  bool operator==(const Rig&) const = default;
};

// Index of the animation of that name; throws omma::Error that lists the names there are, or where
// several have it.
int find_animation(const Scene& scene, const std::string& name);

// Where a camera (index into Scene::cameras) is at a time, s, in those animations (indices; none:
// all). Throws omma::Error as World::at does.
Mat4 camera_at(const Scene& scene, int camera, double time_s, const std::vector<int>& animations);

// The rig of a scene that is put elsewhere. Throws omma::Error where bones bend meshes, and the
// transform has no inverse.
Rig placed_rig(const Rig& rig, const Mat4& world_from_scene);

// The same rig with cameras, and so eyes, that are larger by a factor.
Rig with_scaled_cameras(const Rig& rig, double factor);

// How many meshes, cameras and nodes the scenes before have.
struct RigOffsets {
  int meshes = 0, cameras = 0, nodes = 0;
};

// Adds the rig of another scene, whose parts come after those.
void append_rig(Rig& rig, const Rig& other, const RigOffsets& before);

}  // namespace omma
