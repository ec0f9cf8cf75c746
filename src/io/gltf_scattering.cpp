// Scattering of glTF 2.0 materials (section 3.9): metallic-roughness, normals, and the extensions
// KHR_materials_ior, _specular, _transmission, _volume, _diffuse_transmission and _clearcoat.
// Occlusion is not read, it is computed. Nor are textures of thickness, which a mesh's own shape
// tells.
#include "io/gltf_scattering.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "io/gltf_spectra.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

struct ScatteringReader {
  GltfTextureReader& textures;
  const json& material;
  const std::string& place;
  Material& result;

  const json& extension(const char* name) const { return gltf_extension(material, name); }

  void warn(const std::string& sentence) const {
    // Without the path: all warnings are of one file.
    textures.warnings.add(sentence, place.substr(textures.gltf.path.size() + 2));
  }
};

void read_surface(const ScatteringReader& reader) {
  // glTF's defaults: a metal. Those of Material are another, as whoever makes one by hand means
  // matter.
  static const json none = json::object();
  const auto found = reader.material.find("pbrMetallicRoughness");
  const json& pbr = found == reader.material.end() ? none : *found;
  Material& m = reader.result;
  m.metallic = pbr.value("metallicFactor", 1.0f);
  m.roughness = pbr.value("roughnessFactor", 1.0f);
  m.metallic_roughness_texture = read_texture_use(reader.textures, pbr, "metallicRoughnessTexture",
                                                  reader.place, TextureMeaning::data);
  m.normal_texture = read_texture_use(reader.textures, reader.material, "normalTexture",
                                      reader.place, TextureMeaning::data);
  if (m.normal_texture.texture >= 0)
    m.normal_scale = reader.material["normalTexture"].value("scale", 1.0f);
}

void read_specular(const ScatteringReader& reader) {
  Material& m = reader.result;
  m.ior = reader.extension("KHR_materials_ior").value("ior", 1.5f);
  if (m.ior == 0) {
    reader.warn(
        "an index of refraction of 0, for a reflection without Fresnel's law, is not "
        "supported; 1.5 is taken");
    m.ior = 1.5f;
  }
  const json& specular = reader.extension("KHR_materials_specular");
  m.specular = specular.value("specularFactor", 1.0f);
  if (specular.contains("specularColorFactor")) {
    const Vec3 color = gltf_vec3(specular["specularColorFactor"]);
    m.specular_color = {std::min(color.x, 1.0f), std::min(color.y, 1.0f), std::min(color.z, 1.0f)};
    if (m.specular_color != color) reader.warn("a specular colour above 1 counts as 1");
  }
  m.specular_texture = read_texture_use(reader.textures, specular, "specularTexture", reader.place,
                                        TextureMeaning::alpha);
  m.specular_color_texture =
      read_texture_use(reader.textures, specular, "specularColorTexture", reader.place);
  const json& coat = reader.extension("KHR_materials_clearcoat");
  m.clearcoat = coat.value("clearcoatFactor", 0.0f);
  m.clearcoat_roughness = coat.value("clearcoatRoughnessFactor", 0.0f);
  m.clearcoat_texture = read_texture_use(reader.textures, coat, "clearcoatTexture", reader.place,
                                         TextureMeaning::data);
  m.clearcoat_roughness_texture = read_texture_use(
      reader.textures, coat, "clearcoatRoughnessTexture", reader.place, TextureMeaning::data);
  m.clearcoat_normal_texture = read_texture_use(reader.textures, coat, "clearcoatNormalTexture",
                                                reader.place, TextureMeaning::data);
  if (m.clearcoat_normal_texture.texture >= 0)
    m.clearcoat_normal_scale = coat["clearcoatNormalTexture"].value("scale", 1.0f);
}

void read_transmission(const ScatteringReader& reader) {
  Material& m = reader.result;
  const json& straight = reader.extension("KHR_materials_transmission");
  m.transmission = straight.value("transmissionFactor", 0.0f);
  m.transmission_texture = read_texture_use(reader.textures, straight, "transmissionTexture",
                                            reader.place, TextureMeaning::data);
  const json& diffuse = reader.extension("KHR_materials_diffuse_transmission");
  m.diffuse_transmission = diffuse.value("diffuseTransmissionFactor", 0.0f);
  if (diffuse.contains("diffuseTransmissionColorFactor"))
    m.diffuse_transmission_color = gltf_vec3(diffuse["diffuseTransmissionColorFactor"]);
  m.diffuse_transmission_texture =
      read_texture_use(reader.textures, diffuse, "diffuseTransmissionColorTexture", reader.place);
  m.diffuse_transmission_factor_texture =
      read_texture_use(reader.textures, diffuse, "diffuseTransmissionTexture", reader.place,
                       TextureMeaning::alpha);
}

void read_volume(const ScatteringReader& reader) {
  Material& m = reader.result;
  const json& volume = reader.extension("KHR_materials_volume");
  m.thickness_m = volume.value("thicknessFactor", 0.0f);
  m.attenuation_distance_m = volume.value("attenuationDistance", m.attenuation_distance_m);
  if (volume.contains("attenuationColor"))
    m.attenuation_color = gltf_vec3(volume["attenuationColor"]);
  if (m.thickness_m == 0 || (m.metallic == 0 && m.clearcoat == 0)) return;
  reader.warn("KHR_materials_volume of a metal or under a clear coat is not supported: such "
              "surfaces are thin");
  m.thickness_m = 0;
}

// Its Mueller elements are in a buffer view; validate_scene looks at the rest.
void read_boundary(const ScatteringReader& reader, const json& said) {
  BoundaryTable& table = reader.result.boundary;
  table.wavelength_nm = said["wavelength_nm"].get<std::vector<double>>();
  table.cosines = said["cosines"].get<int>();
  const std::string place = reader.place + ": extras.omma.boundary.mueller";
  const std::span<const std::uint8_t> bytes =
      buffer_view_bytes(reader.textures.gltf, said["mueller"].get<int>(), place);
  if (bytes.size() % sizeof(float) != 0)
    throw Error(place + ": expected floats, found " + std::to_string(bytes.size()) + " bytes");
  table.mueller.resize(bytes.size() / sizeof(float));
  if (!bytes.empty()) std::memcpy(table.mueller.data(), bytes.data(), bytes.size());
}

void read_spectra(const ScatteringReader& reader) {
  const json& said = omma_extras(reader.material);
  Material& m = reader.result;
  m.reflectance = read_spectrum(said, "reflectance");
  m.transmittance = read_spectrum(said, "transmittance");
  m.emission = read_spectrum(said, "emission");
  m.absorption_per_m = read_spectrum(said, "absorption_per_m");
  m.spectral_luminance = said.value("spectral_luminance", 1.0f);
  if (said.contains("boundary")) read_boundary(reader, said["boundary"]);
  if (!said.contains("extra_reflectance")) return;
  const json& extra = said["extra_reflectance"];
  m.extra.texture =
      read_texture_use(reader.textures, extra, "texture", reader.place, TextureMeaning::data);
  if (m.extra.texture.texture < 0) return;
  for (std::size_t c = 0; c < extra["spectra"].size(); ++c)
    m.extra.spectrum[c] = read_spectrum(extra["spectra"][c]);
}

}  // namespace

void read_scattering(GltfTextureReader& textures, const json& material, const std::string& place,
                     Material& result) {
  const ScatteringReader reader{textures, material, place, result};
  read_surface(reader);
  read_specular(reader);
  read_transmission(reader);
  read_volume(reader);
  read_spectra(reader);
}

}  // namespace omma
