// Reading numbers out of glTF accessors: every component type, normalised, strided, sparse. All
// bounds are checked in 64 bits before anything is read or allocated.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace omma {

// What an accessor says, as it says it, with the bytes of its buffer views.
struct GltfAccessor {
  std::string place;  // for errors, such as "scene.gltf: accessor 3"
  int component_type =
      0;  // 5120 and on: byte, unsigned byte, short, unsigned short, -, unsigned int, float
  std::size_t components = 1;  // of an element, 1 to 4
  bool normalized = false;
  std::uint64_t count = 0;  // elements

  bool has_view = false;  // without one all elements are zero
  std::span<const std::uint8_t> view;
  std::uint64_t byte_offset = 0;
  std::uint64_t byte_stride = 0;  // 0: elements follow one another

  // Elements that replace those of the view.
  std::uint64_t sparse_count = 0;
  int sparse_index_type = 0;
  std::span<const std::uint8_t> sparse_indices, sparse_values;
  std::uint64_t sparse_indices_offset = 0, sparse_values_offset = 0;
};

// Throws omma::Error where the accessor does not fit its bytes or is of no known type.
void check_accessor(const GltfAccessor& accessor);

// [element][component]; integers are scaled to [-1, 1] or [0, 1] where normalised. Throws
// omma::Error where a number is not finite. The accessor is checked already.
std::vector<float> read_floats(const GltfAccessor& accessor);

// [element], of an unsigned integer type; throws omma::Error for any other and where an element is
// the type's largest value (primitive restart). The accessor is checked already.
std::vector<std::uint32_t> read_indices(const GltfAccessor& accessor);

}  // namespace omma
