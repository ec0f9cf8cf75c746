// Materials, textures, samplers and images of glTF 2.0 (sections 3.8 and 3.9), with the extensions
// KHR_texture_transform, KHR_materials_emissive_strength and KHR_materials_unlit.
#include "io/gltf_material.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <exception>
#include <map>

#include "omma/error.h"
#include "omma/io.h"

namespace omma {
namespace {

using nlohmann::json;

struct MaterialReader {
  const GltfContainer& gltf;
  Scene& scene;
  GltfWarnings& warnings;
  std::map<int, int> texture_of;  // scene texture by glTF texture
  std::map<int, int> image_of;    // scene image by glTF image
};

std::string quoted_name(const json& object) {
  const std::string name = object.value("name", "");
  return name.empty() ? name : " \"" + name + "\"";
}

// The element of a top-level array that an index names.
const json& element(const GltfContainer& gltf, const char* array, int index,
                    const std::string& place) {
  const auto found = gltf.document.find(array);
  const std::size_t size = found == gltf.document.end() ? 0 : found->size();
  if (static_cast<std::size_t>(index) >= size)
    throw Error(place + ": refers to " + array + "[" + std::to_string(index) + "], there are " +
                std::to_string(size));
  return (*found)[static_cast<std::size_t>(index)];
}

// An extension of an object; an empty object where it is not there.
const json& extension(const json& object, const char* name) {
  static const json none = json::object();
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return none;
  const auto found = extensions->find(name);
  return found == extensions->end() ? none : *found;
}

float number(const json& values, std::size_t i) {
  return values[i].get<float>();
}

Wrap read_wrap(const json& sampler, const char* name, const std::string& place) {
  const int wrap = sampler.value(name, 10497);
  switch (wrap) {
    case 10497:
      return Wrap::repeat;
    case 33648:
      return Wrap::mirrored_repeat;
    case 33071:
      return Wrap::clamp_to_edge;
    default:
      throw Error(place + ": " + name + ": expected 10497, 33648 or 33071, found " +
                  std::to_string(wrap));
  }
}

Filter read_filter(const json& sampler, const std::string& place) {
  const int filter = sampler.value("magFilter", 9729);
  if (filter != 9728 && filter != 9729)
    throw Error(place + ": magFilter: expected 9728 or 9729, found " + std::to_string(filter));
  return filter == 9728 ? Filter::nearest : Filter::linear;
}

// How a texture is sampled: its wrapping and filter.
Texture read_sampling(const GltfContainer& gltf, const json& texture, const std::string& place) {
  Texture made;
  if (!texture.contains("sampler")) return made;
  const int sampler_index = texture["sampler"].get<int>();
  const json& sampler = element(gltf, "samplers", sampler_index, place);
  const std::string inside = gltf.path + ": sampler " + std::to_string(sampler_index);
  made.wrap_u = read_wrap(sampler, "wrapS", inside);
  made.wrap_v = read_wrap(sampler, "wrapT", inside);
  made.filter = read_filter(sampler, inside);
  return made;
}

// Index of the scene's texture for a glTF texture, -1 where that has no image Omma can read.
int read_texture(MaterialReader& reader, int index, const std::string& user) {
  const auto known = reader.texture_of.find(index);
  if (known != reader.texture_of.end()) return known->second;
  const json& texture = element(reader.gltf, "textures", index, user);
  const std::string place = reader.gltf.path + ": texture " + std::to_string(index);
  int result = -1;
  if (texture.contains("source")) {
    const int source = texture["source"].get<int>();
    element(reader.gltf, "images", source, place);
    const auto [image, is_new] =
        reader.image_of.try_emplace(source, static_cast<int>(reader.image_of.size()));
    Texture made = read_sampling(reader.gltf, texture, place);
    made.image = image->second;
    result = static_cast<int>(reader.scene.textures.size());
    reader.scene.textures.push_back(made);
  } else {
    reader.warnings.add("a texture has no PNG or JPEG image and counts as white",
                        "texture " + std::to_string(index));
  }
  reader.texture_of[index] = result;
  return result;
}

TextureUse read_texture_use(MaterialReader& reader, const json& parent, const char* name,
                            const std::string& place) {
  TextureUse use;
  const auto info = parent.find(name);
  if (info == parent.end()) return use;
  const json& transform = extension(*info, "KHR_texture_transform");
  use.texture = read_texture(reader, (*info)["index"].get<int>(), place + ": " + name);
  use.texcoord_set = transform.value("texCoord", info->value("texCoord", 0));
  if (use.texcoord_set > 1)
    throw Error(place + ": " + name + ": uses texture coordinate set " +
                std::to_string(use.texcoord_set) + "; sets 0 and 1 are supported");
  if (transform.contains("offset"))
    use.offset = {number(transform["offset"], 0), number(transform["offset"], 1)};
  if (transform.contains("scale"))
    use.scale = {number(transform["scale"], 0), number(transform["scale"], 1)};
  use.rotation_rad = transform.value("rotation", 0.0f);
  return use;
}

AlphaMode read_alpha_mode(const json& material, const std::string& place) {
  const std::string mode = material.value("alphaMode", "OPAQUE");
  if (mode == "OPAQUE") return AlphaMode::opaque;
  if (mode == "MASK") return AlphaMode::mask;
  if (mode == "BLEND") return AlphaMode::blend;
  throw Error(place + ": alphaMode: expected OPAQUE, MASK or BLEND, found \"" + mode + "\"");
}

Material read_material(MaterialReader& reader, const json& material, const std::string& place) {
  Material result;
  result.name = material.value("name", "");
  if (material.contains("pbrMetallicRoughness")) {
    const json& pbr = material["pbrMetallicRoughness"];
    if (pbr.contains("baseColorFactor")) {
      const json& factor = pbr["baseColorFactor"];
      result.base_color = {number(factor, 0), number(factor, 1), number(factor, 2),
                           number(factor, 3)};
    }
    result.base_color_texture = read_texture_use(reader, pbr, "baseColorTexture", place);
  }
  result.alpha_mode = read_alpha_mode(material, place);
  result.alpha_cutoff = material.value("alphaCutoff", 0.5f);
  result.double_sided = material.value("doubleSided", false);
  result.unlit =
      material.contains("extensions") && material["extensions"].contains("KHR_materials_unlit");
  // An unlit material is its base colour and nothing else; emission is there for renderers that do
  // not know the extension.
  if (result.unlit) return result;
  if (material.contains("emissiveFactor")) {
    const json& factor = material["emissiveFactor"];
    const float strength =
        extension(material, "KHR_materials_emissive_strength").value("emissiveStrength", 1.0f);
    result.emissive = Vec3{number(factor, 0), number(factor, 1), number(factor, 2)} * strength;
  }
  result.emissive_texture = read_texture_use(reader, material, "emissiveTexture", place);
  return result;
}

Image read_image(const GltfContainer& gltf, int index) {
  const json& source = gltf.document["images"][static_cast<std::size_t>(index)];
  std::string place = gltf.path + ": image " + std::to_string(index) + quoted_name(source);
  Image image;
  if (source.contains("bufferView")) {
    image = decode_image(buffer_view_bytes(gltf, source["bufferView"].get<int>(), place), place);
  } else if (source.contains("uri")) {
    const std::string& uri = source["uri"].get_ref<const std::string&>();
    const std::string bytes = read_uri(gltf.path, uri, place, {});
    if (!uri.starts_with("data:")) place += " (" + uri + ")";
    image =
        decode_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, place);
  } else {
    throw Error(place + ": has neither a URI nor a buffer view");
  }
  image.name = source.value("name", "");
  return image;
}

// All images at once; of several errors the first image's is thrown, whatever the threads did.
void read_images(MaterialReader& reader, const WorkPart& work) {
  reader.scene.images.resize(reader.image_of.size());
  std::vector<int> sources(reader.image_of.size());
  for (const auto& [source, image] : reader.image_of)
    sources[static_cast<std::size_t>(image)] = source;
  std::vector<std::exception_ptr> errors(sources.size());
  std::atomic<std::size_t> finished{0};
  tbb::parallel_for(std::size_t{0}, sources.size(), [&](std::size_t i) {
    try {
      work.reach(static_cast<double>(finished) / static_cast<double>(sources.size()));
      reader.scene.images[i] = read_image(reader.gltf, sources[i]);
      ++finished;
    } catch (...) {
      errors[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace

Image read_gltf_texture(const GltfContainer& gltf, int index, const std::string& place,
                        Texture& sampling) {
  const json& texture = element(gltf, "textures", index, place);
  const std::string inside = gltf.path + ": texture " + std::to_string(index);
  sampling = read_sampling(gltf, texture, inside);
  if (!texture.contains("source")) throw Error(inside + ": has no image, used by " + place);
  const int source = texture["source"].get<int>();
  element(gltf, "images", source, inside);
  return read_image(gltf, source);
}

void read_materials(const GltfContainer& gltf, Scene& scene, GltfWarnings& warnings,
                    const WorkPart& work) {
  if (!gltf.document.contains("materials")) return;
  MaterialReader reader{gltf, scene, warnings, {}, {}};
  for (const json& material : gltf.document["materials"])
    scene.materials.push_back(read_material(reader, material,
                                            gltf.path + ": material " +
                                                std::to_string(scene.materials.size()) +
                                                quoted_name(material)));
  read_images(reader, work);
}

}  // namespace omma
