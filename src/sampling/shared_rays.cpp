// Builds the lattice and the weights. Densities come in steps of two, so that one lattice serves
// each: where ommatidia ask for 2^k rays per steradian, to the nearest k, the points of the lattice
// of that density are rays. What each ommatidium would draw itself is then weighed by the density
// of all: the balance heuristic (Veach and Guibas 1995, SIGGRAPH, 419-428).
#include "sampling/shared_rays.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kernel/hash.h"
#include "model/curve_order.h"
#include "model/nearest_axis.h"
#include "omma/pose.h"
#include "sampling/sharing_groups.h"
#include "sampling/sphere_cells.h"
#include "sampling/sphere_lattice.h"

namespace omma {
namespace {

// Beyond this many standard deviations a Gaussian has 0.03 % of its weight; leaving it out raises
// the modulation transfer by 0.001 at most.
constexpr double reach_sigmas = 4;

// Intervals in a table of densities; between them they are within 2e-5.
constexpr int pdf_intervals = 512;

// Largest angle from the axis at which rays count. A lens's dark rings go on to the side: what is
// left out beyond a few widths would be percents. Those share nothing, and have rays of their own.
double reach_rad(const Acceptance& a) {
  switch (a.kernel) {
    case Kernel::gaussian:
    case Kernel::compoundray:
      return std::min(reach_sigmas * sigma_per_fwhm * a.width_rad, pi);
    case Kernel::pillbox:
      return std::min(0.5 * a.width_rad, pi);
    case Kernel::table:
      return a.table->right_rad.back();
    case Kernel::airy:
    case Kernel::lens_rhabdom:
      return 0;
  }
  return 0;
}

double chord(double angle_rad) {
  return 2 * std::sin(std::min(angle_rad, pi) / 2);
}

// Density of an ommatidium's own sampling per steradian, by the squared chord from its axis.
struct PdfTable {
  double reach_chord2 = -1;  // none count beyond
  float scale = 0;           // intervals per squared chord
  float acceptance_rad = 0;
  std::array<float, pdf_intervals + 2> pdf{};
};

PdfTable make_pdf_table(const AcceptanceWarp& warp, double reach_rad) {
  PdfTable table;
  table.reach_chord2 = chord(reach_rad) * chord(reach_rad);
  table.scale = static_cast<float>(pdf_intervals / table.reach_chord2);
  table.acceptance_rad = static_cast<float>(acceptance_width_rad(warp.acceptance, 0));
  for (int i = 0; i <= pdf_intervals; ++i) {
    // A hair inside, where a pillbox has not ended yet.
    const double chord2 = table.reach_chord2 * (1 - 1e-12) * i / pdf_intervals;
    table.pdf[static_cast<std::size_t>(i)] =
        static_cast<float>(acceptance_pdf(view(warp), angle_from_chord_squared(chord2), 0));
  }
  table.pdf[pdf_intervals + 1] = table.pdf[pdf_intervals];
  return table;
}

// For one warp: what weighs rays, and what decides how dense they are.
struct Densities {
  PdfTable weight, demand;
};

std::vector<Densities> make_densities(const std::vector<AcceptanceWarp>& warps) {
  std::vector<Densities> all(warps.size());
  oneapi::tbb::parallel_for(std::size_t{0}, warps.size(), [&](std::size_t w) {
    const AcceptanceWarp& warp = warps[w];
    const Acceptance& acceptance = warp.sensitivity.acceptance;
    const double reach = reach_rad(acceptance), width_rad = acceptance_width_rad(acceptance, 0);
    if (reach == 0) return;
    all[w].weight = make_pdf_table(warp, reach);
    all[w].demand = all[w].weight;
    if (acceptance.kernel != Kernel::pillbox) return;
    // Discs overlap in many small pieces, each of which would have a lattice of its own; the border
    // of one is where points are too many or too few. Gaussians with 0.6 of the radius for standard
    // deviation are as wide, and add up smoothly.
    const double sigma = 0.6 * 0.5 * width_rad;
    Acceptance smooth;
    smooth.width_rad = sigma / sigma_per_fwhm;
    all[w].demand = make_pdf_table(make_acceptance_warp(smooth), std::min(3 * sigma, pi));
    all[w].demand.acceptance_rad = all[w].weight.acceptance_rad;
  });
  return all;
}

float look_up(const PdfTable& table, double chord2) {
  const float x = static_cast<float>(chord2) * table.scale;
  const int i = std::min(static_cast<int>(x), pdf_intervals);
  const float before = table.pdf[static_cast<std::size_t>(i)];
  return before +
         (x - static_cast<float>(i)) * (table.pdf[static_cast<std::size_t>(i) + 1] - before);
}

// One group of ommatidia.
struct Group {
  std::vector<std::uint32_t> member;        // index in the eye
  std::vector<Vec3d> axes;                  // [member]
  std::vector<const Densities*> densities;  // [member]
  int samples = 0;
  double most_reach = 0;  // chord
};

struct LatticeRay {
  Vec3d direction;
  std::uint32_t start;   // member
  float acceptance_rad;  // the smallest of those it counts for
  double area_sr;        // that it stands for
};

// What the members ask for in a direction.
struct Demand {
  float density = 0;  // per steradian, what all together would sample it with
  std::uint32_t nearest = 0;
  float acceptance_rad = 0;  // the smallest
};

Demand find_demand(const Group& group, const SphereCells& cells, Vec3d direction) {
  Demand demand;
  double nearest = 8;
  float pdf = 0;
  cells.for_each_near(direction, [&](std::uint32_t k, double chord2) {
    if (chord2 < nearest || (chord2 == nearest && k < demand.nearest)) {
      nearest = chord2;
      demand.nearest = k;
    }
    const PdfTable& table = group.densities[k]->demand;
    if (chord2 > table.reach_chord2) return;
    pdf += look_up(table, chord2);
    if (demand.acceptance_rad == 0 || table.acceptance_rad < demand.acceptance_rad)
      demand.acceptance_rad = table.acceptance_rad;
  });
  demand.density = pdf * static_cast<float>(group.samples);
  return demand;
}

// Steps of density: that of step k is 2^k of the median asked for at the axes, so that eyes that
// are alike all over get what they ask for; 1 per steradian at least.
struct DensitySteps {
  double unit = 1;
  int lowest = 0, top = 0;

  double density(int step) const { return unit * std::exp2(step); }
  int of(float asked) const {
    const double step = std::log2(static_cast<double>(asked) / unit);
    return std::clamp(static_cast<int>(std::lround(step)), lowest, top);
  }
};

// More than at any axis may be asked for between axes, but nobody alone asks for more than there.
DensitySteps make_steps(std::vector<float> at_axes) {
  std::sort(at_axes.begin(), at_axes.end());
  const auto first = std::upper_bound(at_axes.begin(), at_axes.end(), 0.0f);
  DensitySteps steps;
  if (first == at_axes.end()) return steps;
  steps.unit = static_cast<double>(*(first + (at_axes.end() - first) / 2));
  steps.lowest = static_cast<int>(std::ceil(-std::log2(steps.unit)));
  steps.top = std::max(
      steps.lowest,
      static_cast<int>(std::lround(std::log2(static_cast<double>(at_axes.back()) / steps.unit))));
  return steps;
}

Mat4 random_rotation(std::uint64_t hash) {
  double q[4];
  for (std::uint64_t i = 0; i < 4; ++i)
    q[i] = normal_quantile(unit_interval(hash_combine(hash, i)));
  return pose_from_quaternion({0, 0, 0}, q[0], q[1], q[2], q[3]);
}

// The lattice points whose own density is the one asked for there.
std::vector<LatticeRay> make_lattice(const Group& group, std::uint64_t hash) {
  const SphereCells cells(group.axes, group.most_reach);
  const AxisTree tree(group.axes);
  std::vector<float> at_axes(group.axes.size());
  oneapi::tbb::parallel_for(std::size_t{0}, at_axes.size(), [&](std::size_t k) {
    at_axes[k] = find_demand(group, cells, group.axes[k]).density;
  });
  const DensitySteps steps = make_steps(std::move(at_axes));
  const double most_angle =
      angle_from_chord_squared(group.most_reach * group.most_reach) * (1 + 1e-9);
  const auto wanted = [&](Vec3d centre, double radius) {
    return radius >= pi || angle_from_chord_squared(tree.nearest(centre, 1).chord_squared[0]) <=
                               most_angle + radius;
  };
  std::vector<LatticeRay> rays;
  if (4 * pi * steps.density(steps.top) > most_lattice_points) return rays;
  for (int step = steps.top; step >= steps.lowest; --step) {
    SphereLattice lattice;
    lattice.points = static_cast<std::uint64_t>(std::ceil(4 * pi * steps.density(step)));
    lattice.turn = random_rotation(hash_combine(hash, static_cast<std::uint64_t>(step)));
    const std::vector<LatticePatch> patches = lattice_patches(lattice, wanted);
    std::vector<std::vector<LatticeRay>> found(patches.size());
    oneapi::tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t p) {
      for (const std::uint64_t i : points_of(patches[p])) {
        const Vec3d direction = lattice_point(lattice, i);
        const Demand demand = find_demand(group, cells, direction);
        if (demand.density > 0 && steps.of(demand.density) == step)
          found[p].push_back({direction, demand.nearest, demand.acceptance_rad,
                              4 * pi / static_cast<double>(lattice.points)});
      }
    });
    for (const std::vector<LatticeRay>& some : found)
      rays.insert(rays.end(), some.begin(), some.end());
  }
  return rays;
}

void add_ray(SharedRays& shared, const Eye& eye, std::uint32_t start, Vec3d direction,
             float acceptance_rad) {
  // The engine takes the focal offset back along the ray; it is to start behind the ommatidium.
  const Vec3d origin =
      to_double(eye.position_m[start]) +
      (direction - to_double(eye.axis[start])) * static_cast<double>(eye.focal_offset_m[start]);
  shared.rays.position_m.push_back(to_float(origin));
  shared.rays.axis.push_back(to_float(direction));
  shared.rays.acceptance_angle_rad.push_back(acceptance_rad);
  shared.rays.focal_offset_m.push_back(eye.focal_offset_m[start]);
  shared.rays.eye_id.push_back(eye.eye_id[start]);
}

struct Entry {
  std::int32_t ray;
  float weight;
};

// The lattice rays of a group in an order along a curve, so that what follows one another in memory
// does so in the packets too, and the weights they have in each member.
struct GroupRays {
  std::vector<std::uint32_t> member;
  std::vector<LatticeRay> lattice;
  std::vector<std::vector<Entry>> rows;  // [member], rays by their place in `lattice`
};

GroupRays make_group_rays(const Eye& eye, const DirectionTables& tables,
                          const std::vector<Densities>& densities,
                          std::vector<std::uint32_t> member, std::uint64_t hash) {
  Group group;
  group.samples = tables.samples;
  for (const std::uint32_t i : member) {
    const Densities& both = densities[tables.warp_of[i]];
    group.axes.push_back(normalize(to_double(eye.axis[i])));
    group.densities.push_back(&both);
    group.most_reach =
        std::max(group.most_reach, std::sqrt(std::max(0.0, both.demand.reach_chord2)));
  }
  GroupRays rays;
  rays.rows.resize(member.size());
  rays.member = std::move(member);
  if (rays.member.size() == 1) return rays;  // nobody to share with

  const std::vector<LatticeRay> lattice = make_lattice(group, hash);
  Eye along;
  for (const LatticeRay& ray : lattice) {
    along.axis.push_back(to_float(ray.direction));
    along.eye_id.push_back(0);
  }
  std::vector<Vec3d> directions;
  for (const std::uint32_t i : order_along_curve(along)) {
    rays.lattice.push_back(lattice[i]);
    directions.push_back(lattice[i].direction);
  }
  const SphereCells cells(directions, group.most_reach);
  oneapi::tbb::parallel_for(std::size_t{0}, rays.rows.size(), [&](std::size_t k) {
    std::vector<Entry>& row = rays.rows[k];
    const PdfTable& table = group.densities[k]->weight;
    cells.for_each_near(group.axes[k], [&](std::uint32_t ray, double chord2) {
      if (chord2 > table.reach_chord2) return;
      const float weight = look_up(table, chord2) * static_cast<float>(rays.lattice[ray].area_sr);
      if (weight > 0) row.push_back({static_cast<std::int32_t>(ray), weight});
    });
    std::sort(row.begin(), row.end(), [](Entry a, Entry b) { return a.ray < b.ray; });
  });
  return rays;
}

// Rays of its own, for an ommatidium that the lattice leaves with too few.
void add_own_rays(SharedRays& shared, const Eye& eye, const DirectionTables& tables,
                  std::uint32_t i, std::uint64_t hash, std::vector<Entry>& row) {
  const Vec3d axis = to_double(eye.axis[i]);
  const Vec3d side =
      normalize(cross(std::fabs(axis.y) < 0.7 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}, axis));
  const Vec3d other = cross(axis, side);
  const float acceptance_rad = eye.acceptance_angle_rad[i];
  row.clear();
  // Along the axis all are the same.
  const int count = acceptance_rad == 0 ? 1 : tables.samples;
  for (int k = 0; k < count; ++k) {
    float x = 0, y = 0, z = 0;
    make_direction(tables, static_cast<int>(tables.warp_of[i]),
                   static_cast<std::uint32_t>(hash_combine(hash, i)), k, x, y, z);
    row.push_back({static_cast<std::int32_t>(shared.rays.size()), 1.0f});
    add_ray(shared, eye, i,
            side * static_cast<double>(x) + other * static_cast<double>(y) +
                axis * static_cast<double>(z),
            acceptance_rad);
  }
}

// Adds the lattice rays that somebody uses, and lets the rows count them from the first of all.
void add_lattice_rays(SharedRays& shared, const Eye& eye, int samples, GroupRays& group) {
  std::vector<char> used(group.lattice.size(), 0);
  for (std::vector<Entry>& row : group.rows) {
    if (row.size() < static_cast<std::size_t>(samples)) row.clear();
    for (const Entry& entry : row) used[static_cast<std::size_t>(entry.ray)] = 1;
  }
  std::vector<std::int32_t> index(group.lattice.size());
  for (std::size_t r = 0; r < group.lattice.size(); ++r) {
    index[r] = static_cast<std::int32_t>(shared.rays.size());
    const LatticeRay& ray = group.lattice[r];
    if (used[r] != 0)
      add_ray(shared, eye, group.member[ray.start], ray.direction, ray.acceptance_rad);
  }
  for (std::vector<Entry>& row : group.rows)
    for (Entry& entry : row) entry.ray = index[static_cast<std::size_t>(entry.ray)];
}

}  // namespace

SharedRays make_shared_rays(const Eye& eye, const DirectionTables& tables, int pattern) {
  SharedRays shared;
  std::vector<std::vector<Entry>> rows(eye.size());
  const std::uint64_t hash =
      hash_combine(mix_bits(tables.seed ^ 0x73686172ull), static_cast<std::uint64_t>(pattern));
  const std::vector<Densities> densities = make_densities(tables.warps);
  for (std::vector<std::uint32_t>& member : sharing_groups(eye)) {
    const std::uint64_t group_hash = hash_combine(hash, member.front());
    GroupRays group = make_group_rays(eye, tables, densities, std::move(member), group_hash);
    add_lattice_rays(shared, eye, tables.samples, group);
    for (std::size_t k = 0; k < group.rows.size(); ++k)
      rows[group.member[k]] = std::move(group.rows[k]);
  }

  shared.first.push_back(0);
  for (std::uint32_t i = 0; i < eye.size(); ++i) {
    std::vector<Entry>& row = rows[i];
    if (row.empty()) add_own_rays(shared, eye, tables, i, hash, row);
    double sum = 0;
    for (const Entry& entry : row) sum += static_cast<double>(entry.weight);
    for (const Entry& entry : row) {
      shared.ray.push_back(entry.ray);
      shared.weight.push_back(static_cast<float>(static_cast<double>(entry.weight) / sum));
    }
    while (shared.ray.size() % weight_group != 0) {
      shared.ray.push_back(row.front().ray);
      shared.weight.push_back(0);
    }
    shared.first.push_back(static_cast<std::int64_t>(shared.ray.size()));
    row = {};
  }
  validate_eye(shared.rays);  // which fills what such rays have no use for
  return shared;
}

DirectionTables make_ray_tables(const Eye& rays, const RenderSettings& settings) {
  RenderSettings without_points = settings;
  without_points.sampling = Sampling::random;
  DirectionTables tables = make_direction_tables(rays, without_points);
  tables.samples = 1;
  tables.patterns = 1;
  tables.sampling = Sampling::low_discrepancy;
  tables.polar = {};
  for (std::size_t i = 0; i < tables.warps.size(); ++i)
    tables.local.insert(tables.local.end(), {0.0f, 0.0f, 1.0f});
  return tables;
}

}  // namespace omma
