// Scenes for JavaScript: read from bytes, and what is in them.
#include <emscripten/bind.h>

#include <array>

#include "files.h"
#include "handles.h"
#include "omma/io.h"
#include "scene_parts.h"

namespace omma::web {
namespace {

SceneHandle read_scene(const MemoryFiles& files) {
  return {std::make_shared<const Scene>(load_scene(files.path()))};
}

SceneHandle scene_of_bytes(const std::string& name, const val& bytes) {
  return checked([&] { return read_scene(MemoryFiles(name, bytes)); });
}
SceneHandle scene_of_files(const std::string& name, const val& bytes, const val& others) {
  return checked([&] { return read_scene(MemoryFiles(name, bytes, others)); });
}

val cameras_of(const Scene& scene) {
  val list = val::array();
  for (const Camera& camera : scene.cameras) {
    val entry = val::object();
    entry.set("name", camera.name);
    entry.set("world_from_camera", array_of(camera.world_from_camera));
    list.call<void>("push", entry);
  }
  return list;
}

val info_of(const SceneHandle& handle) {
  return checked([&] {
    const Scene& scene = *handle.scene;
    val info = val::object();
    info.set("triangles", static_cast<double>(triangle_count(scene)));
    info.set("splats", static_cast<double>(splat_count(scene)));
    info.set("meshes", scene.meshes.size());
    info.set("instances", scene.instances.size());
    info.set("materials", scene.materials.size());
    const Bounds box = scene_bounds(scene);
    if (!box.empty)
      info.set("bounds_m", list_of(std::vector<double>{box.lower.x, box.lower.y, box.lower.z,
                                                       box.upper.x, box.upper.y, box.upper.z}));
    else
      info.set("bounds_m", val::null());
    info.set("cameras", cameras_of(scene));
    info.set("bands", rgb_bands);
    info.set("background", background_of(scene));
    info.set("warnings", list_of(scene.warnings));
    return info;
  });
}

}  // namespace

void bind_scene() {
  emscripten::class_<SceneHandle>("Scene")
      .function("info", &info_of)
      .function("parts", &parts_of)
      .function("image", &image_of);
  emscripten::function("load_scene", &scene_of_bytes);
  emscripten::function("load_scene", &scene_of_files);
}

}  // namespace omma::web
