// Arbitrary bytes as a .gltf or .glb file: each is a valid scene or an omma::Error. URIs lead into
// a folder that is not there.
#include <cstddef>
#include <cstdint>
#include <string>

#include "io/gltf.h"
#include "omma/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const omma::Scene scene = omma::parse_scene(
        std::string(reinterpret_cast<const char*>(data), size), "no-such-folder/scene.gltf");
    omma::scene_bounds(scene);
    omma::triangle_count(scene);
  } catch (const omma::Error&) {
  }
  return 0;
}
