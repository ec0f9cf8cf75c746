// The acceleration structure of the CPU: a Scene in Embree, laid out as backend/scene_layout.h
// says. What has been moved is in a top scene of its own, so that moving it again builds nothing
// but the boxes around what moves.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/embree/embree_api.h"
#include "backend/scene_layout.h"
#include "physics/views/scene_view.h"
#include "model/long_work.h"
#include "model/scene_place.h"
#include "omma/scene.h"

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
  // Geometries of both top scenes have the index of their instance here as id.
  SceneLayout layout;
  std::vector<std::unique_ptr<FilterData>> filters;
  // [instance of the layout], null for what is shared and what needs no filter.
  std::vector<const FilterData*> filter_of;
  std::vector<RTCScene> scene_of_mesh;  // [mesh], what is shared; null where it never is
  std::string name;                     // e.g. "embree 3.13.5"
};

// Refers to the Scene's vertices and triangles, which must outlive it unchanged. Throws omma::Error
// where Embree fails, out of memory for instance, and omma::Cancelled where `work` is cancelled.
std::unique_ptr<EmbreeTracer> make_embree_tracer(const Scene& scene, const SceneView& view,
                                                 const Placement& placement,
                                                 WorkState* work = nullptr);

// Moves instances of the Scene that are in `moving`, and gives meshes the shape that they have now.
// Throws omma::Error where Embree fails; they may be anywhere then.
void move_instances(EmbreeTracer& tracer, std::span<const int> instances,
                    std::span<const int> meshes, const Placement& placement);

}  // namespace omma
