// Builds the lattice and the weights. Densities come in steps of two, so that one lattice
// (Fibonacci points on the sphere: Swinbank and Purser 2006) serves each: where ommatidia ask for
// 2^k rays per steradian, to the nearest k, the points of the lattice of that density are rays.
#include "sampling/shared_rays.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernel/hash.h"
#include "model/curve_order.h"
#include "model/nearest_axis.h"
#include "omma/pose.h"

namespace omma {
namespace {

// Beyond this many standard deviations a Gaussian has 0.2 % of its weight.
constexpr double reach_sigmas = 3.5;

// Density step of directions that no ommatidium looks in.
constexpr int no_rays = -1000;

// Largest angle from the axis at which rays count.
double reach_rad(Kernel kernel, double acceptance_rad) {
  const double reach = kernel == Kernel::pillbox ? 0.5 * acceptance_rad
                                                 : reach_sigmas * sigma_per_fwhm * acceptance_rad;
  return std::min(reach, pi);
}

double chord(double angle_rad) {
  return 2 * std::sin(std::min(angle_rad, pi) / 2);
}

// Ommatidia that may share: those of one eye, and of one cluster of nodal points, as some files
// hold both eyes of a head under one number. Clusters lie further apart than several facets.
std::vector<std::vector<std::uint32_t>> sharing_groups(const Eye& eye) {
  const std::size_t n = eye.size();
  std::vector<Vec3d> positions(n);
  for (std::size_t i = 0; i < n; ++i) positions[i] = to_double(eye.position_m[i]);
  const AxisTree tree(positions);
  std::vector<NearestAxes> near(n);
  oneapi::tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    near[i] = tree.nearest(positions[i], NearestAxes::most);
  });
  std::vector<double> spacing(n);  // squared distance to the farthest of the near ones
  for (std::size_t i = 0; i < n; ++i)
    spacing[i] = near[i].chord_squared[static_cast<std::size_t>(near[i].count - 1)];
  std::vector<double> sorted = spacing;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2),
                   sorted.end());
  const double most = 9 * sorted[n / 2];

  std::vector<std::uint32_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::uint32_t i = 0; i < n; ++i)
    for (int k = 0; k < near[i].count; ++k) {
      const auto j = static_cast<std::uint32_t>(near[i].index[static_cast<std::size_t>(k)]);
      if (eye.eye_id[i] == eye.eye_id[j] &&
          near[i].chord_squared[static_cast<std::size_t>(k)] <= most)
        parent[std::max(root(i), root(j))] = std::min(root(i), root(j));
    }
  std::vector<std::vector<std::uint32_t>> groups;
  std::vector<std::int64_t> group_of(n, -1);
  for (std::uint32_t i = 0; i < n; ++i) {
    std::int64_t& group = group_of[root(i)];
    if (group < 0) {
      group = static_cast<std::int64_t>(groups.size());
      groups.emplace_back();
    }
    groups[static_cast<std::size_t>(group)].push_back(i);
  }
  return groups;
}

// One group of ommatidia.
struct Group {
  const DirectionTables* tables = nullptr;
  std::vector<std::uint32_t> member;  // index in the eye
  AxisTree tree{{}};                  // of the members' axes
  std::vector<double> reach_chord2;   // [member]
  double most_reach = 0;              // chord
};

Group make_group(const Eye& eye, const DirectionTables& tables, std::vector<std::uint32_t> member) {
  Group group;
  group.tables = &tables;
  std::vector<Vec3d> axes;
  for (const std::uint32_t i : member) {
    axes.push_back(to_double(eye.axis[i]));
    const AcceptanceWarp& warp = tables.warps[tables.warp_of[i]];
    const double reach = chord(reach_rad(warp.kernel, warp.acceptance_rad));
    group.reach_chord2.push_back(reach * reach);
    group.most_reach = std::max(group.most_reach, reach);
  }
  group.tree = AxisTree(std::move(axes));
  group.member = std::move(member);
  return group;
}

// Calls found(member, density) for each member that a ray in this direction is within reach of; the
// density is that of its own sampling, per steradian.
template <typename Found>
void for_each_in_reach(const Group& group, Vec3d direction, const Found& found) {
  group.tree.within(direction, group.most_reach, [&](std::uint32_t k, double chord2) {
    const AcceptanceWarp& warp = group.tables->warps[group.tables->warp_of[group.member[k]]];
    if (chord2 > group.reach_chord2[k] || warp.acceptance_rad == 0) return;
    found(k, acceptance_pdf(view(warp), angle_from_chord_squared(chord2)));
  });
}

// Step of the density that a direction is asked for: what all ommatidia would sample it with.
int density_step(const Group& group, Vec3d direction) {
  double demand = 0;
  for_each_in_reach(group, direction, [&](std::uint32_t, double pdf) { demand += pdf; });
  return demand > 0 ? static_cast<int>(std::lround(std::log2(group.tables->samples * demand)))
                    : no_rays;
}

struct LatticeRay {
  Vec3d direction;
  std::uint32_t start;  // ommatidium, index in the eye
  double area_sr;       // that it stands for
};

Mat4 random_rotation(std::uint64_t hash) {
  double q[4];
  for (std::uint64_t i = 0; i < 4; ++i)
    q[i] = normal_quantile(unit_interval(hash_combine(hash, i)));
  return pose_from_quaternion({0, 0, 0}, q[0], q[1], q[2], q[3]);
}

// The lattice points whose own density is the one asked for there.
std::vector<LatticeRay> make_lattice(const Group& group, std::uint64_t hash) {
  std::vector<LatticeRay> rays;
  std::vector<int> steps(group.member.size());
  oneapi::tbb::parallel_for(std::size_t{0}, steps.size(), [&](std::size_t k) {
    steps[k] = density_step(group, group.tree.axis(k));
  });
  const int top = *std::max_element(steps.begin(), steps.end());
  const double golden_angle = pi * (3 - std::sqrt(5.0));
  // Below one in 2^12 of the highest density there is nothing to see.
  for (int step = top; top != no_rays && step >= 0 && step > top - 12; --step) {
    const auto points = static_cast<std::size_t>(std::ceil(4 * pi * std::exp2(step)));
    const Mat4 turn = random_rotation(hash_combine(hash, static_cast<std::uint64_t>(step)));
    std::vector<std::uint32_t> start(points, UINT32_MAX);
    std::vector<Vec3d> direction(points);
    oneapi::tbb::parallel_for(std::size_t{0}, points, [&](std::size_t i) {
      const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(points);
      const double across = std::sqrt(1 - z * z), azimuth = golden_angle * static_cast<double>(i);
      direction[i] =
          transform_vector(turn, {across * std::cos(azimuth), across * std::sin(azimuth), z});
      double chord2 = 0;
      const auto k = static_cast<std::size_t>(group.tree.nearest(direction[i], 0, chord2));
      if (chord2 > group.most_reach * group.most_reach) return;
      if (density_step(group, direction[i]) == step) start[i] = group.member[k];
    });
    for (std::size_t i = 0; i < points; ++i)
      if (start[i] != UINT32_MAX)
        rays.push_back({direction[i], start[i], 4 * pi / static_cast<double>(points)});
  }
  return rays;
}

void add_ray(SharedRays& shared, const Eye& eye, std::uint32_t start, Vec3d direction) {
  // The engine takes the focal offset back along the ray; it is to start behind the ommatidium.
  const Vec3d origin =
      to_double(eye.position_m[start]) +
      (direction - to_double(eye.axis[start])) * static_cast<double>(eye.focal_offset_m[start]);
  shared.rays.position_m.push_back(to_float(origin));
  shared.rays.axis.push_back(to_float(direction));
  shared.rays.acceptance_angle_rad.push_back(eye.acceptance_angle_rad[start]);
  shared.rays.focal_offset_m.push_back(eye.focal_offset_m[start]);
  shared.rays.eye_id.push_back(eye.eye_id[start]);
}

struct Entry {
  std::int32_t ray;
  double weight;
};

// Rays of its own, for an ommatidium that the lattice leaves with too few.
void add_own_rays(SharedRays& shared, const Eye& eye, const DirectionTables& tables,
                  std::uint32_t i, std::uint64_t hash, std::vector<Entry>& row) {
  const Vec3d axis = to_double(eye.axis[i]);
  const Vec3d side =
      normalize(cross(std::fabs(axis.y) < 0.7 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}, axis));
  const Vec3d other = cross(axis, side);
  row.clear();
  for (int k = 0; k < tables.samples; ++k) {
    float x = 0, y = 0, z = 0;
    make_direction(tables, static_cast<int>(tables.warp_of[i]),
                   static_cast<std::uint32_t>(hash_combine(hash, i)), k, x, y, z);
    row.push_back({static_cast<std::int32_t>(shared.rays.size()), 1.0});
    add_ray(shared, eye, i,
            side * static_cast<double>(x) + other * static_cast<double>(y) +
                axis * static_cast<double>(z));
  }
}

}  // namespace

SharedRays make_shared_rays(const Eye& eye, const DirectionTables& tables, int pattern) {
  SharedRays shared;
  std::vector<std::vector<Entry>> rows(eye.size());
  const std::uint64_t hash =
      hash_combine(mix_bits(tables.seed ^ 0x73686172ull), static_cast<std::uint64_t>(pattern));
  for (std::vector<std::uint32_t>& member : sharing_groups(eye)) {
    const std::uint64_t group_hash = hash_combine(hash, member.front());
    const Group group = make_group(eye, tables, std::move(member));
    std::vector<LatticeRay> lattice = make_lattice(group, group_hash);

    // Along a curve, so that what follows one another in memory does so in the packets too.
    Eye along;
    for (const LatticeRay& ray : lattice) {
      along.axis.push_back(to_float(ray.direction));
      along.eye_id.push_back(0);
    }
    for (const std::uint32_t i : order_along_curve(along)) {
      const LatticeRay& ray = lattice[i];
      const auto index = static_cast<std::int32_t>(shared.rays.size());
      add_ray(shared, eye, ray.start, ray.direction);
      for_each_in_reach(group, ray.direction, [&](std::uint32_t k, double pdf) {
        if (pdf > 0) rows[group.member[k]].push_back({index, pdf * ray.area_sr});
      });
    }
  }

  shared.first.push_back(0);
  for (std::uint32_t i = 0; i < eye.size(); ++i) {
    std::vector<Entry>& row = rows[i];
    if (row.size() < static_cast<std::size_t>(tables.samples))
      add_own_rays(shared, eye, tables, i, hash, row);
    double sum = 0;
    for (const Entry& entry : row) sum += entry.weight;
    for (const Entry& entry : row) {
      shared.ray.push_back(entry.ray);
      shared.weight.push_back(static_cast<float>(entry.weight / sum));
    }
    while (shared.ray.size() % weight_group != 0) {
      shared.ray.push_back(row.front().ray);
      shared.weight.push_back(0);
    }
    shared.first.push_back(static_cast<std::int64_t>(shared.ray.size()));
  }
  return shared;
}

DirectionTables make_ray_tables(const Eye& rays, const RenderSettings& settings) {
  DirectionTables tables = make_direction_tables(rays, settings);
  tables.samples = 1;
  tables.patterns = 1;
  tables.sampling = Sampling::low_discrepancy;
  tables.local.clear();
  for (std::size_t i = 0; i < tables.warps.size(); ++i)
    tables.local.insert(tables.local.end(), {0.0f, 0.0f, 1.0f});
  return tables;
}

}  // namespace omma
