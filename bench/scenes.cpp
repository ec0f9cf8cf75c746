// See scenes.h.
#include "scenes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>

namespace omma::bench {
namespace {

const std::string data = OMMA_SHARED_DATA "/compound-ray";
const std::string examples = OMMA_EXAMPLES;

// Squares of two greys, `squares` across a texture 256 pixels wide; of 8-bit sRGB.
void add_checkerboard(Scene& scene, int squares, int dark, int light) {
  Image image;
  image.width = image.height = 256;
  const int side = 256 / squares;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const auto value = static_cast<std::uint8_t>((x / side + y / side) % 2 == 0 ? dark : light);
      image.rgba_srgb8.insert(image.rgba_srgb8.end(), {value, value, 90, 255});
    }
  scene.images.push_back(std::move(image));
  scene.textures.push_back({0, Wrap::repeat, Wrap::repeat, Filter::linear});
  Material material;
  material.base_color_texture.texture = 0;
  material.double_sided = true;
  scene.materials.push_back(material);
}

// A grid of cells x cells over a square of `side_m`, its texture repeated every `repeat_m`.
template <typename Height>
Scene make_ground(int cells, double side_m, double repeat_m, const Height& height) {
  Scene scene;
  Mesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = side_m * i / cells - side_m / 2, z = side_m * j / cells - side_m / 2;
      mesh.positions.push_back(to_float({x, height(x, z), z}));
      mesh.texcoords[0].push_back(
          {static_cast<float>(x / repeat_m), static_cast<float>(z / repeat_m)});
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (cells + 1) + i);
      const std::uint32_t b = a + 1, c = a + static_cast<std::uint32_t>(cells) + 1, d = c + 1;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  mesh.material = 0;
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({"ground", 0, {}});
  scene.background.type = BackgroundType::simple_sky;
  return scene;
}

Eye bundled_eye() {
  const PlacedEye eyes[] = {{load_eye(examples + "/honeybee_worker_left.eye"), {}},
                            {load_eye(examples + "/honeybee_worker_right.eye"), {}}};
  return merge_eyes(eyes);
}

}  // namespace

bool have_data(const char* left_out) {
  if (std::filesystem::exists(data)) return true;
  std::fprintf(stderr, "left out: %s (no CompoundRay data at %s)\n", left_out, data.c_str());
  return false;
}

std::string data_folder() {
  return data;
}

Eye bee_eye() {
  if (std::filesystem::exists(data)) return load_eye(data + "/bees/AM_60185-real.eye");
  return bundled_eye();
}

Eye thousand_eye() {
  return load_eye(data + "/scenes/eyes/1000-equidistant.eye");
}

Eye even_eye(int n) {
  Eye eye;
  for (int i = 0; i < n; ++i) {
    const double y = 1 - (2 * i + 1.0) / n, r = std::sqrt(1 - y * y);
    const double turn = i * pi * (3 - std::sqrt(5.0));
    eye.axis.push_back(to_float({r * std::cos(turn), y, r * std::sin(turn)}));
    eye.position_m.push_back({});
    eye.acceptance_angle_rad.push_back(static_cast<float>(3 * degree));
    eye.focal_offset_m.push_back(0);
    eye.eye_id.push_back(0);
  }
  validate_eye(eye);
  return eye;
}

Eye sector(const Eye& eye, std::size_t n) {
  std::vector<std::size_t> order(eye.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return azimuth_elevation_rad(eye.axis[a]).x < azimuth_elevation_rad(eye.axis[b]).x;
  });
  const std::size_t end = eye.size() / 2;
  order = {order.begin() + static_cast<std::ptrdiff_t>(end - std::min(end, eye.size() / n)),
           order.begin() + static_cast<std::ptrdiff_t>(end)};
  Eye few;
  for (std::size_t i : order) {
    few.position_m.push_back(eye.position_m[i]);
    few.axis.push_back(eye.axis[i]);
    few.acceptance_angle_rad.push_back(eye.acceptance_angle_rad[i]);
    few.focal_offset_m.push_back(eye.focal_offset_m[i]);
    few.eye_id.push_back(eye.eye_id[i]);
  }
  return few;
}

Setup meadow() {
  return {"natural-standin-sky",
          std::make_shared<const Scene>(load_scene(data + "/scenes/natural-standin-sky.gltf")),
          bee_eye(),
          {pose_from_quaternion({0.0, 0.15, 0.0}, 0, 0, 0, 1)}};
}

Setup arena() {
  auto scene = std::make_shared<const Scene>(load_scene(data + "/scenes/ofstad-arena.gltf"));
  const auto camera = std::find_if(scene->cameras.begin(), scene->cameras.end(),
                                   [](const Camera& c) { return c.type == CameraType::compound; });
  Mat4 pose = camera->world_from_camera;
  for (int c = 0; c < 3; ++c) {
    const double scale = length({pose.m[0][c], pose.m[1][c], pose.m[2][c]});
    for (int r = 0; r < 3; ++r) pose.m[r][c] /= scale;
  }
  return {"arena", scene, bee_eye(), {pose}};
}

Setup bundled() {
  auto scene = std::make_shared<const Scene>(load_scene(examples + "/meadow.glb"));
  return {"bundled meadow", scene, bundled_eye(), {find_camera(*scene, "bee").world_from_camera}};
}

Setup bundled_lit() {
  auto scene = std::make_shared<const Scene>(load_scene(examples + "/meadow_lit.glb"));
  return {"bundled meadow lit", scene, bundled_eye(), {find_camera(*scene, "bee").world_from_camera}};
}

Setup bundled_opaque() {
  Setup setup = bundled();
  Scene scene = *setup.scene;
  for (Material& material : scene.materials) material.alpha_mode = AlphaMode::opaque;
  return {"bundled meadow opaque", std::make_shared<const Scene>(std::move(scene)), setup.eye,
          setup.poses};
}

Setup hills(int cells) {
  const auto height = [](double x, double z) {
    return 6 * std::sin(0.02 * x) * std::cos(0.017 * z) + 0.7 * std::sin(0.31 * x + 0.2 * z) +
           0.2 * std::sin(1.3 * x) * std::sin(1.1 * z);
  };
  Scene scene = make_ground(cells, 1000, 10, height);
  add_checkerboard(scene, 8, 75, 195);
  return {"hills",
          std::make_shared<const Scene>(std::move(scene)),
          bee_eye(),
          {pose_from_quaternion({0, height(0, 0) + 2.0, 0}, 0, 0, 0, 1)}};
}

Setup checkerboard() {
  Scene scene = make_ground(64, 400, 8 * 0.05, [](double, double) { return 0.0; });
  add_checkerboard(scene, 8, 30, 220);
  return {"checkerboard",
          std::make_shared<const Scene>(std::move(scene)),
          bee_eye(),
          {pose_from_quaternion({0, 1.5, 0}, 0, 0, 0, 1)}};
}

std::vector<Mat4> flight(const Setup& setup, std::size_t count) {
  std::vector<Mat4> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double turn = 2 * pi * static_cast<double>(i) / 256;
    Mat4 step = pose_from_quaternion({0.05 * std::cos(turn), 0, 0.05 * std::sin(turn)}, 0,
                                     std::sin(turn / 2), 0, std::cos(turn / 2));
    poses.push_back(setup.poses.front() * step);
  }
  return poses;
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double best_seconds(double least_s, const std::function<void()>& work) {
  double best_s = 1e9;
  const auto start = Clock::now();
  for (int i = 0; i < 3 || seconds_since(start) < least_s; ++i) {
    const auto before = Clock::now();
    work();
    best_s = std::min(best_s, seconds_since(before));
  }
  return best_s;
}

}  // namespace omma::bench
