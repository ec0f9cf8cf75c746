// Our own acceleration structure, for any processor: a Scene as a hierarchy of boxes that
// physics/traverse.h searches.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/placement.h"
#include "model/long_work.h"
#include "omma/scene.h"
#include "physics/bvh.h"
#include "physics/scene_view.h"

namespace omma {

// A tree of triangles.
struct TreeRoot {
  std::uint32_t index = none;          // of its root among the nodes; `none`: nothing to hit
  float lower[3] = {}, upper[3] = {};  // m, the box around it in its frame
};

struct PortableTracer {
  Vec3d origin_m;          // of the traced frame, in the world: rays are relative to it too
  double half_size_m = 0;  // of the box around the scene, its longest side
  // Never empty: packets look up entry 0 for lanes that missed.
  std::vector<PlacedMesh> placed{PlacedMesh{}};
  std::string name = "portable";
  BvhView view;  // of the arrays below

  std::vector<WideNode> top_nodes, nodes;
  std::vector<PlacedTree> trees;
  std::vector<TriangleBlock> blocks;

  const Scene* scene = nullptr;
  const SceneView* scene_view = nullptr;
  std::vector<Mat4> world_from_mesh;    // [instance of the scene], now
  std::vector<std::uint8_t> is_moving;  // [instance of the scene], whether it ever moved
  Placement placement;
  TreeRoot copies;                // of all that is not shared
  std::vector<TreeRoot> of_mesh;  // [mesh], where it is shared
};

// Reads the Scene where it builds and updates: it must outlive the tracer unchanged. Throws
// omma::Cancelled where `work` is cancelled.
std::unique_ptr<PortableTracer> make_portable_tracer(const Scene& scene, const SceneView& view,
                                                     WorkState* work = nullptr);

// Moves instances of the scene: `world_from_mesh[k]` is the new transform of instances[k]. Those
// that move for the first time leave what is built of all that stands still, which is then built
// again; else only the tree over what is placed is.
void update_portable_tracer(PortableTracer& tracer, std::span<const std::int32_t> instances,
                            std::span<const Mat4> world_from_mesh);

}  // namespace omma
