// A scene for a page that draws it with a library of its own: meshes with where they stand and the
// colour that an unlit world shows, images, the background's mean. Splats are left out.
#include "scene_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "omma/error.h"

namespace omma::web {
namespace {

const char* name_of(AlphaMode mode) {
  return mode == AlphaMode::opaque ? "opaque" : mode == AlphaMode::mask ? "mask" : "blend";
}

// As KHR_texture_transform says, v pointing down.
val coordinates_of(const Mesh& mesh, const TextureUse& use) {
  std::vector<Vec2> uv = mesh.texcoords[static_cast<std::size_t>(use.texcoord_set)];
  if (uv.empty()) return val::null();
  const float c = std::cos(use.rotation_rad), s = std::sin(use.rotation_rad);
  for (Vec2& at : uv) {
    const Vec2 p{at.x * use.scale.x, at.y * use.scale.y};
    at = {c * p.x + s * p.y + use.offset.x, -s * p.x + c * p.y + use.offset.y};
  }
  return array_of(std::span<const float>(&uv.data()->x, 2 * uv.size()));
}

// The colour: base colour, or emission where there is no other.
void add_material(val& part, const Scene& scene, const Mesh& mesh) {
  static const Material white;
  const Material& m =
      mesh.material < 0 ? white : scene.materials[static_cast<std::size_t>(mesh.material)];
  const Vec4 base = m.base_color;
  const bool shines = base.x == 0 && base.y == 0 && base.z == 0;
  const TextureUse& use = shines ? m.emissive_texture : m.base_color_texture;
  const Vec3 color = shines ? m.emissive : Vec3{base.x, base.y, base.z};
  part.set("colour", list_of(std::vector<float>{color.x, color.y, color.z, base.w}));
  int image = -1;
  bool repeats = true;
  if (use.texture >= 0) {
    const Texture& texture = scene.textures[static_cast<std::size_t>(use.texture)];
    image = texture.image;
    repeats = texture.wrap_u != Wrap::clamp_to_edge || texture.wrap_v != Wrap::clamp_to_edge;
  }
  part.set("image", image);
  part.set("repeats", repeats);
  part.set("texture_coordinates", image < 0 ? val::null() : coordinates_of(mesh, use));
  part.set("alpha", std::string(name_of(m.alpha_mode)));
  part.set("cutoff", m.alpha_cutoff);
  part.set("both_sides", m.double_sided);
}

val part_of(const Scene& scene, const Mesh& mesh, const std::vector<float>& places) {
  val part = val::object();
  part.set("positions", array_of(mesh.positions));
  part.set("triangles", array_of(std::span<const std::uint32_t>(mesh.triangles.data()->data(),
                                                                3 * mesh.triangles.size())));
  part.set("colours", mesh.colors.empty() ? val::null()
                                          : array_of(std::span<const float>(
                                                &mesh.colors.data()->x, 4 * mesh.colors.size())));
  part.set("instances", array_of(places));
  add_material(part, scene, mesh);
  return part;
}

// Linear light as an 8-bit sRGB value.
std::uint8_t srgb8(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  const float value = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255 * value));
}

}  // namespace

val parts_of(const SceneHandle& handle) {
  return checked([&] {
    const Scene& scene = *handle.scene;
    std::vector<std::vector<float>> places(scene.meshes.size());  // [mesh], 16 numbers each
    for (const Instance& instance : scene.instances) {
      std::vector<float>& of_mesh = places[static_cast<std::size_t>(instance.mesh)];
      for (const auto& row : instance.world_from_mesh.m)
        for (const double x : row) of_mesh.push_back(static_cast<float>(x));
    }
    val parts = val::array();
    for (std::size_t m = 0; m < scene.meshes.size(); ++m)
      if (!places[m].empty() && !scene.meshes[m].triangles.empty())
        parts.call<void>("push", part_of(scene, scene.meshes[m], places[m]));
    return parts;
  });
}

val image_of(const SceneHandle& handle, int image) {
  return checked([&] {
    const std::vector<Image>& images = handle.scene->images;
    if (image < 0 || image >= static_cast<int>(images.size()))
      throw Error("image: expected a number under " + std::to_string(images.size()) +
                  " (the scene's images), found " + std::to_string(image));
    const Image& from = images[static_cast<std::size_t>(image)];
    std::vector<std::uint8_t> pixels = from.rgba_srgb8;
    if (pixels.empty()) {
      pixels.resize(from.rgba_linear.size());
      for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = i % 4 == 3 ? static_cast<std::uint8_t>(
                                     std::lround(255 * std::clamp(from.rgba_linear[i], 0.0f, 1.0f)))
                               : srgb8(from.rgba_linear[i]);
    }
    val picture = val::object();
    picture.set("width", from.width);
    picture.set("height", from.height);
    picture.set("pixels", array_of(pixels));
    return picture;
  });
}

val background_of(const Scene& scene) {
  // Seen by rays that are spread evenly over the sphere (a Fibonacci lattice), with nothing before
  // it.
  constexpr int rays = 512;
  auto empty = std::make_shared<Scene>();
  empty->background = scene.background;
  Eye eye;
  for (int i = 0; i < rays; ++i) {
    const double y = 1 - (2 * i + 1.0) / rays, azimuth = i * pi * (3 - std::sqrt(5.0));
    const double across = std::sqrt(1 - y * y);
    eye.axis.push_back(to_float(Vec3d{across * std::sin(azimuth), y, -across * std::cos(azimuth)}));
  }
  eye.position_m.resize(eye.axis.size());
  eye.focal_offset_m.resize(eye.axis.size());
  eye.eye_id.resize(eye.axis.size());
  validate_eye(eye);
  const Renderer renderer(std::move(empty), std::move(eye), {.sampling = Fixed{1}});
  std::vector<float> seen(rays * rgb_bands);
  renderer.render(std::vector<Mat4>(1), seen);
  std::vector<double> mean(rgb_bands, 0.0);
  for (std::size_t i = 0; i < seen.size(); ++i) mean[i % rgb_bands] += seen[i] / double{rays};
  return list_of(mean);
}

}  // namespace omma::web
