// The larger scenes of the render tests, see test_scenes.h.
#include "test_scenes.h"

#include <array>

namespace omma::test {
namespace {

Vec3d random_point(Random& random, double half) {
  return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
}

float random_float(Random& random, double lower, double upper) {
  return static_cast<float>(random.uniform(lower, upper));
}

Vec4 random_color(Random& random) {
  return {random_float(random, 0, 1), random_float(random, 0, 1), random_float(random, 0, 1),
          random_float(random, 0, 1)};
}

Image random_image(Random& random, bool eight_bit) {
  const int width = 2 + random.index(7), height = 2 + random.index(7);
  Image image = make_image(width, height, [&](int, int) { return random_color(random); });
  if (eight_bit) {
    for (const float value : image.rgba_linear)
      image.rgba_srgb8.push_back(static_cast<std::uint8_t>(value * 255.0f + 0.5f));
    image.rgba_linear.clear();
  }
  return image;
}

TextureUse random_use(Random& random, int texture_count) {
  TextureUse use;
  use.texture = random.index(texture_count + 1) - 1;
  use.texcoord_set = random.index(2);
  if (random.index(2) == 0) {
    use.offset = {random_float(random, -1, 1), random_float(random, -1, 1)};
    use.scale = {random_float(random, -2, 2), random_float(random, -2, 2)};
    use.rotation_rad = random_float(random, -pi, pi);
  }
  return use;
}

Material random_material(Random& random, int texture_count) {
  Material material;
  material.base_color = random_color(random);
  material.base_color_texture = random_use(random, texture_count);
  if (random.index(2) == 0) {
    const Vec4 glow = random_color(random);
    material.emissive = {glow.x, glow.y, glow.z};
    material.emissive_texture = random_use(random, texture_count);
  }
  material.alpha_mode = std::array{AlphaMode::opaque, AlphaMode::opaque, AlphaMode::mask,
                                   AlphaMode::blend}[static_cast<std::size_t>(random.index(4))];
  // Half of the cut-outs would otherwise be wholly invisible: the alphas multiply.
  if (material.alpha_mode == AlphaMode::mask) {
    material.base_color.w = 1;
    material.alpha_cutoff = random_float(random, 0.1, 0.5);
  }
  material.double_sided = random.index(2) == 0;
  material.unlit = random.index(4) == 0;
  return material;
}

Mesh random_mesh(Random& random, int material_count) {
  Mesh mesh;
  mesh.material = random.index(material_count + 1) - 1;
  const bool colored = random.index(2) == 0;
  const int triangle_count = 4 + random.index(12);
  for (int i = 0; i < triangle_count; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const Vec3d centre = random_point(random, 0.7);
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back(to_float(centre + random_point(random, 0.5)));
      for (auto& texcoords : mesh.texcoords)
        texcoords.push_back({random_float(random, -1.5, 2.5), random_float(random, -1.5, 2.5)});
      if (colored) mesh.colors.push_back(random_color(random));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    // A neighbour that shares an edge, so that vertices are shared too.
    if (i > 0) mesh.triangles.push_back({first + 1, first, first - 1});
  }
  return mesh;
}

}  // namespace

Scene flat_triangles(std::uint64_t seed, int triangle_count, int colors) {
  Random random{seed};
  Scene scene;
  // Eighths: sums of them are exact in float, whatever their order.
  for (int i = 0; i < colors; ++i)
    add_color(scene, {static_cast<float>(random.index(9)) / 8,
                      static_cast<float>(random.index(9)) / 8, static_cast<float>(i + 1) / 8});
  for (int i = 0; i < triangle_count; ++i) {
    Mesh mesh;
    mesh.material = random.index(colors);
    const Vec3d towards = random.direction();
    const Vec3d centre = towards * random.uniform(1, 3);
    for (int k = 0; k < 3; ++k)
      mesh.positions.push_back(to_float(centre + random_point(random, 0.6)));
    mesh.triangles = {{0, 1, 2}};
    add_instance(scene, add_mesh(scene, mesh));
  }
  scene.background = constant_background({0.25f, 0.5f, 0});
  return scene;
}

Scene random_scene(std::uint64_t seed) {
  Random random{seed};
  Scene scene;
  const std::array wraps{Wrap::repeat, Wrap::mirrored_repeat, Wrap::clamp_to_edge};
  for (std::size_t i = 0; i < 9; ++i)
    add_texture(scene, random_image(random, i % 2 == 0),
                {-1, wraps[i % 3], wraps[i / 3], i % 4 == 3 ? Filter::nearest : Filter::linear});
  for (int i = 0; i < 8; ++i) add_material(scene, random_material(random, 9));
  for (int i = 0; i < 5; ++i) add_mesh(scene, random_mesh(random, 8));
  for (int i = 0; i < 16; ++i) {
    const double mirror = random.index(3) == 0 ? -1 : 1;
    // One number after the other: compilers are free in the order of operands and arguments.
    const Mat4 first_turn = random_rotation(random);
    const Mat4 size =
        scaling({mirror * random.uniform(0.5, 2), random.uniform(0.5, 2), random.uniform(0.5, 2)});
    const Mat4 last_turn = random_rotation(random);
    const Vec3d towards = random.direction();
    const Vec3d place = towards * random.uniform(2, 5);
    const int mesh = random.index(5);
    add_instance(scene, mesh, translation(place) * last_turn * size * first_turn);
  }
  if (seed % 3 == 0) {
    scene.background.type = BackgroundType::test_pattern;
  } else if (seed % 3 == 1) {
    scene.background.type = BackgroundType::simple_sky;
  } else {
    scene.background = image_background(random_image(random, false));
  }
  return scene;
}

}  // namespace omma::test
