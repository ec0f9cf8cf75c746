// Copies of poses, checked and relative to the tracing origin.
#include "world/traced_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "model/pose_check.h"
#include "model/scene_place.h"
#include "omma/error.h"

namespace omma {
namespace {

// How far from the tracing origin rays of the eye start at most, along any axis of the world.
double reach_m(const Mat4& pose, const EyeArrays& eye) {
  const double beside_origin = most_stretch(pose) * eye.most_offset_m;
  double reach = 0;
  for (int r = 0; r < 3; ++r) {
    double along = std::fabs(pose.m[r][3]) + beside_origin;
    for (int c = 0; c < 3; ++c) along += std::fabs(pose.m[r][c]) * eye.most_origin_m[c];
    reach = std::max(reach, along);
  }
  return reach;
}

// Within a scene rounding by this much is told: eyes look at things of centimetres.
constexpr double notable_m = 1e-3;
// From further away than this many half sizes a scene is seen as a whole, and rounding counts as a
// fraction of it.
constexpr double from_outside = 16, notable_fraction = 1e-4;

// Turns that were rounded, or put together of rounded ones, stretch by less.
constexpr double notable_stretch = 1e-2;
// From this many half sizes away all of a scene is within 0.4 degrees.
constexpr double far_outside = 300;

}  // namespace

std::string precision_warning(std::span<const Mat4> world_from_head, Vec3d origin_m,
                              double half_size_m) {
  if (!(half_size_m > 0)) return "";
  double worst = 0;
  std::size_t worst_pose = 0;
  for (std::size_t p = 0; p < world_from_head.size(); ++p) {
    const auto& m = world_from_head[p].m;
    const double distance =
        std::max({std::fabs(m[0][3] - origin_m.x), std::fabs(m[1][3] - origin_m.y),
                  std::fabs(m[2][3] - origin_m.z)});
    if (distance > worst) worst_pose = p;
    worst = std::max(worst, distance);
  }
  const double off = float_rounding * worst;
  const double notable =
      worst > from_outside * half_size_m ? notable_fraction * half_size_m : notable_m;
  if (!(off >= notable)) return "";
  char text[300];
  std::snprintf(text, sizeof text,
                "poses[%zu] lies %.3g m from the origin that the scene is traced from: single "
                "precision places rays and surfaces there within %.2g m",
                worst_pose, worst, off);
  return text;
}

std::string pose_slip(std::span<const Mat4> world_from_head, Vec3d origin_m, double half_size_m,
                      const std::vector<Camera>& cameras) {
  for (std::size_t p = 0; p < world_from_head.size(); ++p) {
    const auto& m = world_from_head[p].m;
    const Vec3d right{m[0][0], m[1][0], m[2][0]}, up{m[0][1], m[1][1], m[2][1]},
        back{m[0][2], m[1][2], m[2][2]};
    const double squares[3] = {dot(right, right), dot(up, up), dot(back, back)};
    const auto [least, most] = std::minmax_element(squares, squares + 3);
    const bool mirrored = dot(cross(right, up), back) < 0;
    const double skew =
        std::max({std::fabs(dot(right, up)), std::fabs(dot(up, back)), std::fabs(dot(back, right))});
    const std::string place = "poses[" + std::to_string(p) + "]";
    if (mirrored || std::sqrt(*most) > 1 + notable_stretch ||
        std::sqrt(*least) < 1 - notable_stretch || skew > notable_stretch * *most) {
      // The whole transform of a camera's node applies to its eye, as CompoundRay's files have it:
      // one that is as large along all axes is meant, a mirror or a stretch hardly.
      const bool is_camera = std::any_of(cameras.begin(), cameras.end(), [&](const Camera& camera) {
        for (int r = 0; r < 3; ++r)
          if (!std::equal(m[r], m[r] + 3, camera.world_from_camera.m[r])) return false;
        return true;
      });
      const bool is_even = skew <= notable_stretch * *most &&
                           std::sqrt(*least) > (1 - notable_stretch) * std::sqrt(*most);
      if (is_camera && is_even && !mirrored) continue;
      const std::string of = place + (is_camera ? ", of a camera of the scene," : "");
      if (mirrored) return of + " mirrors the head: its right is left; expected a turn";
      char stretches[80];
      std::snprintf(stretches, sizeof stretches, " by %.3g to %.3g", std::sqrt(*least),
                    std::sqrt(*most));
      return of + " stretches the head" + stretches +
             ", and where its ommatidia are; expected a turn and a place in metres";
    }
    const Vec3d there{m[0][3], m[1][3], m[2][3]};
    const double away = length(there - origin_m);
    if (half_size_m > 0 && away > far_outside * half_size_m &&
        length(there * 1e-3 - origin_m) < 2 * half_size_m) {
      char distances[120];
      std::snprintf(distances, sizeof distances, " lies %.3g m from a scene of %.3g m", away,
                    2 * half_size_m);
      return place + distances +
             ", where it is a speck; in millimetres it would be inside; expected metres";
    }
  }
  return "";
}

std::vector<Mat4> traced_poses(std::span<const Mat4> world_from_head, const EyeArrays& eye,
                               Vec3d origin_m) {
  std::vector<Mat4> poses(world_from_head.begin(), world_from_head.end());
  for (std::size_t p = 0; p < poses.size(); ++p) {
    Mat4& pose = poses[p];
    const std::string fault = pose_fault(pose);
    if (!fault.empty()) throw Error("poses[" + std::to_string(p) + "]: " + fault);
    pose.m[0][3] -= origin_m.x;
    pose.m[1][3] -= origin_m.y;
    pose.m[2][3] -= origin_m.z;
    const double reach = reach_m(pose, eye);
    if (reach < most_distance_m) continue;
    char distances[64];
    std::snprintf(distances, sizeof distances, "%.0e m of the scene, found up to %.3g m",
                  most_distance_m, reach);
    throw Error("poses[" + std::to_string(p) + "]: expected rays of the eye to start within " +
                distances + " from it (position, focal offset and aperture at this pose)");
  }
  return poses;
}

}  // namespace omma
