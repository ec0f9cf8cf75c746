// Mirror images of discs, one for each disc and each direction that smooth flat surfaces face;
// spheres about surfaces that shine, one for each piece of a mesh that hangs together.
#include "backend/light_aims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "physics/surface/microfacet.h"

namespace omma {
namespace {

// Each is tested for each ommatidium in each frame, and has a number of 16 bits (AimsInView).
constexpr std::size_t most_aims = 1024, most_mirror_images = 8;

// A mesh of more triangles, as of ground that glows, is one piece.
constexpr std::size_t most_divided_triangles = 100'000;

// Of scenes full of small mirrors the first so many directions count; others are found by rays.
constexpr std::size_t most_mirrors = 64;

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

// The direction that all triangles of an instance face, unit, or none.
std::optional<Vec3d> facing(const Scene& scene, const Placement& placement, const SceneView& view,
                            std::size_t instance) {
  const auto mesh = static_cast<std::size_t>(scene.instances[instance].mesh);
  const Mat4& world_from_mesh = placement.world_from_mesh[instance];
  std::optional<Vec3d> found;
  for (const auto& triangle : scene.meshes[mesh].triangles) {
    Vec3d corner[3];
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = place_of(view.meshes[mesh], world_from_mesh, triangle[k]);
    const Vec3d normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double size = length(normal);
    if (!(size > 0)) continue;
    const Vec3d unit = normal * (1 / size);
    if (!found) found = unit;
    const Vec3d off = cross(*found, unit);
    if (length(off) > flat_rad) return std::nullopt;
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

void add_mirror_images(const LightData& data, const Scene& scene, const Placement& placement,
                       const SceneView& view, std::vector<AimView>& aims) {
  if (data.discs.empty()) return;
  const auto bands = static_cast<std::size_t>(data.view.bands);
  struct Mirror {
    Vec3d facing;
    double spread_rad;
  };
  std::vector<Mirror> mirrors;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const auto mesh = static_cast<std::size_t>(scene.instances[i].mesh);
    const std::int32_t material = scene.meshes[mesh].material;
    if (material < 0 || !is_mirror(scene.materials[static_cast<std::size_t>(material)])) continue;
    const std::optional<Vec3d> normal = facing(scene, placement, view, i);
    if (!normal) continue;
    const double spread = spread_rad(scene.materials[static_cast<std::size_t>(material)]);
    const auto same = std::find_if(mirrors.begin(), mirrors.end(), [&](const Mirror& known) {
      return length(cross(known.facing, *normal)) < flat_rad;
    });
    if (same != mirrors.end())
      same->spread_rad = std::max(same->spread_rad, spread);
    else if (mirrors.size() < most_mirrors)
      mirrors.push_back({*normal, spread});
  }
  for (std::size_t d = 0; d < data.discs.size(); ++d) {
    const DiscView& disc = data.discs[d];
    const float* radiance = data.disc_radiance.data() + d * bands;
    const double brightest = static_cast<double>(*std::max_element(radiance, radiance + bands));
    const double radius_rad = 2 * std::asin(0.5 * std::sqrt(static_cast<double>(disc.chord_2)));
    for (const Mirror& mirror : mirrors) {
      const Vec3d from = to_double(disc.direction);
      const Vec3d image = from - mirror.facing * (2 * dot(from, mirror.facing));
      AimView aim;
      aim.centre = to_float(normalize(image));
      const double wide_rad = radius_rad + mirror.spread_rad;
      aim.chord_2 = static_cast<float>(4 * std::pow(std::sin(0.5 * wide_rad), 2));
      aim.brightest = static_cast<float>(brightest * solid_of(radius_rad) / solid_of(wide_rad));
      aims.push_back(aim);
    }
  }
}

// Vertices of each piece of a mesh that hangs together, where there are `most` at most; else of
// all.
std::vector<std::vector<std::uint32_t>> pieces_of(const Mesh& mesh, std::size_t most) {
  const std::size_t vertices = mesh.positions.size();
  std::vector<std::uint32_t> all(vertices);
  std::iota(all.begin(), all.end(), 0u);
  if (mesh.triangles.size() > most_divided_triangles) return {all};
  // Union-find; what is at the same place hangs together.
  std::vector<std::uint32_t> parent = all;
  const auto root_of = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::map<std::array<float, 3>, std::uint32_t> first_at;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) {
      const Vec3& p = mesh.positions[v];
      const std::uint32_t same = first_at.try_emplace({p.x, p.y, p.z}, v).first->second;
      parent[root_of(v)] = root_of(same);
      parent[root_of(v)] = root_of(triangle[0]);
    }
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_root;
  std::vector<char> is_used(vertices, 0);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) is_used[v] = 1;
  for (const std::uint32_t v : all)
    if (is_used[v]) of_root[root_of(v)].push_back(v);
  if (of_root.size() > most) return {all};
  std::vector<std::vector<std::uint32_t>> pieces;
  for (auto& [root, of] : of_root) pieces.push_back(std::move(of));
  return pieces;
}

void add_shining(const LightData& data, const Scene& scene, const Placement& placement,
                 const SceneView& view, std::vector<AimView>& aims) {
  std::map<std::int32_t, std::vector<std::vector<std::uint32_t>>> pieces_of_mesh;
  for (const EmissiveView& emissive : data.emissive) {
    const auto [known, is_new] = pieces_of_mesh.try_emplace(emissive.mesh);
    if (is_new)
      known->second = pieces_of(scene.meshes[static_cast<std::size_t>(emissive.mesh)], most_aims);
    const Mat4& world_from_mesh =
        placement.world_from_mesh[static_cast<std::size_t>(emissive.instance)];
    const double scale = largest_scale(world_from_mesh);
    const std::int32_t material = view.meshes[emissive.mesh].material;
    const Vec3 factor = view.materials[material].emissive;
    const float* matrix = view.scatter[material].emission;
    float brightest = 0;
    for (std::int32_t b = 0; b < data.view.bands; ++b)
      brightest = std::max(brightest, matrix[3 * b] * factor.x + matrix[3 * b + 1] * factor.y +
                                          matrix[3 * b + 2] * factor.z);
    for (const std::vector<std::uint32_t>& piece : known->second) {
      const float* positions = view.meshes[emissive.mesh].positions;
      Vec3d middle{};
      for (const std::uint32_t v : piece) {
        const float* p = positions + 3 * static_cast<std::size_t>(v);
        middle = middle + Vec3d{p[0], p[1], p[2]} * (1.0 / static_cast<double>(piece.size()));
      }
      const Vec3d centre = transform_point(world_from_mesh, middle);
      double radius_m = 0;
      for (const std::uint32_t v : piece)
        radius_m = std::max(
            radius_m, length(place_of(view.meshes[emissive.mesh], world_from_mesh, v) - centre));
      AimView aim;
      aim.centre = to_float(middle);
      aim.radius_m = static_cast<float>(radius_m / scale);
      aim.instance = emissive.instance;
      aim.brightest = brightest;
      aims.push_back(aim);
    }
  }
}

}  // namespace

std::vector<AimView> make_aims(const LightData& data, const Scene& scene, const Placement& placement,
                               const SceneView& view) {
  std::vector<AimView> aims;
  add_mirror_images(data, scene, placement, view, aims);
  std::stable_sort(aims.begin(), aims.end(), [](const AimView& a, const AimView& b) {
    return a.brightest * a.chord_2 > b.brightest * b.chord_2;
  });
  if (aims.size() > most_mirror_images) aims.resize(most_mirror_images);
  const auto first_shining = static_cast<std::ptrdiff_t>(aims.size());
  add_shining(data, scene, placement, view, aims);
  const auto power = [&](const AimView& aim) {
    const double radius_m =
        static_cast<double>(aim.radius_m) *
        largest_scale(placement.world_from_mesh[static_cast<std::size_t>(aim.instance)]);
    return static_cast<double>(aim.brightest) * radius_m * radius_m;
  };
  std::stable_sort(aims.begin() + first_shining, aims.end(),
                   [&](const AimView& a, const AimView& b) { return power(a) > power(b); });
  if (aims.size() > most_aims) aims.resize(most_aims);
  return aims;
}

}  // namespace omma
