// Arbitrary bytes as a .gltf or .glb file: each is a valid scene or an omma::Error. URIs may lead
// to the files in fuzz/beside. Sizes that are odd are read by the colour rule `compoundray`.
#include <cstddef>
#include <cstdint>
#include <string>

#include "io/gltf.h"
#include "omma/error.h"
#include "omma/rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  omma::SceneOptions options;
  if (size % 2 == 1) options.color_rule = omma::ColorRule::compoundray;
  try {
    const omma::Scene scene =
        omma::parse_scene(std::string(reinterpret_cast<const char*>(data), size),
                          OMMA_FUZZ_BESIDE "/scene.gltf", options);
    omma::scene_bounds(scene);
    omma::triangle_count(scene);
    if (scene.rig != nullptr)
      for (std::size_t camera = 0; camera < scene.cameras.size() && camera < 4; ++camera)
        omma::camera_at(scene, static_cast<int>(camera), 0.5, {0});
  } catch (const omma::Error&) {
  }
  return 0;
}
