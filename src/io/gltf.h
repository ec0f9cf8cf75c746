// The glTF loader behind omma::load_scene, for callers who have the bytes already.
#pragma once

#include <string>

#include "omma/io.h"
#include "omma/scene.h"

namespace omma {

// From the bytes of a .gltf or .glb file; URIs in it are relative to the folder of `path`.
Scene parse_scene(std::string file, const std::string& path, const SceneOptions& options = {});

}  // namespace omma
