// Meshes packed by Draco, unpacked by its own library.
#include "io/draco_mesh.h"

#include <exception>

#include "omma/error.h"

#ifdef OMMA_HAS_DRACO
#include <draco/compression/decode.h>
#endif

namespace omma {

#ifdef OMMA_HAS_DRACO

struct DracoMesh {
  std::unique_ptr<draco::Mesh> unpacked;
};

namespace {

// The elements of all vertices. Nothing that an index of the stream says is trusted.
template <typename T>
bool convert(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
             std::size_t components, std::vector<std::uint8_t>& bytes) {
  bytes.resize(mesh.num_points() * components * sizeof(T));
  std::vector<T> element(components);
  const auto there = static_cast<std::int64_t>(attribute.buffer()->data_size());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    const std::int64_t end = attribute.byte_offset() +
                             attribute.byte_stride() * (std::int64_t{value.value()} + 1);
    if (value.value() >= attribute.size() || end > there) return false;
    if (!attribute.ConvertValue(value, static_cast<std::int8_t>(components), element.data()))
      return false;
    std::copy_n(reinterpret_cast<const std::uint8_t*>(element.data()), components * sizeof(T),
                bytes.data() + i * components * sizeof(T));
  }
  return true;
}

}  // namespace

bool has_draco() {
  return true;
}

std::shared_ptr<const DracoMesh> unpack_draco(std::span<const std::uint8_t> packed,
                                              const std::string& place) {
  std::string why;
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(packed.data()), packed.size());
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (mesh.ok()) {
      auto made = std::make_shared<DracoMesh>();
      made->unpacked = std::move(mesh).value();
      return made;
    }
    why = mesh.status().error_msg();
  } catch (const std::exception& error) {
    why = error.what();
  }
  throw Error(place + ": " + draco_extension + ": its " + std::to_string(packed.size()) +
              " bytes do not unpack: " + why);
}

std::vector<std::uint32_t> draco_corners(const DracoMesh& mesh) {
  const draco::Mesh& from = *mesh.unpacked;
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * from.num_faces());
  for (std::uint32_t f = 0; f < from.num_faces(); ++f)
    for (const draco::PointIndex& corner : from.face(draco::FaceIndex(f)))
      corners.push_back(corner.value());
  return corners;
}

std::uint64_t draco_vertices(const DracoMesh& mesh) {
  return mesh.unpacked->num_points();
}

std::vector<std::uint8_t> draco_attribute(const DracoMesh& mesh, int number, int component_type,
                                          std::size_t components, const std::string& place) {
  const draco::Mesh& from = *mesh.unpacked;
  const draco::PointAttribute* attribute =
      from.GetAttributeByUniqueId(static_cast<std::uint32_t>(number));
  if (attribute == nullptr || attribute->buffer() == nullptr)
    throw Error(place + ": " + draco_extension + ": has no attribute " + std::to_string(number));
  std::vector<std::uint8_t> bytes;
  bool good = static_cast<std::size_t>(attribute->num_components()) == components;
  if (component_type == 5120)
    good = good && convert<std::int8_t>(from, *attribute, components, bytes);
  else if (component_type == 5121)
    good = good && convert<std::uint8_t>(from, *attribute, components, bytes);
  else if (component_type == 5122)
    good = good && convert<std::int16_t>(from, *attribute, components, bytes);
  else if (component_type == 5123)
    good = good && convert<std::uint16_t>(from, *attribute, components, bytes);
  else if (component_type == 5125)
    good = good && convert<std::uint32_t>(from, *attribute, components, bytes);
  else
    good = good && convert<float>(from, *attribute, components, bytes);
  if (!good)
    throw Error(place + ": " + draco_extension + ": attribute " + std::to_string(number) +
                " is not of " + std::to_string(components) + " components of type " +
                std::to_string(component_type) + ", as its accessor says");
  return bytes;
}

#else

struct DracoMesh {};

bool has_draco() {
  return false;
}

std::shared_ptr<const DracoMesh> unpack_draco(std::span<const std::uint8_t>,
                                              const std::string& place) {
  throw Error(place + ": " + draco_extension + ": this build has no Draco");
}

std::vector<std::uint32_t> draco_corners(const DracoMesh&) {
  return {};
}

std::uint64_t draco_vertices(const DracoMesh&) {
  return 0;
}

std::vector<std::uint8_t> draco_attribute(const DracoMesh&, int, int, std::size_t,
                                          const std::string&) {
  return {};
}

#endif

}  // namespace omma
