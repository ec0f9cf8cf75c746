// Small scenes, eyes and transforms made in memory for the render tests, and seeded random numbers
// that are the same with every standard library (std::uniform_real_distribution is not).
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "omma/eye.h"
#include "omma/render.h"
#include "omma/scene.h"
#include "omma/world.h"
#include "omma/vec.h"

namespace omma::test {

// SplitMix64 (Steele, Lea, Flood 2014, doi:10.1145/2660193.2660195).
struct Random {
  std::uint64_t state = 0;

  std::uint64_t next() {
    std::uint64_t z = (state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  // Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }
  int index(int count) { return static_cast<int>(next() % static_cast<std::uint64_t>(count)); }
  // Uniform on the unit sphere.
  Vec3d direction() {
    const double z = uniform(-1, 1), azimuth = uniform(-pi, pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
  }
};

// --- Transforms.
inline Mat4 translation(Vec3d t) {
  Mat4 m;
  m.m[0][3] = t.x, m.m[1][3] = t.y, m.m[2][3] = t.z;
  return m;
}

inline Mat4 scaling(Vec3d s) {
  Mat4 m;
  m.m[0][0] = s.x, m.m[1][1] = s.y, m.m[2][2] = s.z;
  return m;
}

// Right-handed rotation about a unit axis (Rodrigues).
inline Mat4 rotation(Vec3d axis, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad), k = 1 - c;
  const auto [x, y, z] = axis;
  Mat4 m;
  m.m[0][0] = c + k * x * x, m.m[0][1] = k * x * y - s * z, m.m[0][2] = k * x * z + s * y;
  m.m[1][0] = k * x * y + s * z, m.m[1][1] = c + k * y * y, m.m[1][2] = k * y * z - s * x;
  m.m[2][0] = k * x * z - s * y, m.m[2][1] = k * y * z + s * x, m.m[2][2] = c + k * z * z;
  return m;
}

inline Mat4 random_rotation(Random& random) {
  const Vec3d axis = random.direction();
  return rotation(axis, random.uniform(-pi, pi));
}

// Two unit vectors that make a right-handed frame (u, v, w) with the unit vector w.
inline std::pair<Vec3d, Vec3d> tangents(Vec3d w) {
  const Vec3d other = std::fabs(w.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
  const Vec3d u = normalize(cross(other, w));
  return {u, cross(w, u)};
}

// The unit vector at polar angle theta and azimuth phi around w.
inline Vec3d direction_about(Vec3d w, double theta_rad, double phi_rad) {
  const auto [u, v] = tangents(w);
  return w * std::cos(theta_rad) +
         (u * std::cos(phi_rad) + v * std::sin(phi_rad)) * std::sin(theta_rad);
}

// Azimuth grows from straight ahead (-Z) to the right (+X), elevation upwards.
inline Vec3d from_azimuth_elevation(double azimuth_rad, double elevation_rad) {
  return {std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
          -std::cos(azimuth_rad) * std::cos(elevation_rad)};
}

// --- Eyes: every ommatidium of eye 0, at the origin unless it is moved afterwards.
inline Eye make_eye(std::span<const Vec3d> axes, double acceptance_rad) {
  Eye eye;
  for (const Vec3d axis : axes) {
    eye.position_m.push_back({0, 0, 0});
    eye.axis.push_back(to_float(axis));
    eye.acceptance_angle_rad.push_back(static_cast<float>(acceptance_rad));
    eye.focal_offset_m.push_back(0);
    eye.eye_id.push_back(0);
  }
  validate_eye(eye);
  return eye;
}

inline Eye make_eye(Vec3d axis, double acceptance_rad, std::size_t copies = 1) {
  return make_eye(std::vector<Vec3d>(copies, axis), acceptance_rad);
}

// Directions spread evenly over the sphere (Fibonacci lattice).
inline std::vector<Vec3d> sphere_directions(int count) {
  std::vector<Vec3d> directions;
  for (int i = 0; i < count; ++i) {
    const double y = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - y * y);
    const double azimuth = i * pi * (3 - std::sqrt(5.0));
    directions.push_back({r * std::sin(azimuth), y, -r * std::cos(azimuth)});
  }
  return directions;
}

// --- Scenes.
inline int add_material(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

// Opaque, both sides visible, one colour.
inline int add_color(Scene& scene, Vec3 color) {
  Material material;
  material.base_color = {color.x, color.y, color.z, 1};
  material.double_sided = true;
  return add_material(scene, material);
}

inline int add_texture(Scene& scene, Image image, Texture texture = {}) {
  scene.images.push_back(std::move(image));
  texture.image = static_cast<int>(scene.images.size()) - 1;
  scene.textures.push_back(texture);
  return static_cast<int>(scene.textures.size()) - 1;
}

inline void add_instance(Scene& scene, int mesh, const Mat4& world_from_mesh = {}) {
  scene.instances.push_back({"", mesh, world_from_mesh});
}

inline int add_mesh(Scene& scene, Mesh mesh) {
  scene.meshes.push_back(std::move(mesh));
  return static_cast<int>(scene.meshes.size()) - 1;
}

// A parallelogram centre +- u +- v whose front looks along u x v; texture coordinates from (0, 0)
// at -u +v (the image's top left) to (1, 1) at +u -v.
inline Mesh quad(Vec3d centre, Vec3d u, Vec3d v, int material) {
  Mesh mesh;
  mesh.material = material;
  for (const auto& [a, b] : {std::pair{-1, 1}, {-1, -1}, {1, -1}, {1, 1}}) {
    mesh.positions.push_back(to_float(centre + u * a + v * b));
    mesh.texcoords[0].push_back({a < 0 ? 0.0f : 1.0f, b > 0 ? 0.0f : 1.0f});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

inline void add_quad(Scene& scene, Vec3d centre, Vec3d u, Vec3d v, int material) {
  add_instance(scene, add_mesh(scene, quad(centre, u, v, material)));
}

// A cube of half side `half_m` around the origin; its faces show front to the inside.
inline Mesh cube_seen_from_inside(double half_m, int material) {
  Mesh cube;
  cube.material = material;
  const Vec3d axes[3] = {{half_m, 0, 0}, {0, half_m, 0}, {0, 0, half_m}};
  for (int side = 0; side < 6; ++side) {
    const Vec3d w = axes[side % 3] * (side < 3 ? 1 : -1);
    const Vec3d u = axes[(side + 1) % 3], v = axes[(side + 2) % 3];
    const Mesh face = side < 3 ? quad(w, v, u, material) : quad(w, u, v, material);
    const auto first = static_cast<std::uint32_t>(cube.positions.size());
    for (const Vec3 p : face.positions) cube.positions.push_back(p);
    for (const auto& t : face.triangles)
      cube.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return cube;
}

inline Background constant_background(Vec3 color) {
  Background background;
  background.color = color;
  return background;
}

// A float image with the colour `color(column, row)`.
template <typename Color>
Image make_image(int width, int height, Color color) {
  Image image;
  image.width = width, image.height = height;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const Vec4 c = color(column, row);
      for (const float value : {c.x, c.y, c.z, c.w}) image.rgba_linear.push_back(value);
    }
  return image;
}

inline Background image_background(Image image) {
  Background background;
  background.type = BackgroundType::image;
  background.image = std::move(image);
  return background;
}

// Flat-coloured double-sided triangles in all directions, 1 to 3 m away; `colors` of them.
Scene flat_triangles(std::uint64_t seed, int triangle_count, int colors = 7);

// Everything a scene can hold: instanced meshes under rotations, non-uniform and negative scales,
// textures of all wraps and filters, two coordinate sets, texture transforms, vertex colours, all
// alpha modes, emission, back faces. Around the origin, a few metres away.
Scene random_scene(std::uint64_t seed);

// --- Rendering.
struct Result {
  std::vector<float> response, standard_error;  // [pose][ommatidium][channel]

  double at(std::size_t ommatidium, int channel = 0) const {
    return response[ommatidium * rgb_bands + static_cast<std::size_t>(channel)];
  }
};

// What traces rays in the tests that this program runs: --backend=NAME on its command line, else the
// fastest that is built in.
inline std::string backend_under_test;

inline World make_world(const Scene& scene, WorldSettings settings = {}) {
  if (settings.backend.empty()) settings.backend = backend_under_test;
  return World(std::make_shared<const Scene>(scene), settings);
}

inline Renderer make_renderer(const Scene& scene, const Eye& eye,
                              const RenderSettings& settings = {}) {
  WorldSettings of_world;
  of_world.threads = settings.threads;
  return Renderer(make_world(scene, of_world), eye, settings);
}

inline Result render(const Renderer& renderer, std::span<const Mat4> poses, bool with_error = false,
                     std::uint64_t first_pose = 0) {
  Result result;
  result.response.resize(poses.size() * renderer.eye().size() * rgb_bands, -1e30f);
  if (with_error) result.standard_error.resize(result.response.size(), -1e30f);
  RenderCall call;
  call.first_pose = first_pose;
  call.standard_error = result.standard_error;
  renderer.render(poses, result.response, call);
  return result;
}

inline Result render(const Scene& scene, const Eye& eye, const RenderSettings& settings = {},
                     const Mat4& world_from_head = {}, bool with_error = false) {
  return render(make_renderer(scene, eye, settings), std::span(&world_from_head, 1), with_error);
}

inline std::string name_of(Kernel kernel) {
  if (kernel == Kernel::gaussian) return "gaussian";
  return kernel == Kernel::pillbox ? "pillbox" : "compoundray";
}

inline std::string name_of(Points points) {
  return points == Points::random ? "random" : "low_discrepancy";
}

// A surround without edges: low frequencies in azimuth and elevation, on a fine image.
inline Scene smooth_scene() {
  Scene scene;
  constexpr int width = 1024, height = 512;
  scene.background = image_background(make_image(width, height, [](int column, int row) {
    const double azimuth = 2 * pi * (column + 0.5) / width, elevation = pi * (row + 0.5) / height;
    const double s = std::sin(elevation);
    return Vec4{static_cast<float>(0.5 + 0.5 * s * s * std::cos(2 * azimuth)),
                static_cast<float>(0.5 + 0.4 * s * std::sin(azimuth + 1)),
                static_cast<float>(elevation / pi), 1};
  }));
  return scene;
}

inline std::vector<Mat4> turning_poses(int count) {
  std::vector<Mat4> poses;
  for (int i = 0; i < count; ++i)
    poses.push_back(translation({0.02 * i, 0, 0}) * rotation({0, 1, 0}, 0.3 * i));
  return poses;
}

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace omma::test
