// The glTF loader behind omma::load_scene, for callers who have the bytes already.
#pragma once

#include <string>

#include "model/long_work.h"
#include "omma/io.h"
#include "omma/scene.h"

namespace omma {

// From the bytes of a .gltf or .glb file; URIs in it are relative to the folder of `path`.
// Its progress goes to `work`, not to that of the options.
Scene parse_scene(std::string file, const std::string& path, const SceneOptions& options = {},
                  const WorkPart& work = {});

// What a camera's extras, JSON text, say of it, and themselves: `extras_json`, the type of a
// perspective camera that is panoramic or compound, the eye and projection of a compound one.
// Throws omma::Error where the text is not JSON.
void read_camera_extras(Camera& camera, const std::string& json_text);

}  // namespace omma
