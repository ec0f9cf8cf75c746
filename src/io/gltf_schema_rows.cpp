// The schema as tables, one row a member, and the tree that is made of them.
#include "io/gltf_schema_rows.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <vector>

#include "io/draco_mesh.h"
#include "io/gltf_schema.h"
#include "io/gltf_splats.h"
#include "io/meshopt.h"

namespace omma {
namespace {

using nlohmann::json;

bool is_anything(const json&) {
  return true;
}
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

constexpr GltfKind boolean{"true or false", [](const json& v) { return v.is_boolean(); }};
constexpr GltfKind string{"a string", is_string};
constexpr GltfKind strings{"an array of strings", is_list<is_string>};
constexpr GltfKind number{"a number", is_number};
constexpr GltfKind numbers{"an array of numbers", is_list<is_number>};
constexpr GltfKind two_numbers{"an array of 2 numbers", is_numbers<2>};
constexpr GltfKind three_numbers{"an array of 3 numbers", is_numbers<3>};
constexpr GltfKind four_numbers{"an array of 4 numbers", is_numbers<4>};
constexpr GltfKind sixteen_numbers{"an array of 16 numbers", is_numbers<16>};
// Indices and enumerations; sizes, offsets and counts.
constexpr GltfKind integer{"an integer from 0 to 2147483647", is_integer};
constexpr GltfKind integers{"an array of integers from 0 to 2147483647", is_list<is_integer>};
constexpr GltfKind byte_size{"an integer that is not negative",
                             [](const json& v) { return gltf_whole_number(v).has_value(); }};
constexpr GltfKind integer_map{"an object of accessor indices",
                               [](const json& v) {
                                 return v.is_object() &&
                                        std::all_of(v.begin(), v.end(), is_integer);
                               },
                               true};
bool is_integer_map(const json& value) {
  return integer_map.matches(value);
}
constexpr GltfKind integer_maps{"an array of objects of accessor indices",
                                is_list<is_integer_map>};
constexpr GltfKind object{"an object", is_object};
constexpr GltfKind whole_object{"an object", is_object, true};
constexpr GltfKind objects{"an array of objects", is_list<is_object>};
// Extras may be anything, as may what is kept of them as it is.
constexpr GltfKind extras{"anything", is_anything};
constexpr GltfKind anything{"anything", is_anything, true};
bool is_spectrum_or_null(const json& value) {
  if (value.is_null()) return true;
  if (!value.is_object() || !value.contains("wavelength_nm") || !value.contains("value"))
    return false;
  return is_list<is_number>(value["wavelength_nm"]) && is_list<is_number>(value["value"]);
}
constexpr GltfKind spectra{"an array of at most 3 spectra or nulls", [](const json& v) {
                             return is_list<is_spectrum_or_null>(v) && v.size() <= 3;
                           }};

struct Row {
  const char* name;
  GltfKind kind;
  bool is_required = false;
};

constexpr bool required = true;

// The member that a path leads to; "[]" stands for every element of a list.
GltfMember& member_at(GltfMember& root, std::string_view path) {
  GltfMember* at = &root;
  while (!path.empty()) {
    std::string_view name = path.substr(0, path.find('.'));
    path.remove_prefix(std::min(name.size() + 1, path.size()));
    const bool list = name.ends_with("[]");
    if (list) name.remove_suffix(2);
    at = &at->members.at(std::string(name));
    if (list) at->is_list = true;
  }
  return *at;
}

void add(GltfMember& root, const std::string& path, const std::vector<Row>& rows) {
  GltfMember& parent = member_at(root, path);
  for (const Row& row : rows) {
    GltfMember& made = parent.members[row.name];
    made.kind = row.kind;
    made.is_required = row.is_required;
  }
}

// An object in which a name that is not known is an error.
void add_closed(GltfMember& root, const std::string& path, const std::vector<Row>& rows) {
  add(root, path, rows);
  member_at(root, path).is_closed = true;
}

// A member `name` of the object at `path` that says which texture is used, and how.
void add_texture_use(GltfMember& root, const std::string& path, const char* name,
                     bool is_required = false) {
  add(root, path, {{name, object, is_required}});
  const std::string use = path + "." + name;
  add(root, use, {{"index", integer, required}, {"texCoord", integer}, {"extensions", object}});
  add(root, use + ".extensions", {{"KHR_texture_transform", object}});
  add(root, use + ".extensions.KHR_texture_transform",
      {{"offset", two_numbers}, {"scale", two_numbers}, {"rotation", number}, {"texCoord", integer}});
}

const std::vector<Row> spectrum = {{"wavelength_nm", numbers, required},
                                   {"value", numbers, required}};

// How materials scatter light: their extensions, and the spectra in extras.
void add_scattering(GltfMember& root) {
  const std::string extensions = "materials[].extensions";
  add(root, extensions,
      {{"KHR_materials_unlit", object},
       {"KHR_materials_emissive_strength", object},
       {"KHR_materials_ior", object},
       {"KHR_materials_specular", object},
       {"KHR_materials_transmission", object},
       {"KHR_materials_diffuse_transmission", object},
       {"KHR_materials_clearcoat", object},
       {"KHR_materials_volume", object}});
  add(root, extensions + ".KHR_materials_emissive_strength", {{"emissiveStrength", number}});
  add(root, extensions + ".KHR_materials_ior", {{"ior", number}});
  const std::string specular = extensions + ".KHR_materials_specular";
  add(root, specular, {{"specularFactor", number}, {"specularColorFactor", three_numbers}});
  add_texture_use(root, specular, "specularTexture");
  add_texture_use(root, specular, "specularColorTexture");
  const std::string transmission = extensions + ".KHR_materials_transmission";
  add(root, transmission, {{"transmissionFactor", number}});
  add_texture_use(root, transmission, "transmissionTexture");
  add(root, extensions + ".KHR_materials_volume",
      {{"thicknessFactor", number},
       {"attenuationDistance", number},
       {"attenuationColor", three_numbers}});
  const std::string diffuse = extensions + ".KHR_materials_diffuse_transmission";
  add(root, diffuse,
      {{"diffuseTransmissionFactor", number}, {"diffuseTransmissionColorFactor", three_numbers}});
  add_texture_use(root, diffuse, "diffuseTransmissionTexture");
  add_texture_use(root, diffuse, "diffuseTransmissionColorTexture");
  const std::string coat = extensions + ".KHR_materials_clearcoat";
  add(root, coat, {{"clearcoatFactor", number}, {"clearcoatRoughnessFactor", number}});
  add_texture_use(root, coat, "clearcoatTexture");
  add_texture_use(root, coat, "clearcoatRoughnessTexture");
  add_texture_use(root, coat, "clearcoatNormalTexture");
  add(root, coat + ".clearcoatNormalTexture", {{"scale", number}});

  const std::string omma = "materials[].extras.omma";
  add(root, "materials[]", {{"extras", extras}});
  add(root, "materials[].extras", {{"omma", object}});
  add_closed(root, omma,
             {{"reflectance", object},
              {"transmittance", object},
              {"spectral_luminance", number},
              {"emission", object},
              {"absorption_per_m", object},
              {"extra_reflectance", object},
              {"boundary", object}});
  for (const char* name : {".reflectance", ".transmittance", ".emission", ".absorption_per_m"})
    add(root, omma + name, spectrum);
  add(root, omma + ".extra_reflectance", {{"spectra", spectra, required}});
  add_texture_use(root, omma + ".extra_reflectance", "texture", required);
  add(root, omma + ".boundary",
      {{"wavelength_nm", numbers, required},
       {"cosines", integer, required},
       {"mueller", integer, required}});
}

void add_materials(GltfMember& root) {
  add(root, "materials[]",
      {{"name", string},
       {"pbrMetallicRoughness", object},
       {"emissiveFactor", three_numbers},
       {"alphaMode", string},
       {"alphaCutoff", number},
       {"doubleSided", boolean},
       {"extensions", object}});
  add_texture_use(root, "materials[]", "emissiveTexture");
  add_texture_use(root, "materials[]", "normalTexture");
  add(root, "materials[].normalTexture", {{"scale", number}});
  const std::string pbr = "materials[].pbrMetallicRoughness";
  add(root, pbr,
      {{"baseColorFactor", four_numbers}, {"metallicFactor", number}, {"roughnessFactor", number}});
  add_texture_use(root, pbr, "baseColorTexture");
  add_texture_use(root, pbr, "metallicRoughnessTexture");
  add_scattering(root);
  add(root, "textures[]",
      {{"sampler", integer}, {"source", integer}, {"extensions", object}});
  add(root, "textures[].extensions",
      {{"EXT_texture_webp", object}, {"KHR_texture_basisu", whole_object}});  // that it is there
  add(root, "textures[].extensions.EXT_texture_webp", {{"source", integer}});
  add(root, "samplers[]",
      {{"magFilter", integer}, {"wrapS", integer}, {"wrapT", integer}});
  add(root, "images[]",
      {{"name", string}, {"uri", string}, {"bufferView", integer}, {"extras", extras}});
  add(root, "images[].extras", {{"omma-linear-rgba", integer}});
}

void add_lights(GltfMember& root) {
  const std::string lights = "extensions.KHR_lights_punctual.lights[]";
  add(root, "extensions", {{"KHR_lights_punctual", object}});
  add(root, "extensions.KHR_lights_punctual", {{"lights", objects, required}});
  add(root, lights,
      {{"name", string},
       {"type", string, required},
       {"color", three_numbers},
       {"intensity", number},
       {"range", number},
       {"spot", object},
       {"extras", extras}});
  add(root, lights + ".spot", {{"innerConeAngle", number}, {"outerConeAngle", number}});
  add(root, lights + ".extras", {{"omma", object}});
  add_closed(root, lights + ".extras.omma", {{"spectrum", object}});
  add(root, lights + ".extras.omma.spectrum", spectrum);
  add(root, "nodes[].extensions", {{"KHR_lights_punctual", object}});
  add(root, "nodes[].extensions.KHR_lights_punctual", {{"light", integer, required}});
}

// Scenes and nodes with what hangs from them; eyes check their own members (oces_file.h).
void add_nodes(GltfMember& root) {
  add(root, "scenes[]", {{"name", string}, {"nodes", integers}, {"extras", extras}});
  add(root, "scenes[].extras",
      {{"background-shader", anything},
       {"background-color", three_numbers},
       {"background-image", integer}});
  add(root, "nodes[]",
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
       {"scale", three_numbers}});
  add(root, "nodes[].extensions",
      {{"OCES_eyes", anything},
       {"KHR_node_visibility", object},
       {"EXT_mesh_gpu_instancing", object}});
  add(root, "nodes[].extensions.KHR_node_visibility", {{"visible", boolean}});
  add(root, "nodes[].extensions.EXT_mesh_gpu_instancing", {{"attributes", integer_map, required}});
  add(root, "extensions", {{"OCES_eyes", anything}});
  add(root, "cameras[]",
      {{"name", string},
       {"type", string, required},
       {"perspective", object},
       {"orthographic", object},
       {"extras", anything}});
  add(root, "cameras[].perspective",
      {{"yfov", number, required},
       {"znear", number, required},
       {"zfar", number},
       {"aspectRatio", number}});
  add(root, "cameras[].orthographic",
      {{"xmag", number, required},
       {"ymag", number, required},
       {"znear", number, required},
       {"zfar", number, required}});
}

// Meshes and the numbers that they are made of.
void add_geometry(GltfMember& root) {
  add(root, "meshes[]",
      {{"name", string},
       {"primitives", objects, required},
       {"weights", numbers},
       {"extras", extras}});
  add(root, "meshes[].extras", {{"hitbox", anything}});
  add(root, "meshes[].primitives[]",
      {{"attributes", integer_map, required},
       {"indices", integer},
       {"material", integer},
       {"mode", integer},
       {"targets", integer_maps},
       {"extensions", object}});
  const std::string extensions = "meshes[].primitives[].extensions";
  add(root, extensions, {{draco_extension, object}, {splats_extension, object}});
  add(root, extensions + "." + draco_extension,
      {{"bufferView", integer, required}, {"attributes", integer_map, required}});
  const std::string splats = extensions + "." + splats_extension;
  add(root, splats,
      {{"kernel", string, required}, {"colorSpace", string, required}, {"extras", extras}});
  add(root, splats + ".extras", {{"direction", anything}, {"white", numbers}, {"bands_nm", numbers}});
  add(root, "accessors[]",
      {{"name", string},
       {"bufferView", integer},
       {"byteOffset", byte_size},
       {"componentType", integer, required},
       {"normalized", boolean},
       {"count", byte_size, required},
       {"type", string, required},
       {"sparse", object}});
  add(root, "accessors[].sparse",
      {{"count", integer, required}, {"indices", object, required}, {"values", object, required}});
  add(root, "accessors[].sparse.indices",
      {{"bufferView", integer, required},
       {"byteOffset", integer},
       {"componentType", integer, required}});
  add(root, "accessors[].sparse.values",
      {{"bufferView", integer, required}, {"byteOffset", integer}});
  add(root, "bufferViews[]",
      {{"buffer", integer, required},
       {"byteOffset", byte_size},
       {"byteLength", byte_size, required},
       {"byteStride", integer},
       {"extensions", object}});
  add(root, "bufferViews[].extensions", {{meshopt_extension, object}});
  add(root, std::string("bufferViews[].extensions.") + meshopt_extension,
      {{"buffer", integer, required},
       {"byteOffset", byte_size},
       {"byteLength", byte_size, required},
       {"byteStride", integer, required},
       {"count", integer, required},
       {"mode", string, required},
       {"filter", string}});
  add(root, "buffers[]",
      {{"uri", string}, {"byteLength", byte_size, required}, {"extensions", object}});
  add(root, "buffers[].extensions", {{meshopt_extension, whole_object}});  // of no use to readers
}

// Animations and skins.
void add_rig(GltfMember& root) {
  add(root, "animations[]",
      {{"name", string}, {"channels", objects, required}, {"samplers", objects, required}});
  add(root, "animations[].channels[]",
      {{"sampler", integer, required}, {"target", object, required}});
  add(root, "animations[].channels[].target", {{"node", integer}, {"path", string, required}});
  add(root, "animations[].samplers[]",
      {{"input", integer, required}, {"output", integer, required}, {"interpolation", string}});
  add(root, "skins[]",
      {{"name", string}, {"joints", integers, required}, {"inverseBindMatrices", integer}});
}

}  // namespace

const GltfMember& gltf_schema() {
  static const GltfMember root = [] {
    GltfMember made;
    made.kind = object;
    add(made, "",
        {{"asset", object, required},
         {"extensionsUsed", strings},
         {"extensionsRequired", strings},
         {"scene", integer},
         {"extensions", object}});
    for (const char* list : {"scenes", "nodes", "meshes", "materials", "textures", "samplers",
                             "images", "cameras", "accessors", "bufferViews", "buffers",
                             "animations", "skins"})
      add(made, "", {{list, objects}});
    add(made, "asset", {{"version", string, required}, {"minVersion", string}, {"generator", anything}});
    add_nodes(made);
    add_materials(made);
    add_lights(made);
    add_geometry(made);
    add_rig(made);
    return made;
  }();
  return root;
}

}  // namespace omma
