// The brute-force reference renderer, see reference.h. Rules: glTF 2.0, sections 3.8 (textures) and
// 3.9 (materials), KHR_texture_transform with its rotation as Blender, three.js and the Khronos
// viewer read it (counter-clockwise in UV space as drawn, whose v axis points down),
// KHR_materials_unlit.
#include "reference.h"

#include <algorithm>
#include <cmath>

#include "test_scenes.h"

namespace omma::test {
namespace {

using Color4 = std::array<double, 4>;

struct Hit {
  double t = 0;
  std::array<double, 3> weight{};  // barycentric
  const ReferenceTriangle* triangle = nullptr;
  bool from_front = true;
  bool near_edge = false;  // within float arithmetic of an edge, inside or outside
  bool inside = true;
};

// Moeller and Trumbore 1997. A point this close to an edge is one that float arithmetic may put on
// the other side: transforms and intersection each round at 2^-24 of the distances involved, some
// ten times, and grazing incidence stretches it.
constexpr double position_error = 3e-6;

bool intersect(const ReferenceRay& ray, const ReferenceTriangle& triangle, Hit& hit) {
  const Vec3d e1 = triangle.corner[1] + triangle.corner[0] * -1.0;
  const Vec3d e2 = triangle.corner[2] + triangle.corner[0] * -1.0;
  const Vec3d normal = cross(e1, e2);
  const Vec3d p = cross(ray.direction, e2);
  const double det = dot(e1, p), area2 = length(normal);
  if (det == 0 || area2 == 0) return false;
  const Vec3d s = ray.origin + triangle.corner[0] * -1.0;
  const double u = dot(s, p) / det;
  const Vec3d q = cross(s, e1);
  const double v = dot(ray.direction, q) / det;
  hit.t = dot(e2, q) / det;
  hit.weight = {1 - u - v, u, v};
  hit.triangle = &triangle;
  hit.from_front = (dot(normal, ray.direction) < 0) != triangle.mirrored;
  const double cosine = std::fabs(dot(normal, ray.direction)) / area2;
  const double reach = std::fabs(hit.t) + length(ray.origin) + 1;
  hit.inside = u >= 0 && v >= 0 && u + v <= 1;
  const double sides[3] = {length(e2 + e1 * -1.0), length(e2), length(e1)};
  double distance = 1e300;  // to the nearest edge; negative outside
  for (std::size_t k = 0; k < 3; ++k)
    distance = std::min(distance, hit.weight[k] * area2 / sides[k]);
  hit.near_edge = std::fabs(distance) * cosine < position_error * reach || cosine < 1e-3;
  return hit.inside || (hit.near_edge && distance > -10 * position_error * reach / cosine);
}

double linear_from_srgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// `encoded`: 8-bit values as they are, over 255.
Color4 texel(const Image& image, long column, long row, bool encoded) {
  const auto at = 4 * static_cast<std::size_t>(row * image.width + column);
  if (!image.rgba_linear.empty()) {
    const float* p = &image.rgba_linear[at];
    return {p[0], p[1], p[2], p[3]};
  }
  const std::uint8_t* p = &image.rgba_srgb8[at];
  if (encoded) return {p[0] / 255.0, p[1] / 255.0, p[2] / 255.0, p[3] / 255.0};
  return {linear_from_srgb(p[0] / 255.0), linear_from_srgb(p[1] / 255.0),
          linear_from_srgb(p[2] / 255.0), p[3] / 255.0};
}

long wrap(Wrap mode, long i, long size) {
  if (mode == Wrap::clamp_to_edge) return std::clamp(i, 0L, size - 1);
  const long period = mode == Wrap::repeat ? size : 2 * size;
  const long j = ((i % period) + period) % period;
  return j < size ? j : period - 1 - j;
}

Color4 bilinear(const Image& image, double x, double y, Wrap wrap_u, Wrap wrap_v, bool encoded) {
  const double fx = std::floor(x - 0.5), fy = std::floor(y - 0.5);
  const double ax = x - 0.5 - fx, ay = y - 0.5 - fy;
  Color4 sum{};
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const Color4 c = texel(image, wrap(wrap_u, static_cast<long>(fx) + dx, image.width),
                             wrap(wrap_v, static_cast<long>(fy) + dy, image.height), encoded);
      const double w = (dx ? ax : 1 - ax) * (dy ? ay : 1 - ay);
      for (std::size_t k = 0; k < 4; ++k) sum[k] += w * c[k];
    }
  return sum;
}

// A texture read at a hit; white where there is none.
Color4 read(const Scene& scene, const TextureUse& use, const Hit& hit, bool& doubtful) {
  if (use.texture < 0) return {1, 1, 1, 1};
  const Mesh& mesh = *hit.triangle->mesh;
  const auto& texcoords = mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)];
  double u = 0, v = 0;
  if (!texcoords.empty())
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 uv = texcoords[mesh.triangles[hit.triangle->index][k]];
      u += hit.weight[k] * uv.x, v += hit.weight[k] * uv.y;
    }
  u *= use.scale.x, v *= use.scale.y;
  const double c = std::cos(use.rotation_rad), s = std::sin(use.rotation_rad);
  const double turned_u = c * u + s * v + use.offset.x, turned_v = -s * u + c * v + use.offset.y;
  const Texture& texture = scene.textures[static_cast<std::size_t>(use.texture)];
  const Image& image = scene.images[static_cast<std::size_t>(texture.image)];
  const double x = turned_u * image.width, y = turned_v * image.height;
  const bool encoded = scene.color_rule == ColorRule::compoundray;
  if (texture.filter == Filter::linear)
    return bilinear(image, x, y, texture.wrap_u, texture.wrap_v, encoded);
  // A border between texels is an edge like any other.
  if (std::fabs(x - std::round(x)) < 1e-3 || std::fabs(y - std::round(y)) < 1e-3) doubtful = true;
  return texel(image, wrap(texture.wrap_u, static_cast<long>(std::floor(x)), image.width),
               wrap(texture.wrap_v, static_cast<long>(std::floor(y)), image.height), encoded);
}

Color4 vertex_color(const Hit& hit) {
  const Mesh& mesh = *hit.triangle->mesh;
  Color4 color{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec4 c = mesh.colors[mesh.triangles[hit.triangle->index][k]];
    color[0] += hit.weight[k] * c.x, color[1] += hit.weight[k] * c.y;
    color[2] += hit.weight[k] * c.z, color[3] += hit.weight[k] * c.w;
  }
  return color;
}

// ColorRule::compoundray: opaque and seen from both sides whatever the material says.
Color4 shade_as_compoundray(const Scene& scene, const Material& material, const Hit& hit,
                            bool& doubtful) {
  const bool by_vertex = !hit.triangle->mesh->colors.empty();
  const Color4 shown =
      by_vertex ? vertex_color(hit) : read(scene, material.base_color_texture, hit, doubtful);
  const Vec4 f = material.base_color;
  const double factor[3] = {by_vertex ? 1 : f.x, by_vertex ? 1 : f.y, by_vertex ? 1 : f.z};
  Color4 color{0, 0, 0, 1};
  for (std::size_t k = 0; k < 3; ++k) color[k] = factor[k] * std::pow(shown[k], 2.2);
  return color;
}

// Radiance of a surface and how much of the ray it stops; 0 where it is invisible.
Color4 shade(const Scene& scene, const Hit& hit, bool& doubtful) {
  static const Material white;
  const Mesh& mesh = *hit.triangle->mesh;
  const Material& material =
      mesh.material < 0 ? white : scene.materials[static_cast<std::size_t>(mesh.material)];
  if (scene.color_rule == ColorRule::compoundray)
    return shade_as_compoundray(scene, material, hit, doubtful);
  if (!material.double_sided && !hit.from_front) return {0, 0, 0, 0};
  Color4 color = read(scene, material.base_color_texture, hit, doubtful);
  const Vec4 factor = material.base_color;
  const double factors[4] = {factor.x, factor.y, factor.z, factor.w};
  for (std::size_t k = 0; k < 4; ++k) color[k] *= factors[k];
  if (!mesh.colors.empty()) {
    const Color4 vertex = vertex_color(hit);
    for (std::size_t k = 0; k < 4; ++k) color[k] *= vertex[k];
  }
  if (!material.unlit) {
    const Color4 glow = read(scene, material.emissive_texture, hit, doubtful);
    color[0] += material.emissive.x * glow[0];
    color[1] += material.emissive.y * glow[1];
    color[2] += material.emissive.z * glow[2];
  }
  if (material.alpha_mode == AlphaMode::opaque) color[3] = 1;
  if (material.alpha_mode == AlphaMode::mask) {
    if (std::fabs(color[3] - material.alpha_cutoff) < 1e-4) doubtful = true;
    color[3] = color[3] >= material.alpha_cutoff ? 1 : 0;
  }
  return color;
}

}  // namespace

Reference make_reference(const Scene& scene) {
  Reference reference{&scene, scene.background, {}};
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      ReferenceTriangle triangle{{}, &mesh, i, determinant(instance.world_from_mesh) < 0};
      for (std::size_t k = 0; k < 3; ++k)
        triangle.corner[k] = transform_point(instance.world_from_mesh,
                                             to_double(mesh.positions[mesh.triangles[i][k]]));
      reference.triangles.push_back(triangle);
    }
  }
  return reference;
}

ReferenceRay axis_ray(const Mat4& world_from_head, const Eye& eye, std::size_t ommatidium) {
  const Vec3d axis = to_double(eye.axis[ommatidium]);
  const double offset = eye.focal_offset_m[ommatidium];
  const Vec3d turned = transform_vector(world_from_head, axis);
  return {transform_point(world_from_head, to_double(eye.position_m[ommatidium]) + axis * -offset),
          normalize(turned), offset * length(turned) / length(axis)};
}

Radiance background_radiance(const Background& background, Vec3d direction) {
  Radiance result;
  const double elevation = std::asin(std::clamp(direction.y, -1.0, 1.0));
  if (background.type == BackgroundType::constant)
    result.channel = {background.color.x, background.color.y, background.color.z};
  if (background.type == BackgroundType::simple_sky) {
    const double horizon[3] = {143 / 255.0 * 0.8, 179 / 255.0 * 0.8, 203 / 255.0 * 0.8};
    const double zenith[3] = {1 / 255.0, 31 / 255.0, 117 / 255.0};
    const double up = std::max(0.0, elevation / (pi / 2));
    for (std::size_t k = 0; k < 3; ++k)
      result.channel[k] = horizon[k] + up * (zenith[k] - horizon[k]);
  }
  if (background.type == BackgroundType::test_pattern) {
    const double least =
        std::min({std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)});
    if (least >= 0.01)
      result.channel = {(std::atan2(direction.z, direction.x) + pi) / (2 * pi),
                        (elevation + pi / 2) / pi, 0};
    if (std::fabs(least - 0.01) < 1e-5) result.doubtful = true;
  }
  if (background.type == BackgroundType::image) {
    const Image& image = background.image;
    const double azimuth = std::atan2(direction.x, -direction.z);
    const Color4 c =
        bilinear(image, (0.5 + azimuth / (2 * pi)) * image.width,
                 (0.5 - elevation / pi) * image.height, Wrap::repeat, Wrap::clamp_to_edge, false);
    result.channel = {c[0], c[1], c[2]};
  }
  return result;
}

Radiance reference_radiance(const Reference& reference, const ReferenceRay& ray) {
  std::vector<Hit> hits;
  for (const ReferenceTriangle& triangle : reference.triangles) {
    Hit hit;
    if (intersect(ray, triangle, hit) && hit.t > ray.near_m - 1e-4) hits.push_back(hit);
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.t < b.t; });
  Radiance result;
  double passed = 1, last_t = -1e300;
  for (const Hit& hit : hits) {
    bool doubtful = hit.near_edge || std::fabs(hit.t - ray.near_m) < 1e-5 ||
                    hit.t - last_t < 1e-5 * (1 + hit.t);  // order beyond float's resolution
    const Color4 color = shade(*reference.scene, hit, doubtful);
    // What back-face culling hides is no edge, unless the surface is seen edge on.
    const bool hidden = color[3] == 0 && !doubtful;
    if (!hidden) {
      result.doubtful |= doubtful;
      last_t = hit.t;
    }
    if (!hit.inside || hit.t < ray.near_m) continue;
    for (std::size_t k = 0; k < 3; ++k) result.channel[k] += passed * color[3] * color[k];
    passed *= 1 - color[3];
    if (passed <= 0) break;
  }
  const Radiance behind = background_radiance(reference.background, ray.direction);
  if (passed > 0) result.doubtful |= behind.doubtful;
  for (std::size_t k = 0; k < 3; ++k) result.channel[k] += passed * behind.channel[k];
  return result;
}

double sensitivity(Kernel kernel, double theta_rad, double acceptance_rad) {
  if (kernel == Kernel::gaussian)
    return std::exp2(-4 * theta_rad * theta_rad / (acceptance_rad * acceptance_rad));
  if (kernel == Kernel::pillbox) return theta_rad <= acceptance_rad / 2 ? 1 : 0;
  // A normal over all angles, full width `acceptance_rad`: what is turned by more than half a
  // circle comes round.
  double sum = 0;
  for (int turn = -20; turn <= 20; ++turn) {
    const double x = (theta_rad + 2 * pi * turn) / acceptance_rad;
    sum += std::exp2(-4 * x * x);
  }
  return sum / std::sin(theta_rad);
}

std::array<double, 3> reference_response(const Reference& reference, const Mat4& world_from_head,
                                         const Eye& eye, std::size_t ommatidium, Kernel kernel,
                                         int theta_steps, int phi_steps) {
  ReferenceRay ray = axis_ray(world_from_head, eye, ommatidium);
  const Vec3d axis = ray.direction;
  const double acceptance = eye.acceptance_angle_rad[ommatidium];
  std::array<double, 3> sum{};
  double total = 0;
  for (int i = 0; i < theta_steps; ++i) {
    const double theta = pi * (i + 0.5) / theta_steps;
    const double weight = sensitivity(kernel, theta, acceptance) * std::sin(theta);
    for (int j = 0; j < phi_steps; ++j) {
      ray.direction = direction_about(axis, theta, 2 * pi * (j + 0.5) / phi_steps);
      const Radiance radiance = reference_radiance(reference, ray);
      for (std::size_t k = 0; k < 3; ++k) sum[k] += weight * radiance.channel[k];
      total += weight;
    }
  }
  for (double& s : sum) s /= total;
  return sum;
}

}  // namespace omma::test
