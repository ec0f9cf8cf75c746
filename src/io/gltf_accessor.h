// Reading numbers out of glTF accessors: every component type, normalised, strided, sparse. All
// bounds are checked in 64 bits before anything is read or allocated.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf_container.h"

namespace omma {

// An accessor whose bytes are known to be there and, where they are floats, to be finite.
struct GltfAccessor {
  std::string place;  // for errors, such as "scene.gltf: accessor 3"
  int component_type =
      0;  // 5120 to 5126: (unsigned) byte, (unsigned) short, -, unsigned int, float
  std::size_t components = 1;  // of an element: 1 to 4, 4 to 16 of a matrix
  bool matrix = false;
  bool normalized = false;
  std::size_t count = 0;                // elements
  const std::uint8_t* first = nullptr;  // of the file's bytes, or of `own`
  std::size_t stride = 0;               // bytes from one element to the next
  std::vector<std::uint8_t> own;        // where the file does not have the elements in one piece
};

// Accessor `index` of the file; throws omma::Error where there is none (starting with `user`), it
// does not fit its bytes, is of no known type or has a float that is not finite.
GltfAccessor read_accessor(GltfContainer& gltf, int index, const std::string& user);

// The same whose elements are not in the file as the accessor says, but were packed otherwise: asks
// `unpack` for their bytes, in one piece, given an accessor with all but these.
GltfAccessor read_packed_accessor(
    GltfContainer& gltf, int index, const std::string& user,
    const std::function<std::vector<std::uint8_t>(const GltfAccessor&)>& unpack);

// The elements listed in `which`, ascending (empty: all), straight from the file's bytes into
// `out`, `out_components` numbers each; those past the accessor's own stay as they are. Integers
// are scaled to [-1, 1] or [0, 1] where normalised. Runs on all threads.
void read_floats(const GltfAccessor& accessor, std::span<const std::uint32_t> which,
                 std::size_t out_components, float* out);

// All elements as they are, in double precision.
void read_doubles(const GltfAccessor& accessor, std::span<double> out);

// All elements, of an unsigned integer type; throws omma::Error for any other and where one is the
// type's largest value (primitive restart).
void read_indices(const GltfAccessor& accessor, std::span<std::uint32_t> out);

}  // namespace omma
