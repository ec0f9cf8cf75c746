// The glTF 2.0 schema as tables: one row a property.
#include "io/gltf_schema.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

bool is_string(const json& value) {
  return value.is_string();
}
bool is_number(const json& value) {
  return value.is_number();
}
bool is_object(const json& value) {
  return value.is_object();
}
bool is_integer(const json& value) {
  const auto whole = gltf_whole_number(value);
  return whole && *whole <= static_cast<std::uint64_t>(std::numeric_limits<int>::max());
}
template <bool (*test)(const json&)>
bool is_list(const json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), test);
}
template <std::size_t length>
bool is_numbers(const json& value) {
  return is_list<is_number>(value) && value.size() == length;
}

struct Kind {
  const char* expected;
  bool (*matches)(const json&);
};
constexpr Kind boolean{"true or false", [](const json& v) { return v.is_boolean(); }};
constexpr Kind string{"a string", is_string};
constexpr Kind strings{"an array of strings", is_list<is_string>};
constexpr Kind number{"a number", is_number};
constexpr Kind numbers{"an array of numbers", is_list<is_number>};
constexpr Kind two_numbers{"an array of 2 numbers", is_numbers<2>};
constexpr Kind three_numbers{"an array of 3 numbers", is_numbers<3>};
constexpr Kind four_numbers{"an array of 4 numbers", is_numbers<4>};
constexpr Kind sixteen_numbers{"an array of 16 numbers", is_numbers<16>};
// Indices and enumerations; sizes, offsets and counts.
constexpr Kind integer{"an integer from 0 to 2147483647", is_integer};
constexpr Kind integers{"an array of integers from 0 to 2147483647", is_list<is_integer>};
constexpr Kind byte_size{"an integer that is not negative",
                         [](const json& v) { return gltf_whole_number(v).has_value(); }};
constexpr Kind integer_map{"an object of accessor indices", [](const json& v) {
                             return v.is_object() && std::all_of(v.begin(), v.end(), is_integer);
                           }};
bool is_integer_map(const json& value) {
  return integer_map.matches(value);
}
constexpr Kind integer_maps{"an array of objects of accessor indices", is_list<is_integer_map>};
constexpr Kind object{"an object", is_object};
constexpr Kind objects{"an array of objects", is_list<is_object>};
bool is_spectrum_or_null(const json& value) {
  if (value.is_null()) return true;
  if (!value.is_object() || !value.contains("wavelength_nm") || !value.contains("value"))
    return false;
  return is_list<is_number>(value["wavelength_nm"]) && is_list<is_number>(value["value"]);
}
constexpr Kind spectra{"an array of at most 3 spectra or nulls", [](const json& v) {
                         return is_list<is_spectrum_or_null>(v) && v.size() <= 3;
                       }};

struct Property {
  const char* name;
  Kind kind;
  bool required = false;
};

constexpr bool required = true;

std::string shortened(const json& value) {
  if (value.is_structured() && value.size() > 16)
    return std::string(value.is_array() ? "an array" : "an object") + " of " +
           std::to_string(value.size());
  // Not cut inside a character: whatever is not ASCII is escaped.
  const std::string text = value.dump(-1, ' ', true);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

// Properties of the objects that a path leads to; "[]" stands for every element of a list.
struct Object {
  std::string path;
  std::vector<Property> properties;
};

// What uses a texture.
void add_texture_use(std::vector<Object>& all, const std::string& path) {
  all.push_back(
      {path, {{"index", integer, required}, {"texCoord", integer}, {"extensions", object}}});
  all.push_back({path + ".extensions", {{"KHR_texture_transform", object}}});
  all.push_back({path + ".extensions.KHR_texture_transform",
                 {{"offset", two_numbers},
                  {"scale", two_numbers},
                  {"rotation", number},
                  {"texCoord", integer}}});
}

// How materials scatter light: their extensions, and the spectra in extras.
void add_scattering(std::vector<Object>& all) {
  const std::string extensions = "materials[].extensions.", omma = "materials[].extras.omma";
  all.push_back({extensions + "KHR_materials_ior", {{"ior", number}}});
  all.push_back({extensions + "KHR_materials_specular",
                 {{"specularFactor", number},
                  {"specularTexture", object},
                  {"specularColorFactor", three_numbers},
                  {"specularColorTexture", object}}});
  all.push_back({extensions + "KHR_materials_transmission",
                 {{"transmissionFactor", number}, {"transmissionTexture", object}}});
  all.push_back({extensions + "KHR_materials_diffuse_transmission",
                 {{"diffuseTransmissionFactor", number},
                  {"diffuseTransmissionColorFactor", three_numbers},
                  {"diffuseTransmissionColorTexture", object}}});
  all.push_back({extensions + "KHR_materials_clearcoat",
                 {{"clearcoatFactor", number},
                  {"clearcoatTexture", object},
                  {"clearcoatRoughnessFactor", number},
                  {"clearcoatRoughnessTexture", object}}});
  all.push_back({"materials[].extras", {{"omma", object}}});
  all.push_back({omma,
                 {{"reflectance", object},
                  {"transmittance", object},
                  {"spectral_luminance", number},
                  {"emission", object},
                  {"extra_reflectance", object}}});
  const std::vector<Property> spectrum = {{"wavelength_nm", numbers, required},
                                          {"value", numbers, required}};
  for (const char* name : {".reflectance", ".transmittance", ".emission"})
    all.push_back({omma + name, spectrum});
  all.push_back({omma + ".extra_reflectance",
                 {{"texture", object, required}, {"spectra", spectra, required}}});
  for (const std::string& use :
       {std::string("materials[].emissiveTexture"), std::string("materials[].normalTexture"),
        std::string("materials[].pbrMetallicRoughness.baseColorTexture"),
        std::string("materials[].pbrMetallicRoughness.metallicRoughnessTexture"),
        extensions + "KHR_materials_diffuse_transmission.diffuseTransmissionColorTexture",
        omma + ".extra_reflectance.texture"})
    add_texture_use(all, use);
  all.push_back({"materials[].normalTexture", {{"scale", number}}});
}

void add_lights(std::vector<Object>& all) {
  const std::string lights = "extensions.KHR_lights_punctual.lights[]";
  all.push_back({"extensions", {{"KHR_lights_punctual", object}}});
  all.push_back({"extensions.KHR_lights_punctual", {{"lights", objects, required}}});
  all.push_back({lights,
                 {{"name", string},
                  {"type", string, required},
                  {"color", three_numbers},
                  {"intensity", number},
                  {"range", number},
                  {"spot", object}}});
  all.push_back({lights + ".spot", {{"innerConeAngle", number}, {"outerConeAngle", number}}});
  all.push_back({lights + ".extras", {{"omma", object}}});
  all.push_back({lights + ".extras.omma", {{"spectrum", object}}});
  all.push_back({lights + ".extras.omma.spectrum",
                 {{"wavelength_nm", numbers, required}, {"value", numbers, required}}});
  all.push_back({"nodes[].extensions", {{"KHR_lights_punctual", object}}});
  all.push_back({"nodes[].extensions.KHR_lights_punctual", {{"light", integer, required}}});
}

// Animations and skins.
void add_rig(std::vector<Object>& all) {
  all.push_back({"animations[]",
                 {{"name", string}, {"channels", objects, required}, {"samplers", objects, required}}});
  all.push_back(
      {"animations[].channels[]", {{"sampler", integer, required}, {"target", object, required}}});
  all.push_back(
      {"animations[].channels[].target", {{"node", integer}, {"path", string, required}}});
  all.push_back({"animations[].samplers[]",
                 {{"input", integer, required},
                  {"output", integer, required},
                  {"interpolation", string}}});
  all.push_back({"skins[]",
                 {{"name", string},
                  {"joints", integers, required},
                  {"inverseBindMatrices", integer},
                  {"skeleton", integer}}});
}

// Every list and object is checked before what is in it.
const std::vector<Object>& schema() {
  static const std::vector<Object> all = [] {
    std::vector<Object> rows = {
        {"",
         {{"asset", object, required},
          {"extensionsUsed", strings},
          {"extensionsRequired", strings},
          {"scene", integer},
          {"scenes", objects},
          {"nodes", objects},
          {"meshes", objects},
          {"materials", objects},
          {"textures", objects},
          {"samplers", objects},
          {"images", objects},
          {"cameras", objects},
          {"accessors", objects},
          {"bufferViews", objects},
          {"buffers", objects},
          {"animations", objects},
          {"skins", objects},
          {"extensions", object}}},
        {"asset", {{"version", string, required}, {"minVersion", string}}},
        {"scenes[]", {{"name", string}, {"nodes", integers}}},
        {"nodes[]",
         {{"name", string},
          {"children", integers},
          {"mesh", integer},
          {"camera", integer},
          {"skin", integer},
          {"weights", numbers},
          {"extensions", object},
          {"matrix", sixteen_numbers},
          {"translation", three_numbers},
          {"rotation", four_numbers},
          {"scale", three_numbers}}},
        {"meshes[]", {{"name", string}, {"primitives", objects, required}, {"weights", numbers}}},
        {"meshes[].primitives[]",
         {{"attributes", integer_map, required},
          {"indices", integer},
          {"material", integer},
          {"mode", integer},
          {"targets", integer_maps}}},
        {"materials[]",
         {{"name", string},
          {"pbrMetallicRoughness", object},
          {"emissiveFactor", three_numbers},
          {"emissiveTexture", object},
          {"normalTexture", object},
          {"alphaMode", string},
          {"alphaCutoff", number},
          {"doubleSided", boolean},
          {"extensions", object}}},
        {"materials[].pbrMetallicRoughness",
         {{"baseColorFactor", four_numbers},
          {"baseColorTexture", object},
          {"metallicFactor", number},
          {"roughnessFactor", number},
          {"metallicRoughnessTexture", object}}},
        {"materials[].extensions",
         {{"KHR_materials_unlit", object},
          {"KHR_materials_emissive_strength", object},
          {"KHR_materials_ior", object},
          {"KHR_materials_specular", object},
          {"KHR_materials_transmission", object},
          {"KHR_materials_diffuse_transmission", object},
          {"KHR_materials_clearcoat", object},
          {"KHR_materials_volume", object}}},
        {"materials[].extensions.KHR_materials_emissive_strength", {{"emissiveStrength", number}}},
        {"textures[]", {{"sampler", integer}, {"source", integer}}},
        {"samplers[]",
         {{"magFilter", integer}, {"minFilter", integer}, {"wrapS", integer}, {"wrapT", integer}}},
        {"images[]", {{"name", string}, {"uri", string}, {"bufferView", integer}}},
        {"cameras[]",
         {{"name", string},
          {"type", string, required},
          {"perspective", object},
          {"orthographic", object}}},
        {"cameras[].perspective",
         {{"yfov", number, required},
          {"znear", number, required},
          {"zfar", number},
          {"aspectRatio", number}}},
        {"cameras[].orthographic",
         {{"xmag", number, required},
          {"ymag", number, required},
          {"znear", number, required},
          {"zfar", number, required}}},
        {"accessors[]",
         {{"name", string},
          {"bufferView", integer},
          {"byteOffset", byte_size},
          {"componentType", integer, required},
          {"normalized", boolean},
          {"count", byte_size, required},
          {"type", string, required},
          {"sparse", object}}},
        {"accessors[].sparse",
         {{"count", integer, required},
          {"indices", object, required},
          {"values", object, required}}},
        {"accessors[].sparse.indices",
         {{"bufferView", integer, required},
          {"byteOffset", integer},
          {"componentType", integer, required}}},
        {"accessors[].sparse.values", {{"bufferView", integer, required}, {"byteOffset", integer}}},
        {"bufferViews[]",
         {{"buffer", integer, required},
          {"byteOffset", byte_size},
          {"byteLength", byte_size, required},
          {"byteStride", integer}}},
        {"buffers[]", {{"uri", string}, {"byteLength", byte_size, required}}}};
    add_scattering(rows);
    add_lights(rows);
    add_rig(rows);
    return rows;
  }();
  return all;
}

void check_object(const json& value, const std::string& place,
                  const std::vector<Property>& properties) {
  for (const Property& property : properties) {
    const auto found = value.find(property.name);
    if (found == value.end()) {
      if (property.required)
        throw Error(place + property.name + ": is missing, expected " + property.kind.expected);
    } else if (!property.kind.matches(*found)) {
      throw Error(place + property.name + ": expected " + property.kind.expected + ", found " +
                  shortened(*found));
    }
  }
}

// Checks the objects that `path` leads to from `value`.
void check_path(const json& value, const std::string& place, std::string_view path,
                const std::vector<Property>& properties) {
  if (path.empty()) return check_object(value, place, properties);
  std::string name(path.substr(0, path.find('.')));
  path.remove_prefix(std::min(name.size() + 1, path.size()));
  const bool list = name.ends_with("[]");
  if (list) name.resize(name.size() - 2);
  const auto found = value.find(name);
  if (found == value.end()) return;
  if (!list) return check_path(*found, place + name + ".", path, properties);
  std::size_t index = 0;
  for (const json& element : *found)
    check_path(element, place + name + "[" + std::to_string(index++) + "].", path, properties);
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

void check_gltf_schema(const json& document, const std::string& path) {
  if (!document.is_object()) throw Error(path + ": is not a glTF file: its JSON is not an object");
  for (const Object& checked : schema())
    check_path(document, path + ": ", checked.path, checked.properties);
}

}  // namespace omma
