// The glTF 2.0 schema as tables: one row a property.
#include "io/gltf_schema.h"

#include <cstdint>
#include <initializer_list>
#include <limits>

#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

enum class Kind {
  boolean,
  string,
  strings,
  number,
  numbers,  // of the given length, 0 for any
  integer,  // of the size of an int, not negative: indices, enumerations
  integers,
  byte_size,  // any unsigned 64-bit integer: sizes, offsets, counts
  integer_map,
  object,
  objects,
};

struct Property {
  const char* name;
  Kind kind;
  bool required = false;
  std::size_t length = 0;
};

constexpr bool required = true;

bool is_integer(const json& value) {
  return value.is_number_unsigned() &&
         value.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<int>::max());
}

template <typename Test>
bool all_of(const json& values, Test test) {
  for (const json& value : values)
    if (!test(value)) return false;
  return true;
}

bool matches(const json& value, const Property& property) {
  switch (property.kind) {
    case Kind::boolean:
      return value.is_boolean();
    case Kind::string:
      return value.is_string();
    case Kind::strings:
      return value.is_array() && all_of(value, [](const json& v) { return v.is_string(); });
    case Kind::number:
      return value.is_number();
    case Kind::numbers:
      return value.is_array() && (property.length == 0 || value.size() == property.length) &&
             all_of(value, [](const json& v) { return v.is_number(); });
    case Kind::integer:
      return is_integer(value);
    case Kind::integers:
      return value.is_array() && all_of(value, is_integer);
    case Kind::byte_size:
      return value.is_number_unsigned();
    case Kind::integer_map:
      return value.is_object() && all_of(value, is_integer);
    case Kind::object:
      return value.is_object();
    case Kind::objects:
      return value.is_array() && all_of(value, [](const json& v) { return v.is_object(); });
  }
  return false;
}

std::string expected(const Property& property) {
  switch (property.kind) {
    case Kind::boolean:
      return "true or false";
    case Kind::string:
      return "a string";
    case Kind::strings:
      return "an array of strings";
    case Kind::number:
      return "a number";
    case Kind::numbers:
      return "an array of " + (property.length ? std::to_string(property.length) + " " : "") +
             "numbers";
    case Kind::integer:
      return "an integer from 0 to 2147483647";
    case Kind::integers:
      return "an array of integers from 0 to 2147483647";
    case Kind::byte_size:
      return "an integer that is not negative";
    case Kind::integer_map:
      return "an object of accessor indices";
    case Kind::object:
      return "an object";
    case Kind::objects:
      return "an array of objects";
  }
  return "";
}

std::string shortened(const json& value) {
  if (value.is_structured() && value.size() > 16)
    return std::string(value.is_array() ? "an array" : "an object") + " of " +
           std::to_string(value.size());
  // Not cut inside a character: whatever is not ASCII is escaped.
  const std::string text = value.dump(-1, ' ', true);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

void check(const json& object, const std::string& place,
           std::initializer_list<Property> properties) {
  for (const Property& property : properties) {
    const auto found = object.find(property.name);
    if (found == object.end()) {
      if (property.required)
        throw Error(place + property.name + ": is missing, expected " + expected(property));
    } else if (!matches(*found, property)) {
      throw Error(place + property.name + ": expected " + expected(property) + ", found " +
                  shortened(*found));
    }
  }
}

// Calls `visit(element, place)` for the elements of an array that is there.
template <typename Visit>
void each(const json& parent, const std::string& place, const char* name, Visit visit) {
  const auto found = parent.find(name);
  if (found == parent.end()) return;
  std::size_t index = 0;
  for (const json& element : *found)
    visit(element, place + name + "[" + std::to_string(index++) + "].");
}

void check_texture_info(const json& parent, const std::string& place, const char* name) {
  const auto found = parent.find(name);
  if (found == parent.end()) return;
  const std::string inside = place + name + ".";
  check(*found, inside,
        {{"index", Kind::integer, required},
         {"texCoord", Kind::integer},
         {"extensions", Kind::object}});
  if (!found->contains("extensions")) return;
  const json& extensions = (*found)["extensions"];
  const std::string extension = inside + "extensions.";
  check(extensions, extension, {{"KHR_texture_transform", Kind::object}});
  if (extensions.contains("KHR_texture_transform"))
    check(extensions["KHR_texture_transform"], extension + "KHR_texture_transform.",
          {{"offset", Kind::numbers, false, 2},
           {"scale", Kind::numbers, false, 2},
           {"rotation", Kind::number},
           {"texCoord", Kind::integer}});
}

void check_material(const json& material, const std::string& place) {
  check(material, place,
        {{"name", Kind::string},
         {"pbrMetallicRoughness", Kind::object},
         {"emissiveFactor", Kind::numbers, false, 3},
         {"emissiveTexture", Kind::object},
         {"alphaMode", Kind::string},
         {"alphaCutoff", Kind::number},
         {"doubleSided", Kind::boolean},
         {"extensions", Kind::object}});
  check_texture_info(material, place, "emissiveTexture");
  if (material.contains("pbrMetallicRoughness")) {
    const json& pbr = material["pbrMetallicRoughness"];
    const std::string inside = place + "pbrMetallicRoughness.";
    check(pbr, inside,
          {{"baseColorFactor", Kind::numbers, false, 4}, {"baseColorTexture", Kind::object}});
    check_texture_info(pbr, inside, "baseColorTexture");
  }
  if (!material.contains("extensions")) return;
  const json& extensions = material["extensions"];
  const std::string inside = place + "extensions.";
  check(extensions, inside,
        {{"KHR_materials_unlit", Kind::object}, {"KHR_materials_emissive_strength", Kind::object}});
  if (extensions.contains("KHR_materials_emissive_strength"))
    check(extensions["KHR_materials_emissive_strength"],
          inside + "KHR_materials_emissive_strength.", {{"emissiveStrength", Kind::number}});
}

void check_accessor(const json& accessor, const std::string& place) {
  check(accessor, place,
        {{"name", Kind::string},
         {"bufferView", Kind::integer},
         {"byteOffset", Kind::byte_size},
         {"componentType", Kind::integer, required},
         {"normalized", Kind::boolean},
         {"count", Kind::byte_size, required},
         {"type", Kind::string, required},
         {"sparse", Kind::object}});
  if (!accessor.contains("sparse")) return;
  const json& sparse = accessor["sparse"];
  const std::string inside = place + "sparse.";
  check(sparse, inside,
        {{"count", Kind::integer, required},
         {"indices", Kind::object, required},
         {"values", Kind::object, required}});
  check(sparse["indices"], inside + "indices.",
        {{"bufferView", Kind::integer, required},
         {"byteOffset", Kind::integer},
         {"componentType", Kind::integer, required}});
  check(sparse["values"], inside + "values.",
        {{"bufferView", Kind::integer, required}, {"byteOffset", Kind::integer}});
}

void check_camera(const json& camera, const std::string& place) {
  check(camera, place,
        {{"name", Kind::string},
         {"type", Kind::string, required},
         {"perspective", Kind::object},
         {"orthographic", Kind::object}});
  if (camera.contains("perspective"))
    check(camera["perspective"], place + "perspective.",
          {{"yfov", Kind::number, required},
           {"znear", Kind::number, required},
           {"zfar", Kind::number},
           {"aspectRatio", Kind::number}});
  if (camera.contains("orthographic"))
    check(camera["orthographic"], place + "orthographic.",
          {{"xmag", Kind::number, required},
           {"ymag", Kind::number, required},
           {"znear", Kind::number, required},
           {"zfar", Kind::number, required}});
}

}  // namespace

void check_gltf_schema(const json& document, const std::string& path) {
  const std::string root = path + ": ";
  if (!document.is_object()) throw Error(path + ": is not a glTF file: its JSON is not an object");
  check(document, root,
        {{"asset", Kind::object, required},
         {"extensionsUsed", Kind::strings},
         {"extensionsRequired", Kind::strings},
         {"scene", Kind::integer},
         {"scenes", Kind::objects},
         {"nodes", Kind::objects},
         {"meshes", Kind::objects},
         {"materials", Kind::objects},
         {"textures", Kind::objects},
         {"samplers", Kind::objects},
         {"images", Kind::objects},
         {"cameras", Kind::objects},
         {"accessors", Kind::objects},
         {"bufferViews", Kind::objects},
         {"buffers", Kind::objects},
         {"animations", Kind::objects}});
  check(document["asset"], root + "asset.",
        {{"version", Kind::string, required}, {"minVersion", Kind::string}});

  each(document, root, "scenes", [](const json& scene, const std::string& place) {
    check(scene, place, {{"name", Kind::string}, {"nodes", Kind::integers}});
  });
  each(document, root, "nodes", [](const json& node, const std::string& place) {
    check(node, place,
          {{"name", Kind::string},
           {"children", Kind::integers},
           {"mesh", Kind::integer},
           {"camera", Kind::integer},
           {"skin", Kind::integer},
           {"matrix", Kind::numbers, false, 16},
           {"translation", Kind::numbers, false, 3},
           {"rotation", Kind::numbers, false, 4},
           {"scale", Kind::numbers, false, 3}});
  });
  each(document, root, "meshes", [](const json& mesh, const std::string& place) {
    check(mesh, place, {{"name", Kind::string}, {"primitives", Kind::objects, required}});
    each(mesh, place, "primitives", [](const json& primitive, const std::string& inside) {
      check(primitive, inside,
            {{"attributes", Kind::integer_map, required},
             {"indices", Kind::integer},
             {"material", Kind::integer},
             {"mode", Kind::integer},
             {"targets", Kind::objects}});
    });
  });
  each(document, root, "materials", check_material);
  each(document, root, "textures", [](const json& texture, const std::string& place) {
    check(texture, place, {{"sampler", Kind::integer}, {"source", Kind::integer}});
  });
  each(document, root, "samplers", [](const json& sampler, const std::string& place) {
    check(sampler, place,
          {{"magFilter", Kind::integer},
           {"minFilter", Kind::integer},
           {"wrapS", Kind::integer},
           {"wrapT", Kind::integer}});
  });
  each(document, root, "images", [](const json& image, const std::string& place) {
    check(image, place,
          {{"name", Kind::string}, {"uri", Kind::string}, {"bufferView", Kind::integer}});
  });
  each(document, root, "cameras", check_camera);
  each(document, root, "accessors", check_accessor);
  each(document, root, "bufferViews", [](const json& view, const std::string& place) {
    check(view, place,
          {{"buffer", Kind::integer, required},
           {"byteOffset", Kind::byte_size},
           {"byteLength", Kind::byte_size, required},
           {"byteStride", Kind::integer}});
  });
  each(document, root, "buffers", [](const json& buffer, const std::string& place) {
    check(buffer, place, {{"uri", Kind::string}, {"byteLength", Kind::byte_size, required}});
  });
}

}  // namespace omma
