// Reading numbers out of glTF accessors: every component type, normalised, strided, sparse. All
// bounds are checked in 64 bits before anything is read or allocated.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "io/gltf_container.h"

namespace omma {

// What an accessor says, as it says it, with the bytes of its buffer views.
struct GltfAccessor {
  std::string place;  // for errors, such as "scene.gltf: accessor 3"
  int component_type =
      0;  // 5120 and on: byte, unsigned byte, short, unsigned short, -, unsigned int, float
  std::size_t components = 1;  // of an element: 1 to 4, 4 to 16 of a matrix; 0: of no known type
  bool matrix = false;
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

// An accessor of the file's list, of which there is one of that index, as it describes itself;
// throws omma::Error where it names a buffer view that is not there.
GltfAccessor gltf_accessor(const GltfContainer& gltf, std::size_t index);

// Throws omma::Error where the accessor does not fit its bytes or is of no known type.
void check_accessor(const GltfAccessor& accessor);

// Throws omma::Error where a number of the accessor is not finite or an element that its sparse
// part replaces is not there. The accessor is checked already.
void check_floats(const GltfAccessor& accessor);

// The elements listed in `which`, ascending (empty: all), straight from the file's bytes into
// `out`, `out_components` numbers each; those past the accessor's own stay as they are. Integers
// are scaled to [-1, 1] or [0, 1] where normalised. Runs on all threads. check_floats has passed.
void read_floats(const GltfAccessor& accessor, std::span<const std::uint32_t> which,
                 std::size_t out_components, float* out);

// All elements as they are, in double precision.
void read_doubles(const GltfAccessor& accessor, std::span<double> out);

// All elements, of an unsigned integer type; throws omma::Error for any other and where one is the
// type's largest value (primitive restart). The accessor is checked already.
void read_indices(const GltfAccessor& accessor, std::span<std::uint32_t> out);

}  // namespace omma
