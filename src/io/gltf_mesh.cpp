// Primitives of glTF 2.0 (section 3.7.2) as indexed triangles.
#include "io/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "io/csv_text.h"
#include "io/draco_mesh.h"
#include "model/texture_uses.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

const GltfAccessor& accessor_at(GltfMeshReader& reader, int index, const std::string& place) {
  const auto packed = reader.packed.find(index);
  if (packed != reader.packed.end()) return packed->second;
  const auto known = reader.accessors.find(index);
  if (known != reader.accessors.end()) return known->second;
  const json& source = gltf_element(reader.gltf, "accessors", "accessor", index, place);
  if (source["type"].get_ref<const std::string&>().starts_with("MAT"))
    throw Error(place + ": accessor " + std::to_string(index) + gltf_name(source) +
                " holds matrices, expected scalars or vectors");
  return reader.accessors.emplace(index, read_accessor(reader.gltf, index, place)).first->second;
}

// Where a primitive is packed by Draco, the accessors that it says are unpacked.
void unpack_primitive(GltfMeshReader& reader, const json& primitive, const std::string& place) {
  reader.packed.clear();
  const json& packing = gltf_extension(primitive, draco_extension);
  if (packing.empty() || !has_draco()) return;
  const int mode = primitive.value("mode", 4);
  if (mode != 4)
    throw Error(place + ": mode: expected 4 with " + draco_extension + ", found " +
                std::to_string(mode));
  const std::span<const std::uint8_t> bytes =
      buffer_view_bytes(reader.gltf, packing["bufferView"].get<int>(), place);
  const auto mesh = unpack_draco(bytes, place);
  const json& attributes = primitive["attributes"];
  for (const auto& [semantic, number] : packing["attributes"].items()) {
    const auto found = attributes.find(semantic);
    if (found == attributes.end())
      throw Error(place + ": attributes: has no " + shown_text(semantic) + ", which " +
                  draco_extension + " has");
    const std::string inside = place + ", " + semantic;
    const auto unpack = [&, id = number.get<int>()](const GltfAccessor& accessor) {
      if (accessor.count != draco_vertices(*mesh))
        throw Error(inside + ": " + accessor.place + " has " + std::to_string(accessor.count) +
                    " elements, " + draco_extension + " " + std::to_string(draco_vertices(*mesh)));
      return draco_attribute(*mesh, id, accessor.component_type, accessor.components, inside);
    };
    const int index = found->get<int>();
    reader.packed.emplace(index, read_packed_accessor(reader.gltf, index, inside, unpack));
  }
  if (!primitive.contains("indices"))
    throw Error(place + ": indices: expected an accessor with " + draco_extension);
  const int index = primitive["indices"].get<int>();
  const std::vector<std::uint32_t> corners = draco_corners(*mesh);
  reader.gltf.budget.spend(corners.size(), sizeof(std::uint32_t));
  GltfAccessor indices;
  indices.place = place + ", indices";
  indices.component_type = 5125;
  indices.count = corners.size();
  indices.stride = sizeof(std::uint32_t);
  const auto* first = reinterpret_cast<const std::uint8_t*>(corners.data());
  indices.own.assign(first, first + corners.size() * sizeof(std::uint32_t));
  indices.first = indices.own.data();
  reader.packed[index] = std::move(indices);
}

void note_progress(GltfMeshReader& reader, std::uint64_t elements) {
  reader.finished = std::min(reader.finished + static_cast<double>(elements), reader.all);
  reader.work.reach(reader.finished / reader.all);
}

// An attribute of every vertex; null where it is not there.
const GltfAccessor* attribute(GltfMeshReader& reader, const json& attributes,
                              const std::string& primitive_place, const std::string& semantic,
                              std::size_t fewest, std::size_t most) {
  const auto found = attributes.find(semantic);
  if (found == attributes.end()) return nullptr;
  const std::string place = primitive_place + ", " + semantic;
  const GltfAccessor& accessor = accessor_at(reader, found->get<int>(), place);
  if (accessor.components < fewest || accessor.components > most)
    throw Error(place + ": " + accessor.place + " has " + std::to_string(accessor.components) +
                " components, expected " + std::to_string(fewest) +
                (most > fewest ? " or " + std::to_string(most) : ""));
  return &accessor;
}

void check_count(const GltfAccessor* accessor, std::uint64_t vertices, const std::string& place,
                 const std::string& semantic) {
  if (accessor && accessor->count != vertices)
    throw Error(place + ": " + semantic + " has " + std::to_string(accessor->count) +
                " elements, POSITION has " + std::to_string(vertices));
}

// Checks what indices name.
void check_corners(std::span<const std::uint32_t> corners, std::uint64_t vertices,
                   const std::string& place) {
  const auto bad = std::find_if(corners.begin(), corners.end(),
                                [&](std::uint32_t corner) { return corner >= vertices; });
  if (bad != corners.end())
    throw Error(place + ": index " + std::to_string(bad - corners.begin()) + " is " +
                std::to_string(*bad) + ", past its " + std::to_string(vertices) + " vertices");
}

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Strips and fans (section 3.7.2.1) from the vertex of each corner.
Triangles assemble(int mode, const std::vector<std::uint32_t>& corners) {
  Triangles triangles;
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    if (mode == 5)  // strip: every other triangle is turned round
      triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
    else  // fan
      triangles.push_back({corners[i + 1], corners[i + 2], corners[0]});
  }
  return triangles;
}

// The corners are those of the indices, or 0, 1, 2 ... where there are none.
Triangles read_triangles(GltfMeshReader& reader, const json& primitive, const std::string& place,
                         int mode, std::uint64_t vertices) {
  const int index = primitive.value("indices", -1);
  const GltfAccessor* indices =
      index < 0 ? nullptr : &accessor_at(reader, index, place + ", indices");
  const std::uint64_t count = indices ? indices->count : vertices;
  const bool list = mode == 4;
  if (count < 3 || (list && count % 3 != 0))
    reader.warnings.add("corners that make no whole triangle are passed over", place);
  if (count == 0) return {};
  reader.gltf.budget.spend(count,
                           list ? sizeof(std::uint32_t) : sizeof(std::array<std::uint32_t, 4>));

  // A list of triangles is read into its place; corners beyond the last whole one are dropped then.
  std::vector<std::uint32_t> corners(list ? 0 : count);
  Triangles triangles(list ? (count + 2) / 3 : 0);
  std::uint32_t* first = list ? triangles.data()->data() : corners.data();
  const std::span<std::uint32_t> all(first, count);
  if (indices == nullptr) {
    std::iota(all.begin(), all.end(), 0u);
  } else {
    read_indices(*indices, all);
    check_corners(all, vertices, place);
  }
  note_progress(reader, count);
  if (list)
    triangles.resize(count / 3);
  else
    triangles = assemble(mode, corners);
  return triangles;
}

// Where only few of the vertices are used, the others are dropped and the triangles renumbered.
// Returns the vertices kept, in order; empty for all.
std::vector<std::uint32_t> keep_used(Triangles& triangles, std::uint64_t vertices) {
  std::vector<std::uint32_t> used;
  if (vertices <= 6 * triangles.size()) return used;
  used.reserve(3 * triangles.size());
  for (const auto& triangle : triangles) used.insert(used.end(), triangle.begin(), triangle.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (auto& triangle : triangles)
    for (std::uint32_t& vertex : triangle)
      vertex = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), vertex) -
                                          used.begin());
  return used;
}

// The attribute of each vertex kept, `fill` where the accessor has fewer components. With room for
// one more: Embree reads a little beyond the last position.
template <typename T>
std::vector<T> gathered(GltfMeshReader& reader, const GltfAccessor* accessor,
                        const std::vector<std::uint32_t>& kept, T fill = {}) {
  std::vector<T> result;
  if (accessor == nullptr) return result;
  const std::size_t count = kept.empty() ? accessor->count : kept.size();
  reader.gltf.budget.spend(count, sizeof(T));
  result.reserve(count + 1);
  result.resize(count, fill);
  read_floats(*accessor, kept, sizeof(T) / sizeof(float), &result.data()->x);
  note_progress(reader, accessor->count);
  return result;
}

void check_colors(const GltfAccessor* colors, const std::string& place) {
  if (colors && colors->component_type != 5126 && !colors->normalized)
    throw Error(place + ": COLOR_0 is of integers that are not normalised");
}

// A texture coordinate set that the material reads and the primitive lacks counts as (0, 0).
void warn_of_missing_texcoords(GltfMeshReader& reader, const std::string& place, const Mesh& mesh) {
  if (mesh.material < 0) return;
  if (lacks_coordinates(mesh, reader.materials[static_cast<std::size_t>(mesh.material)]))
    reader.warnings.add(without_coordinates, place);
}

void read_targets(GltfMeshReader& reader, const json& primitive, const std::string& place,
                  const std::vector<std::uint32_t>& kept, std::uint64_t vertices,
                  Deformation& deformation) {
  if (!primitive.contains("targets")) return;
  for (const json& target : primitive["targets"]) {
    const std::string target_place =
        place + ", targets[" + std::to_string(deformation.targets.size()) + "]";
    MorphTarget& made = deformation.targets.emplace_back();
    const auto read = [&](const char* semantic) {
      const GltfAccessor* given = attribute(reader, target, target_place, semantic, 3, 3);
      check_count(given, vertices, target_place, semantic);
      return gathered<Vec3>(reader, given, kept);
    };
    made.positions = read("POSITION");
    if (!deformation.normals.empty()) made.normals = read("NORMAL");
  }
}

// Exporters round weights to bytes one by one: eight of them are off by up to 8 x 0.5 / 255 = 0.016
// together.
constexpr float weights_off = 0.02f;

void check_bones(const Deformation& deformation, std::size_t joints, const std::string& place) {
  const auto influences = static_cast<std::size_t>(deformation.influences);
  for (std::size_t i = 0; i < deformation.joints.size(); ++i)
    if (deformation.joints[i] >= joints)
      throw Error(place + ", JOINTS_" + std::to_string(i % influences / 4) + ": vertex " +
                  std::to_string(i / influences) + " has joint " +
                  std::to_string(deformation.joints[i]) + ", the skin has " +
                  std::to_string(joints));
}

// Makes the weights of each vertex sum to 1.
void normalize_weights(Deformation& deformation, const std::string& place) {
  const auto influences = static_cast<std::size_t>(deformation.influences);
  for (std::size_t first = 0; first < deformation.weights.size(); first += influences) {
    float sum = 0;
    bool is_negative = false;
    for (std::size_t k = first; k < first + influences; ++k) {
      sum += deformation.weights[k];
      is_negative = is_negative || deformation.weights[k] < 0;
    }
    if (is_negative || !(std::fabs(sum - 1) <= weights_off))
      throw Error(place + ", WEIGHTS_0: the weights of vertex " +
                  std::to_string(first / influences) + " sum to " + std::to_string(sum) +
                  (is_negative ? " and some are below 0" : "") +
                  ", expected 1 to within 0.02, none below 0");
    for (std::size_t k = first; k < first + influences; ++k) deformation.weights[k] /= sum;
  }
}

void read_bones(GltfMeshReader& reader, const json& attributes, const std::string& place,
                const std::vector<std::uint32_t>& kept, std::uint64_t vertices, std::size_t joints,
                Deformation& deformation) {
  if (attributes.contains("JOINTS_2") || attributes.contains("WEIGHTS_2"))
    throw Error(place + ": JOINTS_2: expected at most 8 bones on a vertex (JOINTS_0 and 1)");
  const std::size_t sets = attributes.contains("JOINTS_1") ? 2 : 1;
  deformation.influences = static_cast<int>(4 * sets);
  const std::size_t count = deformation.positions.size();
  reader.gltf.budget.spend(count, 4 * sets * (sizeof(float) + sizeof(std::uint16_t)));
  deformation.joints.resize(4 * sets * count);
  deformation.weights.resize(4 * sets * count);
  for (std::size_t set = 0; set < sets; ++set) {
    const auto read = [&](const std::string& semantic, bool is_joint) {
      const GltfAccessor* given = attribute(reader, attributes, place, semantic, 4, 4);
      if (given == nullptr)
        throw Error(place + ": " + semantic + ": is missing, as its node has a skin");
      check_count(given, vertices, place, semantic);
      const bool is_integer = given->component_type == 5121 || given->component_type == 5123;
      const bool fits = is_joint ? is_integer && !given->normalized
                                 : given->component_type == 5126 || (is_integer && given->normalized);
      if (!fits)
        throw Error(place + ", " + semantic + ": expected " +
                    (is_joint ? "unsigned bytes or shorts"
                              : "floats, or unsigned bytes or shorts that are normalised") +
                    ", found component type " + std::to_string(given->component_type));
      return gathered<Vec4>(reader, given, kept);
    };
    const std::string number = std::to_string(set);
    const std::vector<Vec4> bones = read("JOINTS_" + number, true);
    const std::vector<Vec4> weights = read("WEIGHTS_" + number, false);
    for (std::size_t i = 0; i < count; ++i) {
      const float bone[4] = {bones[i].x, bones[i].y, bones[i].z, bones[i].w};
      const float weight[4] = {weights[i].x, weights[i].y, weights[i].z, weights[i].w};
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t at = 4 * (sets * i + set) + k;
        deformation.joints[at] = static_cast<std::uint16_t>(bone[k]);
        deformation.weights[at] = weight[k];
      }
    }
  }
  check_bones(deformation, joints, place);
  normalize_weights(deformation, place);
}

}  // namespace

bool read_primitive(GltfMeshReader& reader, const json& primitive, const std::string& place,
                    Mesh& mesh, Deformation* deformation, std::size_t joints) {
  const json& attributes = primitive["attributes"];
  const int mode = primitive.value("mode", 4);
  if (mode > 6) throw Error(place + ": mode: expected 0 to 6, found " + std::to_string(mode));
  if (mode < 4) {
    reader.warnings.add("points and lines are not shown", place);
    return false;
  }
  unpack_primitive(reader, primitive, place);
  mesh.material = primitive.value("material", -1);
  if (mesh.material >= 0) gltf_element(reader.gltf, "materials", "material", mesh.material, place);
  const GltfAccessor* positions = attribute(reader, attributes, place, "POSITION", 3, 3);
  if (positions == nullptr) {
    reader.warnings.add("a primitive without positions is not shown", place);
    return false;
  }
  const std::uint64_t vertices = positions->count;
  if (vertices > std::numeric_limits<std::uint32_t>::max())
    throw Error(place + ": has " + std::to_string(vertices) + " vertices, more than 32 bits count");

  mesh.triangles = read_triangles(reader, primitive, place, mode, vertices);
  if (mesh.triangles.empty()) return false;
  const std::vector<std::uint32_t> kept = keep_used(mesh.triangles, vertices);

  mesh.positions = gathered<Vec3>(reader, positions, kept);
  const GltfAccessor* normals = attribute(reader, attributes, place, "NORMAL", 3, 3);
  check_count(normals, vertices, place, "NORMAL");
  mesh.normals = gathered<Vec3>(reader, normals, kept);
  const auto is_normal = [](Vec3 n) {
    return std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z) && n != Vec3{0, 0, 0};
  };
  if (!std::all_of(mesh.normals.begin(), mesh.normals.end(), is_normal)) {
    reader.warnings.add(
        "normals of which some are zero or not finite are ignored, those of triangles are taken",
        place);
    mesh.normals.clear();
  }
  for (std::size_t set = 0; set < 2; ++set) {
    const std::string semantic = "TEXCOORD_" + std::to_string(set);
    const GltfAccessor* texcoords = attribute(reader, attributes, place, semantic, 2, 2);
    check_count(texcoords, vertices, place, semantic);
    mesh.texcoords[set] = gathered<Vec2>(reader, texcoords, kept);
  }
  const GltfAccessor* colors = attribute(reader, attributes, place, "COLOR_0", 3, 4);
  check_colors(colors, place);
  check_count(colors, vertices, place, "COLOR_0");
  mesh.colors = gathered<Vec4>(reader, colors, kept, Vec4{1, 1, 1, 1});
  warn_of_missing_texcoords(reader, place, mesh);
  if (deformation == nullptr) return true;
  deformation->positions = mesh.positions;
  deformation->normals = mesh.normals;
  read_targets(reader, primitive, place, kept, vertices, *deformation);
  if (deformation->skin >= 0)
    read_bones(reader, attributes, place, kept, vertices, joints, *deformation);
  return true;
}

}  // namespace omma
