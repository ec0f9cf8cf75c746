// A glTF file as CompoundRay takes it: its cameras, eyes, background and the boxes around meshes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "state.h"

namespace omma::compat {
namespace {

bool can_open(const std::string& path) {
  std::ifstream file(path);
  return file.is_open() && file.peek() != std::ifstream::traits_type::eof();
}

// The path of an eye file: as given, or else put behind the folder of the scene.
std::string find_eye_file(const std::string& given, const std::string& scene_path) {
  if (can_open(given)) return given;
  std::fprintf(stderr,
               "WARNING: Unable to open \"%s\", attempting to open at relative address...\n",
               given.c_str());
  const std::string beside = scene_path.substr(0, scene_path.find_last_of("/\\") + 1) + given;
  if (!can_open(beside)) throw Error("Unable to open \"" + beside + "\", read cancelled.");
  return beside;
}

// CompoundRay reads the first eight numbers of a line and passes over what comes behind them.
Eye load_eight_columns(const std::string& path) {
  std::ifstream file(path);
  std::string text, line, word;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    for (int i = 0; i < 8 && words >> word; ++i) text += (i > 0 ? " " : "") + word;
    text += '\n';
  }
  return parse_eye(text, path, 1.0);  // the node's scale makes the unit
}

CompoundEye load_compound_eye(const Camera& from, const std::string& scene_path) {
  if (from.compound_structure.empty()) throw Error("Eye data path empty or non-existent.");
  if (from.compound_projection.empty())
    throw Error("Projection shader specifier empty or non-existent.");
  CompoundEye compound;
  compound.path = find_eye_file(from.compound_structure, scene_path);
  compound.eye = load_eight_columns(compound.path);
  if (const auto projection = find_projection(from.compound_projection))
    compound.projection = *projection;
  else
    std::fprintf(stderr,
                 "ERROR: Camera '%s': the projection shader '%s' is not known, using "
                 "spherical_orientationwise.\n",
                 from.data_name.c_str(), from.compound_projection.c_str());
  return compound;
}

CompatCamera make_camera(const Camera& from, const std::string& scene_path) {
  CompatCamera camera;
  camera.name = from.data_name;
  camera.type = from.type;
  const Mat4& pose = from.world_from_camera;
  const auto column = [&pose](int c, double sign) {
    return to_float(Vec3d{pose.m[0][c], pose.m[1][c], pose.m[2][c]} * sign);
  };
  camera.space = {column(0, 1), column(1, 1), column(2, -1)};  // a glTF camera looks along -z
  camera.position = column(3, 1);
  if (from.type == CameraType::orthographic)
    camera.scale_x = from.xmag_m, camera.scale_y = from.ymag_m;
  else
    camera.scale_x = camera.scale_y = std::tan(from.yfov_rad / 2);  // its aspect is always 1
  if (from.type == CameraType::compound) camera.compound = load_compound_eye(from, scene_path);
  return camera;
}

Kernel kernel_from_environment() {
  const char* name = std::getenv("OMMA_COMPAT_KERNEL");
  if (name == nullptr || std::string(name) == "compoundray") return Kernel::compoundray;
  if (std::string(name) == "gaussian") return Kernel::gaussian;
  std::fprintf(stderr,
               "ERROR: OMMA_COMPAT_KERNEL: expected \"compoundray\" or \"gaussian\", found "
               "\"%s\"; using compoundray.\n",
               name);
  return Kernel::compoundray;
}

// The box around the corners of a mesh's own box, once they are where the node puts them.
Box box_around(const std::vector<Vec3>& positions, const Mat4& world_from_mesh) {
  if (positions.empty()) return {};
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto include = [](Vec3d& lower, Vec3d& upper, Vec3d p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  };
  Vec3d own[2] = {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  Vec3d world[2] = {own[0], own[1]};
  for (const Vec3 p : positions) include(own[0], own[1], to_double(p));
  for (unsigned corner = 0; corner < 8; ++corner)
    include(world[0], world[1],
            transform_point(world_from_mesh,
                            {own[corner & 1].x, own[corner >> 1 & 1].y, own[corner >> 2 & 1].z}));
  return {to_float(world[0]), to_float(world[1])};
}

}  // namespace

void load(State& state, const std::string& path) {
  const Kernel kernel = kernel_from_environment();
  SceneOptions options;
  options.color_rule = ColorRule::compoundray;
  auto scene = std::make_shared<Scene>(load_scene(path, options));
  for (const std::string& warning : scene->warnings)
    std::fprintf(stderr, "glTF WARNING: %s\n", warning.c_str());
  // What CompoundRay shows where the scene names no background of its own.
  if (scene->background.type == BackgroundType::constant)
    scene->background.type = BackgroundType::test_pattern;

  std::vector<CompatCamera> cameras;
  for (const Camera& camera : scene->cameras) try {
      cameras.push_back(make_camera(camera, path));
    } catch (const Error& error) {
      std::fprintf(stderr, "ERROR: Camera '%s': %s\n", camera.data_name.c_str(), error.what());
    }
  World world(scene);

  state.kernel = kernel;
  state.scene = std::move(scene);
  state.world = std::move(world);
  state.cameras = std::move(cameras);
  state.current = 0;
  current_camera(state);  // a scene without cameras gets one
}

Box geometry_bounds(const State& state, const std::string& name) {
  if (!state.scene) return {};
  for (const HitBox& box : state.scene->hit_boxes)
    if (box.name == name) return box_around(box.positions, box.world_from_mesh);
  for (const Instance& instance : state.scene->instances) {
    const Mesh& mesh = state.scene->meshes[static_cast<std::size_t>(instance.mesh)];
    if (mesh.name == name) return box_around(mesh.positions, instance.world_from_mesh);
  }
  return {};
}

bool is_inside_hit_geometry(const State& state, Vec3d point, const std::string& name) {
  if (state.scene)
    for (const HitBox& box : state.scene->hit_boxes)
      if (box.name == name) return is_inside(box, point);
  std::fprintf(stderr, "WARNING: No hitbox with the given name \"%s\" is present in the scene.\n",
               name.c_str());
  return false;
}

}  // namespace omma::compat
