// What a World holds: what was built of its scene, shared by all that see it, and who uses that
// now.
#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "backend/lit_data.h"
#include "backend/shading_data.h"
#include "backend/splat_data.h"
#include "model/long_work.h"
#include "model/scene_place.h"
#include "omma/world.h"
#include "threads/arena.h"

namespace omma {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct CameraRays;  // camera_rays.h

// A list of what lit worlds have besides their scene; it only grows while anything is rendered.
struct LitWorld {
  std::weak_ptr<LitData> lit;
  LitWorld* next = nullptr;
};

// What the scene's animations move.
struct Animated {
  struct Thing {
    int thing, node;  // index into Things, index into Rig::nodes
  };
  std::vector<Thing> things;
  std::vector<int> deformations;  // indices into Rig::deformations
};

// What can be moved: instances of the scene that belong together.
struct Things {
  std::vector<int> first;     // [thing + 1], into `instance`
  std::vector<int> instance;  // indices of the scene's instances

  std::size_t count() const { return first.size() - 1; }
};

// Worlds that differ in nothing but the background share this.
struct BuiltScene {
  explicit BuiltScene(int wanted_threads) : threads(wanted_threads) {}
  ~BuiltScene();

  std::shared_ptr<const Scene> scene;
  std::unique_ptr<ShadingData> shading;
  std::unique_ptr<SplatData> splats;  // null where there are none
  WorldBuildTimes times;
  ThreadArena threads;
  const Backend* backend = nullptr;
  std::vector<int> devices;
  Launches launches;  // of the backend, on these devices

  Things things;
  Animated animated;

  // These change as things move, and only while nothing is rendered.
  Acceleration acceleration;
  Placement placement;
  std::vector<Bounds> box_of_mesh;  // [mesh], where it is placed somewhere
  std::vector<float> frames;  // [instance][3][4], where they are in the traced frame, row major
  // Lamps do not move, but the traced frame's origin may: where the first one is in it now, m.
  Vec3d first_origin_m;
  float first_origin_now_m[3] = {0, 0, 0};
  ChangingVersions versions;  // of what the views read of these, and of colours
  Bounds still_box;           // around what was never moved, and splats
  std::vector<int> moving;  // indices of instances that were
  // Pictures that replaced images of the scene, by image; their addresses stay.
  std::map<int, std::unique_ptr<const Image>> images;
  bool has_other_colors = false;  // a material was given one

  // Renders under way; -1 while things are being moved. Nobody waits for it, so that no forked
  // process can wait for threads that it does not have.
  mutable std::atomic<int> renders = 0;
  // Of all worlds of this scene that are lit; owned. Added to by those who hold a Rendering.
  mutable std::atomic<LitWorld*> lit_worlds = nullptr;
  // Of the last picture (render_camera); owned, taken out by who uses it.
  mutable std::atomic<CameraRays*> camera_rays = nullptr;
};

// The first instance of the scene that belongs to a thing; all have the same name and transform.
inline std::size_t first_instance(const BuiltScene& built, std::size_t thing) {
  return static_cast<std::size_t>(
      built.things.instance[static_cast<std::size_t>(built.things.first[thing])]);
}

inline const std::string& name_of(const BuiltScene& built, std::size_t thing) {
  return built.scene->instances[first_instance(built, thing)].name;
}

// Cells of baked light know nothing of what dims and what shines between surfaces: throws
// omma::Error where there are splats.
void expect_no_splats(const Scene& scene);

// An acceleration structure of the scene as it is placed now.
Acceleration built_as_placed(const BuiltScene& built, WorkState& work);
// Takes it, and notes what moves in it.
void take_acceleration(BuiltScene& built, Acceleration acceleration);

struct World::State {
  WorldSettings settings;
  std::shared_ptr<BuiltScene> built;
  BackgroundData background;         // refers to the settings' background, or else the scene's
  std::vector<float> band_from_rgb;  // [band][3], empty where the bands are RGB itself
  std::shared_ptr<LitData> lit;      // where the world is lit
  double radiance_unit = 1;          // what a radiance of 1 is in `view`
  SceneView view;                    // what the physics reads
};

// While it lives, nothing of the world can be moved. Throws omma::Error where something is being.
class Rendering {
 public:
  explicit Rendering(const World& world);
  Rendering(const Rendering&) = delete;
  Rendering& operator=(const Rendering&) = delete;
  ~Rendering();

 private:
  const BuiltScene& built_;
};

// While it lives its owner moves things, and nobody else renders or moves anything. Throws
// omma::Error, which begins with what the owner does, where somebody is at it.
class Moving {
 public:
  Moving(BuiltScene& built, const char* doing);
  Moving(const Moving&) = delete;
  Moving& operator=(const Moving&) = delete;
  ~Moving();

 private:
  BuiltScene& built_;
};

// Where things are to be, and what shape meshes are to have.
struct Moves {
  std::vector<int> instances;  // things
  std::vector<Mat4> world_from_node;
  std::vector<int> meshes;
  std::vector<Shape> shapes;  // of all their vertices
};

// Makes moves, of who holds a Moving. Whatever is thrown, all is as it was.
void make_moves(BuiltScene& built, Moves moves, const Progress& progress);

// What puts things and meshes back to where they are now.
Moves moves_back(const BuiltScene& built, const Moves& moves);

// What the scene's animations move, to where it is at a time; `animations` are chosen_animations.
Moves moves_at(const BuiltScene& built, std::span<const int> animations, double time_s);

// Of a scene with a rig.
Animated animated_of(const Scene& scene, const Things& things);

// Points the shading data of all worlds of this scene to the shapes that meshes have now.
void follow_shapes(BuiltScene& built);
// Tells all worlds of this scene that are lit where what shines is now, if any of these instances
// does.
void follow_places(const BuiltScene& built, std::span<const int> instances);
// Both of a lit world, from now on. Its maker holds a Rendering.
void follow_moves(const BuiltScene& built, const std::shared_ptr<LitData>& lit);

}  // namespace omma
