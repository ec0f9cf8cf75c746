// Textures as materials use them, each made once, and the coordinates that meshes read them with.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/shading_data.h"
#include "threads/parallel.h"

namespace omma {

// Per triangle corner: one place in memory per hit instead of an index and three vertices.
template <typename T>
std::vector<T> per_corner(const Mesh& mesh, const std::vector<T>& per_vertex) {
  std::vector<T> corners(3 * mesh.triangles.size());
  parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = per_vertex[mesh.triangles[i][k]];
  });
  return corners;
}

// Index of the view of a scene's texture in `data.textures`, made where there is none yet; -1 for
// none. Where alpha matters, or codes are another thing, coarser levels differ.
std::int32_t find_texture(const Scene& scene, ShadingData& data, int texture, AlphaMode alpha,
                          ImageCodes codes);

// Has all textures of an image read another picture of the same size, which stays where it is.
void replace_image(const Scene& scene, ShadingData& data, int image, const Image& picture);

// The coordinates that a mesh reads a texture with, of corners, or in large scenes of vertices;
// kept by `data`, or the mesh's own.
const Vec2* texture_coordinates(const Mesh& mesh, const TextureUse& use, bool large,
                                ShadingData& data);

// Of the texels of a texture of `data` read with these coordinates, see MeshView; kept by `data`.
// Null where the texture has no levels.
const float* texel_densities(const Mesh& mesh, const Vec2* uvs, std::int32_t texture, bool large,
                             ShadingData& data);

}  // namespace omma
