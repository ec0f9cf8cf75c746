// Opacity maps (backend/opacity_maps, physics/surface/opacity.h) only say what reading the image would say,
// in the arithmetic of the read itself, and say it of most places; renders have the same bits
// without them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "backend/backend.h"
#include "backend/denormals.h"
#include "backend/eye_arrays.h"
#include "backend/shading_data.h"
#include "omma/io.h"
#include "physics/rays/replicates.h"
#include "physics/surface/surface.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

float moved_by_ulps(float x, int ulps) {
  const float towards = ulps < 0 ? -10.0f : 10.0f;
  for (int i = 0; i < std::abs(ulps); ++i) x = std::nextafter(x, towards);
  return x;
}

// Blobs, blades, noise or a ramp, of 8-bit or of float alpha.
Image random_cut_out_image(Random& random) {
  const int width = 1 + random.index(40), height = 1 + random.index(40);
  const int kind = random.index(4), period = 2 + random.index(12);
  const double slope = random.uniform(0, 2);
  const auto alpha = [&](int x, int y) {
    switch (kind) {
      case 0:
        return std::hypot(x - 0.5 * width, y - 0.4 * height) < 0.35 * width ? 1.0 : 0.0;
      case 1:
        return (x + static_cast<int>(slope * y)) % period < 2 ? 1.0 : 0.0;
      case 2:
        return random.uniform();
      default:
        return (x + slope * y) / (width + 2.0 * height);
    }
  };
  if (random.index(2) == 0)
    return make_image(width, height, [&](int x, int y) {
      // Of floats alpha may be anything.
      const double a = kind == 3 ? 3 * alpha(x, y) - 1 : alpha(x, y);
      return Vec4{0.5f, 0.5f, 0.5f, static_cast<float>(a)};
    });
  Image image;
  image.width = width, image.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto code = static_cast<std::uint8_t>(std::lround(255 * alpha(x, y)));
      image.rgba_srgb8.insert(image.rgba_srgb8.end(), {90, 120, 30, code});
    }
  return image;
}

// A mesh of cut-out triangles of all sizes in the image, some many repeats wide or far away in it.
Scene random_cut_out(Random& random, int triangles) {
  Scene scene;
  const Wrap wraps[] = {Wrap::repeat, Wrap::mirrored_repeat, Wrap::clamp_to_edge};
  Texture texture;
  texture.wrap_u = wraps[random.index(3)];
  texture.wrap_v = wraps[random.index(3)];
  texture.filter = random.index(3) == 0 ? Filter::nearest : Filter::linear;
  Material material;
  if (random.index(8) != 0)
    material.base_color_texture.texture = add_texture(scene, random_cut_out_image(random), texture);
  if (random.index(3) == 0) {
    material.base_color_texture.offset = {static_cast<float>(random.uniform(-2, 2)), 0.3f};
    material.base_color_texture.scale = {1.7f, static_cast<float>(random.uniform(-1, 1))};
    material.base_color_texture.rotation_rad = static_cast<float>(random.uniform(-3, 3));
  }
  const float cutoffs[] = {
      0.5f, 0.5f, 0.0f, 1.0f, -0.1f, 127.0f / 255.0f, static_cast<float>(random.uniform())};
  material.alpha_mode = AlphaMode::mask;
  material.alpha_cutoff = cutoffs[random.index(7)];
  if (random.index(3) == 0) material.base_color.w = static_cast<float>(random.uniform(0, 3));
  // One alpha, and a cutoff within its rounding.
  if (random.index(8) == 0) {
    const auto alpha = static_cast<float>(random.uniform());
    for (Image& image : scene.images)
      image = make_image(9, 7, [&](int, int) { return Vec4{1, 1, 1, alpha}; });
    material.alpha_cutoff = moved_by_ulps(
        (scene.images.empty() ? 1.0f : alpha) * material.base_color.w, random.index(9) - 4);
  }
  add_material(scene, material);
  const bool has_colors = random.index(2) == 0, one_alpha = random.index(2) == 0;
  Mesh mesh;
  mesh.material = 0;
  for (int t = 0; t < triangles; ++t) {
    const double size = std::pow(10.0, random.uniform(-3, 1));
    const double far = random.index(5) == 0 ? std::pow(10.0, random.uniform(0, 6)) : 1;
    const Vec2 near{static_cast<float>(far * random.uniform(-1, 1)),
                    static_cast<float>(far * random.uniform(-1, 1))};
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back(to_float(random.direction()));
      mesh.texcoords[0].push_back({near.x + static_cast<float>(size * random.uniform(-1, 1)),
                                   near.y + static_cast<float>(size * random.uniform(-1, 1))});
      if (has_colors)
        mesh.colors.push_back(
            {1, 1, 1,
             one_alpha ? 1.0f : static_cast<float>(std::max(random.uniform(-1, 1.5), 0.0))});
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  add_instance(scene, add_mesh(scene, std::move(mesh)));
  if (random.index(6) == 0) scene.color_rule = ColorRule::compoundray;
  validate_scene(scene);
  return scene;
}

// Places where a map or a read is on the edge between two answers, and any others.
Vec2 awkward_place(Random& random, const SceneView& scene, std::uint32_t triangle) {
  const MeshView& mesh = scene.meshes[0];
  float u = static_cast<float>(random.uniform()), v = static_cast<float>(random.uniform());
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const auto side = static_cast<float>(1 << (mesh.opacity[triangle] & 15));
  const int kind = random.index(6);
  if (kind == 1 || kind == 2) u = std::floor(u * side) / side;  // edges between pieces
  if (kind == 2) v = std::floor(v * side) / side;
  if (kind == 3) v = (std::floor((u + v) * side) - u * side) / side;  // their diagonals
  if (kind == 4 && mesh.base_uv != nullptr) {  // borders and centres of texels
    const TextureView& texture = scene.textures[scene.materials[0].base_texture];
    const int axis = random.index(2), size = axis == 0 ? texture.width : texture.height;
    const double a = mesh.base_uv[6 * triangle + static_cast<unsigned>(axis)];
    const double b = mesh.base_uv[6 * triangle + 2 + static_cast<unsigned>(axis)];
    const double c = mesh.base_uv[6 * triangle + 4 + static_cast<unsigned>(axis)];
    const double found = a + (b - a) * u + (c - a) * v;
    const double wanted = std::round(found * size * 2) / (2.0 * size);
    if (b != a) u += static_cast<float>((wanted - found) / (b - a));
  }
  if (kind == 5) {  // edges of the triangle
    const int edge = random.index(3);
    if (edge == 0) u = 0;
    if (edge == 1) v = 0;
    if (edge == 2) v = 1 - u;
  }
  return {moved_by_ulps(u, random.index(7) - 3), moved_by_ulps(v, random.index(7) - 3)};
}

struct Agreement {
  int places = 0, decided = 0, wrong = 0;
};

Agreement compare(Random& random, const SceneView& scene, std::uint32_t triangles, int places) {
  Agreement found;
  for (int i = 0; i < places; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random.index(static_cast<int>(triangles)));
    const Vec2 at = awkward_place(random, scene, triangle);
    const Opacity state =
        find_opacity(scene.meshes[0].opacity[triangle], scene.opacity_states, at.x, at.y);
    ++found.places;
    if (state == Opacity::ask) continue;
    ++found.decided;
    if (is_above_cutoff(scene, {0, triangle, at.x, at.y}) != (state == Opacity::opaque))
      ++found.wrong;
  }
  return found;
}

TEST(OpacityMaps, SayWhatTheImageSays) {
  Random random{11};
  Agreement all;
  for (int i = 0; i < 600; ++i) {
    const Scene scene = random_cut_out(random, 20);
    const auto data = make_shading_data(scene);
    // As while tracing, and not.
    const auto compare_some = [&] { return compare(random, data->view, 20, 4000); };
    Agreement found;
    if (i % 2 == 0) {
      const DenormalsAreZero denormals_are_zero;
      found = compare_some();
    } else {
      found = compare_some();
    }
    ASSERT_EQ(found.wrong, 0) << "scene " << i << " of " << found.decided << " decided";
    all.places += found.places, all.decided += found.decided;
  }
  // Half of the places chosen lie on edges, and images are noise and small: still most are decided.
  EXPECT_GT(all.decided, all.places / 2);
}

// A leaf of ten lobes in a square image.
Image leaf_image(int size) {
  return make_image(size, size, [&](int x, int y) {
    const double dx = (x + 0.5) / size - 0.5, dy = (y + 0.5) / size - 0.5;
    const double edge = 0.3 + 0.12 * std::cos(10 * std::atan2(dy, dx));
    return Vec4{0.2f, 0.5f, 0.1f, std::hypot(dx, dy) < edge ? 1.0f : 0.0f};
  });
}

Scene leaf(const Image& image) {
  Scene scene;
  Material material;
  material.base_color_texture.texture = add_texture(scene, image);
  material.alpha_mode = AlphaMode::mask;
  material.double_sided = true;
  add_material(scene, material);
  add_mesh(scene, quad({0, 0, -2}, {1, 0, 0}, {0, 1, 0}, 0));
  return scene;
}

TEST(OpacityMaps, SeldomAskOfALeaf) {
  const auto data = make_shading_data(leaf(leaf_image(256)));
  Random random{3};
  int count[3] = {};
  constexpr int places = 100000;
  for (int i = 0; i < places; ++i) {
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto triangle = static_cast<std::uint32_t>(i % 2);
    ++count[static_cast<int>(find_opacity(data->meshes[0].opacity[triangle],
                                          data->view.opacity_states, static_cast<float>(u),
                                          static_cast<float>(v)))];
  }
  // The leaf's outline is some 1,050 texels long. Reads change within a texel of it, and pieces
  // are a texel wide: a band of some three texels, a twentieth of the image.
  EXPECT_LT(count[0], places * 0.07);
  // The area of the leaf: pi (0.3^2 + 0.12^2 / 2).
  EXPECT_NEAR(count[2] / static_cast<double>(places), 0.305, 0.035);
}

TEST(OpacityMaps, OfOneKindNeedNoStates) {
  for (const float alpha : {0.0f, 1.0f}) {
    const auto data = make_shading_data(leaf(make_image(64, 64, [&](int, int) {
      return Vec4{1, 1, 1, alpha};
    })));
    EXPECT_TRUE(data->opacity.states.empty());
    const Opacity state = alpha > 0 ? Opacity::opaque : Opacity::transparent;
    EXPECT_EQ(find_opacity(data->meshes[0].opacity[1], data->view.opacity_states, 0.3f, 0.3f),
              state);
  }
}

TEST(OpacityMaps, AreSharedByTrianglesThatAreCutOutAlike) {
  Scene scene = leaf(leaf_image(256));
  const std::size_t of_one = make_shading_data(scene)->opacity.states.size();
  for (int i = 1; i < 50; ++i) add_mesh(scene, quad({0.1 * i, 0, -2}, {1, 0, 0}, {0, 1, 0}, 0));
  EXPECT_EQ(make_shading_data(scene)->opacity.states.size(), of_one);
}

// Triangles that all differ, so that none shares its map.
Scene many_leaves(Random& random, int triangles, double size) {
  Scene scene = leaf(leaf_image(512));
  Mesh mesh;
  mesh.material = 0;
  for (int t = 0; t < triangles; ++t) {
    const Vec2 at{static_cast<float>(random.uniform()), static_cast<float>(random.uniform())};
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back(to_float(random.direction()));
      mesh.texcoords[0].push_back({at.x + static_cast<float>(size * random.uniform(-1, 1)),
                                   at.y + static_cast<float>(size * random.uniform(-1, 1))});
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  scene.meshes[0] = std::move(mesh);
  return scene;
}

TEST(OpacityMaps, StayWithinTheirMemory) {
  Random random{5};
  struct Case {
    int triangles;
    double size;
  };
  for (const auto [triangles, size] : {Case{40000, 0.02}, Case{20000, 0.5}, Case{30, 8.0}}) {
    const Scene scene = many_leaves(random, triangles, size);
    const auto data = make_shading_data(scene);
    EXPECT_LE(
        data->opacity.states.size() * sizeof(std::int32_t),
        most_opacity_bytes + most_opacity_bytes_per_triangle * static_cast<std::size_t>(triangles));
    EXPECT_EQ(data->opacity.triangles[0].size(), static_cast<std::size_t>(triangles));
    const Agreement found =
        compare(random, data->view, static_cast<std::uint32_t>(triangles), 100000);
    EXPECT_EQ(found.wrong, 0) << triangles;
    EXPECT_GT(found.decided, 0) << triangles;
  }
}

TEST(OpacityMaps, AreTheSameOfVerticesAsOfCorners) {
  Random random{6};
  for (int i = 0; i < 20; ++i) {
    const Scene scene = random_cut_out(random, 50);
    const auto data = make_shading_data(scene);
    // Corners in another order, as vertices that an index names.
    const std::size_t corners = 3 * scene.meshes[0].triangles.size();
    std::vector<std::int32_t> vertex_of_corner(corners);
    std::vector<float> uvs(2 * corners), colors(4 * corners);
    MeshView mesh = data->meshes[0];
    for (std::size_t c = 0; c < corners; ++c) {
      const std::size_t at = corners - 1 - c;
      vertex_of_corner[c] = static_cast<std::int32_t>(at);
      for (std::size_t k = 0; k < 2 && mesh.base_uv != nullptr; ++k)
        uvs[2 * at + k] = mesh.base_uv[2 * c + k];
      for (std::size_t k = 0; k < 4 && mesh.colors != nullptr; ++k)
        colors[4 * at + k] = mesh.colors[4 * c + k];
    }
    mesh.vertex_of_corner = vertex_of_corner.data();
    if (mesh.base_uv != nullptr) mesh.base_uv = uvs.data();
    if (mesh.colors != nullptr) mesh.colors = colors.data();
    SceneView view = data->view;
    view.meshes = &mesh;
    const std::size_t triangles = corners / 3;
    const OpacityMaps maps = make_opacity_maps(view, {&triangles, 1});
    EXPECT_EQ(maps.triangles[0], data->opacity.triangles[0]);
    EXPECT_EQ(maps.states, data->opacity.states);
  }
}

std::vector<float> rendered(const Scene& scene, const Eye& eye, const Mat4& world_from_head,
                            bool with_maps) {
  const auto shading = make_shading_data(scene);
  if (!with_maps)
    for (MeshView& mesh : shading->meshes) mesh.opacity = nullptr;
  const BackgroundData background = make_background_data(scene.background);
  SceneView view = shading->view;
  view.background = background.view;
  const Placement placement = placement_of(scene);
  const Backend& backend = find_backend(backend_under_test);
  const Acceleration built = backend.build(scene, shading->view, placement, {}, nullptr);
  const DirectionTables directions = make_direction_tables(eye, {}, 21);
  const EyeArrays arrays = make_eye_arrays(eye, directions);
  const DirectionsView directions_view = omma::view(directions);
  const EyeView eye_view = omma::view(arrays);
  const FrameView frame{&view, &eye_view, &directions_view};
  std::vector<float> responses(eye.size() * rgb_bands, -1.0f);
  BlockTask task;
  const double origin[3] = {placement.origin_m.x, placement.origin_m.y, placement.origin_m.z};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c)
      task.world_from_head[r][c] =
          static_cast<float>(world_from_head.m[r][c] - (c == 3 ? origin[r] : 0));
  task.responses = responses.data();
  std::vector<BlockTask> tasks;
  const int ommatidia = static_cast<int>(eye.size());
  for (task.first = 0; task.first < ommatidia; task.first += most_per_block) {
    task.count = std::min(most_per_block, ommatidia - task.first);
    tasks.push_back(task);
  }
  backend.launches({}).render(frame, tasks, built.tracer.get());
  return responses;
}

TEST(OpacityMaps, LeaveTheBitsOfRenders) {
  const Eye eye = make_eye(sphere_directions(200), 12 * degree);
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    Scene scene = random_scene(seed);
    for (Material& material : scene.materials)
      if (material.alpha_mode == AlphaMode::opaque && seed % 2 == 0)
        material.alpha_mode = AlphaMode::mask;
    EXPECT_EQ(rendered(scene, eye, {}, true), rendered(scene, eye, {}, false)) << seed;
  }
}

TEST(OpacityMaps, LeaveTheBitsOfTheMeadow) {
  const Scene scene = load_scene(OMMA_EXAMPLES "/meadow.glb");
  const Mat4 bee = find_camera(scene, "bee").world_from_camera;
  const Eye eye = make_eye(sphere_directions(200), 3 * degree);
  const std::vector<float> with = rendered(scene, eye, bee, true);
  EXPECT_EQ(with, rendered(scene, eye, bee, false));
  Scene opaque = scene;
  for (Material& material : opaque.materials) material.alpha_mode = AlphaMode::opaque;
  EXPECT_NE(with, rendered(opaque, eye, bee, true)) << "no cut-out is seen";
}

}  // namespace
}  // namespace omma::test
