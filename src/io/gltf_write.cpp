// Scenes as .glb files that load_scene reads to equal ones, bit for bit, and that other programs
// open. Nodes are flat: one for each set of instances that move together, each camera and each hit
// box, with their whole transforms. What glTF has no place for is in extras: backgrounds, and the
// values of images in linear floats, of which others see 8 bits.
//
// Not written is what nobody sees: meshes that no instance places, textures and images that no
// material uses; nor the colour rule, and names of meshes that share a node, but the first. The
// loader gives the others in the order of their first use, and a mesh that is alone in one node and
// with others in another twice.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "io/glb_bytes.h"
#include "io/image_formats.h"
#include "model/long_work.h"
#include "omma/error.h"
#include "omma/io.h"

namespace omma {
namespace {

using nlohmann::json;

// Numbers of the glTF 2.0 specification.
constexpr int gl_float = 5126, gl_unsigned_int = 5125, gl_triangles = 4;
constexpr int gl_array_buffer = 34962, gl_element_array_buffer = 34963;

struct Writer {
  const Scene& scene;
  json document = {{"asset", {{"version", "2.0"}, {"generator", "Omma"}}}};
  std::string binary = {};
  std::map<std::size_t, json> primitives = {};          // by mesh of the scene
  std::map<std::vector<std::size_t>, int> meshes = {};  // by the meshes of a node

  int push(const char* list, json element) {
    document[list].push_back(std::move(element));
    return static_cast<int>(document[list].size()) - 1;
  }

  void use_extension(const char* name) {
    json& used = document["extensionsUsed"];
    if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
  }

  int view(const void* data, std::size_t bytes, int target = 0) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json made = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes}};
    if (target != 0) made["target"] = target;
    binary.append(static_cast<const char*>(data), bytes);
    return push("bufferViews", std::move(made));
  }

  template <typename Vector>
  int floats(const std::vector<Vector>& values) {
    constexpr int components = sizeof(Vector) / sizeof(float);
    const int at = view(values.data(), values.size() * sizeof(Vector), gl_array_buffer);
    return push("accessors", {{"bufferView", at},
                              {"componentType", gl_float},
                              {"count", values.size()},
                              {"type", "VEC" + std::to_string(components)}});
  }
};

json numbers(Vec2 v) {
  return {v.x, v.y};
}
json numbers(Vec3 v) {
  return {v.x, v.y, v.z};
}
json numbers(Vec4 v) {
  return {v.x, v.y, v.z, v.w};
}

json matrix(const Mat4& t) {  // column major
  json values = json::array();
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) values.push_back(t.m[r][c]);
  return values;
}

void set_name(json& object, const std::string& name) {
  if (!name.empty()) object["name"] = name;
}

std::uint8_t srgb8(float linear) {
  const double v = std::clamp(static_cast<double>(linear), 0.0, 1.0);
  const double encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

// What an 8-bit PNG holds of an image.
std::vector<std::uint8_t> eight_bits(const Image& image) {
  if (!image.rgba_srgb8.empty()) return image.rgba_srgb8;
  std::vector<std::uint8_t> rgba(image.rgba_linear.size());
  for (std::size_t i = 0; i < rgba.size(); ++i) {
    const float value = image.rgba_linear[i];
    rgba[i] = i % 4 == 3 ? static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.f, 1.f)))
                         : srgb8(value);
  }
  return rgba;
}

int write_image(Writer& writer, const Image& image, const std::string& place,
                const WorkPart& work) {
  std::vector<std::uint8_t> pixels = eight_bits(image);
  bool opaque = true;
  for (std::size_t i = 3; i < pixels.size() && opaque; i += 4) opaque = pixels[i] == 255;
  if (opaque) {
    for (std::size_t i = 0; i < pixels.size() / 4; ++i)
      std::copy_n(&pixels[4 * i], 3, &pixels[3 * i]);
    pixels.resize(pixels.size() / 4 * 3);
  }
  const std::string png =
      encode_png(pixels, image.width, image.height, opaque ? 3 : 4, place, work);
  json made = {{"mimeType", "image/png"}, {"bufferView", writer.view(png.data(), png.size())}};
  set_name(made, image.name);
  if (!image.rgba_linear.empty())
    made["extras"]["omma-linear-rgba"] =
        writer.view(image.rgba_linear.data(), image.rgba_linear.size() * sizeof(float));
  return writer.push("images", std::move(made));
}

json sampler(const Texture& texture) {
  const auto wrap = [](Wrap w) {
    return w == Wrap::repeat ? 10497 : w == Wrap::mirrored_repeat ? 33648 : 33071;
  };
  const bool linear = texture.filter == Filter::linear;
  return {{"wrapS", wrap(texture.wrap_u)},
          {"wrapT", wrap(texture.wrap_v)},
          {"magFilter", linear ? 9729 : 9728},
          {"minFilter", linear ? 9987 : 9984}};  // with levels, as Omma reads them
}

json texture_use(Writer& writer, const TextureUse& use) {
  json made = {{"index", use.texture}};
  if (use.texcoord_set != 0) made["texCoord"] = use.texcoord_set;
  if (use.offset != Vec2{0, 0} || use.scale != Vec2{1, 1} || use.rotation_rad != 0) {
    writer.use_extension("KHR_texture_transform");
    made["extensions"]["KHR_texture_transform"] = {{"offset", numbers(use.offset)},
                                                   {"scale", numbers(use.scale)},
                                                   {"rotation", use.rotation_rad}};
  }
  return made;
}

json written_material(Writer& writer, const Material& material) {
  json made = {{"pbrMetallicRoughness",
                {{"baseColorFactor", numbers(material.base_color)},
                 {"metallicFactor", 0},
                 {"roughnessFactor", 1}}}};
  set_name(made, material.name);
  if (material.base_color_texture.texture >= 0)
    made["pbrMetallicRoughness"]["baseColorTexture"] =
        texture_use(writer, material.base_color_texture);
  if (material.emissive_texture.texture >= 0)
    made["emissiveTexture"] = texture_use(writer, material.emissive_texture);
  const Vec3 e = material.emissive;
  if (e != Vec3{0, 0, 0}) {
    // The factor is at most 1, the strength a power of two, so that their product is exact.
    int exponent = 0;
    std::frexp(std::max({e.x, e.y, e.z, 1.0f}), &exponent);
    const float strength = e.x > 1 || e.y > 1 || e.z > 1 ? std::ldexp(1.0f, exponent) : 1.0f;
    made["emissiveFactor"] = numbers(e * (1 / strength));
    if (strength != 1) {
      writer.use_extension("KHR_materials_emissive_strength");
      made["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = strength;
    }
  }
  if (material.unlit) {
    if (e != Vec3{0, 0, 0} || material.emissive_texture.texture >= 0)
      throw Error("material '" + material.name +
                  "': is unlit and has an emission, which glTF has not for unlit materials");
    writer.use_extension("KHR_materials_unlit");
    made["extensions"]["KHR_materials_unlit"] = json::object();
  }
  constexpr float usual_cutoff = 0.5f;
  if (material.alpha_mode != AlphaMode::opaque || material.alpha_cutoff != usual_cutoff)
    made["alphaMode"] = material.alpha_mode == AlphaMode::mask    ? "MASK"
                        : material.alpha_mode == AlphaMode::blend ? "BLEND"
                                                                  : "OPAQUE";
  if (material.alpha_cutoff != usual_cutoff) made["alphaCutoff"] = material.alpha_cutoff;
  if (material.double_sided) made["doubleSided"] = true;
  return made;
}

// Positions with their bounds, which glTF asks for, and triangles.
json written_triangles(Writer& writer, const std::vector<Vec3>& positions,
                       const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  Vec3 low = positions[0], high = positions[0];
  for (const Vec3 p : positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const int at = writer.floats(positions);
  json& accessor = writer.document["accessors"][static_cast<std::size_t>(at)];
  accessor["min"] = numbers(low);
  accessor["max"] = numbers(high);
  const int indices = writer.view(triangles.data(), triangles.size() * sizeof(triangles[0]),
                                  gl_element_array_buffer);
  return {{"attributes", {{"POSITION", at}}},
          {"mode", gl_triangles},
          {"indices", writer.push("accessors", {{"bufferView", indices},
                                                {"componentType", gl_unsigned_int},
                                                {"count", 3 * triangles.size()},
                                                {"type", "SCALAR"}})}};
}

const json& written_primitive(Writer& writer, std::size_t index) {
  const auto [found, is_new] = writer.primitives.try_emplace(index);
  if (!is_new) return found->second;
  const Mesh& mesh = writer.scene.meshes[index];
  json& made = found->second = written_triangles(writer, mesh.positions, mesh.triangles);
  json& attributes = made["attributes"];
  if (!mesh.normals.empty()) attributes["NORMAL"] = writer.floats(mesh.normals);
  for (std::size_t set = 0; set < mesh.texcoords.size(); ++set)
    if (!mesh.texcoords[set].empty())
      attributes["TEXCOORD_" + std::to_string(set)] = writer.floats(mesh.texcoords[set]);
  if (!mesh.colors.empty()) attributes["COLOR_0"] = writer.floats(mesh.colors);
  if (mesh.material >= 0) made["material"] = mesh.material;
  return made;
}

// The glTF mesh of all that one node places; nodes that place the same share it.
int written_mesh(Writer& writer, const std::vector<std::size_t>& parts) {
  const auto [found, is_new] = writer.meshes.try_emplace(parts);
  if (!is_new) return found->second;
  json primitives = json::array();
  for (const std::size_t part : parts) primitives.push_back(written_primitive(writer, part));
  json made = {{"primitives", std::move(primitives)}};
  set_name(made, writer.scene.meshes[parts[0]].name);
  return found->second = writer.push("meshes", std::move(made));
}

void add_node(Writer& writer, json node, const std::string& name, const Mat4& world_from_node) {
  set_name(node, name);
  if (world_from_node != Mat4{}) node["matrix"] = matrix(world_from_node);
  const int at = writer.push("nodes", std::move(node));
  writer.document["scenes"][0]["nodes"].push_back(at);
}

void write_instances(Writer& writer) {
  struct Node {
    std::size_t first;               // instance
    std::vector<std::size_t> parts;  // meshes
  };
  std::vector<Node> nodes;
  std::map<int, std::size_t> node_of;
  const std::vector<Instance>& instances = writer.scene.instances;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const auto mesh = static_cast<std::size_t>(instances[i].mesh);
    if (writer.scene.meshes[mesh].triangles.empty()) continue;
    std::size_t at = nodes.size();
    if (instances[i].node >= 0) at = node_of.try_emplace(instances[i].node, at).first->second;
    if (at == nodes.size()) nodes.push_back({i, {}});
    nodes[at].parts.push_back(mesh);
  }
  for (const Node& node : nodes) {
    const Instance& instance = instances[node.first];
    add_node(writer, {{"mesh", written_mesh(writer, node.parts)}}, instance.name,
             instance.world_from_mesh);
  }
}

void write_camera(Writer& writer, const Camera& camera) {
  json lens = {{"znear", camera.znear_m}};
  const bool flat = camera.type == CameraType::orthographic;
  if (flat) {
    lens["xmag"] = camera.xmag_m;
    lens["ymag"] = camera.ymag_m;
    lens["zfar"] = camera.zfar_m;
  } else {
    lens["yfov"] = camera.yfov_rad;
    if (camera.aspect_ratio != 0) lens["aspectRatio"] = camera.aspect_ratio;
    if (camera.zfar_m != 0) lens["zfar"] = camera.zfar_m;
  }
  const char* type = flat ? "orthographic" : "perspective";
  json made = {{"type", type}, {type, std::move(lens)}};
  set_name(made, camera.data_name);
  if (!camera.extras_json.empty()) made["extras"] = json::parse(camera.extras_json);
  add_node(writer, {{"camera", writer.push("cameras", std::move(made))}}, camera.name,
           camera.world_from_camera);
}

void write_hit_box(Writer& writer, const HitBox& box) {
  if (box.triangles.empty()) return;
  json mesh = {{"primitives", {written_triangles(writer, box.positions, box.triangles)}},
               {"extras", {{"hitbox", "true"}}}};
  set_name(mesh, box.name);
  add_node(writer, {{"mesh", writer.push("meshes", std::move(mesh))}}, "", box.world_from_mesh);
}

void write_background(Writer& writer, const Background& background, const WorkPart& work) {
  json& extras = writer.document["scenes"][0]["extras"];
  switch (background.type) {
    case BackgroundType::constant:
      extras["background-color"] = numbers(background.color);
      return;
    case BackgroundType::simple_sky:
      extras["background-shader"] = "simple_sky";
      return;
    case BackgroundType::test_pattern:
      extras["background-shader"] = "default_background";
      return;
    case BackgroundType::image:
      extras["background-image"] = write_image(writer, background.image, "background", work);
      return;
  }
}

std::string glb_of(const Scene& scene, const WorkPart& work) {
  Writer writer{scene};
  writer.document["scene"] = 0;
  writer.document["scenes"] = json::array({json::object()});
  const double images = static_cast<double>(scene.images.size() + 1);
  for (std::size_t i = 0; i < scene.images.size(); ++i)
    write_image(writer, scene.images[i], "image " + std::to_string(i),
                work.part(static_cast<double>(i) / images, static_cast<double>(i + 1) / images));
  for (const Texture& texture : scene.textures)
    writer.push("textures", {{"source", texture.image},
                             {"sampler", writer.push("samplers", sampler(texture))}});
  for (const Material& material : scene.materials)
    writer.push("materials", written_material(writer, material));
  write_instances(writer);
  for (const Camera& camera : scene.cameras) write_camera(writer, camera);
  for (const HitBox& box : scene.hit_boxes) write_hit_box(writer, box);
  write_background(writer, scene.background, work.part((images - 1) / images, 1));
  return glb_bytes(writer.document, std::move(writer.binary), "the scene");
}

}  // namespace

void save_scene(const std::string& path, const Scene& scene,
                const std::function<bool(double)>& progress) {
  validate_scene(scene);
  std::string bytes;
  run_watched(progress, [&](WorkState& state) { bytes = glb_of(scene, WorkPart{&state}); });
  write_file_atomically(path, bytes);
}

}  // namespace omma
