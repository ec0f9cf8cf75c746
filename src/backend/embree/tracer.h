// The acceleration structure of the CPU: a Scene in Embree. Meshes placed once, and in small scenes
// all, are put into the world directly; in large scenes meshes placed more often are kept once and
// instanced. What has been moved is instanced too, in a top scene of its own, so that moving it
// again builds nothing but the boxes around what moves. The Scene and its shading data hold every
// mesh once in any case.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/embree/embree_api.h"
#include "backend/shading_data.h"
#include "model/long_work.h"
#include "model/scene_place.h"
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
  RTCScene scene = nullptr;   // top scene of what was never moved
  RTCScene moving = nullptr;  // top scene of what was, as instances; null where nothing was
  Vec3d origin_m;             // of the traced frame, in the world: rays are relative to it too
  // [geometry of the top scenes]: ids of `scene` go on where those of `moving` end. Never empty:
  // packets look up entry 0 for lanes that missed.
  std::vector<PlacedMesh> placed{PlacedMesh{}};
  std::vector<std::unique_ptr<FilterData>> filters;
  // [geometry of the top scenes], null for instances and what needs no filter.
  std::vector<const FilterData*> filter_of;
  std::vector<RTCScene> scene_of_mesh;  // [mesh], what is instanced; null where it never is
  std::vector<Vec3d> origin_of_mesh_m;  // [mesh], of that scene, in the mesh's frame
  std::vector<unsigned> moving_id;      // [instance of the Scene], its id in `moving`, or invalid
  std::string name;                     // e.g. "embree 3.13.5"
};

// Refers to the Scene's vertices and triangles, which must outlive it unchanged. Throws omma::Error
// where Embree fails, out of memory for instance, and omma::Cancelled where `work` is cancelled.
std::unique_ptr<EmbreeTracer> make_embree_tracer(const Scene& scene, const SceneView& view,
                                                 const Placement& placement,
                                                 WorkState* work = nullptr);

// Moves instances of the Scene that are in `moving`. Throws omma::Error where Embree fails; they
// may be anywhere then.
void move_instances(EmbreeTracer& tracer, const Scene& scene, std::span<const int> instances,
                    const Placement& placement);

}  // namespace omma
