// Meshes that change their shape, and all that a scene's animations move.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <unordered_map>
#include <vector>

#include "backend/emissive_data.h"
#include "model/animation.h"
#include "model/deform.h"
#include "model/pose_check.h"
#include "omma/error.h"
#include "omma/world.h"
#include "threads/parallel.h"
#include "world/world_state.h"

namespace omma {
namespace {

bool is_finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_mesh(const Scene& scene, int mesh) {
  if (static_cast<std::size_t>(mesh) >= scene.meshes.size())
    throw Error("mesh: expected an index into the " + std::to_string(scene.meshes.size()) +
                " meshes of the scene, found " + std::to_string(mesh));
}

void check_vectors(const char* name, std::span<const Vec3> vectors, const Mesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  if (vectors.size() != vertices)
    throw Error(std::string(name) + ": expected one for each of " + std::to_string(vertices) +
                " vertices of the mesh, found " + std::to_string(vectors.size()));
  for (std::size_t i = 0; i < vertices; ++i)
    if (!is_finite(vectors[i]))
      throw Error(std::string(name) + "[" + std::to_string(i) + "]: is not finite");
}

// Embree reads a little beyond the last position.
std::vector<Vec3> with_room(std::span<const Vec3> positions) {
  std::vector<Vec3> copy;
  copy.reserve(positions.size() + 1);
  copy.assign(positions.begin(), positions.end());
  return copy;
}

RigPose rig_pose_at(const Rig& rig, std::span<const int> animations, double time_s) {
  if (!std::isfinite(time_s))
    throw Error("time_s: expected a finite time, found " + std::to_string(time_s));
  return eval_rig(rig, animations, time_s);
}

void point_to_shapes(const Scene& scene, const Placement& placement, ShadingData& shading) {
  for (std::size_t m = 0; m < shading.meshes.size(); ++m) {
    const Shape& shape = placement.shapes[m];
    MeshView& view = shading.meshes[m];
    if (view.positions == nullptr) continue;  // it has no triangles
    const bool is_own = shape.positions.empty();
    view.shape_version = is_own ? shading.view.version : shape.version;
    view.positions = is_own ? &scene.meshes[m].positions.data()->x : &shape.positions.data()->x;
    if (view.normals != nullptr)
      view.normals = is_own ? &scene.meshes[m].normals.data()->x : &shape.normals.data()->x;
  }
}

}  // namespace

void follow_shapes(BuiltScene& built) {
  point_to_shapes(*built.scene, built.placement, *built.shading);
  for (LitWorld* world = built.lit_worlds; world != nullptr; world = world->next)
    if (const std::shared_ptr<LitData> lit = world->lit.lock())
      point_to_shapes(*built.scene, built.placement, *lit->shading);
}

void follow_places(const BuiltScene& built, std::span<const int> instances) {
  for (LitWorld* world = built.lit_worlds; world != nullptr; world = world->next) {
    const std::shared_ptr<LitData> lit = world->lit.lock();
    if (lit == nullptr) continue;
    const std::vector<std::int32_t>& emissive = lit->light->emissive_of_instance;
    if (std::any_of(instances.begin(), instances.end(), [&](int instance) {
          return emissive[static_cast<std::size_t>(instance)] >= 0;
        }))
      place_emissive(*lit->light, built.frames.data());
  }
}

void follow_moves(const BuiltScene& built, const std::shared_ptr<LitData>& lit) {
  point_to_shapes(*built.scene, built.placement, *lit->shading);
  auto* const added = new LitWorld{lit, built.lit_worlds.load()};
  while (!built.lit_worlds.compare_exchange_weak(added->next, added)) {
  }
}

Animated animated_of(const Scene& scene, const Things& things) {
  Animated animated;
  const Rig& rig = *scene.rig;
  const std::vector<char> moves = nodes_that_move(rig);
  std::vector<char> is_bent(scene.meshes.size(), 0);
  for (std::size_t d = 0; d < rig.deformations.size(); ++d) {
    const Deformation& deformation = rig.deformations[d];
    is_bent[static_cast<std::size_t>(deformation.mesh)] = deformation.skin >= 0;
    if (is_animated(rig, deformation, moves)) animated.deformations.push_back(static_cast<int>(d));
  }
  // Bones place what they bend, wherever its own node is.
  std::unordered_map<int, int> thing_of_node;
  for (std::size_t thing = 0; thing < things.count(); ++thing) {
    const Instance& instance = scene.instances[static_cast<std::size_t>(
        things.instance[static_cast<std::size_t>(things.first[thing])])];
    if (instance.node >= 0 && !is_bent[static_cast<std::size_t>(instance.mesh)])
      thing_of_node[instance.node] = static_cast<int>(thing);
  }
  for (std::size_t n = 0; n < rig.nodes.size(); ++n) {
    const auto found = thing_of_node.find(rig.nodes[n].file_node);
    if (moves[n] && found != thing_of_node.end())
      animated.things.push_back({found->second, static_cast<int>(n)});
  }
  return animated;
}

Moves moves_at(const BuiltScene& built, std::span<const int> animations, double time_s) {
  const Rig& rig = *built.scene->rig;
  const RigPose pose = rig_pose_at(rig, animations, time_s);
  Moves moves;
  for (const Animated::Thing& animated : built.animated.things) {
    const auto node = static_cast<std::size_t>(animated.node);
    const std::string fault = pose_fault(pose.world_from_node[node]);
    if (!fault.empty()) {
      char time[32];
      std::snprintf(time, sizeof time, "%.6g", time_s);
      throw Error(std::string("animation at ") + time + " s, node \"" + rig.nodes[node].name +
                  "\": " + fault);
    }
    moves.instances.push_back(animated.thing);
    moves.world_from_node.push_back(pose.world_from_node[node]);
  }
  run_in_arena(*built.threads.arena, [&] {
    for (const int index : built.animated.deformations) {
      const Deformation& deformation = rig.deformations[static_cast<std::size_t>(index)];
      moves.meshes.push_back(deformation.mesh);
      moves.shapes.push_back(eval_shape(rig, deformation, pose));
    }
  });
  return moves;
}

std::vector<int> World::animated() const {
  std::vector<int> things;
  for (const Animated::Thing& animated : state_->built->animated.things)
    things.push_back(animated.thing);
  return things;
}

std::vector<Mat4> World::animated_at(double time_s, std::span<const int> animations) const {
  const BuiltScene& built = *state_->built;
  const std::vector<int> chosen = chosen_animations(*built.scene, animations);
  std::vector<Mat4> world_from_node;
  if (built.animated.things.empty()) return world_from_node;
  const RigPose pose = rig_pose_at(*built.scene->rig, chosen, time_s);
  for (const Animated::Thing& animated : built.animated.things)
    world_from_node.push_back(pose.world_from_node[static_cast<std::size_t>(animated.node)]);
  return world_from_node;
}

std::vector<int> World::reshaped() const {
  const Rendering unmoved(*this);
  std::vector<int> meshes;
  const std::vector<Shape>& shapes = state_->built->placement.shapes;
  for (std::size_t m = 0; m < shapes.size(); ++m)
    if (!shapes[m].positions.empty()) meshes.push_back(static_cast<int>(m));
  return meshes;
}

std::vector<Vec3> World::positions(int mesh) const {
  const Rendering unmoved(*this);
  const BuiltScene& built = *state_->built;
  check_mesh(*built.scene, mesh);
  return positions_of(*built.scene, built.placement, static_cast<std::size_t>(mesh));
}

std::vector<Vec3> World::normals(int mesh) const {
  const Rendering unmoved(*this);
  const BuiltScene& built = *state_->built;
  check_mesh(*built.scene, mesh);
  const Shape& shape = built.placement.shapes[static_cast<std::size_t>(mesh)];
  return shape.positions.empty() ? built.scene->meshes[static_cast<std::size_t>(mesh)].normals
                                 : shape.normals;
}

void World::set_vertices(int mesh, std::span<const Vec3> positions, std::span<const Vec3> normals,
                         const std::function<bool(double)>& progress) {
  BuiltScene& built = *state_->built;
  check_mesh(*built.scene, mesh);
  const Mesh& own = built.scene->meshes[static_cast<std::size_t>(mesh)];
  check_vectors("positions_m", positions, own);
  Shape shape;
  shape.positions = with_room(positions);
  if (!normals.empty()) {
    if (own.normals.empty())
      throw Error("normals: expected none, as the mesh has no normals of vertices");
    check_vectors("normals", normals, own);
    for (std::size_t i = 0; i < normals.size(); ++i)
      if (normals[i] == Vec3{0, 0, 0}) throw Error("normals[" + std::to_string(i) + "]: is zero");
    shape.normals.assign(normals.begin(), normals.end());
  } else if (!own.normals.empty()) {
    shape.normals = normals_of(shape.positions, own.triangles, own.normals);
  }
  const Moving moving(built, "set_vertices");
  Moves moves;
  moves.meshes.push_back(mesh);
  moves.shapes.push_back(std::move(shape));
  make_moves(built, std::move(moves), progress);
}

void World::set_time(double time_s, std::span<const int> animations,
                     const std::function<bool(double)>& progress) {
  BuiltScene& built = *state_->built;
  const std::vector<int> chosen = chosen_animations(*built.scene, animations);
  const Moving moving(built, "at");
  make_moves(built, moves_at(built, chosen, time_s), progress);
}

}  // namespace omma
