// Materials of glTF 2.0 (section 3.9): what of them is seen without light, with the extensions
// KHR_materials_emissive_strength and KHR_materials_unlit.
#include "io/gltf_material.h"

#include "io/gltf_scattering.h"
#include "io/gltf_textures.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

AlphaMode read_alpha_mode(const json& material, const std::string& place) {
  const std::string mode = material.value("alphaMode", "OPAQUE");
  if (mode == "OPAQUE") return AlphaMode::opaque;
  if (mode == "MASK") return AlphaMode::mask;
  if (mode == "BLEND") return AlphaMode::blend;
  throw Error(place + ": alphaMode: expected OPAQUE, MASK or BLEND, found \"" + mode + "\"");
}

Material read_material(GltfTextureReader& reader, const json& material, const std::string& place,
                       bool scattering) {
  Material result;
  result.name = material.value("name", "");
  if (material.contains("pbrMetallicRoughness")) {
    const json& pbr = material["pbrMetallicRoughness"];
    if (pbr.contains("baseColorFactor")) {
      const json& factor = pbr["baseColorFactor"];
      result.base_color = {gltf_number(factor, 0), gltf_number(factor, 1), gltf_number(factor, 2),
                           gltf_number(factor, 3)};
    }
    result.base_color_texture = read_texture_use(reader, pbr, "baseColorTexture", place);
  }
  result.alpha_mode = read_alpha_mode(material, place);
  result.alpha_cutoff = material.value("alphaCutoff", 0.5f);
  result.double_sided = material.value("doubleSided", false);
  result.unlit =
      material.contains("extensions") && material["extensions"].contains("KHR_materials_unlit");
  if (scattering) read_scattering(reader, material, place, result);
  // An unlit material is its base colour and nothing else; emission is there for renderers that do
  // not know the extension.
  if (result.unlit) return result;
  if (material.contains("emissiveFactor")) {
    const json& factor = material["emissiveFactor"];
    const float strength =
        gltf_extension(material, "KHR_materials_emissive_strength").value("emissiveStrength", 1.0f);
    result.emissive = gltf_vec3(factor) * strength;
  }
  if (!result.emission.empty() && result.emissive == Vec3{0, 0, 0})
    // Without the path: all warnings are of one file.
    reader.warnings.add("a spectrum of emission is not seen where the emissive factor is 0",
                        place.substr(reader.gltf.path.size() + 2));
  result.emissive_texture = read_texture_use(reader, material, "emissiveTexture", place);
  return result;
}

}  // namespace

void read_materials(GltfContainer& gltf, Scene& scene, GltfWarnings& warnings, bool scattering,
                    const WorkPart& work) {
  GltfTextureReader reader{gltf, scene, warnings};
  for (const json& material : gltf_list(gltf.document, "materials"))
    scene.materials.push_back(read_material(
        reader, material,
        gltf.path + ": material " + std::to_string(scene.materials.size()) + gltf_name(material),
        scattering));
  read_images(reader, work);
}

}  // namespace omma
