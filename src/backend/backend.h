// A way of finding where rays meet surfaces. A backend builds an acceleration structure of a scene
// and runs the hot loop (physics/block/block.h) with a search of its own; all that lies between a
// pose and a response besides is the same for all of them.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "backend/launches.h"
#include "model/long_work.h"
#include "model/scene_place.h"
#include "omma/scene.h"

namespace omma {

// What a backend has built of a scene.
struct Acceleration {
  std::shared_ptr<void> tracer;  // the backend's own
  std::string name;              // begins with the backend's, e.g. "embree 3.13.5"
  std::vector<int> cards = {};   // ordinals of graphics cards that trace; of a processor none
};

// `devices`: ordinals of the cards that are used, each once, as WorldSettings has them; empty: the
// first one, or the processor.
struct Backend {
  const char* name;
  // Refers to the Scene's vertices and triangles and to the view, which must outlive it unchanged.
  // Throws omma::Error where it fails, and omma::Cancelled where `work`, if there is any, is
  // cancelled.
  Acceleration (*build)(const Scene& scene, const SceneView& view, const Placement& placement,
                        std::span<const int> devices, WorkState* work);
  // Moves instances of the Scene that moved before it was built to where they are placed now, and
  // gives meshes that had changed their shape before it was built the one that they have now. Throws
  // omma::Error where that fails; they may be anywhere then.
  void (*move)(Acceleration& acceleration, std::span<const int> instances,
               std::span<const int> meshes, const Placement& placement);
  // On this machine. Throws omma::Error where there are no such devices.
  Launches (*launches)(std::span<const int> devices);
};

// Those built in, the fastest first.
std::span<const Backend> backends();

// The one of that name, "" for the fastest; throws omma::Error that lists them.
const Backend& find_backend(std::string_view name);

// Of a processor: throws omma::Error where there are any.
void expect_no_devices(const char* backend, std::span<const int> devices);

}  // namespace omma
