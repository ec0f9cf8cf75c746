// KHR_draco_mesh_compression: triangles and attributes of primitives in one packed stream.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace omma {

inline constexpr const char* draco_extension = "KHR_draco_mesh_compression";

// Whether this build has Draco.
bool has_draco();

struct DracoMesh;  // unpacked

// Throws omma::Error that starts with `place` where the bytes are no such stream.
std::shared_ptr<const DracoMesh> unpack_draco(std::span<const std::uint8_t> packed,
                                              const std::string& place);

// Of each triangle its three vertices.
std::vector<std::uint32_t> draco_corners(const DracoMesh& mesh);

std::uint64_t draco_vertices(const DracoMesh& mesh);

// The attribute of that number as elements of so many components of a glTF component type, in one
// piece. Throws omma::Error that starts with `place` where there is none, or it is of another kind.
std::vector<std::uint8_t> draco_attribute(const DracoMesh& mesh, int number, int component_type,
                                          std::size_t components, const std::string& place);

}  // namespace omma
