// Eyes as values: checking them, what fills a gap, and how closely their axes lie.
#include "omma/eye.h"

#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <unordered_set>

#include "model/nearest_axis.h"
#include "model/unit_axis.h"
#include "omma/error.h"
#include "threads/parallel.h"

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

void check_length(const Eye& eye, std::size_t i, const char* what, float length_m) {
  if (!(length_m >= 0) || !std::isfinite(length_m))
    fail_at(eye, i,
            std::string("the ") + what + " must be finite and not negative, is " +
                std::to_string(length_m) + " m");
}

// Arrays that may be left out get an entry for each ommatidium.
void fill_gaps(Eye& eye) {
  const std::size_t count = eye.size();
  if (eye.acceptance_angle_rad.empty()) eye.acceptance_angle_rad.resize(count, 0.0f);
  if (eye.up.empty()) eye.up.resize(count);
  if (eye.facet_diameter_m.empty()) eye.facet_diameter_m.resize(count, 0.0f);
  if (eye.aperture_diameter_m.empty()) eye.aperture_diameter_m.resize(count, 0.0f);
  if (eye.acceptance_of.empty()) eye.acceptance_of.resize(count, -1);
  if (eye.first_receptor.empty()) eye.first_receptor.resize(count + 1, 0);
}

// The up vector across the axis; a given one that is already both is left as it is, to the bit.
Vec3 upright(const Eye& eye, std::size_t i) {
  const Vec3 given = eye.up[i];
  if (given.x == 0 && given.y == 0 && given.z == 0) return default_up(eye.axis[i]);
  if (!finite(given)) fail_at(eye, i, "the up vector must be finite");
  const Vec3d axis = normalize(to_double(eye.axis[i]));
  const Vec3d unit = normalize(to_double(unit_axis(to_double(given))));
  const double along = dot(unit, axis);
  if (std::fabs(along) <= 2e-7) return unit_axis(to_double(given));
  const Vec3d across = unit - axis * along;
  if (!(length(across) > 1e-6)) fail_at(eye, i, "the up vector must not be along the axis");
  return to_float(normalize(across));
}

void check_receptors(const Eye& eye) {
  const auto expect = [&](bool good, const std::string& what) {
    if (!good) throw Error(name_of(eye) + ": " + what);
  };
  for (std::size_t t = 0; t < eye.receptor_types.size(); ++t)
    validate_receptor_type(eye.receptor_types[t],
                           name_of(eye) + ", receptor type " + std::to_string(t));
  expect(eye.first_receptor.size() == eye.size() + 1,
         "first_receptor must have one entry more than axis (" + std::to_string(eye.size() + 1) +
             "), has " + std::to_string(eye.first_receptor.size()));
  expect(eye.first_receptor.front() == 0, "first_receptor must begin with 0");
  for (std::size_t i = 0; i < eye.size(); ++i)
    expect(eye.first_receptor[i] <= eye.first_receptor[i + 1],
           "first_receptor must not decrease, does after ommatidium " + std::to_string(i));
  expect(static_cast<std::size_t>(eye.first_receptor.back()) == eye.receptor_type.size(),
         "first_receptor must end with the number of receptors (" +
             std::to_string(eye.receptor_type.size()) + "), ends with " +
             std::to_string(eye.first_receptor.back()));
  for (const std::int32_t type : eye.receptor_type)
    expect(type >= 0 && static_cast<std::size_t>(type) < eye.receptor_types.size(),
           "receptor_type must be from 0 to the number of types less one (" +
               std::to_string(eye.receptor_types.size()) + " types), is " + std::to_string(type));
}

void check_columns(const Eye& eye) {
  std::unordered_set<std::string_view> names;
  for (const EyeColumn& column : eye.columns) {
    const std::string place = name_of(eye) + ", column '" + column.name + "'";
    if (column.name.empty()) throw Error(place + ": a column must have a name");
    if (!column.numbers.empty() && !column.texts.empty())
      throw Error(place + ": must hold numbers or texts, holds both");
    const std::size_t size = column.texts.empty() ? column.numbers.size() : column.texts.size();
    if (size != eye.size())
      throw Error(place + ": must have as many entries as there are ommatidia (" +
                  std::to_string(eye.size()) + "), has " + std::to_string(size));
    if (!names.insert(column.name).second) throw Error(place + ": the name is there twice");
  }
}

}  // namespace

void validate_eye(Eye& eye) {
  fill_gaps(eye);
  check_size(eye, "position_m", eye.position_m.size());
  check_size(eye, "acceptance_angle_rad", eye.acceptance_angle_rad.size());
  check_size(eye, "focal_offset_m", eye.focal_offset_m.size());
  check_size(eye, "eye_id", eye.eye_id.size());
  check_size(eye, "up", eye.up.size());
  check_size(eye, "facet_diameter_m", eye.facet_diameter_m.size());
  check_size(eye, "aperture_diameter_m", eye.aperture_diameter_m.size());
  check_size(eye, "acceptance_of", eye.acceptance_of.size());
  if (eye.size() == 0) throw Error(name_of(eye) + ": an eye must have at least one ommatidium");
  std::vector<float> mean_width_rad(eye.acceptances.size(), 0.0f);  // where asked for
  for (std::size_t k = 0; k < eye.acceptances.size(); ++k) {
    check_cancelled();
    validate_acceptance(eye.acceptances[k], name_of(eye) + ", acceptance " + std::to_string(k));
  }
  constexpr auto full_turn = static_cast<float>(2 * pi);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    check_cancelled();
    if (!finite(eye.position_m[i])) fail_at(eye, i, "the position must be finite");
    const std::int32_t which = eye.acceptance_of[i];
    if (which < -1 || which >= static_cast<std::int32_t>(eye.acceptances.size()))
      fail_at(eye, i,
              "acceptance_of must be -1 or an index into acceptances (" +
                  std::to_string(eye.acceptances.size()) + "), is " + std::to_string(which));
    float& acceptance = eye.acceptance_angle_rad[i];
    if (which >= 0 && acceptance == 0) {
      float& width = mean_width_rad[static_cast<std::size_t>(which)];
      if (width == 0)
        width = static_cast<float>(
            mean_acceptance_width_rad(eye.acceptances[static_cast<std::size_t>(which)]));
      acceptance = width;
    }
    if (!(acceptance >= 0 && acceptance <= full_turn))
      fail_at(eye, i,
              "the acceptance angle must be from 0 to 2 pi rad, is " + std::to_string(acceptance));
    check_length(eye, i, "focal offset", eye.focal_offset_m[i]);
    check_length(eye, i, "facet diameter", eye.facet_diameter_m[i]);
    check_length(eye, i, "aperture diameter", eye.aperture_diameter_m[i]);
    if (eye.eye_id[i] < 0)
      fail_at(eye, i, "eye_id must not be negative, is " + std::to_string(eye.eye_id[i]));
    if (!finite(eye.axis[i])) fail_at(eye, i, "the axis must be finite");
    const Vec3 unit = unit_axis(to_double(eye.axis[i]));
    if (!(dot(unit, unit) > 0)) fail_at(eye, i, "the axis must not be zero");
    eye.axis[i] = unit;
    eye.up[i] = upright(eye, i);
  }
  check_receptors(eye);
  check_columns(eye);
}

// +Y turned with the axis from the horizon; at the zenith the limit from ahead.
Vec3 default_up(Vec3 axis) {
  const Vec3d a = normalize(to_double(axis));
  const Vec3d across = Vec3d{0, 1, 0} - a * a.y;
  if (length(across) > 1e-6) return to_float(normalize(across));
  const Vec3d back{0, 0, a.y > 0 ? 1.0 : -1.0};
  return to_float(normalize(back - a * dot(back, a)));
}

Acceptance acceptance_at(const Eye& eye, std::size_t ommatidium) {
  const std::int32_t which = eye.acceptance_of[ommatidium];
  if (which >= 0) return eye.acceptances[static_cast<std::size_t>(which)];
  Acceptance gaussian;
  gaussian.width_rad = eye.acceptance_angle_rad[ommatidium];
  return gaussian;
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
    parallel_for(std::size_t{0}, ommatidia.size(), [&](std::size_t k) {
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
