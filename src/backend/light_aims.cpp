// Images of discs, one for each disc and each smooth flat surface; spheres about surfaces that
// shine, one for each piece of a mesh that hangs together.
#include "backend/light_aims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "physics/surface/microfacet.h"

namespace omma {
namespace {

// Of scenes full of small mirrors so many count, first those that each face elsewhere, of images
// the brightest; others are found by rays.
constexpr std::size_t most_mirrors = 64, most_images = 128;

// Meshes of more triangles or pieces, as of ground that glows, are one piece.
constexpr std::size_t most_divided_triangles = 2'000'000, most_pieces = 100'000;

// A rougher surface spreads the sun over degrees, which ordinary rays find.
constexpr float most_mirror_roughness = 0.1f;
// Surfaces whose normals differ by more, rad, show the sun in more than one direction.
constexpr double flat_rad = 5e-4;

bool is_mirror(const Material& material) {
  if (material.unlit) return false;
  if (material.clearcoat > 0 && material.clearcoat_roughness <= most_mirror_roughness &&
      material.clearcoat_normal_texture.texture < 0)
    return true;
  return material.roughness <= most_mirror_roughness && material.normal_texture.texture < 0 &&
         (material.specular > 0 || material.metallic > 0);
}

// By how much a mirror's roughness spreads what it shows: some widths of its normals, twice.
double spread_rad(const Material& material) {
  const float rough = material.clearcoat > 0
                          ? std::min(material.clearcoat_roughness, material.roughness)
                          : material.roughness;
  const double alpha = std::pow(static_cast<double>(std::max(rough, least_roughness)), 2);
  return 2 * flat_rad + 4 * alpha;
}

// A vertex of an instance, in the world.
Vec3d place_of(const MeshView& mesh, const Mat4& world_from_mesh, std::uint32_t vertex) {
  const float* p = mesh.positions + 3 * static_cast<std::size_t>(vertex);
  return transform_point(world_from_mesh, Vec3d{p[0], p[1], p[2]});
}

// Of a plane: its normal in the world, and two directions in it in its mesh; all unit.
struct Plane {
  Vec3d facing, along, across;
};

// The plane of all triangles of an instance, or none.
std::optional<Plane> plane_of(const Scene& scene, const Placement& placement, const SceneView& view,
                              std::size_t instance) {
  const auto mesh = static_cast<std::size_t>(scene.instances[instance].mesh);
  const MeshView& seen = view.meshes[mesh];
  const Mat4& world_from_mesh = placement.world_from_mesh[instance];
  std::optional<Plane> found;
  for (const auto& triangle : scene.meshes[mesh].triangles) {
    Vec3d corner[3];
    for (std::size_t k = 0; k < 3; ++k) corner[k] = place_of(seen, world_from_mesh, triangle[k]);
    const Vec3d normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double size = length(normal);
    if (!(size > 0)) continue;
    const Vec3d unit = normal * (1 / size);
    if (!found) {
      const Vec3d own = place_of(seen, {}, triangle[0]);
      found = {unit, normalize(place_of(seen, {}, triangle[1]) - own),
               normalize(place_of(seen, {}, triangle[2]) - own)};
    }
    if (length(cross(found->facing, unit)) > flat_rad) return std::nullopt;
  }
  return found;
}

// Of the axes of a mesh, as physics/block/aims_in_view.h takes it.
double largest_scale(const Mat4& world_from_mesh) {
  double largest = 0;
  for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    largest = std::max(largest, length(transform_vector(world_from_mesh, axis)));
  return largest;
}

double solid_of(double radius_rad) {
  return 2 * pi * (1 - std::cos(radius_rad));
}

struct Mirror {
  std::int32_t instance;
  Plane plane;
  double spread_rad;  // the largest of those that face there
};

std::vector<Mirror> find_mirrors(const Scene& scene, const Placement& placement,
                                 const SceneView& view) {
  // What faces where others do counts once it is turned.
  std::vector<Mirror> mirrors, others;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const auto mesh = static_cast<std::size_t>(scene.instances[i].mesh);
    const std::int32_t material = scene.meshes[mesh].material;
    if (material < 0 || !is_mirror(scene.materials[static_cast<std::size_t>(material)])) continue;
    const std::optional<Plane> plane = plane_of(scene, placement, view, i);
    if (!plane) continue;
    const Mirror mirror{static_cast<std::int32_t>(i), *plane,
                        spread_rad(scene.materials[static_cast<std::size_t>(material)])};
    const auto same = std::find_if(mirrors.begin(), mirrors.end(), [&](const Mirror& known) {
      return length(cross(known.plane.facing, plane->facing)) < flat_rad;
    });
    if (same != mirrors.end()) {
      same->spread_rad = std::max(same->spread_rad, mirror.spread_rad);
      if (others.size() < most_mirrors) others.push_back(mirror);
    } else if (mirrors.size() < most_mirrors) {
      mirrors.push_back(mirror);
    }
  }
  const std::size_t room = most_mirrors - mirrors.size();
  others.resize(std::min(others.size(), room));
  mirrors.insert(mirrors.end(), others.begin(), others.end());
  return mirrors;
}

// Of a disc, as all mirrors show it, and as it is seen through volumes, which bend its rays.
void add_images(const LightData& data, std::size_t d, const std::vector<Mirror>& mirrors,
                bool has_volumes, std::vector<AimView>& aims) {
  const DiscView& disc = data.discs[d];
  const auto bands = static_cast<std::size_t>(data.view.bands);
  const float* radiance = data.disc_radiance.data() + d * bands;
  const double brightest = static_cast<double>(*std::max_element(radiance, radiance + bands));
  const double radius_rad = 2 * std::asin(0.5 * std::sqrt(static_cast<double>(disc.chord_2)));
  AimView aim;
  aim.disc = static_cast<std::int32_t>(d);
  const auto add = [&](double spread) {
    const double wide_rad = radius_rad + spread;
    aim.chord_2 = static_cast<float>(4 * std::pow(std::sin(0.5 * wide_rad), 2));
    aim.brightest = static_cast<float>(brightest * solid_of(radius_rad) / solid_of(wide_rad));
    aims.push_back(aim);
  };
  if (has_volumes) add(flat_rad);
  for (const Mirror& mirror : mirrors) {
    aim.instance = mirror.instance;
    aim.centre = to_float(mirror.plane.along);
    aim.across = to_float(mirror.plane.across);
    add(mirror.spread_rad);
  }
}

// A piece of a mesh that hangs together.
struct Piece {
  std::vector<std::uint32_t> vertices;
  double share = 0;  // of what the mesh sends
  double area_m2 = 0;
};

// The pieces of a mesh whose triangles send these powers; one where there are too many.
std::vector<Piece> pieces_of(const Mesh& mesh, const std::vector<double>& powers) {
  const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
  std::vector<std::uint32_t> parent(vertices);
  std::iota(parent.begin(), parent.end(), 0u);
  Piece whole{parent, 1, 1};
  const double all = std::accumulate(powers.begin(), powers.end(), 0.0);
  if (triangles > most_divided_triangles) return {whole};
  // Union-find; what is at the same place hangs together.
  const auto root_of = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  const auto at = [&](std::uint32_t v) {
    const Vec3& p = mesh.positions[v];
    return std::array{p.x, p.y, p.z};
  };
  std::vector<std::uint32_t> order = parent;
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return at(a) < at(b); });
  for (std::size_t k = 1; k < vertices; ++k)
    if (at(order[k]) == at(order[k - 1])) parent[root_of(order[k])] = root_of(order[k - 1]);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) parent[root_of(v)] = root_of(triangle[0]);
  std::map<std::uint32_t, Piece> of_root;
  std::vector<char> is_known(vertices, 0);
  for (std::size_t t = 0; t < triangles; ++t) {
    const auto& triangle = mesh.triangles[t];
    Piece& piece = of_root[root_of(triangle[0])];
    if (of_root.size() > most_pieces) return {whole};
    const auto corner = [&](std::size_t k) { return to_double(mesh.positions[triangle[k]]); };
    piece.share += powers[t] / all;
    piece.area_m2 += length(cross(corner(1) - corner(0), corner(2) - corner(0))) / 2;
    for (const std::uint32_t v : triangle)
      if (!std::exchange(is_known[v], char{1})) piece.vertices.push_back(v);
  }
  std::vector<Piece> pieces;
  for (auto& [root, piece] : of_root) pieces.push_back(std::move(piece));
  return pieces;
}

// What the surfaces of a mesh that shines are divided into.
struct Pieces {
  std::vector<Piece> most;  // those that send most, in order, as many as may be aimed at
  double brightest = 0;     // the largest share over area of all
};

double brightness(const Piece& piece) {
  return piece.share / std::max(piece.area_m2, 1e-300);
}

Pieces divide(const Mesh& mesh, const std::vector<double>& powers) {
  Pieces pieces{pieces_of(mesh, powers)};
  for (const Piece& piece : pieces.most)
    pieces.brightest = std::max(pieces.brightest, brightness(piece));
  std::stable_sort(pieces.most.begin(), pieces.most.end(),
                   [](const Piece& a, const Piece& b) { return a.share > b.share; });
  if (pieces.most.size() > most_aims) pieces.most.resize(most_aims);
  return pieces;
}

// The sphere about a piece of an instance.
AimView about(const Piece& piece, const EmissiveView& emissive, const MeshView& mesh,
              const Mat4& world_from_mesh) {
  Vec3d middle{};
  for (const std::uint32_t v : piece.vertices)
    middle = middle + place_of(mesh, {}, v) * (1.0 / static_cast<double>(piece.vertices.size()));
  const Vec3d centre = transform_point(world_from_mesh, middle);
  double radius_m = 0;
  for (const std::uint32_t v : piece.vertices)
    radius_m = std::max(radius_m, length(place_of(mesh, world_from_mesh, v) - centre));
  AimView aim;
  aim.centre = to_float(middle);
  aim.radius_m = static_cast<float>(radius_m / largest_scale(world_from_mesh));
  aim.instance = emissive.instance;
  return aim;
}

// Those that send most, as many as there is room for.
void add_shining(const LightData& data, const Scene& scene, const Placement& placement,
                 const SceneView& view, std::vector<AimView>& aims) {
  struct Shining {
    double power;
    std::size_t emissive;
    const Piece* piece;
  };
  const auto sends_more = [](const Shining& a, const Shining& b) { return a.power > b.power; };
  const std::size_t room = static_cast<std::size_t>(most_aims) - aims.size();
  std::map<std::int32_t, Pieces> pieces_of_mesh;
  std::vector<Shining> found;
  double least = 0;
  for (std::size_t e = 0; e < data.emissive.size(); ++e) {
    const EmissiveView& emissive = data.emissive[e];
    const auto [known, is_new] = pieces_of_mesh.try_emplace(emissive.mesh);
    if (is_new)
      known->second = divide(scene.meshes[static_cast<std::size_t>(emissive.mesh)],
                             data.triangle_powers.at(emissive.mesh));
    const double sent = data.emissive_weight[e];
    for (const Piece& piece : known->second.most) {
      if (!(sent * piece.share > least)) break;
      found.push_back({sent * piece.share, e, &piece});
    }
    // Never many more than there is room for, however often a mesh of many pieces is there.
    if (found.size() < 2 * room && e + 1 < data.emissive.size()) continue;
    std::stable_sort(found.begin(), found.end(), sends_more);
    if (found.size() <= room) continue;
    found.resize(room);
    least = found.back().power;
  }
  for (const Shining& shining : found) {
    const EmissiveView& emissive = data.emissive[shining.emissive];
    const MeshView& mesh = view.meshes[emissive.mesh];
    const Vec3 factor = view.materials[mesh.material].emissive;
    const float* matrix = view.scatter[mesh.material].emission;
    float brightest = 0;
    for (std::int32_t b = 0; b < data.view.bands; ++b)
      brightest = std::max(brightest, matrix[3 * b] * factor.x + matrix[3 * b + 1] * factor.y +
                                          matrix[3 * b + 2] * factor.z);
    const Piece& piece = *shining.piece;
    const double of_mesh = pieces_of_mesh[emissive.mesh].brightest;
    AimView aim = about(piece, emissive, mesh,
                        placement.world_from_mesh[static_cast<std::size_t>(emissive.instance)]);
    aim.brightest = brightest * static_cast<float>(of_mesh > 0 ? brightness(piece) / of_mesh : 1);
    aims.push_back(aim);
  }
}

}  // namespace

std::vector<AimView> make_aims(const LightData& data, const Scene& scene, const Placement& placement,
                               const SceneView& view) {
  std::vector<AimView> aims;
  const std::vector<Mirror> mirrors =
      data.discs.empty() ? std::vector<Mirror>{} : find_mirrors(scene, placement, view);
  for (std::size_t d = 0; d < data.discs.size(); ++d)
    add_images(data, d, mirrors, view.has_volumes, aims);
  std::stable_sort(aims.begin(), aims.end(), [](const AimView& a, const AimView& b) {
    return a.brightest * a.chord_2 > b.brightest * b.chord_2;
  });
  aims.resize(std::min(aims.size(), most_images));
  add_shining(data, scene, placement, view, aims);
  return aims;
}

}  // namespace omma
