// The acceleration structure of the CPU: a Scene in Embree. Meshes placed once, and in small scenes
// all, are put into the world directly; in large scenes meshes placed more often are kept once and
// instanced. The Scene and its shading data hold every mesh once in any case.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "backend/embree/embree_api.h"
#include "backend/shading_data.h"
#include "model/long_work.h"
#include "omma/scene.h"

namespace omma {

// What the candidate filter of one geometry needs.
struct FilterData {
  const SceneView* scene = nullptr;
  std::int32_t mesh = 0;
};

// A geometry of the top scene: which mesh, and metres of the mesh per metre of the world along the
// direction that its transform stretches most.
struct PlacedMesh {
  std::int32_t mesh = -1;
  float mesh_per_world = 0;
};

struct EmbreeTracer {
  EmbreeTracer() = default;
  EmbreeTracer(const EmbreeTracer&) = delete;
  EmbreeTracer& operator=(const EmbreeTracer&) = delete;
  ~EmbreeTracer();

  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  // [geometry of the top scene]. Never empty: packets look up entry 0 for lanes that missed.
  std::vector<PlacedMesh> placed{PlacedMesh{}};
  std::vector<std::unique_ptr<FilterData>> filters;
  std::string name;  // e.g. "embree 3.13.5"
};

// Refers to the Scene's vertices and triangles, which must outlive it unchanged. Throws omma::Error
// where Embree fails, out of memory for instance, and omma::Cancelled where `work` is cancelled.
std::unique_ptr<EmbreeTracer> make_embree_tracer(const Scene& scene, const SceneView& view,
                                                 WorkState* work = nullptr);

}  // namespace omma
