// What the writers of the parts of a glTF file share: the document and its binary chunk.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "io/gltf_container.h"
#include "omma/scene.h"

namespace omma {

struct GltfWriter {
  const Scene& scene;
  nlohmann::json document = {{"asset", {{"version", "2.0"}, {"generator", omma_generator}}}};
  std::string binary = {};
  std::map<std::size_t, nlohmann::json> primitives = {};  // by mesh of the scene
  std::map<std::vector<std::size_t>, int> meshes = {};    // by the meshes of a node

  int push(const char* list, nlohmann::json element) {
    document[list].push_back(std::move(element));
    return static_cast<int>(document[list].size()) - 1;
  }

  void use_extension(const char* name) {
    nlohmann::json& used = document["extensionsUsed"];
    if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
  }

  int view(const void* data, std::size_t bytes, int target = 0) {
    binary.resize((binary.size() + 3) / 4 * 4);
    nlohmann::json made = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes}};
    if (target != 0) made["target"] = target;
    binary.append(static_cast<const char*>(data), bytes);
    return push("bufferViews", std::move(made));
  }

  template <typename Vector>
  int floats(const std::vector<Vector>& values) {
    constexpr int gl_float = 5126, gl_array_buffer = 34962;  // of the glTF 2.0 specification
    constexpr std::size_t components = sizeof(Vector) / sizeof(float);
    const int at = view(values.data(), values.size() * sizeof(Vector), gl_array_buffer);
    return push("accessors", {{"bufferView", at},
                              {"componentType", gl_float},
                              {"count", values.size()},
                              {"type", components == 1 ? std::string("SCALAR")
                                                       : "VEC" + std::to_string(components)}});
  }
};

inline nlohmann::json numbers(Vec2 v) {
  return {v.x, v.y};
}
inline nlohmann::json numbers(Vec3 v) {
  return {v.x, v.y, v.z};
}
inline nlohmann::json numbers(Vec4 v) {
  return {v.x, v.y, v.z, v.w};
}

inline void set_name(nlohmann::json& object, const std::string& name) {
  if (!name.empty()) object["name"] = name;
}

// An element of "materials".
nlohmann::json written_material(GltfWriter& writer, const Material& material);

}  // namespace omma
