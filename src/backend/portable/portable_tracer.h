// Our own acceleration structure, for any processor: a Scene as a hierarchy of boxes that
// physics/search/traverse.h searches.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/scene_layout.h"
#include "model/long_work.h"
#include "model/new_version.h"
#include "omma/scene.h"
#include "physics/search/bvh.h"
#include "physics/views/scene_view.h"

namespace omma {

// A tree of triangles.
struct TreeRoot {
  std::uint32_t index = none;          // of its root among the nodes; `none`: nothing to hit
  std::uint32_t end = 0;               // behind its last node; children come after their parents
  float lower[3] = {}, upper[3] = {};  // m, the box around it in its frame
};

struct PortableTracer {
  std::string name = "portable";
  BvhView view;  // of the arrays below

  std::vector<WideNode> top_nodes, nodes;
  std::vector<PlacedTree> trees;
  std::vector<TriangleQuad> quads;
  Version triangles_version = new_version();  // of nodes and quads
  std::vector<PlacedFrame> frames;

  const Scene* scene = nullptr;
  const SceneView* scene_view = nullptr;
  SceneLayout layout;
  TreeRoot copies;                // of all that is not shared
  std::vector<TreeRoot> of_mesh;  // [mesh], where it is shared
};

// Refers to the Scene and the view, which must outlive the tracer unchanged. Throws omma::Cancelled
// where `work` is cancelled.
std::unique_ptr<PortableTracer> make_portable_tracer(const Scene& scene, const SceneView& view,
                                                     const Placement& placement,
                                                     WorkState* work = nullptr);

// Moves instances of the Scene to where they are placed now: only the tree over what is placed is
// built again. Meshes that changed their shape take it on: the boxes of their trees are fitted to
// it.
void move_instances(PortableTracer& tracer, std::span<const int> instances,
                    std::span<const int> meshes, const Placement& placement);

}  // namespace omma
