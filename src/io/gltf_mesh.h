// Primitives of glTF meshes as indexed triangles. Numbers go straight from the file's bytes into
// the mesh; where many primitives share one set of vertices, each takes those that it uses.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "io/gltf_accessor.h"
#include "io/gltf_warnings.h"
#include "model/long_work.h"
#include "omma/scene.h"

namespace omma {

// One primitive, as the file says it.
struct GltfPrimitive {
  std::string place;  // for errors
  int mode = 4;       // 0 to 6: points to triangle fan
  int indices = -1;   // accessor, -1 for none
  int material = -1;
  std::map<std::string, int> attributes;  // accessor by semantic
};

// Memory that a file may still ask for. A small file can name the same bytes again and again.
struct GltfBudget {
  std::string path;
  std::uint64_t total = 0, left = 0;  // bytes
  void spend(std::uint64_t count, std::uint64_t bytes_each);
};

struct GltfMeshReader {
  std::vector<GltfAccessor> accessors;  // their bounds are checked
  const std::vector<Material>& materials;
  GltfWarnings& warnings;
  GltfBudget& budget;
  WorkPart work;
  std::uint64_t finished = 0, all = 1;  // elements read, and to read as far as that is known
  std::set<int> has_checked = {};       // accessors whose numbers are known to be finite
};

// Adds the primitive's triangles; false where it has none (points, lines, no positions).
bool read_primitive(GltfMeshReader& reader, const GltfPrimitive& primitive, Mesh& mesh);

}  // namespace omma
