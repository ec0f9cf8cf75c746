// The slow search, see portable_rays.h: every triangle, in double precision (Moeller and Trumbore
// 1997), with what rounding may change put as a distance.
#include "portable_rays.h"

#include <cmath>

#include "physics/surface/scene_search.h"

namespace omma::test {
namespace {

struct Crossed {
  bool crosses = false;
  double t_m = 0;
  double inside_m = 0;  // how far inside the nearest edge, across the ray; negative outside
  double facing = 0;    // cosine between ray and plane's normal
};

Crossed cross_exactly(const FlatTriangle& triangle, Vec3d origin, Vec3d direction) {
  const Vec3d a = triangle.corner[0] - origin, b = triangle.corner[1] - origin,
              c = triangle.corner[2] - origin;
  const Vec3d normal = cross(b - a, c - a);
  const double area = length(normal), along = dot(direction, normal);
  Crossed crossed;
  if (!(area > 0) || along == 0) return crossed;
  crossed.crosses = true;
  crossed.t_m = dot(a, normal) / along;
  crossed.facing = along / (area * length(direction));
  crossed.inside_m = std::numeric_limits<double>::infinity();
  const double side = along > 0 ? 1 : -1;
  const Vec3d corner[3] = {a, b, c};
  for (std::size_t i = 0; i < 3; ++i) {
    // The distance of the ray from the edge's line, signed, by the plane through both that is along
    // the ray.
    const Vec3d p = corner[i], edge = corner[(i + 1) % 3] - p;
    const Vec3d across = cross(edge, direction);
    const double width = length(across);
    if (width > 0) crossed.inside_m = std::min(crossed.inside_m, side * dot(p, across) / width);
  }
  return crossed;
}

}  // namespace

std::vector<FlatTriangle> flatten(const PortableTracer& tracer) {
  const SceneSearch<Lanes<1, 1>> search{tracer.scene_view, &tracer.view};
  std::vector<FlatTriangle> triangles;
  for (std::size_t i = 0; i < tracer.layout.instances.size(); ++i) {
    const PlacedInstance& instance = tracer.layout.instances[i];
    const Mesh& mesh = tracer.scene->meshes[static_cast<std::size_t>(instance.mesh)];
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      FlatTriangle flat{
          {}, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(i), instance.is_shared};
      const Triangle corners =
          search.corners(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k));
      for (std::size_t v = 0; v < 3; ++v) flat.corner[v] = corners.corner[v];
      triangles.push_back(flat);
    }
  }
  return triangles;
}

std::string check_hit(const std::vector<FlatTriangle>& triangles, const TestRay& ray,
                      const TestHit& hit, double slack) {
  const Vec3d origin = to_double(ray.origin), direction = to_double(ray.direction);
  // Numbers in the search are as large as the places of what is near the ray, and as its origin.
  const auto slack_m = [&](const FlatTriangle& triangle) {
    double size = length(origin);
    for (const Vec3d& corner : triangle.corner) size = std::max(size, length(corner));
    return slack * size;
  };
  const double speed = length(direction), infinity = std::numeric_limits<double>::infinity();
  // Distances along a ray are off by that much more where it grazes the triangle.
  const auto slack_t = [&](const FlatTriangle& triangle, const Crossed& crossed) {
    return slack_m(triangle) / (std::fabs(crossed.facing) * speed);
  };
  double found_t = infinity, found_slack = 0;
  if (hit.placed != none) {
    const auto same = [&](const FlatTriangle& t) {
      return t.triangle == hit.triangle && t.placed == hit.placed;
    };
    const auto at = std::find_if(triangles.begin(), triangles.end(), same);
    if (at == triangles.end()) return "a triangle that is not there";
    const Crossed crossed = cross_exactly(*at, origin, direction);
    if (!crossed.crosses) return "a triangle that cannot be hit";
    if (crossed.inside_m < -slack_m(*at))
      return "missed by " + std::to_string(-crossed.inside_m / slack_m(*at)) +
             " of what is allowed";
    found_t = static_cast<double>(hit.t_m);
    found_slack = slack_t(*at, crossed);
    if (!(std::fabs(found_t - crossed.t_m) <= found_slack))
      return "the distance is " + std::to_string(found_t) + ", not " + std::to_string(crossed.t_m);
    const bool from_behind = hit.normal[0] * ray.direction.x + hit.normal[1] * ray.direction.y +
                                 hit.normal[2] * ray.direction.z >
                             0;
    if (!at->is_shared && std::fabs(crossed.facing) > 1e-3 && from_behind != (crossed.facing > 0))
      return "the wrong side";
  }
  for (const FlatTriangle& triangle : triangles) {
    const Crossed crossed = cross_exactly(triangle, origin, direction);
    if (!crossed.crosses || crossed.inside_m < slack_m(triangle)) continue;
    const double t_slack = slack_t(triangle, crossed);
    if (crossed.t_m < static_cast<double>(ray.t_near_m) + t_slack ||
        crossed.t_m > static_cast<double>(ray.t_far_m) - t_slack)
      continue;
    if (crossed.t_m + t_slack + found_slack < found_t)
      return "found " + std::to_string(found_t) + ", but " + std::to_string(triangle.triangle) +
             " of " + std::to_string(triangle.placed) + " is at " + std::to_string(crossed.t_m);
  }
  return "";
}

std::size_t expect_as_brute_force(const PortableTracer& tracer, const std::vector<TestRay>& rays,
                                  double slack) {
  const std::vector<FlatTriangle> triangles = flatten(tracer);
  const std::vector<TestHit> hits = hits_of(tracer, rays);
  std::size_t wrong = 0, met = 0;
  std::string first;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::string what = check_hit(triangles, rays[i], hits[i], slack);
    if (!what.empty() && wrong++ == 0) first = "ray " + std::to_string(i) + ": " + what;
    met += hits[i].placed != none;
  }
  EXPECT_EQ(wrong, 0u) << "of " << rays.size() << "; " << first;
  return met;
}

}  // namespace omma::test
