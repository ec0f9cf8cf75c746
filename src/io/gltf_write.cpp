// Scenes as .glb files that load_scene reads to equal ones, bit for bit, and that other programs
// open. Nodes are flat: one for each set of instances that move together, each camera, each lamp
// and each hit box, with their whole transforms. What glTF has no place for is in extras:
// backgrounds, spectra, and the values of images in linear floats, of which others see 8 bits.
//
// Not written are animations, and what nobody sees: meshes that no instance places, textures and
// images that no material uses, the scale of normals without a texture, cones of lamps that are no
// spots; nor the colour rule, and names of meshes that share a node, but the first. The loader gives
// the others in the order of their first use, and a mesh that is alone in one node and with others
// in another twice.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "io/glb_bytes.h"
#include "io/gltf_lights.h"
#include "io/gltf_splats.h"
#include "io/gltf_writer.h"
#include "io/image.h"
#include "model/long_work.h"
#include "omma/io.h"

namespace omma {
namespace {

using nlohmann::json;

// Numbers of the glTF 2.0 specification.
constexpr int gl_unsigned_int = 5125, gl_triangles = 4;
constexpr int gl_element_array_buffer = 34963;

json matrix(const Mat4& t) {  // column major
  json values = json::array();
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) values.push_back(t.m[r][c]);
  return values;
}

// What an 8-bit PNG holds of an image; of data, such as normals, the values themselves.
std::vector<std::uint8_t> eight_bits(const Image& image, bool is_data) {
  if (!image.rgba_srgb8.empty()) return image.rgba_srgb8;
  std::vector<std::uint8_t> rgba(image.rgba_linear.size());
  for (std::size_t i = 0; i < rgba.size(); ++i) {
    const double value = std::clamp(static_cast<double>(image.rgba_linear[i]), 0.0, 1.0);
    const bool linear = is_data || i % 4 == 3;
    rgba[i] =
        static_cast<std::uint8_t>(std::lround(255 * (linear ? value : srgb_from_linear(value))));
  }
  return rgba;
}

int write_image(GltfWriter& writer, const Image& image, const std::string& place, bool is_data,
                const WorkPart& work) {
  std::vector<std::uint8_t> pixels = eight_bits(image, is_data);
  bool opaque = true;
  for (std::size_t i = 3; i < pixels.size() && opaque; i += 4) opaque = pixels[i] == 255;
  if (opaque) {
    for (std::size_t i = 0; i < pixels.size() / 4; ++i)
      std::copy_n(&pixels[4 * i], 3, &pixels[3 * i]);
    pixels.resize(pixels.size() / 4 * 3);
  }
  const std::string png =
      encode_png(pixels, image.width, image.height, opaque ? 3 : 4, PngPacking::small, place,
                 work);
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

// Positions with their bounds, which glTF asks for, and triangles.
json written_triangles(GltfWriter& writer, const std::vector<Vec3>& positions,
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

const json& written_primitive(GltfWriter& writer, std::size_t index) {
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
int written_mesh(GltfWriter& writer, const std::vector<std::size_t>& parts) {
  const auto [found, is_new] = writer.meshes.try_emplace(parts);
  if (!is_new) return found->second;
  json primitives = json::array();
  for (const std::size_t part : parts) primitives.push_back(written_primitive(writer, part));
  json made = {{"primitives", std::move(primitives)}};
  set_name(made, writer.scene.meshes[parts[0]].name);
  return found->second = writer.push("meshes", std::move(made));
}

void add_node(GltfWriter& writer, json node, const std::string& name, const Mat4& world_from_node) {
  set_name(node, name);
  if (world_from_node != Mat4{}) node["matrix"] = matrix(world_from_node);
  const int at = writer.push("nodes", std::move(node));
  writer.document["scenes"][0]["nodes"].push_back(at);
}

void write_instances(GltfWriter& writer) {
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

void write_camera(GltfWriter& writer, const Camera& camera) {
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

void write_hit_box(GltfWriter& writer, const HitBox& box) {
  if (box.triangles.empty()) return;
  json mesh = {{"primitives", {written_triangles(writer, box.positions, box.triangles)}},
               {"extras", {{"hitbox", "true"}}}};
  set_name(mesh, box.name);
  add_node(writer, {{"mesh", writer.push("meshes", std::move(mesh))}}, "", box.world_from_mesh);
}

void write_splats(GltfWriter& writer, const SplatCloud& cloud) {
  if (cloud.positions.empty()) return;
  const json mesh = {{"primitives", {written_splats(writer, cloud)}}};
  add_node(writer, {{"mesh", writer.push("meshes", mesh)}}, cloud.name, cloud.world_from_splats);
}

void write_light(GltfWriter& writer, const PunctualLight& light) {
  writer.use_extension(lights_extension);
  json& lights = writer.document["extensions"][lights_extension]["lights"];
  lights.push_back(written_light(light));
  add_node(writer, {{"extensions", {{lights_extension, {{"light", lights.size() - 1}}}}}},
           light.name, light.world_from_light);
}

void write_background(GltfWriter& writer, const Background& background, const WorkPart& work) {
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
      extras["background-image"] = write_image(writer, background.image, "background", false, work);
      return;
  }
}

// Images that are data to all materials, and colours to none.
std::set<int> data_images(const Scene& scene) {
  std::set<int> data, colors;
  const auto add = [&](std::set<int>& to, const TextureUse& use) {
    if (use.texture >= 0) to.insert(scene.textures[static_cast<std::size_t>(use.texture)].image);
  };
  for (const Material& m : scene.materials) {
    for (const TextureUse* use : {&m.base_color_texture, &m.emissive_texture,
                                  &m.specular_color_texture, &m.diffuse_transmission_texture})
      add(colors, *use);
    for (const TextureUse* use :
         {&m.metallic_roughness_texture, &m.normal_texture, &m.transmission_texture,
          &m.clearcoat_texture, &m.clearcoat_roughness_texture, &m.clearcoat_normal_texture,
          &m.extra.texture})
      add(data, *use);
  }
  for (const int image : colors) data.erase(image);
  return data;
}

std::string glb_of(const Scene& scene, const WorkPart& work) {
  GltfWriter writer{scene};
  writer.document["scene"] = 0;
  writer.document["scenes"] = json::array({json::object()});
  const std::set<int> data = data_images(scene);
  const double images = static_cast<double>(scene.images.size() + 1);
  for (std::size_t i = 0; i < scene.images.size(); ++i)
    write_image(writer, scene.images[i], "image " + std::to_string(i),
                data.contains(static_cast<int>(i)),
                work.part(static_cast<double>(i) / images, static_cast<double>(i + 1) / images));
  for (const Texture& texture : scene.textures)
    writer.push("textures", {{"source", texture.image},
                             {"sampler", writer.push("samplers", sampler(texture))}});
  for (const Material& material : scene.materials)
    writer.push("materials", written_material(writer, material));
  write_instances(writer);
  for (const Camera& camera : scene.cameras) write_camera(writer, camera);
  for (const HitBox& box : scene.hit_boxes) write_hit_box(writer, box);
  for (const PunctualLight& light : scene.lights) write_light(writer, light);
  for (const SplatCloud& cloud : scene.splats) write_splats(writer, cloud);
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
