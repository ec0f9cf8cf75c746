// From a scene and two eyes to a picture of what the animal sees, with the C++ library.
//
//   see_through_a_bee SCENE LEFT_EYE RIGHT_EYE PICTURE.png
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "omma/omma.h"

namespace {

void see(const std::string& scene_path, const std::string& left_path, const std::string& right_path,
         const std::string& picture_path) {
  // Load.
  auto scene = std::make_shared<const omma::Scene>(omma::load_scene(scene_path));
  const std::vector<omma::PlacedEye> eyes = {{omma::load_eye(left_path), {}},
                                             {omma::load_eye(right_path), {}}};
  omma::Eye head = omma::merge_eyes(eyes);

  // Build. This makes the acceleration structure once; render as often as you like.
  const omma::Fixed sampling{.samples = 64};  // rays per ommatidium
  const omma::Renderer renderer(scene, std::move(head), {.sampling = sampling});

  // Render: where the scene's first camera is, or else 1.5 m above the origin, looking along -Z.
  const omma::Mat4 world_from_head = scene->cameras.empty()
                                         ? omma::look_at({0, 1.5, 0}, {0, 1.5, -1})
                                         : scene->cameras.front().world_from_camera;
  const std::size_t ommatidia = renderer.eye().size();
  std::vector<float> responses(ommatidia * omma::rgb_bands);  // [ommatidium][channel], linear
  renderer.render({&world_from_head, 1}, responses);

  double mean[omma::rgb_bands] = {};
  for (std::size_t i = 0; i < responses.size(); ++i)
    mean[i % omma::rgb_bands] += responses[i] / static_cast<double>(ommatidia);
  std::printf("%zu ommatidia, %d rays each, %s, mean response %.4f %.4f %.4f\n", ommatidia,
              sampling.samples, renderer.backend().c_str(), mean[0], mean[1], mean[2]);

  // Save: every pixel shows the ommatidium whose axis is nearest, if it is within 5 degrees.
  const int width = 1024, height = 512;
  const std::vector<std::int32_t> ids = omma::equirectangular_ids(
      renderer.eye(), width, height, static_cast<float>(5 * omma::degree));
  omma::save_png(picture_path, omma::paint(ids, responses), width, height, 3);
  std::printf("wrote %s\n", picture_path.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s SCENE LEFT_EYE RIGHT_EYE PICTURE.png\n", argv[0]);
    return 2;
  }
  try {
    see(argv[1], argv[2], argv[3], argv[4]);
  } catch (const std::exception& error) {  // omma::Error names the file and what is wrong with it
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
