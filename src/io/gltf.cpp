// Scenes from glTF 2.0 files (.gltf and .glb). tinygltf reads the structure, and appears here only;
// the layers around it are this project's: gltf_container (chunks, JSON, URIs), gltf_schema
// (types), gltf_accessor and gltf_mesh (geometry), gltf_material (materials and images).
#include "io/gltf.h"

#include <array>
#include <cctype>
#include <cmath>
#include <fstream>  // tinygltf uses it without including it
#include <limits>
#include <set>
#include <string_view>

#include "io/atomic_file.h"
#include "io/gltf_container.h"
#include "io/gltf_material.h"
#include "io/gltf_mesh.h"
#include "io/gltf_nodes.h"
#include "io/gltf_warnings.h"
#include "omma/error.h"
#include "omma/io.h"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#endif
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_INCLUDE_STB_IMAGE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE_WRITE
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace omma {
namespace {

using nlohmann::json;

struct Loader {
  GltfContainer gltf;
  tinygltf::Model model;
  std::vector<GltfNode> nodes;
  GltfWarnings warnings;
  GltfBudget budget;
  Scene scene;
};

constexpr std::array<std::string_view, 5> supported_extensions = {
    "KHR_materials_emissive_strength", "KHR_materials_unlit", "KHR_mesh_quantization",
    "KHR_texture_transform", "OCES_eyes"};  // eyes are nothing to see; load_eye reads them

std::string place_of(const Loader& loader, const char* what, std::size_t index,
                     const std::string& name = "") {
  return loader.gltf.path + ": " + what + " " + std::to_string(index) +
         (name.empty() ? "" : " \"" + name + "\"");
}

std::size_t array_size(const json& document, const char* name) {
  const auto found = document.find(name);
  return found == document.end() ? 0 : found->size();
}

// tinygltf is given the structure only: no URI for it to follow, no image for it to decode.
void parse_structure(Loader& loader) {
  const json& document = loader.gltf.document;
  json structure = {{"asset", {{"version", "2.0"}}}};
  for (const char* part :
       {"scene", "scenes", "nodes", "meshes", "accessors", "bufferViews", "cameras"})
    if (document.contains(part)) structure[part] = document[part];
  const std::string text = structure.dump();
  if (text.size() > std::numeric_limits<unsigned int>::max())
    throw Error(loader.gltf.path + ": its JSON is too large");
  tinygltf::TinyGLTF parser;
  std::string error, warning;
  bool good = false;
  try {
    good = parser.LoadASCIIFromString(&loader.model, &error, &warning, text.c_str(),
                                      static_cast<unsigned int>(text.size()), "");
  } catch (const std::exception& problem) {
    error = problem.what();
  }
  while (!error.empty() && error.back() == '\n') error.pop_back();
  if (!good) throw Error(loader.gltf.path + ": is not valid glTF: " + error);
}

bool is_supported(const std::string& extension) {
  for (const std::string_view supported : supported_extensions)
    if (extension == supported) return true;
  return false;
}

void check_extensions(Loader& loader) {
  const json& document = loader.gltf.document;
  const auto required = document.value("extensionsRequired", std::vector<std::string>());
  for (const std::string& extension : required)
    if (!is_supported(extension))
      throw Error(loader.gltf.path + ": requires the glTF extension " + extension +
                  ", which is not supported");
  const auto used = document.value("extensionsUsed", std::set<std::string>());
  for (const std::string& extension : used)
    if (!is_supported(extension))
      loader.warnings.add("the glTF extension " + extension + " is not supported; it is ignored");
}

Background read_background(Loader& loader, const json& scene) {
  Background background;
  const auto extras = scene.find("extras");
  if (extras == scene.end() || !extras->is_object() || !extras->contains("background-shader"))
    return background;
  const json& shader = (*extras)["background-shader"];
  if (shader == "simple_sky")
    background.type = BackgroundType::simple_sky;
  else if (shader == "default_background")
    background.type = BackgroundType::test_pattern;
  else
    loader.warnings.add("the background shader " + shader.dump() +
                        " is not known; the background is black");
  return background;
}

// Root nodes of the scene asked for. Without any scenes, all nodes that have no parent.
std::vector<int> scene_roots(Loader& loader, const std::vector<int>& parent, int scene_index) {
  const auto& scenes = loader.model.scenes;
  for (const auto& scene : scenes) loader.scene.scene_names.push_back(scene.name);
  const std::string& path = loader.gltf.path;
  if (scene_index < -1 || scene_index >= static_cast<int>(scenes.size()))
    throw Error(path + ": there is no scene " + std::to_string(scene_index) + ", it has " +
                std::to_string(scenes.size()) + " (counted from 0)");
  if (scenes.empty()) {
    std::vector<int> roots;
    for (std::size_t node = 0; node < parent.size(); ++node)
      if (parent[node] < 0) roots.push_back(static_cast<int>(node));
    return roots;  // in the order of their indices
  }
  const int in_file = loader.gltf.document.value("scene", 0);
  const int chosen = scene_index >= 0 ? scene_index : in_file;
  if (chosen >= static_cast<int>(scenes.size()))
    throw Error(path + ": its default scene is " + std::to_string(chosen) + ", it has " +
                std::to_string(scenes.size()) + " (counted from 0)");
  const auto index = static_cast<std::size_t>(chosen);
  std::set<int> seen;
  for (const int root : scenes[index].nodes) {
    const std::string place = place_of(loader, "scene", index, scenes[index].name);
    if (static_cast<std::size_t>(root) >= parent.size())
      throw Error(place + ": its node " + std::to_string(root) + " is not there; there are " +
                  std::to_string(parent.size()) + " nodes");
    if (parent[static_cast<std::size_t>(root)] >= 0)
      throw Error(place + ": its node " + std::to_string(root) + " is no root, it has a parent");
    if (!seen.insert(root).second)
      throw Error(place + ": lists node " + std::to_string(root) + " twice");
  }
  loader.scene.background = read_background(loader, loader.gltf.document["scenes"][index]);
  return {seen.begin(), seen.end()};
}

// CompoundRay's flags: true as a bool, or as a string in any case.
bool is_true(const json& extras, const char* key) {
  const auto found = extras.find(key);
  if (found == extras.end()) return false;
  if (found->is_boolean()) return found->get<bool>();
  if (!found->is_string()) return false;
  std::string text = found->get<std::string>();
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text == "true";
}

std::string text_of(const json& extras, const char* key) {
  const auto found = extras.find(key);
  return found != extras.end() && found->is_string() ? found->get<std::string>() : "";
}

void add_camera(Loader& loader, const tinygltf::Node& node, const Mat4& world_from_node,
                const std::string& place) {
  const auto index = static_cast<std::size_t>(node.camera);
  if (index >= loader.model.cameras.size())
    throw Error(place + ": refers to camera " + std::to_string(index) + ", there are " +
                std::to_string(loader.model.cameras.size()));
  const tinygltf::Camera& source = loader.model.cameras[index];
  Camera camera;
  camera.data_name = source.name;
  camera.name = node.name.empty() ? source.name : node.name;
  if (source.type == "orthographic") {
    camera.type = CameraType::orthographic;
    camera.xmag_m = source.orthographic.xmag;
    camera.ymag_m = source.orthographic.ymag;
    camera.znear_m = source.orthographic.znear;
    camera.zfar_m = source.orthographic.zfar;
  } else {
    camera.yfov_rad = source.perspective.yfov;
    camera.aspect_ratio = source.perspective.aspectRatio;
    camera.znear_m = source.perspective.znear;
    camera.zfar_m = source.perspective.zfar;
  }
  camera.world_from_camera = world_from_node;
  const json& description = loader.gltf.document["cameras"][index];
  if (description.contains("extras")) {
    const json& extras = description["extras"];
    camera.extras_json = extras.dump();
    if (extras.is_object()) {
      camera.compound_structure = text_of(extras, "compound-structure");
      camera.compound_projection = text_of(extras, "compound-projection");
      if (camera.type == CameraType::perspective && is_true(extras, "panoramic"))
        camera.type = CameraType::panoramic;
      else if (camera.type == CameraType::perspective && is_true(extras, "compound-eye"))
        camera.type = CameraType::compound;
    }
  }
  loader.budget.spend(1, sizeof(Camera) + camera.extras_json.size());
  loader.scene.cameras.push_back(std::move(camera));
}

// The scene's meshes for one glTF mesh: one for each primitive that has triangles.
std::vector<int> add_meshes(Loader& loader, GltfMeshReader& reader, std::size_t index) {
  const tinygltf::Mesh& source = loader.model.meshes[index];
  std::vector<int> meshes;
  for (std::size_t p = 0; p < source.primitives.size(); ++p) {
    const tinygltf::Primitive& from = source.primitives[p];
    GltfPrimitive primitive;
    primitive.place =
        place_of(loader, "mesh", index, source.name) + ", primitive " + std::to_string(p);
    primitive.mode = from.mode;
    primitive.indices = from.indices;
    primitive.material = from.material;
    primitive.attributes = from.attributes;
    if (!from.targets.empty())
      loader.warnings.add("morph targets are ignored: the base shape is shown", primitive.place);
    Mesh mesh;
    mesh.name = source.name;
    if (!read_primitive(reader, primitive, mesh)) continue;
    meshes.push_back(static_cast<int>(loader.scene.meshes.size()));
    loader.scene.meshes.push_back(std::move(mesh));
  }
  return meshes;
}

bool is_hit_box(const Loader& loader, std::size_t mesh) {
  const json& description = loader.gltf.document["meshes"][mesh];
  const auto extras = description.find("extras");
  return extras != description.end() && extras->is_object() && is_true(*extras, "hitbox");
}

// All primitives of the mesh in one; nothing of it is drawn.
void add_hit_box(Loader& loader, GltfMeshReader& reader, std::size_t mesh,
                 const Mat4& world_from_node) {
  HitBox box;
  box.name = loader.model.meshes[mesh].name;
  box.world_from_mesh = world_from_node;
  const std::size_t drawn = loader.scene.meshes.size();
  for (const int part : add_meshes(loader, reader, mesh)) {
    const Mesh& from = loader.scene.meshes[static_cast<std::size_t>(part)];
    const auto first = static_cast<std::uint32_t>(box.positions.size());
    box.positions.insert(box.positions.end(), from.positions.begin(), from.positions.end());
    for (const auto& t : from.triangles)
      box.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  loader.scene.meshes.resize(drawn);
  loader.scene.hit_boxes.push_back(std::move(box));
}

void add_nodes(Loader& loader, const std::vector<int>& roots, const WorkPart& work) {
  GltfMeshReader reader{{}, loader.scene.materials, loader.warnings, loader.budget, work};
  for (std::size_t i = 0; i < loader.model.accessors.size(); ++i) {
    reader.accessors.push_back(gltf_accessor(loader.gltf, i));
    // No attribute read here is a matrix.
    if (reader.accessors[i].matrix) reader.accessors[i].components = 0;
    if (reader.accessors[i].components > 0) check_accessor(reader.accessors[i]);
    reader.all += reader.accessors[i].count;
  }
  std::map<std::size_t, std::vector<int>> meshes_of;  // by glTF mesh, once read

  struct Visit {
    int node;
    Mat4 world_from_parent;
  };
  std::vector<Visit> open;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, {}});
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    ++loader.scene.node_count;
    const tinygltf::Node& node = loader.model.nodes[static_cast<std::size_t>(visit.node)];
    const std::string place =
        place_of(loader, "node", static_cast<std::size_t>(visit.node), node.name);
    const Mat4 world_from_node =
        visit.world_from_parent *
        gltf_node_transform(loader.nodes[static_cast<std::size_t>(visit.node)]);
    if (node.skin >= 0)
      loader.warnings.add("skins are ignored: the mesh is shown in its base pose", place);
    if (node.camera >= 0) add_camera(loader, node, world_from_node, place);
    if (node.mesh >= 0) {
      const auto mesh = static_cast<std::size_t>(node.mesh);
      if (mesh >= loader.model.meshes.size())
        throw Error(place + ": refers to mesh " + std::to_string(mesh) + ", there are " +
                    std::to_string(loader.model.meshes.size()));
      if (is_hit_box(loader, mesh)) {
        add_hit_box(loader, reader, mesh, world_from_node);
      } else {
        const auto [found, is_new] = meshes_of.try_emplace(mesh);
        if (is_new) found->second = add_meshes(loader, reader, mesh);
        loader.budget.spend(found->second.size(), sizeof(Instance) + node.name.size());
        for (const int primitive : found->second)
          loader.scene.instances.push_back({node.name, primitive, world_from_node});
      }
    }
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      open.push_back({*child, world_from_node});
  }
}

// What CompoundRay makes of materials (BrainsOnBoard/compound-ray, libEyeRenderer3/shaders.cu and
// MulticamScene.cpp): base colour only, opaque, both sides, textures always repeated and filtered.
void use_compoundray_colors(Scene& scene) {
  scene.color_rule = ColorRule::compoundray;
  for (Material& material : scene.materials) {
    Material plain;
    plain.name = material.name;
    plain.base_color = material.base_color;
    plain.base_color_texture.texture = material.base_color_texture.texture;
    plain.double_sided = true;
    material = std::move(plain);
  }
  for (Texture& texture : scene.textures) texture = {texture.image};
}

// A file may grow into at most this many bytes: ample for meshes that share their vertices and
// nodes that share their meshes, too little for a file made to exhaust the memory.
std::uint64_t memory_budget(const GltfContainer& gltf) {
  std::uint64_t bytes = gltf.file_size;
  for (const std::string& buffer : gltf.buffers) bytes += buffer.size();
  return (std::uint64_t{1} << 28) + 256 * bytes;
}

}  // namespace

Scene parse_scene(std::string file, const std::string& path, const SceneOptions& options,
                  const WorkPart& work) {
  Loader loader;
  loader.gltf = open_gltf(std::move(file), path, work.part(0, 0.5));
  loader.scene.path = path;
  const std::uint64_t budget = memory_budget(loader.gltf);
  loader.budget = {path, budget, budget};
  check_extensions(loader);
  parse_structure(loader);
  loader.nodes = read_gltf_nodes(loader.gltf.document, path);
  const std::vector<int> parent = gltf_node_parents(loader.nodes);
  const std::vector<int> roots = scene_roots(loader, parent, options.scene_index);
  read_materials(loader.gltf, loader.scene, loader.warnings, work.part(0.5, 0.7));
  if (options.color_rule == ColorRule::compoundray) use_compoundray_colors(loader.scene);
  add_nodes(loader, roots, work.part(0.7, 1));
  if (array_size(loader.gltf.document, "animations") > 0)
    loader.warnings.add("animations are ignored: the scene is shown as it stands");
  loader.scene.warnings = loader.warnings.sentences();
  validate_scene(loader.scene);
  return std::move(loader.scene);
}

Scene load_scene(const std::string& path, const SceneOptions& options) {
  Scene scene;
  run_watched(options.progress, [&](WorkState& state) {
    const WorkPart work{&state};
    scene = parse_scene(read_file(path, work.part(0, 0.3)), path, options, work.part(0.3, 1));
  });
  return scene;
}

}  // namespace omma
