// Scenes from glTF 2.0 files (.gltf and .glb). The JSON is parsed once, by gltf_container (chunks,
// JSON, URIs), and checked once, by gltf_schema (types); all readers take what they need from it:
// gltf_accessor and gltf_mesh (geometry), gltf_material (materials and images), gltf_nodes.
#include "io/gltf.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "io/atomic_file.h"
#include "io/csv_text.h"
#include "io/gltf_container.h"
#include "io/gltf_extensions.h"
#include "io/gltf_instances.h"
#include "io/gltf_lights.h"
#include "io/gltf_material.h"
#include "io/gltf_mesh.h"
#include "io/gltf_nodes.h"
#include "io/gltf_rig.h"
#include "io/gltf_splats.h"
#include "io/gltf_textures.h"
#include "io/gltf_warnings.h"
#include "model/scene_place.h"
#include "omma/error.h"
#include "omma/io.h"

namespace omma {
namespace {

using nlohmann::json;

struct Loader {
  GltfContainer gltf;
  std::vector<GltfNode> nodes;
  GltfWarnings warnings;
  Scene scene;
  GltfRigParts rig;
  ColorRule color_rule = ColorRule::gltf;
};

// What the scene's extras say: CompoundRay's "background-shader", or what save_scene writes.
Background read_background(Loader& loader, const json& scene, const std::string& place) {
  Background background;
  const auto extras = scene.find("extras");
  if (extras == scene.end() || !extras->is_object()) return background;
  if (extras->contains("background-shader")) {
    const json& shader = (*extras)["background-shader"];
    if (shader == "simple_sky")
      background.type = BackgroundType::simple_sky;
    else if (shader == "default_background")
      background.type = BackgroundType::test_pattern;
    else
      loader.warnings.add("the background shader " + shader.dump() +
                          " is not known; the background is black");
  } else if (extras->contains("background-color")) {
    background.color = gltf_vec3((*extras)["background-color"]);
  } else if (extras->contains("background-image")) {
    const int index = (*extras)["background-image"].get<int>();
    gltf_element(loader.gltf, "images", "image", index, place + ": background-image");
    background.type = BackgroundType::image;
    background.image = read_gltf_image(loader.gltf, index);
  }
  return background;
}

// Root nodes of the scene asked for. Without any scenes, all nodes that have no parent.
std::vector<int> scene_roots(Loader& loader, const std::vector<int>& parent, int scene_index) {
  const json& document = loader.gltf.document;
  const json& scenes = gltf_list(document, "scenes");
  for (const json& scene : scenes) loader.scene.scene_names.push_back(scene.value("name", ""));
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
  const int chosen = scene_index >= 0 ? scene_index : document.value("scene", 0);
  if (chosen >= static_cast<int>(scenes.size()))
    throw Error(path + ": its default scene is " + std::to_string(chosen) + ", it has " +
                std::to_string(scenes.size()) + " (counted from 0)");
  const json& scene = scenes[static_cast<std::size_t>(chosen)];
  const std::string place = path + ": scene " + std::to_string(chosen) + gltf_name(scene);
  std::set<int> seen;
  for (const int root : scene.value("nodes", std::vector<int>())) {
    const std::string node = ": its node " + std::to_string(root);
    if (static_cast<std::size_t>(root) >= parent.size())
      throw Error(place + node + " is not there; there are " + std::to_string(parent.size()) +
                  " nodes");
    if (parent[static_cast<std::size_t>(root)] >= 0)
      throw Error(place + node + " is no root, it has a parent");
    if (!seen.insert(root).second)
      throw Error(place + ": lists node " + std::to_string(root) + " twice");
  }
  loader.scene.background = read_background(loader, scene, place);
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

void set_extras(Camera& camera, const json& extras) {
  if (extras.empty()) return;  // those say nothing
  camera.extras_json = extras.dump();
  if (!extras.is_object()) return;
  camera.compound_structure = text_of(extras, "compound-structure");
  camera.compound_projection = text_of(extras, "compound-projection");
  if (camera.type == CameraType::perspective && is_true(extras, "panoramic"))
    camera.type = CameraType::panoramic;
  else if (camera.type == CameraType::perspective && is_true(extras, "compound-eye"))
    camera.type = CameraType::compound;
}

void add_camera(Loader& loader, const GltfNode& node, const Mat4& world_from_node) {
  const json& source = gltf_element(loader.gltf, "cameras", "camera", node.camera, node.place);
  const std::string place =
      loader.gltf.path + ": camera " + std::to_string(node.camera) + gltf_name(source);
  Camera camera;
  camera.data_name = source.value("name", "");
  camera.name = node.name.empty() ? camera.data_name : node.name;
  const std::string type = source["type"].get<std::string>();
  if (type != "perspective" && type != "orthographic")
    throw Error(place + ": type: expected perspective or orthographic, found " + shown_text(type));
  const auto lens = source.find(type);
  if (lens == source.end()) throw Error(place + ": " + type + ": is missing, expected an object");
  if (type == "orthographic") {
    camera.type = CameraType::orthographic;
    camera.xmag_m = (*lens)["xmag"].get<double>();
    camera.ymag_m = (*lens)["ymag"].get<double>();
  } else {
    camera.yfov_rad = (*lens)["yfov"].get<double>();
    camera.aspect_ratio = lens->value("aspectRatio", 0.0);
  }
  camera.znear_m = (*lens)["znear"].get<double>();
  camera.zfar_m = lens->value("zfar", 0.0);
  camera.world_from_camera = world_from_node;
  if (source.contains("extras")) set_extras(camera, source["extras"]);
  loader.gltf.budget.spend(1, sizeof(Camera) + camera.extras_json.size());
  loader.scene.cameras.push_back(std::move(camera));
}

// The scene's meshes for one glTF mesh: one for each primitive that has triangles. With the index of
// a node they are that node's alone, as it changes their shape.
std::vector<int> add_meshes(Loader& loader, GltfMeshReader& reader, const json& source,
                            const std::string& place, int reshaping_node = -1) {
  std::vector<int> meshes;
  Deformation deformation;
  std::size_t joints = 0;
  if (reshaping_node >= 0) {
    const GltfNode& node = loader.nodes[static_cast<std::size_t>(reshaping_node)];
    if (node.skin >= 0) joints = gltf_joint_count(loader.gltf, node.skin, node.place);
    deformation.node = reshaping_node;
    deformation.skin = node.skin;
  }
  std::size_t index = 0;
  for (const json& primitive : source["primitives"]) {
    if (has_splats(primitive)) {
      ++index;
      continue;
    }
    Mesh mesh;
    mesh.name = source.value("name", "");
    Deformation one = deformation;
    if (!read_primitive(reader, primitive, place + ", primitive " + std::to_string(index++), mesh,
                        reshaping_node >= 0 ? &one : nullptr, joints))
      continue;
    one.mesh = static_cast<int>(loader.scene.meshes.size());
    if (reshaping_node >= 0) {
      loader.rig.deformations.push_back(std::move(one));
      loader.rig.instance_of_deformation.push_back(
          static_cast<int>(loader.scene.instances.size() + meshes.size()));
    }
    meshes.push_back(static_cast<int>(loader.scene.meshes.size()));
    loader.scene.meshes.push_back(std::move(mesh));
  }
  return meshes;
}

// Splats of a glTF mesh, placed.
void add_splats(Loader& loader, const json& source, const std::string& place,
                const std::string& name, const Mat4& world_from_node) {
  std::size_t index = 0;
  for (const json& primitive : source["primitives"]) {
    const std::string own = place + ", primitive " + std::to_string(index++);
    if (!has_splats(primitive)) continue;
    SplatCloud cloud = read_gltf_splats(loader.gltf, primitive, own, loader.warnings);
    cloud.name = name;
    cloud.world_from_splats = world_from_node;
    if (!cloud.positions.empty()) loader.scene.splats.push_back(std::move(cloud));
  }
}

bool is_not_zero(double weight) {
  return weight != 0;
}

// Whether a node changes the shape of its mesh: bends it, or blends it with others now or some time.
bool reshapes(const GltfNode& node, const json& mesh, bool is_blended) {
  const std::vector<double> weights =
      node.weights.empty() ? mesh.value("weights", std::vector<double>()) : node.weights;
  return node.skin >= 0 || is_blended || std::any_of(weights.begin(), weights.end(), is_not_zero);
}

bool is_hit_box(const json& mesh) {
  const auto extras = mesh.find("extras");
  return extras != mesh.end() && extras->is_object() && is_true(*extras, "hitbox");
}

// All primitives of the mesh in one; nothing of it is drawn.
void add_hit_box(Loader& loader, GltfMeshReader& reader, const json& mesh, const std::string& place,
                 const Mat4& world_from_node) {
  HitBox box;
  box.name = mesh.value("name", "");
  box.world_from_mesh = world_from_node;
  const std::size_t drawn = loader.scene.meshes.size();
  for (const int part : add_meshes(loader, reader, mesh, place)) {
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
  GltfMeshReader reader{loader.gltf, loader.scene.materials, loader.warnings, work};
  for (const json& accessor : gltf_list(loader.gltf.document, "accessors"))
    reader.all += accessor["count"].get<double>();
  std::map<int, std::vector<int>> meshes_of;  // by glTF mesh, once read
  const std::vector<char> blended = gltf_blended_nodes(loader.gltf, loader.nodes.size());

  struct Visit {
    int node;
    bool is_seen;
    Mat4 world_from_parent;
  };
  std::vector<Visit> open;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, true, {}});
  const auto in_file = static_cast<int>(gltf_list(loader.gltf.document, "nodes").size());
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    if (visit.node < in_file) ++loader.scene.node_count;
    const GltfNode& node = loader.nodes[static_cast<std::size_t>(visit.node)];
    const bool is_seen = visit.is_seen && node.is_visible;
    const Mat4 world_from_node = visit.world_from_parent * gltf_node_transform(node);
    if (node.camera >= 0) {
      loader.rig.camera_of_node[visit.node] = static_cast<int>(loader.scene.cameras.size());
      add_camera(loader, node, world_from_node);
    }
    if (node.light >= 0 && is_seen && loader.color_rule == ColorRule::gltf) {
      read_light(loader.gltf, node, world_from_node, loader.scene);
      loader.rig.lamp_nodes.push_back(visit.node);
    }
    if (node.mesh >= 0 && is_seen) {
      const json& mesh = gltf_element(loader.gltf, "meshes", "mesh", node.mesh, node.place);
      const std::string place =
          loader.gltf.path + ": mesh " + std::to_string(node.mesh) + gltf_name(mesh);
      if (is_hit_box(mesh)) {
        loader.rig.hit_box_nodes.push_back(visit.node);
        add_hit_box(loader, reader, mesh, place, world_from_node);
      } else {
        std::vector<int> own;
        const bool is_own = reshapes(node, mesh, blended[static_cast<std::size_t>(visit.node)]);
        const auto [found, is_new] = is_own ? std::pair(meshes_of.end(), false)
                                            : meshes_of.try_emplace(node.mesh);
        if (is_own) own = add_meshes(loader, reader, mesh, place, visit.node);
        if (is_new) found->second = add_meshes(loader, reader, mesh, place);
        const std::vector<int>& placed = is_own ? own : found->second;
        loader.gltf.budget.spend(placed.size(), sizeof(Instance) + node.name.size());
        for (const int primitive : placed)
          loader.scene.instances.push_back({node.name, primitive, world_from_node, visit.node});
        add_splats(loader, mesh, place, node.name, world_from_node);
      }
    }
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      open.push_back({*child, is_seen, world_from_node});
  }
}

// What only a world with a light shows: one sentence counts it. Nothing says so of a primitive
// without a material, and where CompoundRay's colours are asked for it is what was asked for. Who
// saved a scene with Omma knows.
void warn_of_light(Loader& loader) {
  const json& asset = loader.gltf.document["asset"];
  if (asset.contains("generator") && asset["generator"] == omma_generator) return;
  std::set<int> shown, lit;
  for (const Mesh& mesh : loader.scene.meshes) {
    if (mesh.material < 0) continue;
    shown.insert(mesh.material);
    if (!loader.scene.materials[static_cast<std::size_t>(mesh.material)].unlit)
      lit.insert(mesh.material);
  }
  std::string made_for_light;
  const std::size_t lamps = loader.scene.lights.size();
  if (!lit.empty())
    made_for_light = std::to_string(lit.size()) + " of " + std::to_string(shown.size()) +
                     " materials" + (lamps > 0 ? ", " : "");
  if (lamps > 0) made_for_light += std::to_string(lamps) + (lamps == 1 ? " lamp" : " lamps");
  if (!made_for_light.empty())
    loader.warnings.add("without a light surfaces show their own colours, unshaded; made for light: " +
                        made_for_light);
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

}  // namespace

void read_camera_extras(Camera& camera, const std::string& json_text) {
  try {
    set_extras(camera, json::parse(json_text));
  } catch (const json::exception&) {
    throw Error("extras: expected JSON text");
  }
}

Scene parse_scene(std::string file, const std::string& path, const SceneOptions& options,
                  const WorkPart& work) {
  Loader loader;
  loader.gltf = open_gltf(std::move(file), path, work.part(0, 0.4));
  loader.gltf.reading = work.part(0.4, 0.7);
  loader.scene.path = path;
  check_gltf_extensions(loader.gltf, loader.warnings);
  loader.nodes = read_gltf_nodes(loader.gltf.document, path);
  std::vector<int> parent = gltf_node_parents(loader.nodes);
  const std::vector<int> roots = scene_roots(loader, parent, options.scene_index);
  loader.color_rule = options.color_rule;
  read_materials(loader.gltf, loader.scene, loader.warnings, options.color_rule == ColorRule::gltf,
                 work.part(0.4, 0.6));
  if (options.color_rule == ColorRule::compoundray) use_compoundray_colors(loader.scene);
  place_gltf_instances(loader.gltf, loader.nodes, parent, loader.warnings);
  add_nodes(loader, roots, work.part(0.7, 1));
  if (options.color_rule == ColorRule::gltf) warn_of_light(loader);
  read_rig(loader.gltf, loader.nodes, parent, std::move(loader.rig), loader.warnings, loader.scene);
  loader.scene.warnings = loader.warnings.sentences();
  validate_scene(loader.scene);
  for (std::string& warning : place_warnings(loader.scene, "the file has them"))
    loader.scene.warnings.push_back(std::move(warning));
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
