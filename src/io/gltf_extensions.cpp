// The lists of extensions, and the sentences about those that are not read.
#include "io/gltf_extensions.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "io/draco_mesh.h"
#include "io/gltf_lights.h"
#include "io/gltf_splats.h"
#include "io/meshopt.h"
#include "omma/error.h"

namespace omma {
namespace {

constexpr std::array<std::string_view, 18> read_extensions = {
    draco_extension,
    lights_extension,
    meshopt_extension,
    splats_extension,
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "OCES_eyes"};  // eyes are nothing to see; load_eye reads them

// Of what is not seen, or of other choices than the one that the file shows by itself: coarser
// levels, other materials. Also all KHR_physics_*, KHR_audio_*.
constexpr std::array<std::string_view, 10> unseen_extensions = {
    "CESIUM_primitive_outline", "EXT_feature_metadata",   "EXT_instance_features",
    "EXT_mesh_features",        "EXT_structural_metadata", "KHR_implicit_shapes",
    "KHR_materials_variants",   "KHR_xmp",                 "KHR_xmp_json_ld",
    "MSFT_lod"};

// How a file becomes one without the extension, by programs that are free.
struct Conversion {
  std::string_view extension, command;
};
constexpr std::array<Conversion, 5> conversions = {
    {{meshopt_extension, "gltfpack -noq -i in.glb -o out.glb"},
     {draco_extension, "import it into Blender and export it as glTF 2.0 without compression"},
     {"KHR_texture_basisu", "gltf-transform ktxdecompress in.glb out.glb"},
     {"KHR_gaussian_splatting_compression_spz", "splat-transform in.glb out.ply"},
     {"KHR_gaussian_splatting_compression_spz_2", "splat-transform in.glb out.ply"}}};

template <std::size_t count>
bool is_among(const std::array<std::string_view, count>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_seen(std::string_view name) {
  return !is_among(unseen_extensions, name) && !name.starts_with("KHR_physics_") &&
         !name.starts_with("KHR_audio");
}

}  // namespace

void check_gltf_extensions(const GltfContainer& gltf, GltfWarnings& warnings) {
  for (const std::string& name :
       gltf.document.value("extensionsRequired", std::vector<std::string>())) {
    const bool is_there = (name != meshopt_extension || has_meshopt()) &&
                          (name != draco_extension || has_draco());
    if (is_among(read_extensions, name) && is_there) continue;
    std::string how;
    for (const Conversion& one : conversions)
      if (one.extension == name) how = "; to convert it: " + std::string(one.command);
    throw Error(gltf.path + ": requires the glTF extension " + name + ", which is not read" + how);
  }
  for (const auto& [name, unknown] : gltf.unknown_extensions)
    if (is_seen(name))
      warnings.add("the glTF extension " + name +
                       (unknown.is_surface
                            ? " is not read: surfaces look as they would without it"
                            : " is not read: what it moves, adds or hides is missing from the "
                              "picture"),
                   unknown.first_place.empty() ? "the file itself" : unknown.first_place,
                   unknown.count);
}

}  // namespace omma
