// One walk through a document and the schema side by side.
#include "io/gltf_schema.h"

#include <cmath>
#include <string_view>

#include "io/csv_text.h"
#include "io/gltf_schema_rows.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

// Where an object is; put into words only where that is told.
struct Place {
  const Place* outer = nullptr;
  std::string_view name = {};
  std::ptrdiff_t index = -1;  // in a list
};

// "meshes[0].primitives[1]"; "" for the document.
std::string text_of(const Place& place) {
  if (place.outer == nullptr) return "";
  const std::string outer = text_of(*place.outer);
  return outer + (outer.empty() ? "" : ".") + std::string(place.name) +
         (place.index < 0 ? "" : "[" + std::to_string(place.index) + "]");
}

std::string member_text(const Place& place, const std::string& name) {
  return text_of({&place, name});
}

std::string shortened(const json& value) {
  if (value.is_structured() && value.size() > 16)
    return std::string(value.is_array() ? "an array" : "an object") + " of " +
           std::to_string(value.size());
  // Not cut inside a character: whatever is not ASCII is escaped.
  const std::string text = value.dump(-1, ' ', true);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

struct Walk {
  const std::string& path;
  std::map<std::string, GltfUnknownExtension> unknown = {};
};

bool is_surface(std::string_view place) {
  for (const std::string_view list : {"materials[", "textures[", "images[", "samplers["})
    if (place.starts_with(list)) return true;
  return false;
}

// `owner` is the object that has the extension.
void note_extension(Walk& walk, const std::string& name, const Place& owner) {
  GltfUnknownExtension& noted = walk.unknown[name];
  const std::string place = text_of(owner);
  if (noted.count++ == 0) noted.first_place = place;
  noted.is_surface = noted.is_surface && is_surface(place);
}

void check_members(const Walk& walk, const json& object, const GltfMember& schema,
                   const Place& place) {
  for (const auto& [name, member] : schema.members) {
    const auto found = object.find(name);
    if (found == object.end()) {
      if (member.is_required)
        throw Error(walk.path + ": " + member_text(place, name) + ": is missing, expected " +
                    member.kind.expected);
    } else if (!member.kind.matches(*found)) {
      throw Error(walk.path + ": " + member_text(place, name) + ": expected " +
                  member.kind.expected + ", found " + shortened(*found));
    }
  }
}

[[noreturn]] void refuse_name(const Walk& walk, const std::string& name, const GltfMember& schema,
                              const Place& place) {
  std::string known;
  for (const auto& [one, ignored] : schema.members) known += (known.empty() ? "" : ", ") + one;
  throw Error(walk.path + ": " + text_of(place) + ": expected " + known + ", found " +
              shown_text(name));
}

void drop_unknown(Walk& walk, json& object, const GltfMember& schema, const Place& place) {
  auto& members = object.get_ref<json::object_t&>();
  for (auto at = members.begin(); at != members.end();) {
    if (schema.members.contains(at->first)) {
      ++at;
      continue;
    }
    if (schema.is_closed) refuse_name(walk, at->first, schema, place);
    if (place.name == "extensions")
      note_extension(walk, at->first, *place.outer);
    else if (at->first == "extensions" && at->second.is_object())
      for (const auto& extension : at->second.items())
        note_extension(walk, extension.key(), place);
    at = members.erase(at);
  }
}

// All of one level before what is within.
void check_object(Walk& walk, json& object, const GltfMember& schema, const Place& place) {
  check_members(walk, object, schema, place);
  drop_unknown(walk, object, schema, place);
  for (auto& [name, value] : object.get_ref<json::object_t&>()) {
    const GltfMember& member = schema.members.find(name)->second;
    if (member.kind.is_whole) continue;
    if (value.is_object()) {
      check_object(walk, value, member, {&place, name});
    } else if (member.is_list) {
      std::ptrdiff_t index = 0;
      for (json& element : value) check_object(walk, element, member, {&place, name, index++});
    }
  }
}

void add_paths(const GltfMember& parent, const std::string& place,
               std::vector<std::string>& paths) {
  for (const auto& [name, member] : parent.members) {
    const std::string path = place + (place.empty() ? "" : ".") + name;
    paths.push_back(path);
    add_paths(member, path + (member.is_list ? "[]" : ""), paths);
  }
}

}  // namespace

std::optional<std::uint64_t> gltf_whole_number(const json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (!value.is_number()) return std::nullopt;
  const auto whole = value.get<double>();
  constexpr double most = 1ull << 53;  // beyond which a double may be another whole number
  if (!(whole >= 0 && whole <= most) || whole != std::floor(whole)) return std::nullopt;
  return static_cast<std::uint64_t>(whole);
}

std::map<std::string, GltfUnknownExtension> check_gltf_schema(json& document,
                                                              const std::string& path) {
  if (!document.is_object()) throw Error(path + ": is not a glTF file: its JSON is not an object");
  Walk walk{path};
  check_object(walk, document, gltf_schema(), {});
  return std::move(walk.unknown);
}

std::vector<std::string> gltf_schema_paths() {
  std::vector<std::string> paths;
  add_paths(gltf_schema(), "", paths);
  return paths;
}

}  // namespace omma
