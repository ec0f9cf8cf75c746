// Eyes put together and taken apart: several on a head, some ommatidia of one.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "model/unit_axis.h"
#include "omma/error.h"
#include "omma/eye.h"
#include "optics/acceptance_hash.h"

namespace omma {
namespace {

std::string name_of(const Eye& eye) {
  return eye.path.empty() ? "eye" : eye.path;
}

struct ReceptorTypeHash {
  std::size_t operator()(const ReceptorType& t) const {
    std::uint64_t hash = std::hash<std::string>{}(t.name);
    const auto add = [&](double value) { hash = hash_combine(hash, std::hash<double>{}(value)); };
    for (const double value :
         {t.peak_wavelength_nm, t.microvillus_angle_rad, t.polarisation_sensitivity,
          t.absorption_per_m, t.length_m, t.right_rad, t.up_rad})
      add(value);
    for (const double value : t.wavelength_nm) add(value);
    for (const double value : t.sensitivity) add(value);
    return t.acceptance ? hash_combine(hash, AcceptanceHash{}(*t.acceptance)) : hash;
  }
};

// Indices of what an eye under construction holds already.
struct Known {
  std::unordered_map<Acceptance, std::int32_t, AcceptanceHash> acceptances;
  std::unordered_map<ReceptorType, std::int32_t, ReceptorTypeHash> receptor_types;
  std::unordered_set<std::string> columns;
};

// What an angular sensitivity becomes when its eye is seen in a mirror: right and left change.
Acceptance mirrored(Acceptance acceptance) {
  acceptance.major_angle_rad = -acceptance.major_angle_rad;
  if (acceptance.table != nullptr && !acceptance.table->up_rad.empty()) {
    auto table = std::make_shared<SensitivityTable>(*acceptance.table);
    const std::size_t columns = table->right_rad.size();
    std::reverse(table->right_rad.begin(), table->right_rad.end());
    for (double& right : table->right_rad) right = -right;
    for (std::size_t row = 0; row < table->up_rad.size(); ++row) {
      const auto begin = table->sensitivity.begin() + static_cast<std::ptrdiff_t>(row * columns);
      std::reverse(begin, begin + static_cast<std::ptrdiff_t>(columns));
    }
    acceptance.table = std::move(table);
  }
  return acceptance;
}

ReceptorType mirrored(ReceptorType type) {
  type.microvillus_angle_rad = -type.microvillus_angle_rad;
  type.right_rad = -type.right_rad;
  if (type.acceptance) type.acceptance = mirrored(*type.acceptance);
  return type;
}

void mirror_optics(Eye& eye) {
  for (Acceptance& acceptance : eye.acceptances) acceptance = mirrored(acceptance);
  for (ReceptorType& type : eye.receptor_types) type = mirrored(type);
}

void check_transform(const Mat4& t, const std::string& place) {
  const auto refuse = [&](const char* what) { throw Error(place + " must be " + what); };
  for (const auto& row : t.m)
    for (const double value : row)
      if (!std::isfinite(value)) refuse("finite");
  if (t.m[3][0] != 0 || t.m[3][1] != 0 || t.m[3][2] != 0 || t.m[3][3] != 1)
    refuse("affine (its last row 0 0 0 1)");
  if (!(std::fabs(determinant(t)) > 0)) refuse("invertible");
}

void move_eye(Eye& eye, const Mat4& t) {
  const double volume = determinant(t), scale = std::cbrt(std::fabs(volume));
  for (std::size_t i = 0; i < eye.size(); ++i) {
    // The ray origin position - axis * focal_offset must move with the eye, so the offset
    // stretches as the axis does.
    const Vec3d before = to_double(eye.axis[i]), axis = transform_vector(t, before);
    eye.position_m[i] = to_float(transform_point(t, to_double(eye.position_m[i])));
    eye.focal_offset_m[i] =
        static_cast<float>(eye.focal_offset_m[i] * (length(axis) / length(before)));
    eye.axis[i] = unit_axis(axis);
    eye.up[i] = unit_axis(transform_vector(t, to_double(eye.up[i])));
    eye.facet_diameter_m[i] = static_cast<float>(eye.facet_diameter_m[i] * scale);
    eye.aperture_diameter_m[i] = static_cast<float>(eye.aperture_diameter_m[i] * scale);
  }
  if (volume < 0) mirror_optics(eye);
}

// Columns of both by name; where one eye has none of a name, its ommatidia get NaN or "".
void append_columns(Eye& to, Known& known, const Eye& from) {
  const std::size_t before = to.size();
  std::unordered_map<std::string_view, const EyeColumn*> by_name;
  for (const EyeColumn& column : from.columns) {
    by_name.emplace(column.name, &column);
    if (known.columns.insert(column.name).second) {
      EyeColumn added{column.name, {}, {}};
      if (column.texts.empty())
        added.numbers.assign(before, std::numeric_limits<double>::quiet_NaN());
      else
        added.texts.assign(before, "");
      to.columns.push_back(std::move(added));
    }
  }
  for (EyeColumn& column : to.columns) {
    const auto named = by_name.find(column.name);
    const bool there = named != by_name.end();
    const EyeColumn* found = there ? named->second : nullptr;
    const bool text = column.numbers.empty() && (before > 0 || (there && found->numbers.empty()));
    if (there && text == found->texts.empty())
      throw Error(name_of(from) + ", column '" + column.name + "': expected " +
                  (text ? "texts" : "numbers") + " as in the eyes before");
    if (text && there)
      column.texts.insert(column.texts.end(), found->texts.begin(), found->texts.end());
    else if (text)
      column.texts.resize(before + from.size());
    else if (there)
      column.numbers.insert(column.numbers.end(), found->numbers.begin(), found->numbers.end());
    else
      column.numbers.resize(before + from.size(), std::numeric_limits<double>::quiet_NaN());
  }
}

template <typename Value>
void append(std::vector<Value>& to, const std::vector<Value>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

// Both validated, `to` perhaps empty.
void append_eye(Eye& to, Known& known, const Eye& from, std::int32_t eye_id) {
  append_columns(to, known, from);
  append(to.position_m, from.position_m);
  append(to.axis, from.axis);
  append(to.acceptance_angle_rad, from.acceptance_angle_rad);
  append(to.focal_offset_m, from.focal_offset_m);
  to.eye_id.resize(to.axis.size(), eye_id);
  append(to.up, from.up);
  append(to.facet_diameter_m, from.facet_diameter_m);
  append(to.aperture_diameter_m, from.aperture_diameter_m);
  std::vector<std::int32_t> acceptance, type;
  for (const Acceptance& a : from.acceptances) {
    const auto next = static_cast<std::int32_t>(to.acceptances.size());
    const auto [place, is_new] = known.acceptances.try_emplace(a, next);
    if (is_new) to.acceptances.push_back(a);
    acceptance.push_back(place->second);
  }
  for (const std::int32_t which : from.acceptance_of)
    to.acceptance_of.push_back(which < 0 ? -1 : acceptance[static_cast<std::size_t>(which)]);
  for (const ReceptorType& t : from.receptor_types) {
    const auto next = static_cast<std::int32_t>(to.receptor_types.size());
    const auto [place, is_new] = known.receptor_types.try_emplace(t, next);
    if (is_new) to.receptor_types.push_back(t);
    type.push_back(place->second);
  }
  const auto receptors = static_cast<std::int32_t>(to.receptor_type.size());
  if (to.first_receptor.empty()) to.first_receptor.push_back(0);
  for (std::size_t i = 1; i < from.first_receptor.size(); ++i)
    to.first_receptor.push_back(receptors + from.first_receptor[i]);
  for (const std::int32_t t : from.receptor_type)
    to.receptor_type.push_back(type[static_cast<std::size_t>(t)]);
}

}  // namespace

Eye merge_eyes(std::span<const PlacedEye> eyes) {
  if (eyes.empty()) throw Error("merge_eyes: there must be at least one eye");
  Eye head;
  Known known;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    Eye eye = eyes[e].eye;
    validate_eye(eye);
    check_transform(eyes[e].head_from_eye, "merge_eyes: head_from_eye of eye " + std::to_string(e) +
                                               " (" + name_of(eye) + ")");
    move_eye(eye, eyes[e].head_from_eye);
    append_eye(head, known, eye, static_cast<std::int32_t>(e));
    if (!eye.path.empty()) head.path += (head.path.empty() ? "" : " + ") + eye.path;
  }
  validate_eye(head);  // a transform may have carried a number out of the range of float
  return head;
}

Eye take_ommatidia(const Eye& eye, std::span<const std::int64_t> ommatidia) {
  Eye some;
  some.path = eye.path;
  some.acceptances = eye.acceptances;
  some.receptor_types = eye.receptor_types;
  for (const EyeColumn& column : eye.columns) some.columns.push_back({column.name, {}, {}});
  some.first_receptor.push_back(0);
  for (const std::int64_t index : ommatidia) {
    if (index < 0 || index >= static_cast<std::int64_t>(eye.size()))
      throw Error(name_of(eye) + ": expected ommatidia from 0 to " +
                  std::to_string(eye.size() - 1) + ", found " + std::to_string(index));
    const auto i = static_cast<std::size_t>(index);
    some.position_m.push_back(eye.position_m[i]);
    some.axis.push_back(eye.axis[i]);
    some.acceptance_angle_rad.push_back(eye.acceptance_angle_rad[i]);
    some.focal_offset_m.push_back(eye.focal_offset_m[i]);
    some.eye_id.push_back(eye.eye_id[i]);
    some.up.push_back(eye.up[i]);
    some.facet_diameter_m.push_back(eye.facet_diameter_m[i]);
    some.aperture_diameter_m.push_back(eye.aperture_diameter_m[i]);
    some.acceptance_of.push_back(eye.acceptance_of[i]);
    for (std::int32_t r = eye.first_receptor[i]; r < eye.first_receptor[i + 1]; ++r)
      some.receptor_type.push_back(eye.receptor_type[static_cast<std::size_t>(r)]);
    some.first_receptor.push_back(static_cast<std::int32_t>(some.receptor_type.size()));
    for (std::size_t c = 0; c < eye.columns.size(); ++c) {
      if (!eye.columns[c].numbers.empty())
        some.columns[c].numbers.push_back(eye.columns[c].numbers[i]);
      else
        some.columns[c].texts.push_back(eye.columns[c].texts[i]);
    }
  }
  validate_eye(some);
  return some;
}

Eye select_eye(const Eye& head, int eye_id) {
  std::vector<std::int64_t> members;
  for (std::size_t i = 0; i < head.size(); ++i)
    if (head.eye_id[i] == eye_id) members.push_back(static_cast<std::int64_t>(i));
  if (members.empty())
    throw Error(name_of(head) + ": no ommatidium has eye_id " + std::to_string(eye_id));
  return take_ommatidia(head, members);
}

}  // namespace omma
