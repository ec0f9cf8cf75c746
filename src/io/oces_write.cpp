// An eye as an OCES file: one head, one POINT_OMMATIDIAL eye for each eye_id. What the standard has
// no place for goes into properties of our own (oces_name) where it is a number for each
// ommatidium, else into extras; reading the file gives back the same bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "io/csv_text.h"
#include "io/eye_json.h"
#include "io/glb_bytes.h"
#include "io/oces.h"
#include "io/oces_file.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

namespace {

using Members = std::vector<std::size_t>;  // ommatidia of one eye

struct Writer {
  const Eye& eye;
  json document;
  json properties = json::array();
  std::string binary;

  int push(const char* list, json element) {
    document[list].push_back(std::move(element));
    return static_cast<int>(document[list].size()) - 1;
  }

  // A property of `components` floats for each ommatidium; its index in the list of all.
  template <typename Value>
  int property(const Members& members, std::size_t components, Value value) {
    const std::size_t begin = binary.size();
    for (const std::size_t i : members) {
      const std::array<float, 3> numbers = value(i);
      binary.append(reinterpret_cast<const char*>(numbers.data()), components * sizeof(float));
    }
    const int view =
        push("bufferViews",
             {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", binary.size() - begin}});
    const int accessor = push("accessors", {{"bufferView", view},
                                            {"componentType", 5126},
                                            {"count", members.size()},
                                            {"type", components == 3 ? "VEC3" : "SCALAR"}});
    properties.push_back({{"type", "ACCESSOR"}, {"value", accessor}});
    return static_cast<int>(properties.size()) - 1;
  }
  template <typename Value>
  int scalar(const Members& members, Value value) {
    return property(members, 1, [&](std::size_t i) {
      return std::array<float, 3>{static_cast<float>(value(i)), 0, 0};
    });
  }
  int vector(const Members& members, const std::vector<Vec3>& vectors) {
    return property(members, 3, [&](std::size_t i) {  // to OCES's frame
      return std::array<float, 3>{-vectors[i].x + 0.0f, vectors[i].y, -vectors[i].z + 0.0f};
    });
  }
};

// What the standard keeps of the optics of an ommatidium.
struct Facet {
  float diameter_m = 0, distance_m = 0;
};

// Diameter and distance of the focal point that give the acceptance angle; our own where they do.
Facet facet_of(const Eye& eye, std::size_t i) {
  const double angle = eye.acceptance_angle_rad[i], diameter = eye.facet_diameter_m[i],
               offset = eye.focal_offset_m[i];
  if (diameter > 0 && offset > 0 &&
      std::fabs(oces_acceptance_rad(diameter, offset) - angle) <= 1e-6 * angle)
    return {eye.facet_diameter_m[i], eye.focal_offset_m[i]};
  const double tangent = std::tan(std::min(angle / 2, oces_widest_half_angle));
  constexpr double any_m = 1e-6;  // where nothing is known
  Facet facet;
  if (!(tangent > 1e-6))
    facet = {0, offset > 0 ? eye.focal_offset_m[i] : static_cast<float>(any_m)};
  else if (diameter > 0)
    facet = {eye.facet_diameter_m[i], static_cast<float>(diameter / 2 / tangent)};
  else if (offset > 0)
    facet = {static_cast<float>(2 * offset * tangent), eye.focal_offset_m[i]};
  else
    facet = {static_cast<float>(any_m), static_cast<float>(any_m / 2 / tangent)};
  if (!(facet.distance_m > 0) || !std::isfinite(facet.distance_m) ||
      !std::isfinite(facet.diameter_m))
    throw Error("ommatidium " + std::to_string(i) +
                ": its facet diameter and acceptance angle cannot be written as OCES: the focal "
                "point would be out of the range of numbers");
  return facet;
}

bool same_bits(Vec3 a, Vec3 b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

bool fits_float(double value) {
  return std::isfinite(value) && std::fabs(value) <= std::numeric_limits<float>::max() &&
         static_cast<double>(static_cast<float>(value)) == value;
}

json stored_number(double value) {
  return std::isfinite(value) ? json(value) : json{{"number", decimal_text(value)}};
}

// The standard's names and ours, which a column of the same name must not take.
bool is_taken(const std::string& name) {
  static const std::vector<std::string> taken = {"POSITION",
                                                 "ORIENTATION",
                                                 "DIAMETER",
                                                 "FOCAL_OFFSET",
                                                 "DISPLACEMENT",
                                                 "RELATIVE_ORIENTATION",
                                                 "ABSOLUTE_ORIENTATION"};
  return name.starts_with("OMMA_") || std::find(taken.begin(), taken.end(), name) != taken.end();
}

// The text that all members have in the column of eye names; "" where there is no such.
std::string name_of(const Eye& eye, const Members& members) {
  for (const EyeColumn& column : eye.columns) {
    if (column.name != oces_name::eye_name_column || column.texts.empty()) continue;
    const std::string& name = column.texts[members.front()];
    const bool same = std::all_of(members.begin(), members.end(),
                                  [&](std::size_t i) { return column.texts[i] == name; });
    return same ? name : "";
  }
  return "";
}

void add_columns(Writer& writer, const Members& members, bool named, json& list, json& extras) {
  for (const EyeColumn& column : writer.eye.columns) {
    if (named && column.name == oces_name::eye_name_column) continue;
    const bool exact = column.texts.empty() &&
                       std::all_of(members.begin(), members.end(),
                                   [&](std::size_t i) { return fits_float(column.numbers[i]); });
    const bool finite =
        column.texts.empty() && std::all_of(members.begin(), members.end(), [&](std::size_t i) {
          return std::isfinite(static_cast<float>(column.numbers[i]));
        });
    if (finite && !is_taken(column.name))
      list[column.name] = writer.scalar(members, [&](std::size_t i) { return column.numbers[i]; });
    if (exact && !is_taken(column.name)) continue;
    json values = json::array();
    for (const std::size_t i : members)
      values.push_back(column.texts.empty() ? stored_number(column.numbers[i])
                                            : json(column.texts[i]));
    extras["columns"][column.name] = std::move(values);
  }
}

// Properties of our own: only those that reading the standard's would not give.
void add_own_properties(Writer& writer, const Members& members, const std::vector<Facet>& facets,
                        json& list) {
  const Eye& eye = writer.eye;
  const auto any = [&](auto differs) {
    return std::any_of(members.begin(), members.end(), differs);
  };
  const auto angle_of = [&](std::size_t i) {
    return static_cast<float>(oces_acceptance_rad(facets[i].diameter_m, facets[i].distance_m));
  };
  const bool focal =
      any([&](std::size_t i) { return facets[i].distance_m != eye.focal_offset_m[i]; });
  const bool facet =
      any([&](std::size_t i) { return facets[i].diameter_m != eye.facet_diameter_m[i]; });
  const bool acceptance = any([&](std::size_t i) { return eye.acceptance_of[i] >= 0; });
  // The angle tells the reader whether the rest still belongs to the standard's properties.
  if (focal || facet || acceptance ||
      any([&](std::size_t i) { return angle_of(i) != eye.acceptance_angle_rad[i]; }))
    list[oces_name::acceptance_angle] =
        writer.scalar(members, [&](std::size_t i) { return eye.acceptance_angle_rad[i]; });
  if (focal)
    list[oces_name::focal_offset] =
        writer.scalar(members, [&](std::size_t i) { return eye.focal_offset_m[i]; });
  if (facet)
    list[oces_name::facet_diameter] =
        writer.scalar(members, [&](std::size_t i) { return eye.facet_diameter_m[i]; });
  if (acceptance)
    list[oces_name::acceptance] =
        writer.scalar(members, [&](std::size_t i) { return eye.acceptance_of[i] + 1; });
  if (any([&](std::size_t i) { return eye.aperture_diameter_m[i] != 0; }))
    list[oces_name::aperture_diameter] =
        writer.scalar(members, [&](std::size_t i) { return eye.aperture_diameter_m[i]; });
  if (any([&](std::size_t i) { return !same_bits(eye.up[i], default_up(eye.axis[i])); }))
    list[oces_name::up] = writer.vector(members, eye.up);
}

json one_eye(Writer& writer, std::int32_t id, const Members& members,
             const std::vector<Facet>& facets, bool keep_index) {
  const Eye& eye = writer.eye;
  json list = json::object(), extras = {{"eye_id", id}};
  list["POSITION"] = writer.vector(members, eye.position_m);
  list["ORIENTATION"] = writer.vector(members, eye.axis);
  list["DIAMETER"] = writer.scalar(members, [&](std::size_t i) { return facets[i].diameter_m; });
  list["FOCAL_OFFSET"] =
      writer.scalar(members, [&](std::size_t i) { return -facets[i].distance_m; });
  add_own_properties(writer, members, facets, list);
  if (keep_index) list[oces_name::index] = writer.scalar(members, [](std::size_t i) { return i; });
  const std::string name = name_of(eye, members);
  add_columns(writer, members, !name.empty(), list, extras);
  if (name.empty()) extras["unnamed"] = true;
  if (!eye.receptor_type.empty()) {
    json receptors = json::array();
    for (const std::size_t i : members)
      receptors.push_back(
          std::vector<std::int32_t>(eye.receptor_type.begin() + eye.first_receptor[i],
                                    eye.receptor_type.begin() + eye.first_receptor[i + 1]));
    extras["receptors"] = std::move(receptors);
  }
  return {{"name", name.empty() ? "eye " + std::to_string(id) : name},
          {"type", "POINT_OMMATIDIAL"},
          {"ommatidialProperties", std::move(list)},
          {"extras", {{"omma", std::move(extras)}}}};
}

json own_extras(const Eye& eye) {
  json extras = json::object();
  for (const Acceptance& acceptance : eye.acceptances)
    extras["acceptances"].push_back(acceptance_json(acceptance));
  for (const ReceptorType& type : eye.receptor_types)
    extras["receptor_types"].push_back(receptor_type_json(type));
  for (const EyeColumn& column : eye.columns) extras["columns"].push_back(column.name);
  return extras;
}

std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string json_text(const json& document) {
  try {
    return document.dump(1);
  } catch (const json::exception&) {
    throw Error("the eye has texts that are not UTF-8, which OCES cannot hold");
  }
}

}  // namespace

std::string oces_bytes(const Eye& given, bool binary) {
  Eye eye = given;
  validate_eye(eye);
  Writer writer{eye, {{"asset", {{"version", "2.0"}, {"generator", omma_generator}}}}, json::array(), {}};
  std::map<std::int32_t, Members> eyes;
  std::vector<Facet> facets;
  bool in_order = true;  // eyes one after the other, by number
  for (std::size_t i = 0; i < eye.size(); ++i) {
    eyes[eye.eye_id[i]].push_back(i);
    in_order = in_order && (i == 0 || eye.eye_id[i - 1] <= eye.eye_id[i]);
    facets.push_back(facet_of(eye, i));
  }
  if (!in_order && eye.size() > (std::size_t{1} << 24))
    throw Error(
        "the ommatidia are too many to be written as OCES unless they are in the order of "
        "their eyes");
  json list = json::array(), children = json::array();
  json nodes = {{{"name", "head"}, {"extensions", {{"OCES_eyes", {{"head", true}}}}}}};
  for (const auto& [id, members] : eyes) {
    const int index = static_cast<int>(list.size());
    list.push_back(one_eye(writer, id, members, facets, !in_order));
    children.push_back(nodes.size());
    nodes.push_back(
        {{"name", list.back()["name"]}, {"extensions", {{"OCES_eyes", {{"eye", index}}}}}});
  }
  nodes[0]["children"] = std::move(children);
  json& document = writer.document;
  document["extensionsUsed"] = {"OCES_eyes"};
  document["extensions"]["OCES_eyes"] = {{"version", "0.3.0"},  // that of the schemas
                                         {"generator", {{"name", "Omma"}}},
                                         {"ommatidialProperties", std::move(writer.properties)},
                                         {"eyes", std::move(list)},
                                         {"extras", {{"omma", own_extras(eye)}}}};
  document["nodes"] = std::move(nodes);
  document["scene"] = 0;
  document["scenes"] = {{{"name", "eyes"}, {"nodes", {0}}}};
  if (binary) return glb_bytes(document, writer.binary, "the eye");
  document["buffers"] = {{{"byteLength", writer.binary.size()}}};
  document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(writer.binary);
  return json_text(document);
}

}  // namespace omma
