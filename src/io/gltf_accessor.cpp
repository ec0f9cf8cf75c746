// Accessors of glTF 2.0 (section 3.6.2) as plain arrays.
#include "io/gltf_accessor.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <type_traits>

#include "omma/error.h"

namespace omma {

using nlohmann::json;

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
  if constexpr (std::is_floating_point_v<Out> && std::is_integral_v<T>) {
    if (normalized)  // glTF 2.0, section 3.6.2.2; the largest negative value is clamped
      return static_cast<Out>(
          std::max(static_cast<double>(value) / std::numeric_limits<T>::max(), -1.0));
  }
  return static_cast<Out>(value);
}

// Elements of a buffer view, component type T.
template <typename T>
struct Elements {
  const std::uint8_t* first;
  std::size_t stride, components;
  bool normalized;

  explicit Elements(const GltfAccessor& a)
      : first(a.view.data() + a.byte_offset),
        stride(a.byte_stride ? a.byte_stride : sizeof(T) * a.components),
        components(a.components),
        normalized(a.normalized) {}

  template <typename Out>
  void read(std::size_t element, Out* out) const {
    const std::uint8_t* from = first + element * stride;
    for (std::size_t c = 0; c < components; ++c)
      out[c] = converted<T, Out>(from + c * sizeof(T), normalized);
  }
};

// Calls `use(element, bytes of its value)` for the elements that a sparse accessor replaces.
template <typename Use>
void for_each_replaced(const GltfAccessor& accessor, Use use) {
  if (accessor.sparse_count == 0) return;
  const std::uint64_t size =
      component_size(accessor, accessor.component_type) * accessor.components;
  with_component_type(accessor.sparse_index_type, [&](auto zero) {
    using Index = decltype(zero);
    const std::uint8_t* indices = accessor.sparse_indices.data() + accessor.sparse_indices_offset;
    for (std::size_t i = 0; i < accessor.sparse_count; ++i) {
      const auto at = converted<Index, std::uint64_t>(indices + i * sizeof(Index), false);
      if (at >= accessor.count)
        throw Error(accessor.place + ": sparse index " + std::to_string(at) + " is past its " +
                    std::to_string(accessor.count) + " elements");
      use(at, accessor.sparse_values.data() + accessor.sparse_values_offset + i * size);
    }
  });
}

// Long arrays are shared by the threads in pieces of this many elements.
constexpr std::size_t piece = 1 << 16;

using Range = tbb::blocked_range<std::size_t>;

}  // namespace

GltfAccessor gltf_accessor(const GltfContainer& gltf, std::size_t index) {
  const json& source = gltf.document["accessors"][index];
  const std::string name = source.value("name", "");
  GltfAccessor accessor;
  accessor.place =
      gltf.path + ": accessor " + std::to_string(index) + (name.empty() ? "" : " \"" + name + "\"");
  accessor.component_type = source["componentType"].get<int>();
  const std::string& type = source["type"].get_ref<const std::string&>();
  static const std::map<std::string, std::size_t> components = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  const auto known = components.find(type);
  accessor.components = known == components.end() ? 0 : known->second;
  accessor.matrix = type.starts_with("MAT");
  accessor.normalized = source.value("normalized", false);
  accessor.count = source["count"].get<std::uint64_t>();
  accessor.byte_offset = source.value("byteOffset", std::uint64_t{0});
  if (source.contains("bufferView")) {
    const int view = source["bufferView"].get<int>();
    accessor.has_view = true;
    accessor.view = buffer_view_bytes(gltf, view, accessor.place);
    accessor.byte_stride = gltf.document["bufferViews"][static_cast<std::size_t>(view)].value(
        "byteStride", std::uint64_t{0});
  }
  if (!source.contains("sparse")) return accessor;
  const json& sparse = source["sparse"];
  accessor.sparse_count = sparse["count"].get<std::uint64_t>();
  accessor.sparse_index_type = sparse["indices"]["componentType"].get<int>();
  accessor.sparse_indices =
      buffer_view_bytes(gltf, sparse["indices"]["bufferView"].get<int>(), accessor.place);
  accessor.sparse_indices_offset = sparse["indices"].value("byteOffset", std::uint64_t{0});
  accessor.sparse_values =
      buffer_view_bytes(gltf, sparse["values"]["bufferView"].get<int>(), accessor.place);
  accessor.sparse_values_offset = sparse["values"].value("byteOffset", std::uint64_t{0});
  return accessor;
}

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

void check_floats(const GltfAccessor& accessor) {
  const auto fail = [&](std::size_t element, float value) {
    throw Error(accessor.place + ": element " + std::to_string(element) + " is not finite (" +
                std::to_string(value) + ")");
  };
  for_each_replaced(accessor, [&](std::uint64_t at, const std::uint8_t* bytes) {
    for (std::size_t c = 0; accessor.component_type == 5126 && c < accessor.components; ++c) {
      const auto value = converted<float, float>(bytes + c * sizeof(float), false);
      if (!std::isfinite(value)) fail(at, value);
    }
  });
  if (accessor.component_type != 5126 || !accessor.has_view) return;
  const Elements<float> elements(accessor);
  const auto bad_component = [&](std::size_t i) {
    float values[16];
    elements.read(i, values);
    return std::find_if(values, values + elements.components,
                        [](float v) { return !std::isfinite(v); }) -
           values;
  };
  // The first of all, whichever thread finds one first.
  const std::size_t bad = tbb::parallel_reduce(
      Range(0, accessor.count, piece), std::size_t{accessor.count},
      [&](const Range& range, std::size_t found) {
        for (std::size_t i = range.begin(); i < std::min(range.end(), found); ++i)
          if (bad_component(i) < static_cast<std::ptrdiff_t>(elements.components)) return i;
        return found;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (bad == accessor.count) return;
  float values[16];
  elements.read(bad, values);
  fail(bad, values[bad_component(bad)]);
}

void read_floats(const GltfAccessor& accessor, std::span<const std::uint32_t> which,
                 std::size_t out_components, float* out) {
  const std::size_t count = which.empty() ? accessor.count : which.size();
  with_component_type(accessor.component_type, [&](auto zero) {
    using T = decltype(zero);
    if (accessor.has_view) {
      const Elements<T> elements(accessor);
      tbb::parallel_for(Range(0, count, piece), [&](const Range& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          elements.read(which.empty() ? i : which[i], out + i * out_components);
      });
    } else {
      for (std::size_t i = 0; i < count; ++i)
        std::fill_n(out + i * out_components, accessor.components, 0.0f);
    }
    for_each_replaced(accessor, [&](std::uint64_t at, const std::uint8_t* bytes) {
      std::size_t i = at;
      if (!which.empty()) {
        const auto found = std::lower_bound(which.begin(), which.end(), at);
        if (found == which.end() || *found != at) return;
        i = static_cast<std::size_t>(found - which.begin());
      }
      for (std::size_t c = 0; c < accessor.components; ++c)
        out[i * out_components + c] =
            converted<T, float>(bytes + c * sizeof(T), accessor.normalized);
    });
  });
}

void read_doubles(const GltfAccessor& accessor, std::span<double> out) {
  with_component_type(accessor.component_type, [&](auto zero) {
    using T = decltype(zero);
    std::fill(out.begin(), out.end(), 0.0);
    if (accessor.has_view) {
      const Elements<T> elements(accessor);
      for (std::size_t i = 0; i < accessor.count; ++i)
        elements.read(i, &out[i * accessor.components]);
    }
    for_each_replaced(accessor, [&](std::uint64_t at, const std::uint8_t* bytes) {
      for (std::size_t c = 0; c < accessor.components; ++c)
        out[at * accessor.components + c] =
            converted<T, double>(bytes + c * sizeof(T), accessor.normalized);
    });
  });
}

void read_indices(const GltfAccessor& accessor, std::span<std::uint32_t> out) {
  const int type = accessor.component_type;
  if (accessor.components != 1 || (type != 5121 && type != 5123 && type != 5125))
    throw Error(accessor.place + ": indices must be unsigned integer scalars");
  std::uint32_t restart = 0;
  with_component_type(type, [&](auto zero) {
    using Index = decltype(zero);
    if constexpr (std::is_unsigned_v<Index>) {
      restart = std::numeric_limits<Index>::max();
      if (accessor.has_view) {
        const Elements<Index> elements(accessor);
        tbb::parallel_for(Range(0, accessor.count, piece), [&](const Range& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) elements.read(i, &out[i]);
        });
      }
      for_each_replaced(accessor, [&](std::uint64_t at, const std::uint8_t* bytes) {
        out[at] = converted<Index, std::uint32_t>(bytes, false);
      });
    }
  });
  const auto bad = std::find(out.begin(), out.end(), restart);
  if (bad != out.end())
    throw Error(accessor.place + ": index " + std::to_string(bad - out.begin()) + " is " +
                std::to_string(restart) + ", the primitive restart value, which glTF forbids");
}

}  // namespace omma
