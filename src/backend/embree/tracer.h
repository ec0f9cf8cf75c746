// The acceleration structure of the CPU: a Scene in Embree. Meshes placed once, and in small scenes
// all, are put into the world directly; in large scenes meshes placed more often are kept once and
// instanced. The Scene and its shading data hold every mesh once in any case.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "backend/embree/embree_api.h"
#include "backend/shading_data.h"
#include "model/long_work.h"
#include "omma/scene.h"
#include "physics/ray_packet.h"

namespace omma {

struct EmbreeTracer;

// What the candidate filter of one geometry needs.
struct FilterData {
  const SceneView* scene = nullptr;
  std::int32_t mesh = 0;
  const EmbreeTracer* tracer = nullptr;
  const Vec3* position_m = nullptr;                         // [vertex], in Embree's frame
  const std::array<std::uint32_t, 3>* triangles = nullptr;  // [triangle]
};

struct EmbreeTracer {
  EmbreeTracer() = default;
  EmbreeTracer(const EmbreeTracer&) = delete;
  EmbreeTracer& operator=(const EmbreeTracer&) = delete;
  ~EmbreeTracer();

  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  Vec3d origin_m;          // of the traced frame, in the world: rays are relative to it too
  double half_size_m = 0;  // of the box around the scene, its longest side
  // [geometry of the top scene]. Never empty: packets look up entry 0 for lanes that missed.
  std::vector<PlacedMesh> placed{PlacedMesh{}};
  std::vector<std::unique_ptr<FilterData>> filters;
  // [geometry of the top scene], null for instances and what needs no filter.
  std::vector<const FilterData*> filter_of;
  std::string name;  // e.g. "embree 3.13.5"
};

// Refers to the Scene's vertices and triangles, which must outlive it unchanged. Throws omma::Error
// where Embree fails, out of memory for instance, and omma::Cancelled where `work` is cancelled.
std::unique_ptr<EmbreeTracer> make_embree_tracer(const Scene& scene, const SceneView& view,
                                                 WorkState* work = nullptr);

}  // namespace omma
