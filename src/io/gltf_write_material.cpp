// Materials for the writer of scenes: what gltf_material and gltf_scattering read.
#include <algorithm>
#include <cmath>

#include "io/gltf_spectra.h"
#include "io/gltf_writer.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

json texture_use(GltfWriter& writer, const TextureUse& use) {
  json made = {{"index", use.texture}};
  if (use.texcoord_set != 0) made["texCoord"] = use.texcoord_set;
  if (use.offset != Vec2{0, 0} || use.scale != Vec2{1, 1} || use.rotation_rad != 0) {
    writer.use_extension("KHR_texture_transform");
    made["extensions"]["KHR_texture_transform"] = {{"offset", numbers(use.offset)},
                                                   {"scale", numbers(use.scale)},
                                                   {"rotation", use.rotation_rad}};
  }
  return made;
}

// An extension of a material, which is then said to be used.
json& extension(GltfWriter& writer, json& material, const char* name) {
  writer.use_extension(name);
  return material["extensions"][name];
}

void write_scattering(GltfWriter& writer, const Material& m, json& made) {
  const Material usual;
  if (m.metallic_roughness_texture.texture >= 0)
    made["pbrMetallicRoughness"]["metallicRoughnessTexture"] =
        texture_use(writer, m.metallic_roughness_texture);
  const auto add_normals = [&](json& holder, const char* name, const TextureUse& use, float scale) {
    if (use.texture < 0) return;
    holder[name] = texture_use(writer, use);
    if (scale != 1) holder[name]["scale"] = scale;
  };
  add_normals(made, "normalTexture", m.normal_texture, m.normal_scale);
  if (m.ior != usual.ior) extension(writer, made, "KHR_materials_ior") = {{"ior", m.ior}};
  const auto is_there = [](const TextureUse& use) { return use.texture >= 0; };
  const auto add_texture = [&](json& extension, const char* name, const TextureUse& use) {
    if (is_there(use)) extension[name] = texture_use(writer, use);
  };
  if (m.specular != usual.specular || m.specular_color != usual.specular_color ||
      is_there(m.specular_texture) || is_there(m.specular_color_texture)) {
    json& specular = extension(writer, made, "KHR_materials_specular") = {
        {"specularFactor", m.specular}, {"specularColorFactor", numbers(m.specular_color)}};
    add_texture(specular, "specularTexture", m.specular_texture);
    add_texture(specular, "specularColorTexture", m.specular_color_texture);
  }
  if (m.transmission != 0 || is_there(m.transmission_texture)) {
    json& straight = extension(
        writer, made, "KHR_materials_transmission") = {{"transmissionFactor", m.transmission}};
    add_texture(straight, "transmissionTexture", m.transmission_texture);
  }
  if (m.thickness_m != 0 || m.attenuation_color != usual.attenuation_color ||
      m.attenuation_distance_m != usual.attenuation_distance_m) {
    json& volume = extension(writer, made, "KHR_materials_volume") = {
        {"thicknessFactor", m.thickness_m}, {"attenuationColor", numbers(m.attenuation_color)}};
    if (std::isfinite(m.attenuation_distance_m))
      volume["attenuationDistance"] = m.attenuation_distance_m;
  }
  if (m.diffuse_transmission != 0 || is_there(m.diffuse_transmission_texture) ||
      is_there(m.diffuse_transmission_factor_texture) ||
      m.diffuse_transmission_color != usual.diffuse_transmission_color) {
    json& diffuse = extension(writer, made, "KHR_materials_diffuse_transmission") = {
        {"diffuseTransmissionFactor", m.diffuse_transmission},
        {"diffuseTransmissionColorFactor", numbers(m.diffuse_transmission_color)}};
    add_texture(diffuse, "diffuseTransmissionTexture", m.diffuse_transmission_factor_texture);
    add_texture(diffuse, "diffuseTransmissionColorTexture", m.diffuse_transmission_texture);
  }
  if (m.clearcoat != 0 || m.clearcoat_roughness != 0 || is_there(m.clearcoat_texture) ||
      is_there(m.clearcoat_roughness_texture) || is_there(m.clearcoat_normal_texture)) {
    json& coat = extension(writer, made, "KHR_materials_clearcoat") = {
        {"clearcoatFactor", m.clearcoat}, {"clearcoatRoughnessFactor", m.clearcoat_roughness}};
    add_texture(coat, "clearcoatTexture", m.clearcoat_texture);
    add_texture(coat, "clearcoatRoughnessTexture", m.clearcoat_roughness_texture);
    add_normals(coat, "clearcoatNormalTexture", m.clearcoat_normal_texture,
                m.clearcoat_normal_scale);
  }
}

json written_spectra(GltfWriter& writer, const Material& m) {
  json made = json::object();
  if (!m.reflectance.empty()) made["reflectance"] = written_spectrum(m.reflectance);
  if (!m.transmittance.empty()) made["transmittance"] = written_spectrum(m.transmittance);
  if (!m.emission.empty()) made["emission"] = written_spectrum(m.emission);
  if (!m.absorption_per_m.empty())
    made["absorption_per_m"] = written_spectrum(m.absorption_per_m);
  if (m.spectral_luminance != 1) made["spectral_luminance"] = m.spectral_luminance;
  if (m.extra.texture.texture >= 0) {
    json spectra = json::array();
    for (const Spectrum& spectrum : m.extra.spectrum) spectra.push_back(written_spectrum(spectrum));
    made["extra_reflectance"] = {{"texture", texture_use(writer, m.extra.texture)},
                                 {"spectra", std::move(spectra)}};
  }
  if (!m.boundary.empty())
    made["boundary"] = {{"wavelength_nm", m.boundary.wavelength_nm},
                        {"cosines", m.boundary.cosines},
                        {"mueller", writer.view(m.boundary.mueller.data(),
                                                m.boundary.mueller.size() * sizeof(float))}};
  return made;
}

}  // namespace

json written_material(GltfWriter& writer, const Material& material) {
  json made = {{"pbrMetallicRoughness",
                {{"baseColorFactor", numbers(material.base_color)},
                 {"metallicFactor", material.metallic},
                 {"roughnessFactor", material.roughness}}}};
  set_name(made, material.name);
  if (material.base_color_texture.texture >= 0)
    made["pbrMetallicRoughness"]["baseColorTexture"] =
        texture_use(writer, material.base_color_texture);
  if (material.emissive_texture.texture >= 0)
    made["emissiveTexture"] = texture_use(writer, material.emissive_texture);
  const Vec3 e = material.emissive;
  if (e != Vec3{0, 0, 0}) {
    // The factor is at most 1, the strength a power of two, so that their product is exact.
    int exponent = 0;
    std::frexp(std::max({e.x, e.y, e.z, 1.0f}), &exponent);
    const float strength = e.x > 1 || e.y > 1 || e.z > 1 ? std::ldexp(1.0f, exponent) : 1.0f;
    made["emissiveFactor"] = numbers(e * (1 / strength));
    if (strength != 1) {
      writer.use_extension("KHR_materials_emissive_strength");
      made["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = strength;
    }
  }
  if (material.unlit) {
    if (e != Vec3{0, 0, 0} || material.emissive_texture.texture >= 0)
      throw Error("material '" + material.name +
                  "': is unlit and has an emission, which glTF has not for unlit materials");
    writer.use_extension("KHR_materials_unlit");
    made["extensions"]["KHR_materials_unlit"] = json::object();
  }
  constexpr float usual_cutoff = 0.5f;
  if (material.alpha_mode != AlphaMode::opaque || material.alpha_cutoff != usual_cutoff)
    made["alphaMode"] = material.alpha_mode == AlphaMode::mask    ? "MASK"
                        : material.alpha_mode == AlphaMode::blend ? "BLEND"
                                                                  : "OPAQUE";
  if (material.alpha_cutoff != usual_cutoff) made["alphaCutoff"] = material.alpha_cutoff;
  if (material.double_sided) made["doubleSided"] = true;
  write_scattering(writer, material, made);
  const json spectra = written_spectra(writer, material);
  if (!spectra.empty()) made["extras"]["omma"] = spectra;
  return made;
}

}  // namespace omma
