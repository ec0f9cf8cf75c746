// Accessors of glTF 2.0 (section 3.6.2) as plain arrays.
#include "io/gltf_accessor.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <type_traits>

#include "io/csv_text.h"
#include "omma/error.h"
#include "threads/parallel.h"

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

// One element, component type T.
template <typename T, typename Out>
void read_element(const GltfAccessor& accessor, std::size_t element, Out* out) {
  const std::uint8_t* from = accessor.first + element * accessor.stride;
  for (std::size_t c = 0; c < accessor.components; ++c)
    out[c] = converted<T, Out>(from + c * sizeof(T), accessor.normalized);
}

// Long arrays are shared by the threads in pieces of this many elements.
constexpr std::size_t piece = 1 << 16;

bool is_unsigned_integer(int component_type) {
  return component_type == 5121 || component_type == 5123 || component_type == 5125;
}

// Where `count` elements of `size` bytes are, `stride` bytes apart, in the buffer view that
// `description` names.
const std::uint8_t* elements_in_view(GltfContainer& gltf, const GltfAccessor& accessor,
                                     const json& description, std::uint64_t count,
                                     std::uint64_t size, std::uint64_t stride, const char* what) {
  const std::span<const std::uint8_t> bytes =
      buffer_view_bytes(gltf, description["bufferView"].get<int>(), accessor.place);
  const std::uint64_t offset = description.value("byteOffset", std::uint64_t{0});
  if (count == 0) return bytes.data();
  const bool fits = offset <= bytes.size() && size <= bytes.size() - offset &&
                    count - 1 <= (bytes.size() - offset - size) / stride;
  if (!fits)
    throw Error(accessor.place + ": its " + std::to_string(count) + " " + what + " from byte " +
                std::to_string(offset) + " on reach past the end of their buffer view of " +
                std::to_string(bytes.size()) + " bytes");
  return bytes.data() + offset;
}

// Elements of `size` bytes in one piece: zeros or those of the view, and those that replace them.
void gather(GltfContainer& gltf, GltfAccessor& accessor, const json& description,
            std::size_t size) {
  gltf.budget.spend(accessor.count, size);
  accessor.own.resize(accessor.count * size);
  for (std::size_t i = 0; accessor.first != nullptr && i < accessor.count; ++i)
    std::memcpy(&accessor.own[i * size], accessor.first + i * accessor.stride, size);
  accessor.first = accessor.own.data();
  accessor.stride = size;
  if (!description.contains("sparse")) return;
  const json& sparse = description["sparse"];
  const auto count = sparse["count"].get<std::uint64_t>();
  const int type = sparse["indices"]["componentType"].get<int>();
  if (!is_unsigned_integer(type))
    throw Error(accessor.place + ": sparse indices of component type " + std::to_string(type) +
                ", expected an unsigned integer");
  with_component_type(type, [&](auto zero) {
    using Index = decltype(zero);
    const std::uint8_t* indices = elements_in_view(gltf, accessor, sparse["indices"], count,
                                                   sizeof(Index), sizeof(Index), "sparse indices");
    const std::uint8_t* values =
        elements_in_view(gltf, accessor, sparse["values"], count, size, size, "sparse values");
    for (std::size_t i = 0; i < count; ++i) {
      const auto at = converted<Index, std::uint64_t>(indices + i * sizeof(Index), false);
      if (at >= accessor.count)
        throw Error(accessor.place + ": sparse index " + std::to_string(at) + " is past its " +
                    std::to_string(accessor.count) + " elements");
      std::memcpy(&accessor.own[at * size], values + i * size, size);
    }
  });
}

void check_finite(const GltfAccessor& accessor) {
  const auto bad_component = [&](std::size_t element) {
    float values[16];
    read_element<float>(accessor, element, values);
    return static_cast<std::size_t>(std::find_if(values, values + accessor.components,
                                                 [](float v) { return !std::isfinite(v); }) -
                                    values);
  };
  // The first of all, whichever thread finds one first.
  std::atomic<std::size_t> first_bad = accessor.count;
  parallel_ranges(std::size_t{0}, std::size_t{accessor.count}, piece,
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i) {
                      std::size_t known = first_bad;
                      if (i >= known) return;
                      if (bad_component(i) >= accessor.components) continue;
                      while (i < known && !first_bad.compare_exchange_weak(known, i)) {
                      }
                      return;
                    }
                  });
  const std::size_t bad = first_bad;
  if (bad == accessor.count) return;
  float values[16];
  read_element<float>(accessor, bad, values);
  throw Error(accessor.place + ": element " + std::to_string(bad) + " is not finite (" +
              std::to_string(values[bad_component(bad)]) + ")");
}

// All but where the elements are; `size` is that of one.
GltfAccessor describe_accessor(const GltfContainer& gltf, int index, const std::string& user,
                               std::size_t& size) {
  const json& source = gltf_element(gltf, "accessors", "accessor", index, user);
  GltfAccessor accessor;
  accessor.place = gltf.path + ": accessor " + std::to_string(index) + gltf_name(source);
  accessor.component_type = source["componentType"].get<int>();
  accessor.normalized = source.value("normalized", false);
  accessor.count = source["count"].get<std::uint64_t>();
  const std::string& type = source["type"].get_ref<const std::string&>();
  static const std::map<std::string, std::size_t> components = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  const auto known = components.find(type);
  if (known == components.end())
    throw Error(accessor.place + ": type: expected one of glTF 2.0, found " + shown_text(type));
  accessor.components = known->second;
  accessor.matrix = type.starts_with("MAT");
  size = 0;
  if (!with_component_type(accessor.component_type, [&](auto zero) { size = sizeof(zero); }))
    throw Error(accessor.place +
                ": componentType: expected one of glTF 2.0, found component type " +
                std::to_string(accessor.component_type));
  if (accessor.matrix && accessor.component_type != 5126)  // whose columns may be padded
    throw Error(accessor.place + ": expected matrices of floats, found component type " +
                std::to_string(accessor.component_type));
  size *= accessor.components;
  return accessor;
}

}  // namespace

GltfAccessor read_packed_accessor(
    GltfContainer& gltf, int index, const std::string& user,
    const std::function<std::vector<std::uint8_t>(const GltfAccessor&)>& unpack) {
  std::size_t size = 0;
  GltfAccessor accessor = describe_accessor(gltf, index, user, size);
  gltf.budget.spend(accessor.count, size);
  accessor.own = unpack(accessor);
  if (accessor.own.size() != accessor.count * size)
    throw Error(accessor.place + ": has " + std::to_string(accessor.count) + " elements of " +
                std::to_string(size) + " bytes, " + std::to_string(accessor.own.size()) +
                " bytes are packed");
  accessor.first = accessor.own.data();
  accessor.stride = size;
  if (accessor.component_type == 5126) check_finite(accessor);
  return accessor;
}

GltfAccessor read_accessor(GltfContainer& gltf, int index, const std::string& user) {
  std::size_t size = 0;
  GltfAccessor accessor = describe_accessor(gltf, index, user, size);
  const json& source = gltf_element(gltf, "accessors", "accessor", index, user);
  if (source.contains("bufferView")) {
    const int view = source["bufferView"].get<int>();
    accessor.stride = gltf_element(gltf, "bufferViews", "buffer view", view, accessor.place)
                          .value("byteStride", std::size_t{0});
    if (accessor.stride % 4 != 0 || accessor.stride > 252)
      throw Error(accessor.place + ": buffer view " + std::to_string(view) +
                  ": byteStride: expected a multiple of 4 up to 252, found " +
                  std::to_string(accessor.stride));
    if (accessor.stride == 0) accessor.stride = size;
    if (accessor.stride < size)
      throw Error(accessor.place + ": its elements of " + std::to_string(size) +
                  " bytes overlap: the byte stride is " + std::to_string(accessor.stride));
    accessor.first =
        elements_in_view(gltf, accessor, source, accessor.count, size, accessor.stride, "elements");
  }
  if (accessor.first == nullptr || source.contains("sparse")) gather(gltf, accessor, source, size);
  if (accessor.component_type == 5126) check_finite(accessor);
  return accessor;
}

void read_floats(const GltfAccessor& accessor, std::span<const std::uint32_t> which,
                 std::size_t out_components, float* out) {
  const std::size_t count = which.empty() ? accessor.count : which.size();
  with_component_type(accessor.component_type, [&](auto zero) {
    parallel_ranges(std::size_t{0}, count, piece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        read_element<decltype(zero)>(accessor, which.empty() ? i : which[i],
                                     out + i * out_components);
    });
  });
}

void read_doubles(const GltfAccessor& accessor, std::span<double> out) {
  with_component_type(accessor.component_type, [&](auto zero) {
    for (std::size_t i = 0; i < accessor.count; ++i)
      read_element<decltype(zero)>(accessor, i, &out[i * accessor.components]);
  });
}

void read_indices(const GltfAccessor& accessor, std::span<std::uint32_t> out) {
  if (accessor.components != 1 || !is_unsigned_integer(accessor.component_type))
    throw Error(accessor.place + ": indices must be unsigned integer scalars");
  std::uint32_t restart = 0;
  with_component_type(accessor.component_type, [&](auto zero) {
    using Index = decltype(zero);
    if constexpr (std::is_unsigned_v<Index>) {
      restart = std::numeric_limits<Index>::max();
      parallel_ranges(std::size_t{0}, std::size_t{accessor.count}, piece,
                      [&](std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i)
                          read_element<Index>(accessor, i, &out[i]);
                      });
    }
  });
  const auto bad = std::find(out.begin(), out.end(), restart);
  if (bad != out.end())
    throw Error(accessor.place + ": index " + std::to_string(bad - out.begin()) + " is " +
                std::to_string(restart) + ", the primitive restart value, which glTF forbids");
}

}  // namespace omma
