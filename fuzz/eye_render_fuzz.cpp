// Arbitrary bytes as an eye, in any of its formats, that then looks at a tiny scene: numbers that
// are absurd but finite must do no harm beyond the loader either. Each ends in responses or an
// omma::Error.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/eye_csv.h"
#include "io/oces.h"
#include "omma/error.h"
#include "omma/io.h"
#include "omma/render.h"

namespace {

// Told by its beginning, as no file name says it.
omma::Eye parse(const std::string& file) {
  if (file.starts_with("glTF") || file.starts_with('{'))
    return omma::parse_oces(file, OMMA_FUZZ_BESIDE "/eye.gltf");
  const bool number = !file.empty() && (file[0] == '-' || (file[0] >= '0' && file[0] <= '9'));
  return number ? omma::parse_eye(file, "fuzz.eye") : omma::parse_eye_csv(file, "fuzz.csv");
}

// Two triangles ahead, under the simple sky.
std::shared_ptr<const omma::Scene> tiny_scene() {
  omma::Scene scene;
  omma::Mesh mesh;
  mesh.positions = {{-1, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.meshes.push_back(mesh);
  scene.instances.push_back({"", 0, {}});
  scene.background.type = omma::BackgroundType::simple_sky;
  return std::make_shared<const omma::Scene>(std::move(scene));
}

// The ways to render, one after the other with the size of the file.
omma::RenderSettings settings_of(std::size_t size) {
  omma::RenderSettings settings;
  settings.sampling = omma::Fixed{4};
  settings.threads = 1;
  if (size % 4 == 1) settings.sampling = omma::Shared{4};
  if (size % 4 == 2) settings.sampling = omma::ToError{0.05, 4, 16};
  if (size % 4 == 3) settings.kernel = omma::Kernel::compoundray;
  return settings;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::shared_ptr<const omma::Scene> scene = tiny_scene();
  try {
    omma::Eye eye = parse(std::string(reinterpret_cast<const char*>(data), size));
    if (eye.size() > 200) return 0;
    std::vector<float> responses(eye.size() * 3);
    const omma::Renderer renderer(scene, std::move(eye), settings_of(size));
    renderer.render(std::vector<omma::Mat4>(1), responses);
  } catch (const omma::Error&) {
  }
  return 0;
}
