// Primitives of glTF meshes as indexed triangles. Numbers go straight from the file's bytes into
// the mesh; where many primitives share one set of vertices, each takes those that it uses.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/gltf_accessor.h"
#include "io/gltf_warnings.h"
#include "model/long_work.h"
#include "omma/rig.h"
#include "omma/scene.h"

namespace omma {

struct GltfMeshReader {
  GltfContainer& gltf;
  const std::vector<Material>& materials;
  GltfWarnings& warnings;
  WorkPart work;
  double finished = 0, all = 1;                // elements read, and of all accessors
  std::map<int, GltfAccessor> accessors = {};  // those that are used
  std::map<int, GltfAccessor> packed = {};     // of this primitive, those that it has packed
};

// Adds the primitive's triangles; false where it has none (points, lines, no positions). `place`
// names the primitive in errors. With a deformation also what changes its shape: its morph targets,
// and where it has a skin, of that many joints, the bones of its vertices.
bool read_primitive(GltfMeshReader& reader, const nlohmann::json& primitive,
                    const std::string& place, Mesh& mesh, Deformation* deformation = nullptr,
                    std::size_t joints = 0);

}  // namespace omma
