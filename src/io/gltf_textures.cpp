// Textures, samplers and images of glTF 2.0 (section 3.8), with KHR_texture_transform.
#include "io/gltf_textures.h"

#include <atomic>
#include <cstring>
#include <exception>
#include <limits>
#include <utility>

#include "io/csv_text.h"
#include "io/gltf_schema.h"
#include "io/image.h"
#include "omma/error.h"
#include "threads/parallel.h"

namespace omma {
namespace {

using nlohmann::json;

// Which bytes an image is made of.
std::pair<int, std::string_view> image_bytes(const json& image) {
  const auto uri = image.find("uri");
  return {image.value("bufferView", -1),
          uri == image.end() ? std::string_view() : uri->get_ref<const std::string&>()};
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
  const json& sampler = gltf_element(gltf, "samplers", "sampler", sampler_index, place);
  const std::string inside = gltf.path + ": sampler " + std::to_string(sampler_index);
  made.wrap_u = read_wrap(sampler, "wrapS", inside);
  made.wrap_v = read_wrap(sampler, "wrapT", inside);
  made.filter = read_filter(sampler, inside);
  return made;
}

// Which image a texture shows, -1 for none that Omma can read. A WebP takes the place of one that is
// there for others (EXT_texture_webp).
int source_of(const json& texture) {
  return gltf_extension(texture, "EXT_texture_webp").value("source", texture.value("source", -1));
}

// Index of the scene's texture for a glTF texture, -1 where that has no image Omma can read.
int read_texture(GltfTextureReader& reader, int index, const std::string& user) {
  const auto known = reader.texture_of.find(index);
  if (known != reader.texture_of.end()) return known->second;
  const json& texture = gltf_element(reader.gltf, "textures", "texture", index, user);
  const std::string place = reader.gltf.path + ": texture " + std::to_string(index);
  int result = -1;
  const int source = source_of(texture);
  if (source >= 0) {
    const json& image_source = gltf_element(reader.gltf, "images", "image", source, place);
    const int first = reader.source_of.try_emplace(image_bytes(image_source), source).first->second;
    const auto [image, is_new] =
        reader.image_of.try_emplace(first, static_cast<int>(reader.image_of.size()));
    Texture made = read_sampling(reader.gltf, texture, place);
    made.image = image->second;
    result = static_cast<int>(reader.scene.textures.size());
    reader.scene.textures.push_back(made);
  } else {
    reader.warnings.add(
        gltf_extension(texture, "KHR_texture_basisu").empty()
            ? "a texture has no PNG, JPEG or WebP image and counts as white"
            : "a texture has an image in KTX2 alone (KHR_texture_basisu), which is not read, and "
              "counts as white; to convert it: gltf-transform ktxdecompress in.glb out.glb",
        "texture " + std::to_string(index));
  }
  reader.texture_of[index] = result;
  return result;
}

// An image as it is in the file, not decoded.
struct EncodedFile {
  std::string place;  // for errors
  std::string name;
  std::string file;   // the bytes that a URI stands for, or
  EncodedImage view;  // those in a buffer

  EncodedImage bytes() const {
    if (view.data() != nullptr) return view;
    return {reinterpret_cast<const std::uint8_t*>(file.data()), file.size()};
  }
};

// Reads buffers, so one at a time.
EncodedFile read_encoded(GltfContainer& gltf, int index, const WorkPart& work) {
  const json& source = gltf.document["images"][static_cast<std::size_t>(index)];
  EncodedFile image;
  image.name = source.value("name", "");
  image.place = gltf.path + ": image " + std::to_string(index) + gltf_name(source);
  if (source.contains("bufferView")) {
    image.view = buffer_view_bytes(gltf, source["bufferView"].get<int>(), image.place);
  } else if (source.contains("uri")) {
    const std::string& uri = source["uri"].get_ref<const std::string&>();
    image.file = read_uri(gltf.path, uri, image.place, work);
    if (!uri.starts_with("data:")) image.place += " (" + uri + ")";
  } else {
    throw Error(image.place + ": has neither a URI nor a buffer view");
  }
  return image;
}

// What all images claim to have is charged to one budget before any is decoded: a small file can
// name many that unpack to much.
void charge_images(const std::vector<EncodedFile>& images) {
  std::uint64_t encoded = 0, charged = 0;
  for (const EncodedFile& image : images) encoded += image.bytes().size();
  const std::uint64_t budget = image_budget(encoded);
  for (const EncodedFile& image : images) {
    const ImageClaim claim = image_claim(image.bytes(), image.place);
    if (claim.memory > budget - charged)
      throw Error(image.place + ": its " + std::to_string(claim.width) + " x " +
                  std::to_string(claim.height) + " pixels need " + std::to_string(claim.memory) +
                  " bytes of memory and those before it " + std::to_string(charged) +
                  "; for images of " + std::to_string(encoded) + " bytes at most " +
                  std::to_string(budget) + " are expected");
    charged += claim.memory;
  }
}

// Images in linear floats that Omma has written keep their values beside the PNG, [pixel] RGBA.
void use_linear_pixels(GltfContainer& gltf, int index, const std::string& place, Image& image) {
  const json& source = gltf.document["images"][static_cast<std::size_t>(index)];
  const auto extras = source.find("extras");
  if (extras == source.end() || !extras->is_object()) return;
  const auto view = extras->find("omma-linear-rgba");
  if (view == extras->end()) return;
  const auto number = gltf_whole_number(*view);
  if (!number || *number > std::numeric_limits<int>::max())
    throw Error(place + ": extras: omma-linear-rgba: expected a buffer view, found " +
                shown_text(view->dump()));
  const std::span<const std::uint8_t> bytes =
      buffer_view_bytes(gltf, static_cast<int>(*number), place);
  const std::size_t values =
      4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (bytes.size() != values * sizeof(float))
    throw Error(place + ": extras: omma-linear-rgba: has " + std::to_string(bytes.size()) +
                " bytes, expected " + std::to_string(values * sizeof(float)));
  image.rgba_srgb8.clear();
  image.rgba_linear.resize(values);
  std::memcpy(image.rgba_linear.data(), bytes.data(), bytes.size());
}

// Images of 16 bits are decoded to linear light. Of data, such as normals, the codes are wanted.
void use_codes(GltfTextureReader& reader, std::size_t index) {
  Image& image = reader.scene.images[index];
  if (image.rgba_linear.empty()) return;
  if (reader.color_images.contains(static_cast<int>(index))) {
    reader.warnings.add("an image of 16 bits is used as colours and as data; it is read as colours",
                        "image " + std::to_string(index));
    return;
  }
  parallel_for(std::size_t{0}, image.rgba_linear.size() / 4, [&](std::size_t i) {
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = image.rgba_linear[4 * i + c];
      value = static_cast<float>(srgb_from_linear(static_cast<double>(value)));
    }
  });
}

}  // namespace

TextureUse read_texture_use(GltfTextureReader& reader, const json& parent, const char* name,
                            const std::string& place, TextureMeaning meaning) {
  TextureUse use;
  const auto info = parent.find(name);
  if (info == parent.end()) return use;
  const json& transform = gltf_extension(*info, "KHR_texture_transform");
  use.texture = read_texture(reader, (*info)["index"].get<int>(), place + ": " + name);
  if (use.texture < 0) return use;
  const int image = reader.scene.textures[static_cast<std::size_t>(use.texture)].image;
  if (meaning == TextureMeaning::color) reader.color_images.insert(image);
  if (meaning == TextureMeaning::data) reader.data_images.insert(image);
  use.texcoord_set = transform.value("texCoord", info->value("texCoord", 0));
  if (use.texcoord_set > 1)
    throw Error(place + ": " + name + ": uses texture coordinate set " +
                std::to_string(use.texcoord_set) + "; sets 0 and 1 are supported");
  if (transform.contains("offset"))
    use.offset = {gltf_number(transform["offset"], 0), gltf_number(transform["offset"], 1)};
  if (transform.contains("scale"))
    use.scale = {gltf_number(transform["scale"], 0), gltf_number(transform["scale"], 1)};
  use.rotation_rad = transform.value("rotation", 0.0f);
  return use;
}

void read_images(GltfTextureReader& reader, const WorkPart& work) {
  std::vector<int> sources(reader.image_of.size());
  for (const auto& [source, image] : reader.image_of)
    sources[static_cast<std::size_t>(image)] = source;
  std::vector<EncodedFile> encoded;
  const double all = static_cast<double>(sources.size());
  for (const int source : sources) {
    const double read = static_cast<double>(encoded.size());
    encoded.push_back(
        read_encoded(reader.gltf, source, work.part(0.2 * read / all, 0.2 * (read + 1) / all)));
  }
  charge_images(encoded);
  reader.scene.images.resize(sources.size());
  std::vector<std::exception_ptr> errors(sources.size());
  std::atomic<std::size_t> finished{0};
  parallel_for(std::size_t{0}, sources.size(), [&](std::size_t i) {
    try {
      // Each tells of its own part, which of many is the more exact the more there are.
      const double before = 0.2 + 0.8 * static_cast<double>(finished) / all;
      Image& image = reader.scene.images[i];
      image = decode_claimed_image(encoded[i].bytes(), encoded[i].place,
                                   work.part(before, before + 0.8 / all));
      image.name = std::move(encoded[i].name);
      encoded[i].file = std::string();
      ++finished;
    } catch (...) {
      errors[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (reader.data_images.contains(static_cast<int>(i))) use_codes(reader, i);
    use_linear_pixels(reader.gltf, sources[i], encoded[i].place, reader.scene.images[i]);
  }
}

Image read_gltf_image(GltfContainer& gltf, int index) {
  const std::vector<EncodedFile> encoded = {read_encoded(gltf, index, {})};
  charge_images(encoded);
  Image image = decode_claimed_image(encoded[0].bytes(), encoded[0].place, {});
  use_linear_pixels(gltf, index, encoded[0].place, image);
  image.name = encoded[0].name;
  return image;
}

Image read_gltf_texture(GltfContainer& gltf, int index, const std::string& place,
                        Texture& sampling) {
  const json& texture = gltf_element(gltf, "textures", "texture", index, place);
  const std::string inside = gltf.path + ": texture " + std::to_string(index);
  sampling = read_sampling(gltf, texture, inside);
  const int source = source_of(texture);
  if (source < 0) throw Error(inside + ": has no image, used by " + place);
  gltf_element(gltf, "images", "image", source, inside);
  return read_gltf_image(gltf, source);
}

}  // namespace omma
