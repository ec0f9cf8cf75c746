// The world: a scene ready to be seen, before a background, with things in it that can be moved
// between two frames. Made once and seen by any number of renderers.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "omma/error.h"
#include "omma/scene.h"
#include "omma/vec.h"

namespace omma {

struct WorldSettings {
  int threads = 0;                                      // that build it and take pictures; 0: all
  std::optional<Background> background = std::nullopt;  // instead of the scene's own
  // What traces the rays: "embree", "portable", or "" for the fastest that is built in.
  std::string backend = "";
  // What linear RGB, as textures, colours and backgrounds have it, is in each band: [band][3], 1 to
  // most_bands rows. Empty: the bands are RGB itself.
  std::vector<double> band_from_rgb = {};
};

// Something that can be moved: a node of the file with all its primitives, or an instance of a
// scene made in memory that belongs to no node.
struct WorldInstance {
  std::string name;      // of the node; need not be the only one of that name
  Mat4 world_from_node;  // where it is now, m
};

// Seconds spent when the world was made.
struct WorldBuildTimes {
  double scene_s = 0;         // shading data
  double acceleration_s = 0;  // acceleration structure
};

// A handle: copies are the same world, and so are those in renderers. What is moved through one has
// moved for all.
class World {
 public:
  struct State;  // src/world_state.h

  // Builds the acceleration structure; throws omma::Error. The scene must stay as it is: its arrays
  // are read from where they are. `progress` is told of the finished part (0 to 1) several times a
  // second; false throws omma::Cancelled. In a process forked from one that had used threads
  // omma::Error is thrown: Embree cannot build there.
  explicit World(std::shared_ptr<const Scene> scene, WorldSettings settings = {},
                 const std::function<bool(double)>& progress = {});

  // The same world, whose things are where they are in this one and move with them, seen before
  // another background.
  World with_background(const Background& background) const;

  // As it was given: where things are now, instances() says.
  const Scene& scene() const;
  // [instance], in the order of the scene's instances.
  std::vector<WorldInstance> instances() const;
  // Index into instances(); throws omma::Error where none has that name, with those that are nearly
  // called so, or where several have, with their indices.
  int find_instance(const std::string& name) const;

  // Moves things: instances()[instances[i]] to world_from_node[i], for all renderers. A mirrored
  // transform is as good as any, a flattened one is not. What was never moved stays as it was
  // built; moving something for the first time builds that part again, without it, which
  // `progress` is told of and can end. From then on only the boxes around things are touched.
  //
  // Not while anything of this world is being rendered: then, and where an index is out of range or
  // given twice, a transform cannot be used (one that is not finite or not invertible, stretches by
  // less than 1e-15, more than 1e15 or 1e5 times as much one way as another, or takes a surface
  // over 1e12 m away), or in a process forked from one that had used threads, omma::Error is
  // thrown. Whatever is thrown, all is where it was.
  void set_transforms(std::span<const int> instances, std::span<const Mat4> world_from_node,
                      const std::function<bool(double)>& progress = {});

  // As Renderer::precision_warning, of the things where they are now.
  std::string precision_warning(std::span<const Mat4> world_from_head) const;

  const WorldSettings& settings() const;
  const WorldBuildTimes& build_times() const;
  int bands() const;            // numbers that radiance has
  int threads() const;          // that it uses
  std::string backend() const;  // e.g. "embree 3.13.5"

  const State& state() const { return *state_; }

 private:
  World() = default;

  std::shared_ptr<const State> state_;
};

}  // namespace omma
