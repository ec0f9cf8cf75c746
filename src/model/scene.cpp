// Scenes in memory: what must hold before a renderer trusts one, and what can be asked of one.
#include "omma/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <span>
#include <unordered_map>

#include "model/rig_check.h"
#include "model/scene_light.h"
#include "model/splat_check.h"
#include "model/text.h"
#include "model/texture_uses.h"
#include "omma/error.h"
#include "omma/rig.h"  // IWYU pragma: keep, compared here

namespace omma {
namespace {

// The physics counts with 32-bit integers in the arrays of one mesh (12 numbers a triangle) and of
// one image (4 numbers a pixel).
constexpr std::size_t most_triangles = std::size_t(1) << 27;
constexpr std::size_t most_pixels = std::size_t(1) << 28;

// Of a base colour, an emission or a background; 1 is full scale. Squares of what differs by two of
// these, summed over 2^20 rays in eight scrambles, are 3e37 and stay within single precision.
constexpr double most_radiance = 1e15;

bool finite(Vec2 v) {
  return std::isfinite(v.x) && std::isfinite(v.y);
}
bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool finite(Vec4 v) {
  return finite(Vec3{v.x, v.y, v.z}) && std::isfinite(v.w);
}

bool non_negative(Vec3 v) {
  return v.x >= 0 && v.y >= 0 && v.z >= 0;
}

std::string place_of(const Scene& scene, const char* what, std::size_t index,
                     const std::string& name = "") {
  return (scene.path.empty() ? "scene" : scene.path) + ": " + what + " " + std::to_string(index) +
         (name.empty() ? "" : " \"" + name + "\"");
}

// A handle into an array of `size`; -1 stands for none where that is allowed.
void check_handle(int handle, std::size_t size, bool may_be_none, const std::string& place,
                  const char* what) {
  if (may_be_none && handle == -1) return;
  if (handle < 0 || static_cast<std::size_t>(handle) >= size)
    throw Error(place + ": refers to " + what + " " + std::to_string(handle) + ", there are " +
                std::to_string(size));
}

template <typename T>
void check_finite(const std::vector<T>& values, const std::string& place, const char* what) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!finite(values[i]))
      throw Error(place + ": " + what + " of vertex " + std::to_string(i) + " is not finite");
}

void check_size(std::size_t size, std::size_t vertices, const std::string& place,
                const char* what) {
  if (size != 0 && size != vertices)
    throw Error(place + ": has " + std::to_string(size) + " " + what + " for " +
                std::to_string(vertices) + " vertices");
}

void check_transform(const Mat4& t, const std::string& place, const char* what) {
  for (const auto& row : t.m)
    for (const double value : row)
      if (!std::isfinite(value)) throw Error(place + ": " + what + " is not finite");
  if (t.m[3][0] != 0 || t.m[3][1] != 0 || t.m[3][2] != 0 || t.m[3][3] != 1)
    throw Error(place + ": the bottom row of " + what + " is not 0 0 0 1");
}

// Of each instance, the first one that moves with it.
std::vector<std::size_t> first_of_each_node(const std::vector<Instance>& instances) {
  std::unordered_map<int, std::size_t> first_of_node;
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < instances.size(); ++i)
    first.push_back(
        instances[i].node < 0 ? i : first_of_node.try_emplace(instances[i].node, i).first->second);
  return first;
}

bool same_instances(const std::vector<Instance>& a, const std::vector<Instance>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Instance& one, const Instance& other) {
                      return one.name == other.name && one.mesh == other.mesh &&
                             one.world_from_mesh == other.world_from_mesh;
                    }) &&
         first_of_each_node(a) == first_of_each_node(b);
}

// The largest magnitude among the values, at least 1: the factor by which a product may grow.
float largest(std::span<const float> values) {
  float most = 1;
  for (const float value : values) most = std::max(most, std::fabs(value));
  return most;
}

// Factors multiply; none of their products may be so large that sums of squares leave single
// precision. Each alone counts as at least 1, so that what is computed on the way stays in too.
void check_product(std::initializer_list<float> factors, const std::string& place,
                   const char* what) {
  double product = 1;
  for (const float factor : factors)
    product *= std::max(1.0, std::fabs(static_cast<double>(factor)));
  if (product <= most_radiance) return;
  char found[32];
  std::snprintf(found, sizeof found, "%.3g", product);
  throw Error(place + ": " + what + " would reach " + found +
              ", expected at most 1e15 (1 is full scale)");
}

// What textures of a material multiply with at most; `in_image` is [image].
float largest_texel(const Scene& scene, const TextureUse& use, std::span<const float> in_image) {
  if (use.texture < 0) return 1;
  return in_image[static_cast<std::size_t>(
      scene.textures[static_cast<std::size_t>(use.texture)].image)];
}

// Base colour and emission of a material on a mesh with these vertex colours.
void check_radiance(const Scene& scene, const Material& material, std::span<const float> in_image,
                    std::span<const Vec4> colors, const std::string& place) {
  const Vec4 base = material.base_color;
  const std::span<const float> components(colors.empty() ? nullptr : &colors.front().x,
                                          4 * colors.size());
  check_product({std::max({base.x, base.y, base.z, base.w}), largest(components),
                 largest_texel(scene, material.base_color_texture, in_image)},
                place, "its colour (factor x texture x vertex colour)");
  check_product({std::max({material.emissive.x, material.emissive.y, material.emissive.z}),
                 largest_texel(scene, material.emissive_texture, in_image)},
                place, "its emission (factor x texture)");
}

void check_triangles(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                     std::size_t vertices, const std::string& place) {
  if (triangles.size() > most_triangles)
    throw Error(place + ": has " + std::to_string(triangles.size()) +
                " triangles, a mesh may have " + std::to_string(most_triangles));
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::uint32_t vertex : triangles[i])
      if (vertex >= vertices)
        throw Error(place + ": triangle " + std::to_string(i) + " has vertex " +
                    std::to_string(vertex) + ", there are " + std::to_string(vertices));
}

void check_mesh(const Scene& scene, const Mesh& mesh, const std::string& place) {
  check_handle(mesh.material, scene.materials.size(), true, place, "material");
  check_finite(mesh.positions, place, "the position");
  check_size(mesh.normals.size(), mesh.positions.size(), place, "normals");
  check_finite(mesh.normals, place, "the normal");
  const auto zero = std::find(mesh.normals.begin(), mesh.normals.end(), Vec3{0, 0, 0});
  if (zero != mesh.normals.end())
    throw Error(place + ": the normal of vertex " + std::to_string(zero - mesh.normals.begin()) +
                " is zero");
  for (std::size_t set = 0; set < mesh.texcoords.size(); ++set) {
    check_size(mesh.texcoords[set].size(), mesh.positions.size(), place, "texture coordinates");
    check_finite(mesh.texcoords[set], place, "the texture coordinate");
  }
  check_size(mesh.colors.size(), mesh.positions.size(), place, "colours");
  check_finite(mesh.colors, place, "the colour");
  const auto negative = std::find_if(mesh.colors.begin(), mesh.colors.end(), [](const Vec4& color) {
    return !(non_negative({color.x, color.y, color.z}) && color.w >= 0);
  });
  if (negative != mesh.colors.end())
    throw Error(place + ": the colour of vertex " + std::to_string(negative - mesh.colors.begin()) +
                " is negative");
  check_triangles(mesh.triangles, mesh.positions.size(), place);
}

void check_texture_use(const Scene& scene, const TextureUse& use, const std::string& place) {
  check_handle(use.texture, scene.textures.size(), true, place, "texture");
  if (use.texcoord_set < 0 || use.texcoord_set > 1)
    throw Error(place + ": texture coordinate set " + std::to_string(use.texcoord_set) +
                ", expected 0 or 1");
  if (!finite(use.offset) || !finite(use.scale) || !std::isfinite(use.rotation_rad))
    throw Error(place + ": its texture transform is not finite");
}

void check_material(const Scene& scene, const Material& material, const std::string& place) {
  const Vec4 base = material.base_color;
  if (!finite(base) || !non_negative({base.x, base.y, base.z}) || base.w < 0)
    throw Error(place + ": its base colour is negative or not finite");
  if (!finite(material.emissive) || !non_negative(material.emissive))
    throw Error(place + ": its emission is negative or not finite");
  if (!std::isfinite(material.alpha_cutoff))
    throw Error(place + ": its alpha cutoff is not finite");
  for (const TextureUse Material::*use : texture_uses)
    check_texture_use(scene, material.*use, place);
  check_texture_use(scene, material.extra.texture, place);
  check_scattering(material, place + ": ");
}

void check_image(const Image& image, const std::string& place) {
  if (image.width < 1 || image.height < 1)
    throw Error(place + ": has " + std::to_string(image.width) + " x " +
                std::to_string(image.height) + " pixels");
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (pixels > most_pixels)
    throw Error(place + ": has " + std::to_string(pixels) + " pixels, an image may have " +
                std::to_string(most_pixels));
  const std::size_t expected = 4 * pixels;
  const std::size_t encoded = image.rgba_srgb8.size(), linear = image.rgba_linear.size();
  if (!(encoded == expected && linear == 0) && !(encoded == 0 && linear == expected))
    throw Error(place + ": " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                " pixels need " + std::to_string(expected) +
                " values in one of two arrays, found " + std::to_string(encoded) + " 8-bit and " +
                std::to_string(linear) + " float");
  const auto is_finite = [](float v) { return std::isfinite(v); };
  const auto at = std::find_if_not(image.rgba_linear.begin(), image.rgba_linear.end(), is_finite);
  if (at == image.rgba_linear.end()) return;
  const auto pixel = static_cast<std::size_t>(at - image.rgba_linear.begin()) / 4;
  const auto width = static_cast<std::size_t>(image.width);
  throw Error(place + (image.name.empty() ? "" : " (" + readable_text(image.name) + ")") +
              ": expected finite pixels, found " + (std::isnan(*at) ? "nan" : "infinity") +
              " in row " + std::to_string(pixel / width) + ", column " +
              std::to_string(pixel % width));
}

void check_camera(const Camera& camera, const std::string& place) {
  check_transform(camera.world_from_camera, place, "world_from_camera");
  for (const double value : {camera.yfov_rad, camera.aspect_ratio, camera.xmag_m, camera.ymag_m,
                             camera.znear_m, camera.zfar_m})
    if (!std::isfinite(value)) throw Error(place + ": its projection is not finite");
}

}  // namespace

bool operator==(const Scene& a, const Scene& b) {
  return a.color_rule == b.color_rule && a.meshes == b.meshes &&
         same_instances(a.instances, b.instances) && a.materials == b.materials &&
         a.textures == b.textures && a.images == b.images && a.cameras == b.cameras &&
         a.hit_boxes == b.hit_boxes && a.lights == b.lights && a.splats == b.splats &&
         a.background == b.background &&
         (a.rig == b.rig || (a.rig != nullptr && b.rig != nullptr && *a.rig == *b.rig));
}

void validate_scene(const Scene& scene) {
  for (std::size_t i = 0; i < scene.images.size(); ++i)
    check_image(scene.images[i], place_of(scene, "image", i, scene.images[i].name));
  for (std::size_t i = 0; i < scene.textures.size(); ++i)
    check_handle(scene.textures[i].image, scene.images.size(), false, place_of(scene, "texture", i),
                 "image");
  std::vector<float> largest_in_image;
  for (const Image& image : scene.images) largest_in_image.push_back(largest(image.rgba_linear));
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string place = place_of(scene, "material", i, scene.materials[i].name);
    check_material(scene, scene.materials[i], place);
    check_radiance(scene, scene.materials[i], largest_in_image, {}, place);
  }
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    const std::string place = place_of(scene, "mesh", i, mesh.name);
    check_mesh(scene, mesh, place);
    const Material material =
        mesh.material < 0 ? Material{} : scene.materials[static_cast<std::size_t>(mesh.material)];
    if (!mesh.colors.empty()) check_radiance(scene, material, largest_in_image, mesh.colors, place);
  }
  const std::vector<std::size_t> firsts = first_of_each_node(scene.instances);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const std::string place = place_of(scene, "instance", i, instance.name);
    check_handle(instance.mesh, scene.meshes.size(), false, place, "mesh");
    check_transform(instance.world_from_mesh, place, "world_from_mesh");
    const std::size_t first = firsts[i];
    if (scene.instances[first].world_from_mesh != instance.world_from_mesh)
      throw Error(place + ": is of node " + std::to_string(instance.node) + " as instance " +
                  std::to_string(first) + " is, but has another world_from_mesh");
  }
  for (std::size_t i = 0; i < scene.cameras.size(); ++i)
    check_camera(scene.cameras[i], place_of(scene, "camera", i, scene.cameras[i].name));
  for (std::size_t i = 0; i < scene.hit_boxes.size(); ++i) {
    const HitBox& box = scene.hit_boxes[i];
    const std::string place = place_of(scene, "hit box", i, box.name);
    check_finite(box.positions, place, "the position");
    check_triangles(box.triangles, box.positions.size(), place);
    check_transform(box.world_from_mesh, place, "world_from_mesh");
  }
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& light = scene.lights[i];
    const std::string place = place_of(scene, "light", i, light.name);
    check_punctual_light(light, place + ": ");
    check_transform(light.world_from_light, place, "world_from_light");
  }
  check_splats(scene);
  check_rig(scene);
  const std::string background =
      (scene.path.empty() ? "scene" : scene.path) + std::string(": background");
  const Vec3 sky = scene.background.color;
  if (!finite(sky)) throw Error(background + ": its colour is not finite");
  check_product({std::max({std::fabs(sky.x), std::fabs(sky.y), std::fabs(sky.z)})}, background,
                "its radiance");
  if (scene.background.type == BackgroundType::image) {
    check_image(scene.background.image, background);
    check_product({largest(scene.background.image.rgba_linear)}, background, "its radiance");
  }
}

Bounds scene_bounds(const Scene& scene) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Bounds bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, true};
  const auto include = [&](Vec3d p) {
    bounds.lower = {std::min(bounds.lower.x, p.x), std::min(bounds.lower.y, p.y),
                    std::min(bounds.lower.z, p.z)};
    bounds.upper = {std::max(bounds.upper.x, p.x), std::max(bounds.upper.y, p.y),
                    std::max(bounds.upper.z, p.z)};
    bounds.empty = false;
  };
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
    // Only vertices of triangles are seen.
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t vertex : triangle)
        include(transform_point(instance.world_from_mesh, to_double(mesh.positions[vertex])));
  }
  for (const SplatCloud& cloud : scene.splats)
    for (const Vec3 middle : cloud.positions)
      include(transform_point(cloud.world_from_splats, to_double(middle)));
  if (bounds.empty) return {};
  return bounds;
}

Bounds hit_box_bounds(const HitBox& box) {
  Scene alone;
  alone.meshes.push_back({"", box.positions, box.triangles, {}, {}, {}, -1});
  alone.instances.push_back({"", 0, box.world_from_mesh});
  return scene_bounds(alone);
}

bool is_inside(const HitBox& box, Vec3d point) {
  // A ray along +x. A triangle is crossed where the point lies in its shadow on the
  // y-z plane; edges belong to one of the two triangles that share them, since each is taken with
  // its lower end and without its upper one.
  bool inside = false;
  for (const auto& triangle : box.triangles) {
    Vec3d corner[3];
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] =
          transform_point(box.world_from_mesh, to_double(box.positions[triangle[k]])) - point;
    bool in_shadow = false;
    for (std::size_t k = 0; k < 3; ++k) {
      // Always from the lower end to the upper: the same numbers for both triangles of an edge.
      Vec3d a = corner[k], b = corner[(k + 1) % 3];
      if (a.y > b.y) std::swap(a, b);
      if (a.y <= 0 && 0 < b.y) in_shadow ^= a.z * b.y - a.y * b.z > 0;
    }
    if (!in_shadow) continue;
    const Vec3d normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (dot(normal, corner[0]) / normal.x > 0) inside = !inside;
  }
  return inside;
}

std::uint64_t triangle_count(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Instance& instance : scene.instances)
    count += scene.meshes[static_cast<std::size_t>(instance.mesh)].triangles.size();
  return count;
}

std::uint64_t splat_count(const Scene& scene) {
  std::uint64_t count = 0;
  for (const SplatCloud& cloud : scene.splats) count += cloud.positions.size();
  return count;
}

const Camera& find_camera(const Scene& scene, std::string_view name) {
  const std::string place = scene.path.empty() ? "scene" : scene.path;
  // Node names first: a camera under several nodes has one name of its own and several of those.
  for (std::string Camera::*kind : {&Camera::name, &Camera::data_name}) {
    std::string indices;
    std::size_t count = 0, found = 0;
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
      if (scene.cameras[i].*kind != name) continue;
      indices += (count++ == 0 ? "" : ", ") + std::to_string(i);
      found = i;
    }
    if (count > 1)
      throw Error(place + ": " + std::to_string(count) + " cameras are called \"" +
                  std::string(name) + "\": " + indices);
    if (count == 1) return scene.cameras[found];
  }
  std::string message = place + ": there is no camera \"" + std::string(name) + "\"; ";
  if (scene.cameras.empty()) throw Error(message + "the scene has none");
  message += "there are";
  for (std::size_t i = 0; i < scene.cameras.size(); ++i)
    message += (i == 0 ? " " : ", ") + std::to_string(i) + " \"" + scene.cameras[i].name + "\"";
  throw Error(message);
}

}  // namespace omma
