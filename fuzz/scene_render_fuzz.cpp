// Arbitrary bytes as a scene that a small eye then looks at, from its cameras and from the middle:
// numbers that are absurd but finite must do no harm beyond the loader either. Each ends in
// responses or an omma::Error.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/gltf.h"
#include "omma/camera.h"
#include "omma/error.h"
#include "omma/render.h"

namespace {

// Ahead, up and behind; a wide and a narrow sensitivity, a disc of rays and a single ray.
omma::Eye small_eye() {
  omma::Eye eye;
  eye.position_m = {{0, 0, 0}, {0.01f, 0, 0}, {0, 0.01f, 0}, {0, 0, 0}};
  eye.axis = {{0, 0, -1}, {0.6f, 0.8f, 0}, {0, 0, 1}, {0, -0.6f, -0.8f}};
  eye.acceptance_angle_rad = {0.02f, 1.0f, 0.1f, 0};
  eye.focal_offset_m = {0, 0, 0.001f, 0};
  eye.aperture_diameter_m = {0, 0, 0.01f, 0};
  eye.eye_id = {0, 0, 0, 0};
  return eye;
}

bool is_small(const omma::Scene& scene) {
  std::size_t pixels = 0;
  for (const omma::Image& image : scene.images)
    pixels += static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  return omma::triangle_count(scene) <= 20000 && pixels <= 1 << 18;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  omma::SceneOptions options;
  if (size % 2 == 1) options.color_rule = omma::ColorRule::compoundray;
  try {
    const auto scene = std::make_shared<const omma::Scene>(
        omma::parse_scene(std::string(reinterpret_cast<const char*>(data), size),
                          OMMA_FUZZ_BESIDE "/scene.gltf", options));
    if (!is_small(*scene)) return 0;
    omma::RenderSettings settings;
    settings.sampling = omma::Fixed{4};
    settings.threads = 1;
    const omma::Renderer renderer(scene, small_eye(), settings);
    std::vector<omma::Mat4> poses(1);
    for (const omma::Camera& camera : scene->cameras)
      if (poses.size() < 4) poses.push_back(camera.world_from_camera);
    std::vector<float> responses(poses.size() * 4 * 3), errors(responses.size());
    omma::RenderCall call;
    call.standard_error = errors;
    renderer.render(poses, responses, call);
    if (scene->rig != nullptr) {
      omma::World world = renderer.world();
      const int first = 0;
      for (const double time_s : {0.0, 0.5, 1e9}) {
        world.set_time(time_s, {&first, 1});
        renderer.render(poses, responses, call);
      }
    }
    if (scene->cameras.empty()) return 0;
    omma::CameraSettings picture;
    picture.size = {8, 8};
    picture.samples = 1;
    std::vector<float> pixels(8 * 8 * 3);
    omma::render_camera(renderer.world(), scene->cameras.front(), picture, pixels);
  } catch (const omma::Error&) {
  }
  return 0;
}
