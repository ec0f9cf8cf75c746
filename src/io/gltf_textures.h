// Textures of a glTF file with the images they show.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "io/gltf_container.h"
#include "io/gltf_warnings.h"
#include "omma/scene.h"

namespace omma {

struct GltfTextureReader {
  GltfContainer& gltf;
  Scene& scene;
  GltfWarnings& warnings;
  std::map<int, int> texture_of = {};  // scene texture by glTF texture
  std::map<int, int> image_of = {};    // scene image by glTF image
  // The first glTF image of those bytes: a buffer view, or a URI.
  std::map<std::pair<int, std::string_view>, int> source_of = {};
  std::set<int> color_images = {}, data_images = {};  // scene images by what they are used as
};

// Codes of colours are sRGB; those of data, such as normals, and of alpha are the values
// themselves.
enum class TextureMeaning : std::uint8_t { color, data, alpha };

// The texture info `name` of an object; none where it is not there or has no image Omma can read.
// Adds the texture to the scene.
TextureUse read_texture_use(GltfTextureReader& reader, const nlohmann::json& parent,
                            const char* name, const std::string& place,
                            TextureMeaning meaning = TextureMeaning::color);

// Decodes the images of all textures that were read, all at once; of several errors the first
// image's is thrown, whatever the threads did.
void read_images(GltfTextureReader& reader, const WorkPart& work);

// One image, decoded. There is an image of that index.
Image read_gltf_image(GltfContainer& gltf, int index);

// The image of a texture, decoded, and how it is sampled. There is a texture of that index; throws
// omma::Error that names path, texture or image, or `place` where the texture has no image.
Image read_gltf_texture(GltfContainer& gltf, int index, const std::string& place,
                        Texture& sampling);

}  // namespace omma
