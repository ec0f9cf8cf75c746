// Eyes as values: checking them, putting several on a head, taking one from it, and how closely
// their axes lie.
#include "omma/eye.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "model/nearest_axis.h"
#include "model/unit_axis.h"
#include "omma/error.h"

namespace omma {
namespace {

std::string name_of(const Eye& eye) {
  return eye.path.empty() ? "eye" : eye.path;
}

bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_size(const Eye& eye, const char* array, std::size_t size) {
  if (size != eye.size())
    throw Error(name_of(eye) + ": " + array + " must have as many entries as axis (" +
                std::to_string(eye.size()) + "), has " + std::to_string(size));
}

[[noreturn]] void fail_at(const Eye& eye, std::size_t i, const std::string& what) {
  throw Error(name_of(eye) + ", ommatidium " + std::to_string(i) + ": " + what);
}

void append(Eye& to, const Eye& from, std::size_t i, std::int32_t eye_id) {
  to.position_m.push_back(from.position_m[i]);
  to.axis.push_back(from.axis[i]);
  to.acceptance_angle_rad.push_back(from.acceptance_angle_rad[i]);
  to.focal_offset_m.push_back(from.focal_offset_m[i]);
  to.eye_id.push_back(eye_id);
}

}  // namespace

void validate_eye(Eye& eye) {
  check_size(eye, "position_m", eye.position_m.size());
  check_size(eye, "acceptance_angle_rad", eye.acceptance_angle_rad.size());
  check_size(eye, "focal_offset_m", eye.focal_offset_m.size());
  check_size(eye, "eye_id", eye.eye_id.size());
  if (eye.size() == 0) throw Error(name_of(eye) + ": an eye must have at least one ommatidium");
  constexpr auto full_turn = static_cast<float>(2 * pi);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    if (!finite(eye.position_m[i])) fail_at(eye, i, "the position must be finite");
    const float acceptance = eye.acceptance_angle_rad[i];
    if (!(acceptance >= 0 && acceptance <= full_turn))
      fail_at(eye, i,
              "the acceptance angle must be from 0 to 2 pi rad, is " + std::to_string(acceptance));
    const float offset = eye.focal_offset_m[i];
    if (!(offset >= 0) || !std::isfinite(offset))
      fail_at(
          eye, i,
          "the focal offset must be finite and not negative, is " + std::to_string(offset) + " m");
    if (eye.eye_id[i] < 0)
      fail_at(eye, i, "eye_id must not be negative, is " + std::to_string(eye.eye_id[i]));
    if (!finite(eye.axis[i])) fail_at(eye, i, "the axis must be finite");
    const Vec3 unit = unit_axis(to_double(eye.axis[i]));
    if (!(dot(unit, unit) > 0)) fail_at(eye, i, "the axis must not be zero");
    eye.axis[i] = unit;
  }
}

Eye merge_eyes(std::span<const PlacedEye> eyes) {
  if (eyes.empty()) throw Error("merge_eyes: there must be at least one eye");
  Eye head;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    Eye eye = eyes[e].eye;
    validate_eye(eye);
    const Mat4& t = eyes[e].head_from_eye;
    const auto refuse = [&](const char* what) {
      throw Error("merge_eyes: head_from_eye of eye " + std::to_string(e) + " (" + name_of(eye) +
                  ") must be " + what);
    };
    for (const auto& row : t.m)
      for (const double value : row)
        if (!std::isfinite(value)) refuse("finite");
    if (t.m[3][0] != 0 || t.m[3][1] != 0 || t.m[3][2] != 0 || t.m[3][3] != 1)
      refuse("affine (its last row 0 0 0 1)");
    if (!(std::fabs(determinant(t)) > 0)) refuse("invertible");
    for (std::size_t i = 0; i < eye.size(); ++i) {
      // The ray origin position - axis * focal_offset must move with the eye, so the offset
      // stretches as the axis does.
      const Vec3d axis = transform_vector(t, to_double(eye.axis[i]));
      eye.position_m[i] = to_float(transform_point(t, to_double(eye.position_m[i])));
      eye.focal_offset_m[i] = static_cast<float>(eye.focal_offset_m[i] * length(axis));
      eye.axis[i] = unit_axis(axis);
      append(head, eye, i, static_cast<std::int32_t>(e));
    }
    if (!eye.path.empty()) head.path += (head.path.empty() ? "" : " + ") + eye.path;
  }
  validate_eye(head);  // a transform may have carried a number out of the range of float
  return head;
}

Eye select_eye(const Eye& head, int eye_id) {
  Eye eye;
  eye.path = head.path;
  for (std::size_t i = 0; i < head.size(); ++i)
    if (head.eye_id[i] == eye_id) append(eye, head, i, eye_id);
  if (eye.size() == 0)
    throw Error(name_of(head) + ": no ommatidium has eye_id " + std::to_string(eye_id));
  return eye;
}

std::vector<float> interommatidial_angle_rad(const Eye& eye) {
  std::map<std::int32_t, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < eye.size(); ++i) members[eye.eye_id[i]].push_back(i);
  std::vector<float> angle_rad(eye.size(), 0.0f);
  for (const auto& member : members) {
    const std::vector<std::size_t>& ommatidia = member.second;
    std::vector<Vec3d> axes;
    axes.reserve(ommatidia.size());
    for (const std::size_t i : ommatidia) axes.push_back(normalize(to_double(eye.axis[i])));
    const AxisTree tree(axes);
    tbb::parallel_for(std::size_t{0}, ommatidia.size(), [&](std::size_t k) {
      // Seven, as the ommatidium itself is among them unless others share its axis.
      const NearestAxes near = tree.nearest(axes[k], 7);
      double sum = 0;
      int count = 0;
      for (std::size_t n = 0; n < static_cast<std::size_t>(near.count) && count < 6; ++n) {
        if (near.index[n] == static_cast<std::int32_t>(k)) continue;
        sum += angle_from_chord_squared(near.chord_squared[n]);
        ++count;
      }
      if (count > 0) angle_rad[ommatidia[k]] = static_cast<float>(sum / count);
    });
  }
  return angle_rad;
}

Vec2 azimuth_elevation_rad(Vec3 direction) {
  const Vec3d d = to_double(direction);
  double azimuth = std::atan2(d.x, -d.z);
  if (azimuth <= -pi) azimuth = pi;  // from an x of -0
  const double elevation = std::atan2(d.y, std::hypot(d.x, d.z));
  return {static_cast<float>(azimuth), static_cast<float>(elevation)};
}

}  // namespace omma
