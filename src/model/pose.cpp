// Poses from a position and a quaternion, or from a position and a point to look at.
#include "omma/pose.h"

#include <cmath>
#include <string>

#include "model/text.h"
#include "model/transform.h"
#include "omma/error.h"

namespace omma {
namespace {

bool finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::string text(Vec3d v) {
  return "(" + short_text(v.x) + ", " + short_text(v.y) + ", " + short_text(v.z) + ")";
}

void check_finite(const char* function, const char* argument, Vec3d v) {
  if (!finite(v))
    throw Error(std::string(function) + ": " + argument + " must be finite, is " + text(v));
}

// The transform whose columns are the head's right, up and back in the world.
Mat4 from_columns(Vec3d right, Vec3d up, Vec3d back, Vec3d position) {
  Mat4 t;
  const Vec3d columns[4] = {right, up, back, position};
  for (int j = 0; j < 4; ++j) {
    t.m[0][j] = columns[j].x;
    t.m[1][j] = columns[j].y;
    t.m[2][j] = columns[j].z;
  }
  return t;
}

// A vector scaled so that its largest component is 1: its length then neither overflows nor
// vanishes. Zero stays zero.
Vec3d scaled_to_one(Vec3d v) {
  const double largest = std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
  return largest > 0 ? Vec3d{v.x / largest, v.y / largest, v.z / largest} : v;
}

}  // namespace

Mat4 pose_from_quaternion(Vec3d position_m, double x, double y, double z, double w) {
  check_finite("pose_from_quaternion", "position", position_m);
  const double largest =
      std::fmax(std::fmax(std::fabs(x), std::fabs(y)), std::fmax(std::fabs(z), std::fabs(w)));
  const bool finite_parts =
      std::isfinite(x) && std::isfinite(y) && std::isfinite(z) && std::isfinite(w);
  if (!finite_parts || !(largest > 0))
    throw Error(
        "pose_from_quaternion: the quaternion (x, y, z, w) must be finite and not zero, is (" +
        short_text(x) + ", " + short_text(y) + ", " + short_text(z) + ", " + short_text(w) + ")");
  x /= largest;
  y /= largest;
  z /= largest;
  w /= largest;
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  x /= norm;
  y /= norm;
  z /= norm;
  w /= norm;
  return transform_of({position_m.x, position_m.y, position_m.z}, {x, y, z, w}, {1, 1, 1});
}

Mat4 look_at(Vec3d position_m, Vec3d target_m, Vec3d up) {
  check_finite("look_at", "position", position_m);
  check_finite("look_at", "target", target_m);
  check_finite("look_at", "up", up);
  const Vec3d away = scaled_to_one(position_m - target_m);
  if (!(length(away) > 0))
    throw Error("look_at: the target must not be the position, both are " + text(position_m));
  const Vec3d back = normalize(away);
  const Vec3d up_scaled = scaled_to_one(up);
  const Vec3d right = cross(up_scaled, back);
  // Closer to the view than 1e-9 rad, rounding would choose the roll.
  if (!(length(right) > 1e-9 * length(up_scaled)))
    throw Error("look_at: up must not be zero or along the view, is " + text(up) +
                " for a view along " + text(back * -1.0));
  const Vec3d right_unit = normalize(right);
  return from_columns(right_unit, cross(back, right_unit), back, position_m);
}

}  // namespace omma
