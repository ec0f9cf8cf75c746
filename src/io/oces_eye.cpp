// One eye of an OCES file in its own frame: sites become ommatidia with an axis, a focal point and
// an acceptance angle.
#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include "io/csv_text.h"
#include "io/oces_file.h"
#include "model/unit_axis.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

namespace {

const OcesProperty* find(const OcesProperties& properties, const char* name) {
  const auto found = properties.find(name);
  return found == properties.end() ? nullptr : &found->second;
}

Vec3d vector_value(const OcesProperty& property, const OcesSite& site) {
  if (property.components != 3)
    throw Error(property.place + ": expected three numbers for an ommatidium, found " +
                std::to_string(property.components));
  std::array<double, 3> v{};
  oces_value(property, site, v.data());
  return {v[0], v[1], v[2]};
}

double scalar_or(const OcesProperties& properties, const char* name, const OcesSite& site,
                 double otherwise) {
  const OcesProperty* property = find(properties, name);
  return property == nullptr ? otherwise : oces_scalar(*property, site);
}

Vec3d vector_or(const OcesProperties& properties, const char* name, const OcesSite& site,
                Vec3d otherwise) {
  const OcesProperty* property = find(properties, name);
  return property == nullptr ? otherwise : vector_value(*property, site);
}

OcesProperties read_properties(OcesFile& file, const json& eye, const std::string& type,
                               const std::string& place) {
  OcesProperties properties;
  const json* list = oces_member(eye, "ommatidialProperties");
  if (list == nullptr) return properties;
  if (!list->is_object()) throw Error(place + ": ommatidialProperties: expected an object");
  for (const auto& [name, index] : list->items())
    properties.emplace(
        name, read_oces_property(file, index, type != "SPHERICAL", type != "POINT_OMMATIDIAL",
                                 place + ": ommatidialProperties." + name));
  return properties;
}

std::vector<OcesSite> point_sites(const OcesProperties& properties) {
  std::size_t count = 1;
  const OcesProperty* counted = nullptr;
  for (const auto& [name, property] : properties) {
    if (property.coarse) continue;
    const std::size_t elements = oces_element_count(property);
    if (counted != nullptr && elements != count)
      throw Error(property.place + ": expected as many ommatidia as " + counted->place + " (" +
                  std::to_string(count) + "), found " + std::to_string(elements));
    counted = &property;
    count = elements;
  }
  std::vector<OcesSite> sites(count);
  for (std::size_t i = 0; i < count; ++i) {
    sites[i].vertex = {static_cast<std::uint32_t>(i), 0, 0};
    sites[i].position_m = vector_or(properties, "POSITION", sites[i], {0, 0, 0});
    sites[i].normal = {0, 0, 1};
  }
  return sites;
}

// V of the standard: the eye's Y as far as it is across W; where W is along Y, W x X.
Vec3 local_up(Vec3 w) {
  const Vec3 up = default_up({-w.x, w.y, -w.z});  // the same rule in our frame
  return {-up.x, up.y, -up.z};
}

// Along what an ommatidium looks, before its focal point shears it.
Vec3 orientation(const OcesProperties& properties, const OcesSite& site, bool points,
                 const std::string& place) {
  Vec3d w = points ? vector_or(properties, "ORIENTATION", site, {0, 0, 1}) : site.normal;
  if (!points) {
    w = w + vector_or(properties, "RELATIVE_ORIENTATION", site, {0, 0, 0});
    w = vector_or(properties, "ABSOLUTE_ORIENTATION", site, w);
  }
  const Vec3 unit = unit_axis(w);
  if (!(dot(unit, unit) > 0)) throw Error(place + ": its orientation must not be zero");
  return unit;
}

// A cone whose focal point is not behind the middle of its facet. It looks along the line through
// both; its widths in the plane of the shear and across it become those of an elliptical Gaussian.
void shear(Eye& eye, const Vec3d& offset_m, double diameter_m) {
  const Vec3d w = normalize(to_double(eye.axis.back())), v = normalize(to_double(eye.up.back())),
              u = cross(v, w);
  const Vec3d focus = u * offset_m.x + v * offset_m.y + w * offset_m.z;
  const Vec3d axis = normalize(focus * -1.0);
  const double aside = std::hypot(offset_m.x, offset_m.y), back = -offset_m.z;
  const double radius = diameter_m / 2;
  const double across = 2 * std::atan(radius / length(focus));
  const double along = std::atan((radius - aside) / back) + std::atan((radius + aside) / back);
  // The shear's direction in the plane of the facet, and the one across it, seen along the axis.
  const Vec3d sheared = normalize(cross(cross(axis, u * offset_m.x + v * offset_m.y), axis));
  const Vec3d level = cross(axis, sheared);
  eye.axis.back() = unit_axis(axis);
  eye.up.back() = local_up(eye.axis.back());
  eye.focal_offset_m.back() = static_cast<float>(length(focus));
  Acceptance acceptance;
  acceptance.width_rad = std::max(along, across);
  acceptance.minor_width_rad = std::min(along, across);
  // Azimuths grow from up towards right = axis x up.
  const Vec3d up = to_double(eye.up.back()), right = cross(axis, up);
  const Vec3d major = along > across ? sheared : level;
  acceptance.major_angle_rad = std::atan2(dot(major, right), dot(major, up));
  eye.acceptance_angle_rad.back() = 0;  // found from the acceptance
  eye.acceptance_of.back() = static_cast<std::int32_t>(eye.acceptances.size());
  eye.acceptances.push_back(acceptance);
}

// What Omma wrote beside the standard's properties, unless those have been changed since.
void restore(const OcesFile& file, const OcesProperties& properties, const OcesSite& site, Eye& eye,
             const std::string& place) {
  eye.aperture_diameter_m.back() =
      static_cast<float>(scalar_or(properties, oces_name::aperture_diameter, site, 0));
  if (const OcesProperty* up = find(properties, oces_name::up))
    eye.up.back() = to_float(vector_value(*up, site));
  float& angle = eye.acceptance_angle_rad.back();
  const double stored = scalar_or(properties, oces_name::acceptance_angle, site, angle);
  if (std::fabs(std::min(stored, 2 * oces_widest_half_angle) - static_cast<double>(angle)) > 1e-5)
    return;
  angle = static_cast<float>(stored);
  float &focal = eye.focal_offset_m.back(), &facet = eye.facet_diameter_m.back();
  focal = static_cast<float>(scalar_or(properties, oces_name::focal_offset, site, focal));
  facet = static_cast<float>(scalar_or(properties, oces_name::facet_diameter, site, facet));
  const double which = scalar_or(properties, oces_name::acceptance, site, 0);
  if (which == 0) return;
  const auto count = static_cast<double>(file.acceptances.size());
  if (!(which > 0 && which <= count) || which != std::floor(which))
    throw Error(place + ": " + oces_name::acceptance + ": expected a whole number from 0 to " +
                decimal_text(count) + ", found " + decimal_text(which));
  eye.acceptance_of.back() = static_cast<std::int32_t>(which) - 1;
}

void add_ommatidium(const OcesFile& file, const OcesProperties& properties, const OcesSite& site,
                    bool points, Eye& eye, const std::string& place) {
  const Vec3 w = orientation(properties, site, points, place);
  Vec3d position = site.position_m;
  if (!points && find(properties, "DISPLACEMENT") != nullptr) {
    const Vec3d normal = normalize(to_double(unit_axis(site.normal)));
    const Vec3d v = normalize(to_double(local_up(to_float(normal)))), u = cross(v, normal);
    const Vec3d d = vector_value(*find(properties, "DISPLACEMENT"), site);
    position = position + u * d.x + v * d.y + normal * d.z;
  }
  const double diameter_m = scalar_or(properties, "DIAMETER", site, 1);
  if (!(diameter_m >= 0))
    throw Error(place + ": DIAMETER: expected at least 0, found " + std::to_string(diameter_m));
  Vec3d focus{0, 0, -1};
  if (const OcesProperty* offset = find(properties, "FOCAL_OFFSET")) {
    if (offset->components == 1)
      focus.z = oces_scalar(*offset, site);
    else
      focus = vector_value(*offset, site);
  }
  if (!(focus.z < 0))
    throw Error(place +
                ": FOCAL_OFFSET: expected a W below 0 (the focal point is behind the "
                "facet), found " +
                std::to_string(focus.z));
  eye.position_m.push_back(to_float(position));
  eye.axis.push_back(w);
  eye.up.push_back(local_up(w));
  eye.facet_diameter_m.push_back(static_cast<float>(diameter_m));
  eye.focal_offset_m.push_back(static_cast<float>(-focus.z));
  eye.acceptance_angle_rad.push_back(static_cast<float>(oces_acceptance_rad(diameter_m, -focus.z)));
  eye.aperture_diameter_m.push_back(0);
  eye.acceptance_of.push_back(-1);
  eye.eye_id.push_back(0);
  if (focus.x != 0 || focus.y != 0)
    shear(eye, focus, diameter_m);
  else
    restore(file, properties, site, eye, place);
}

bool is_known(const std::string& name) {
  static const std::set<std::string> known = {"POSITION",
                                              "ORIENTATION",
                                              "DIAMETER",
                                              "FOCAL_OFFSET",
                                              "DISPLACEMENT",
                                              "RELATIVE_ORIENTATION",
                                              "ABSOLUTE_ORIENTATION",
                                              oces_name::acceptance_angle,
                                              oces_name::focal_offset,
                                              oces_name::facet_diameter,
                                              oces_name::aperture_diameter,
                                              oces_name::up,
                                              oces_name::acceptance};
  return known.contains(name);
}

// Properties that mean nothing to Omma, a column for each of their numbers.
void add_property_columns(OcesFile& file, const OcesProperties& properties,
                          const std::vector<OcesSite>& sites, Eye& eye) {
  for (const auto& [name, property] : properties) {
    if (is_known(name)) continue;
    file.gltf.budget.spend(sites.size(), property.components * sizeof(double));
    file.gltf.budget.spend(property.components, sizeof(EyeColumn) + name.size() + 8);
    const std::size_t first = eye.columns.size();
    for (std::size_t c = 0; c < property.components; ++c) {
      constexpr std::array<const char*, 4> letters = {"_x", "_y", "_z", "_w"};
      std::string suffix;
      if (property.components > 4)
        suffix.append("_").append(std::to_string(c));
      else if (property.components > 1)
        suffix = letters[c];
      eye.columns.push_back({name + suffix, std::vector<double>(sites.size()), {}});
    }
    std::vector<double> values(property.components);
    for (std::size_t i = 0; i < sites.size(); ++i) {
      oces_value(property, sites[i], values.data());
      for (std::size_t c = 0; c < values.size(); ++c) eye.columns[first + c].numbers[i] = values[c];
    }
  }
}

// Columns of texts, and of numbers that float cannot hold.
void add_stored_columns(const json& columns, Eye& eye, const std::string& place) {
  std::unordered_map<std::string, std::size_t> column_of;
  for (std::size_t c = 0; c < eye.columns.size(); ++c) column_of.emplace(eye.columns[c].name, c);
  for (const auto& [name, values] : columns.items()) {
    const std::string where = place + ": extras.omma.columns." + name;
    if (!values.is_array() || values.size() != eye.size())
      throw Error(where + ": expected an array of " + std::to_string(eye.size()) + " values");
    EyeColumn column{name, {}, {}};
    for (const json& value : values) {
      // Numbers that JSON has no way to write are objects: {"number": "nan"}.
      double number = 0;
      const json* special = value.is_object() ? oces_member(value, "number") : nullptr;
      if (value.is_string())
        column.texts.push_back(value.get<std::string>());
      else if (value.is_number())
        column.numbers.push_back(value.get<double>());
      else if (special != nullptr && special->is_string() &&
               parse_decimal(special->get_ref<const std::string&>(), 0, number))
        column.numbers.push_back(number);
      else
        throw Error(where + ": expected numbers or texts, found " +
                    shown_text(value.dump(-1, ' ', true)));
    }
    if (!column.texts.empty() && !column.numbers.empty())
      throw Error(where + ": expected numbers or texts, found both");
    const auto same = column_of.find(name);
    if (same == column_of.end())
      eye.columns.push_back(std::move(column));
    else
      eye.columns[same->second] = std::move(column);
  }
}

void add_receptors(const OcesFile& file, const json& eye_extras, Eye& eye,
                   const std::string& place) {
  const json* receptors = oces_member(eye_extras, "receptors");
  if (receptors == nullptr) return;
  const std::string where = place + ": extras.omma.receptors";
  if (!receptors->is_array() || receptors->size() != eye.size())
    throw Error(where + ": expected an array of " + std::to_string(eye.size()) + " lists");
  eye.first_receptor.push_back(0);
  for (const json& list : *receptors) {
    if (!list.is_array()) throw Error(where + ": expected lists of indices");
    for (const json& type : list)
      eye.receptor_type.push_back(
          oces_index(type, file.receptor_types.size(), "receptor_types", where));
    eye.first_receptor.push_back(static_cast<std::int32_t>(eye.receptor_type.size()));
  }
}

}  // namespace

double oces_acceptance_rad(double diameter_m, double distance_m) {
  return 2 * std::atan(diameter_m / 2 / distance_m);
}

Eye read_oces_eye(OcesFile& file, const json& description, const std::string& place) {
  const std::string type = oces_text(description, "type", place);
  const bool points = type == "POINT_OMMATIDIAL";
  if (!points && type != "SURFACE" && type != "SPHERICAL")
    throw Error(place + ": type: expected POINT_OMMATIDIAL, SURFACE or SPHERICAL, found " +
                shown_text(type));
  const OcesProperties properties = read_properties(file, description, type, place);
  const std::vector<OcesSite> sites = points ? point_sites(properties)
                                      : type == "SURFACE"
                                          ? oces_surface_sites(file, description, properties, place)
                                          : oces_sphere_sites(description, properties, place);
  file.gltf.budget.spend(sites.size(), 200);
  file.gltf.budget.spend(file.acceptances.size(), sizeof(Acceptance));
  file.gltf.budget.spend(file.receptor_types.size(), sizeof(ReceptorType));
  Eye eye;
  eye.path = file.gltf.path;
  eye.acceptances = file.acceptances;
  eye.receptor_types = file.receptor_types;
  for (std::size_t i = 0; i < sites.size(); ++i)
    add_ommatidium(file, properties, sites[i], points, eye,
                   place + ", ommatidium " + std::to_string(i));
  add_property_columns(file, properties, sites, eye);
  const json& extras = oces_extras(description);
  if (const json* columns = oces_member(extras, "columns")) {
    if (!columns->is_object()) throw Error(place + ": extras.omma.columns: expected an object");
    add_stored_columns(*columns, eye, place);
  }
  add_receptors(file, extras, eye, place);
  return eye;
}

}  // namespace omma
