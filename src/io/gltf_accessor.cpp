// Accessors of glTF 2.0 (section 3.6.2) as plain arrays.
#include "io/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "omma/error.h"

namespace omma {
namespace {

// Calls `use(T{})` with the C++ type of a component type; false for an unknown one.
template <typename Use>
bool with_component_type(int component_type, Use use) {
  switch (component_type) {
    case 5120:
      use(std::int8_t{});
      return true;
    case 5121:
      use(std::uint8_t{});
      return true;
    case 5122:
      use(std::int16_t{});
      return true;
    case 5123:
      use(std::uint16_t{});
      return true;
    case 5125:
      use(std::uint32_t{});
      return true;
    case 5126:
      use(float{});
      return true;
    default:
      return false;
  }
}

std::uint64_t component_size(const GltfAccessor& accessor, int component_type) {
  std::uint64_t size = 0;
  if (!with_component_type(component_type, [&](auto zero) { size = sizeof(zero); }))
    throw Error(accessor.place + ": component type " + std::to_string(component_type) +
                " is not one of glTF 2.0");
  return size;
}

// `count` elements of `size` bytes, `stride` bytes apart, from `offset` on must lie in `bytes`.
void check_range(const GltfAccessor& accessor, std::span<const std::uint8_t> bytes,
                 std::uint64_t offset, std::uint64_t stride, std::uint64_t size,
                 std::uint64_t count, const char* what) {
  if (count == 0) return;
  const bool fits = offset <= bytes.size() && size <= bytes.size() - offset &&
                    count - 1 <= (bytes.size() - offset - size) / stride;
  if (!fits)
    throw Error(accessor.place + ": its " + std::to_string(count) + " " + what + " from byte " +
                std::to_string(offset) + " on reach past the end of their buffer view of " +
                std::to_string(bytes.size()) + " bytes");
}

// Values of type T as stored; Out is float (with normalisation) or an unsigned integer.
template <typename T, typename Out>
Out converted(const std::uint8_t* from, bool normalized) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  if constexpr (std::is_same_v<Out, float> && std::is_integral_v<T>) {
    if (normalized)  // glTF 2.0, section 3.6.2.2; the largest negative value is clamped
      return static_cast<float>(
          std::max(static_cast<double>(value) / std::numeric_limits<T>::max(), -1.0));
  }
  return static_cast<Out>(value);
}

template <typename T, typename Out>
void read_elements(const GltfAccessor& accessor, std::vector<Out>& out) {
  const std::size_t components = accessor.components;
  const std::size_t size = sizeof(T) * components;
  if (accessor.has_view) {
    const std::size_t stride = accessor.byte_stride ? accessor.byte_stride : size;
    for (std::size_t i = 0; i < accessor.count; ++i)
      for (std::size_t c = 0; c < components; ++c)
        out[i * components + c] = converted<T, Out>(
            accessor.view.data() + accessor.byte_offset + i * stride + c * sizeof(T),
            accessor.normalized);
  }
  with_component_type(accessor.sparse_index_type, [&](auto zero) {
    using Index = decltype(zero);
    for (std::size_t i = 0; i < accessor.sparse_count; ++i) {
      const auto at = converted<Index, std::uint64_t>(
          accessor.sparse_indices.data() + accessor.sparse_indices_offset + i * sizeof(Index),
          false);
      if (at >= accessor.count)
        throw Error(accessor.place + ": sparse index " + std::to_string(at) + " is past its " +
                    std::to_string(accessor.count) + " elements");
      for (std::size_t c = 0; c < components; ++c)
        out[at * components + c] =
            converted<T, Out>(accessor.sparse_values.data() + accessor.sparse_values_offset +
                                  i * size + c * sizeof(T),
                              accessor.normalized);
    }
  });
}

}  // namespace

void check_accessor(const GltfAccessor& accessor) {
  const std::uint64_t size =
      component_size(accessor, accessor.component_type) * accessor.components;
  if (accessor.has_view) {
    const std::uint64_t stride = accessor.byte_stride ? accessor.byte_stride : size;
    if (stride < size)
      throw Error(accessor.place + ": its elements of " + std::to_string(size) +
                  " bytes overlap: the byte stride is " + std::to_string(stride));
    check_range(accessor, accessor.view, accessor.byte_offset, stride, size, accessor.count,
                "elements");
  }
  if (accessor.sparse_count == 0) return;
  const int type = accessor.sparse_index_type;
  if (type != 5121 && type != 5123 && type != 5125)
    throw Error(accessor.place + ": sparse indices of component type " + std::to_string(type) +
                ", expected an unsigned integer");
  const std::uint64_t index_size = component_size(accessor, type);
  check_range(accessor, accessor.sparse_indices, accessor.sparse_indices_offset, index_size,
              index_size, accessor.sparse_count, "sparse indices");
  check_range(accessor, accessor.sparse_values, accessor.sparse_values_offset, size, size,
              accessor.sparse_count, "sparse values");
}

std::vector<float> read_floats(const GltfAccessor& accessor) {
  std::vector<float> values(accessor.count * accessor.components);
  with_component_type(accessor.component_type,
                      [&](auto zero) { read_elements<decltype(zero)>(accessor, values); });
  const auto bad =
      std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad != values.end())
    throw Error(
        accessor.place + ": element " +
        std::to_string(static_cast<std::size_t>(bad - values.begin()) / accessor.components) +
        " is not finite (" + std::to_string(*bad) + ")");
  return values;
}

std::vector<std::uint32_t> read_indices(const GltfAccessor& accessor) {
  const int type = accessor.component_type;
  if (accessor.components != 1 || (type != 5121 && type != 5123 && type != 5125))
    throw Error(accessor.place + ": indices must be unsigned integer scalars");
  std::vector<std::uint32_t> values(accessor.count);
  std::uint32_t restart = 0;
  with_component_type(type, [&](auto zero) {
    using Index = decltype(zero);
    if constexpr (std::is_unsigned_v<Index>) {
      restart = std::numeric_limits<Index>::max();
      GltfAccessor plain = accessor;
      plain.normalized = false;
      read_elements<Index>(plain, values);
    }
  });
  const auto bad = std::find(values.begin(), values.end(), restart);
  if (bad != values.end())
    throw Error(accessor.place + ": index " + std::to_string(bad - values.begin()) + " is " +
                std::to_string(restart) + ", the primitive restart value, which glTF forbids");
  return values;
}

}  // namespace omma
