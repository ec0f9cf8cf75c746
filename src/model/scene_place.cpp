// Boxes of meshes and scenes, the origin to trace from, and warnings of what rounding does.
#include "model/scene_place.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "model/pose_check.h"

namespace omma {
namespace {

// A box farther from the origin than this many half sizes is traced from an origin of its own.
// Below, that would gain less than two bits.
constexpr double far_away = 4;

// Rounding by more than this fraction of the scene's half size is told.
constexpr double notable_fraction = 1e-6;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Bounds nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, true};

void include(Bounds& box, Vec3d p) {
  box.lower = {std::min(box.lower.x, p.x), std::min(box.lower.y, p.y), std::min(box.lower.z, p.z)};
  box.upper = {std::max(box.upper.x, p.x), std::max(box.upper.y, p.y), std::max(box.upper.z, p.z)};
  box.empty = false;
}

double largest(Vec3d v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

// Distance from zero of the interval, which is what its numbers were rounded for at least.
double nearest_to_zero(double lower, double upper) {
  return lower <= 0 && upper >= 0 ? 0 : std::min(std::fabs(lower), std::fabs(upper));
}

std::string text(const char* format, double a, double b = 0) {
  char buffer[300];
  std::snprintf(buffer, sizeof buffer, format, a, b);
  return buffer;
}

}  // namespace

Bounds vertex_bounds(const std::vector<Vec3>& positions) {
  Bounds box = nothing;
  if (positions.empty()) return box;
  Vec3 lower = positions.front(), upper = lower;
  for (const Vec3 p : positions) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  return {to_double(lower), to_double(upper), false};
}

Bounds mesh_bounds(const Mesh& mesh) {
  return mesh.triangles.empty() ? nothing : vertex_bounds(mesh.positions);
}

Bounds box_around(const Bounds& a, const Bounds& b) {
  if (b.empty) return a;
  if (a.empty) return b;
  Bounds both = a;
  include(both, b.lower);
  include(both, b.upper);
  return both;
}

Bounds placed_box(const Bounds& box, const Mat4& transform) {
  Bounds placed = nothing;
  if (box.empty) return placed;
  for (int corner = 0; corner < 8; ++corner)
    include(placed, transform_point(transform, {corner & 1 ? box.upper.x : box.lower.x,
                                                corner & 2 ? box.upper.y : box.lower.y,
                                                corner & 4 ? box.upper.z : box.lower.z}));
  return placed;
}

std::vector<Bounds> boxes_of_used_meshes(const Scene& scene) {
  std::vector<Bounds> boxes(scene.meshes.size(), nothing);
  for (const Instance& instance : scene.instances) {
    const auto m = static_cast<std::size_t>(instance.mesh);
    if (boxes[m].empty) boxes[m] = mesh_bounds(scene.meshes[m]);
  }
  return boxes;
}

bool is_too_far(const Bounds& box, Vec3d from) {
  return !box.empty &&
         !(std::max(largest(box.lower - from), largest(box.upper - from)) < most_geometry_m);
}

Bounds rough_scene_bounds(const Scene& scene) {
  const std::vector<Bounds> boxes = boxes_of_used_meshes(scene);
  Bounds all = nothing;
  for (const Instance& instance : scene.instances)
    all = box_around(
        all, placed_box(boxes[static_cast<std::size_t>(instance.mesh)], instance.world_from_mesh));
  for (const SplatCloud& cloud : scene.splats)
    all = box_around(all, placed_box(vertex_bounds(cloud.positions), cloud.world_from_splats));
  return all.empty ? Bounds{} : all;
}

double half_size_m(const Bounds& box) {
  return box.empty ? 0 : 0.5 * largest(box.upper - box.lower);
}

Vec3d origin_near(const Bounds& box) {
  if (box.empty) return {};
  const Vec3d middle = (box.lower + box.upper) * 0.5;
  const double half = half_size_m(box), distance = largest(middle);
  if (!(distance > far_away * half) || !std::isfinite(distance)) return {};
  const double step = std::exp2(std::floor(std::log2(std::max(half, distance * 0x1p-20))));
  const auto rounded = [&](double x) { return std::round(x / step) * step; };
  return {rounded(middle.x), rounded(middle.y), rounded(middle.z)};
}

std::vector<bool> instances_in_reach(const Scene& scene, const Placement& placement) {
  std::vector<Bounds> boxes;  // [mesh]
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    boxes.push_back(scene.meshes[m].triangles.empty() ? nothing
                                                      : vertex_bounds(positions_of(scene, placement, m)));
  std::vector<bool> is_in_reach;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Bounds& box = boxes[static_cast<std::size_t>(scene.instances[i].mesh)];
    is_in_reach.push_back(
        !box.empty && !is_too_far(placed_box(box, placement.world_from_mesh[i]), placement.origin_m));
  }
  return is_in_reach;
}

Placement placement_of(const Scene& scene) {
  Placement placement;
  for (const Instance& instance : scene.instances)
    placement.world_from_mesh.push_back(instance.world_from_mesh);
  placement.moves.resize(scene.instances.size(), 0);
  placement.shapes.resize(scene.meshes.size());
  const Bounds box = rough_scene_bounds(scene);
  placement.origin_m = origin_near(box);
  placement.half_size_m = half_size_m(box);
  return placement;
}

std::vector<std::string> place_warnings(const Scene& scene, const std::string& who) {
  const std::vector<Bounds> boxes = boxes_of_used_meshes(scene);
  const Bounds all = rough_scene_bounds(scene);
  const double half = half_size_m(all);
  const Vec3d origin = origin_near(all);
  double rounding = 0;
  std::size_t rounded = 0, unseen = 0;
  std::string first_unseen;
  for (const Instance& instance : scene.instances) {
    const Bounds& box = boxes[static_cast<std::size_t>(instance.mesh)];
    if (box.empty) continue;
    const double from_zero = std::max({nearest_to_zero(box.lower.x, box.upper.x),
                                       nearest_to_zero(box.lower.y, box.upper.y),
                                       nearest_to_zero(box.lower.z, box.upper.z)});
    // The mean stretch of all directions, exact where they are stretched alike.
    const double stretch = most_stretch(instance.world_from_mesh) / std::sqrt(3.0);
    const double off = float_rounding * from_zero * stretch;
    if (off > notable_fraction * half) ++rounded;
    rounding = std::max(rounding, off);
    if (!is_too_far(placed_box(box, instance.world_from_mesh), origin)) continue;
    if (unseen++ == 0) first_unseen = instance.name;
  }
  std::vector<std::string> warnings;
  if (unseen > 0)
    warnings.push_back("surfaces more than " + text("%.0e", most_geometry_m) +
                       " m away are not seen reliably (node \"" + first_unseen + "\"" +
                       (unseen > 1 ? " and " + std::to_string(unseen - 1) + " more" : "") + ")");
  if (rounded > 0)
    warnings.push_back(
        std::to_string(rounded) + " of " + std::to_string(scene.instances.size()) +
        " placed meshes lie so far from the origin of their own coordinates that single "
        "precision, in which " + who +
        text(", may have moved vertices by up to %.2g m, in a scene of %.3g m; coordinates near "
             "zero, placed by a node, would not be",
             rounding, 2 * half));
  return warnings;
}

}  // namespace omma
