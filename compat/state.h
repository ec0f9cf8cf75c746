// What the library holds between calls: the scene, its cameras with their poses and eyes, the
// frame. One of it, made at the first call (api.cpp).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frame.h"
#include "omma/omma.h"
#include "projections.h"

namespace omma::compat {

// The axes of a camera in the world, the scale of its node in their lengths. Right, up, forward.
struct LocalSpace {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
};

// What only a compound camera has.
struct CompoundEye {
  Eye eye;           // head frame (-z ahead), lengths in units of the camera's local space
  std::string path;  // of the file it came from, as it was opened
  Projection projection = Projection::spherical_orientationwise;
  int samples = 1;  // rays per ommatidium
};

struct CompatCamera {
  std::string name;
  CameraType type = CameraType::perspective;
  // Perspective: tangents of half the field of view; orthographic: half extents, in local units.
  double scale_x = 10, scale_y = 10;
  Vec3 position;
  LocalSpace space;
  CompoundEye compound;

  // Made when first needed and kept while they fit: the renderer of the eye, or of a picture of
  // `picture_width` x `picture_height` pixels, and the eye's id map.
  std::optional<Renderer> renderer;
  int picture_width = 0, picture_height = 0;
  IdMap id_map;
};

struct State {
  bool verbose = true;
  Kernel kernel = Kernel::compoundray;
  std::shared_ptr<const Scene> scene;
  std::optional<World> world;  // that the cameras see
  std::vector<CompatCamera> cameras;
  std::size_t current = 0;  // index into cameras
  Frame frame;
  std::uint64_t frames_rendered = 0;  // picks the random samples
};

// --- scene.cpp
// Replaces the scene and its cameras; throws omma::Error and leaves all as it was.
void load(State& state, const std::string& path);

// First corner and last of the box around a mesh; zeros where no mesh has that name.
struct Box {
  Vec3 lower, upper;
};
Box geometry_bounds(const State& state, const std::string& name);

bool is_inside_hit_geometry(const State& state, Vec3d point, const std::string& name);

// --- camera.cpp
// The camera at hand. Where there is none at all, one at the origin is added, as CompoundRay does.
CompatCamera& current_camera(State& state);
// The same, or null where it is no compound eye.
CompoundEye* current_eye(State& state);
void go_to_camera(State& state, long long index);  // goes round
bool go_to_camera(State& state, const char* name);

void rotate_around(CompatCamera& camera, float angle_rad, Vec3 axis);
Vec3 to_world(const CompatCamera& camera, Vec3 local);  // a direction or step
Mat4 world_from_head(const CompatCamera& camera);

void set_samples(CompatCamera& camera, long long samples);
// Throws omma::Error where an ommatidium cannot be, and leaves the eye as it was.
void set_eye(CompatCamera& camera, Eye eye);

// --- rendering.cpp
void render_frame(State& state);

}  // namespace omma::compat
