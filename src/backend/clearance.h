// Free space about the triangles of a scene: where surfaces stand close together, light on them
// changes within short distances.
#pragma once

#include <vector>

#include "backend/launches.h"
#include "model/scene_place.h"
#include "omma/scene.h"

namespace omma {

// What finds the surfaces: of a backend.
struct Tracing {
  decltype(Launches::closest) closest;
  const void* tracer = nullptr;
};

// Harmonic mean of the distances to what surrounds each triangle, on both its sides,
// [mesh][triangle], m; infinite where nothing does. It sets the spacing of irradiance samples
// (Ward, Rubinstein and Clear 1988, A ray tracing solution for diffuse interreflection, eq. 5). Of
// a mesh with many instances a few stand for all.
std::vector<std::vector<float>> clearances_m(const Tracing& tracing, const Scene& scene,
                                             const Placement& placement);

}  // namespace omma
