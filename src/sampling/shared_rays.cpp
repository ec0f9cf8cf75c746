// Builds the lattices and the weights. Where ommatidia together demand 2^k rays per steradian, to
// the nearest k, the rays are the points of a lattice of that density. An ommatidium weights a ray
// by its own density over that of all: the balance heuristic (Veach and Guibas 1995, SIGGRAPH,
// 419-428).
#include "sampling/shared_rays.h"

#include <algorithm>
#include <cmath>

#include "model/curve_order.h"
#include "model/nearest_axis.h"
#include "omma/error.h"
#include "omma/pose.h"
#include "physics/sampling/low_discrepancy.h"
#include "sampling/sharing_densities.h"
#include "sampling/sharing_groups.h"
#include "sampling/sphere_cells.h"
#include "sampling/sphere_lattice.h"
#include "threads/parallel.h"

namespace omma {
namespace {

double chord(double angle_rad) {
  return 2 * std::sin(std::min(angle_rad, pi) / 2);
}

// A direction at an angle from an axis; azimuths are from an arbitrary one.
Vec3d direction_about(Vec3d axis, Vec3d local) {
  const Vec3d side =
      normalize(cross(std::fabs(axis.y) < 0.7 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}, axis));
  return side * local.x + cross(axis, side) * local.y + axis * local.z;
}

// One class of a group of ommatidia.
struct Group {
  std::vector<std::uint32_t> member;               // index in the eye
  std::vector<Vec3d> axes;                         // [member]
  std::vector<std::uint32_t> warp;                 // [member]
  std::vector<const SharingDensities*> densities;  // [member]
  std::vector<char> shares;                        // [member], whether it is worth it
  int samples = 0;
  double most_reach = 0;  // chord
};

struct LatticeRay {
  Vec3d direction;
  std::uint32_t warp;  // the narrowest of those that ask for it
  std::uint32_t users;
  double area_sr;  // that it stands for
};

// The density of rays that the members demand in a direction.
struct Demand {
  float density = 0;  // per steradian, what all together would sample it with
  std::uint32_t warp = 0;
  std::uint32_t users = 0;  // members that would count such a ray
};

Demand find_demand(const Group& group, const SphereCells& cells, Vec3d direction) {
  Demand demand;
  double narrowest = 8;
  float pdf = 0;
  cells.for_each_near(direction, group.most_reach, [&](std::uint32_t k, double chord2) {
    const SharingDensities& member = *group.densities[k];
    if (group.shares[k] != 0 && chord2 <= member.weight.reach_chord2) ++demand.users;
    if (chord2 > member.demand.reach_chord2) return;
    pdf += member.demand.at(chord2);
    if (member.width_rad < narrowest) {
      narrowest = member.width_rad;
      demand.warp = group.warp[k];
    }
  });
  demand.density = pdf * static_cast<float>(group.samples);
  return demand;
}

// Effective samples of an ommatidium that shares, over its own: importance sampling of p by q has
// an efficiency of 1/E_p[p/q].
double sharing_gain(const Group& group, const SphereCells& cells, std::size_t k) {
  constexpr int angles = SharingDensities::polar_angles;
  const DensityTable& own = group.densities[k]->weight;
  double sum = 0;
  for (int i = 0; i < angles; ++i) {
    const double theta = group.densities[k]->polar_rad[static_cast<std::size_t>(i)];
    const double azimuth = 2.399963229728653 * i;  // the golden angle: as even as it gets
    const Vec3d direction =
        direction_about(group.axes[k], {std::sin(theta) * std::cos(azimuth),
                                        std::sin(theta) * std::sin(azimuth), std::cos(theta)});
    const double chord2 = chord(theta) * chord(theta);
    if (chord2 > own.reach_chord2) continue;
    const float density = find_demand(group, cells, direction).density;
    if (density > 0)
      sum += static_cast<double>(own.at(chord2) * static_cast<float>(group.samples) / density);
  }
  return angles / sum;
}

[[noreturn]] void refuse_weights(std::size_t ommatidia, double weights) {
  throw Error("sampling: Shared, but " + std::to_string(ommatidia) +
              " ommatidia whose fields overlap would count about " +
              std::to_string(static_cast<long long>(weights)) +
              " rays together, each for itself, more than " + std::to_string(most_shared_weights) +
              ": take fewer samples");
}

// Throws where there would be too many weights: about the number of pairs of an ommatidium and
// another in its field, times samples; estimated from some of the members.
void check_weights(const Group& group) {
  constexpr std::size_t some = 64;
  const std::size_t n = group.axes.size(), step = (n + some - 1) / some;
  double pairs = 0, looked_at = 0;
  for (std::size_t k = 0; k < n; k += step, ++looked_at)
    for (const Vec3d& axis : group.axes) {
      const Vec3d apart = axis - group.axes[k];
      if (dot(apart, apart) <= group.densities[k]->weight.reach_chord2) ++pairs;
    }
  const double weights = pairs / looked_at * static_cast<double>(n) * group.samples;
  if (weights > static_cast<double>(most_shared_weights)) refuse_weights(n, weights);
}

// Densities by powers of two: step k is 2^k times the median demand at the axes, so that eyes that
// are even get exactly what they demand; at least 1 per steradian.
struct DensitySteps {
  double unit = 1;
  int lowest = 0, top = 0;

  double density(int step) const { return unit * std::exp2(step); }
  int of(float asked) const {
    const double step = std::log2(static_cast<double>(asked) / unit);
    return std::clamp(static_cast<int>(std::lround(step)), lowest, top);
  }
};

// Demand may be larger between axes than at any, but no ommatidium alone demands more there.
DensitySteps make_steps(std::vector<float> at_axes) {
  std::sort(at_axes.begin(), at_axes.end());
  const auto first = std::upper_bound(at_axes.begin(), at_axes.end(), 0.0f);
  DensitySteps steps;
  if (first == at_axes.end()) return steps;
  steps.unit = static_cast<double>(*(first + (at_axes.end() - first) / 2));
  steps.lowest = static_cast<int>(std::ceil(-std::log2(steps.unit)));
  // No finer than a lattice can be, where many crowd together.
  const double top =
      std::min(std::round(std::log2(static_cast<double>(at_axes.back()) / steps.unit)),
               std::floor(std::log2(most_lattice_points / (4 * pi * steps.unit))));
  steps.top = std::max(steps.lowest, static_cast<int>(top));
  return steps;
}

Mat4 random_rotation(std::uint64_t hash) {
  double q[4];
  for (std::uint64_t i = 0; i < 4; ++i)
    q[i] = normal_quantile(unit_interval(hash_combine(hash, i)));
  return pose_from_quaternion({0, 0, 0}, q[0], q[1], q[2], q[3]);
}

// An upper bound of the demand anywhere within an angle of a direction.
float most_demand(const Group& group, const SphereCells& cells, Vec3d centre, double radius) {
  const double reach_rad = angle_from_chord_squared(group.most_reach * group.most_reach);
  float pdf = 0;
  cells.for_each_near(centre, chord(reach_rad + radius), [&](std::uint32_t k, double chord2) {
    const DensityTable& most = group.densities[k]->most;
    const double apart = angle_from_chord_squared(chord2) - radius;
    const double nearest2 = apart > 0 ? chord(apart) * chord(apart) : 0;
    if (nearest2 * (1 - 1e-9) <= most.reach_chord2)
      pdf += most.density[static_cast<std::size_t>(most.place(nearest2 * (1 - 1e-6)))];
  });
  return pdf * static_cast<float>(group.samples);
}

struct Lattice {
  std::vector<LatticeRay> rays;
  std::uint64_t tried = 0;  // directions that were looked at
};

// The points of each lattice at which its density is the one demanded, if any member uses them.
Lattice make_lattice(const Group& group, const SphereCells& cells, std::uint64_t hash) {
  std::vector<float> at_axes(group.axes.size());
  parallel_for(std::size_t{0}, at_axes.size(), [&](std::size_t k) {
    at_axes[k] = find_demand(group, cells, group.axes[k]).density;
  });
  const DensitySteps steps = make_steps(std::move(at_axes));
  Lattice found_rays;
  double weights = 0;
  for (int step = steps.top; step >= steps.lowest; --step) {
    SphereLattice lattice;
    lattice.points = static_cast<std::uint64_t>(std::ceil(4 * pi * steps.density(step)));
    lattice.turn = random_rotation(hash_combine(hash, static_cast<std::uint64_t>(step)));
    // A step covers demands from half a step below it, the lowest step all below. Large patches are
    // halved without asking.
    constexpr double large_rad = 0.25;
    const double least = step == steps.lowest ? 0 : 0.7 * steps.density(step);
    const std::vector<LatticePatch> patches =
        lattice_patches(lattice, [&](Vec3d centre, double radius) {
          return radius > large_rad ||
                 static_cast<double>(most_demand(group, cells, centre, radius)) > least;
        });
    std::vector<std::vector<LatticeRay>> found(patches.size());
    std::vector<std::uint64_t> tried(patches.size());
    parallel_for(std::size_t{0}, patches.size(), [&](std::size_t p) {
      const std::vector<std::uint64_t> points = points_of(patches[p]);
      tried[p] = points.size();
      for (const std::uint64_t i : points) {
        const Vec3d direction = lattice_point(lattice, i);
        const Demand demand = find_demand(group, cells, direction);
        if (demand.density > 0 && demand.users > 0 && steps.of(demand.density) == step)
          found[p].push_back(
              {direction, demand.warp, demand.users, 4 * pi / static_cast<double>(lattice.points)});
      }
    });
    for (std::size_t p = 0; p < patches.size(); ++p) {
      found_rays.tried += tried[p];
      for (const LatticeRay& ray : found[p]) weights += ray.users;
      found_rays.rays.insert(found_rays.rays.end(), found[p].begin(), found[p].end());
    }
    // An eighth more than foreseen: sets differ a little.
    if (weights > 1.125 * static_cast<double>(most_shared_weights))
      refuse_weights(group.axes.size(), weights);
  }
  return found_rays;
}

void add_ray(SharedRays& shared, const Eye& eye, std::uint32_t start, Vec3d direction,
             std::uint32_t warp) {
  // The engine takes the focal offset back along the ray; it is to start behind the ommatidium.
  const Vec3d origin =
      to_double(eye.position_m[start]) +
      (direction - to_double(eye.axis[start])) * static_cast<double>(eye.focal_offset_m[start]);
  shared.rays.position_m.push_back(to_float(origin));
  shared.rays.axis.push_back(to_float(direction));
  shared.rays.focal_offset_m.push_back(eye.focal_offset_m[start]);
  shared.rays.eye_id.push_back(eye.eye_id[start]);
  shared.warp.push_back(warp);
}

struct Entry {
  std::int32_t ray;
  float weight;
};

Group make_group(const Eye& eye, const DirectionTables& tables,
                 const std::vector<SharingDensities>& densities,
                 std::vector<std::uint32_t> member) {
  Group group;
  group.samples = tables.samples;
  for (const std::uint32_t i : member) {
    const std::uint32_t warp = tables.warp_of[i];
    group.axes.push_back(normalize(to_double(eye.axis[i])));
    group.warp.push_back(warp);
    group.densities.push_back(&densities[warp]);
    const double reach2 =
        std::max(densities[warp].demand.reach_chord2, densities[warp].weight.reach_chord2);
    group.most_reach = std::max(group.most_reach, std::sqrt(reach2));
  }
  group.shares.assign(member.size(), 1);
  group.member = std::move(member);
  return group;
}

// Adds the rays that the members of a class share, in an order along a curve, so that what follows
// one another in memory does so in the packets too, and their rows.
void add_shared_rays(SharedRays& shared, const Eye& eye, const AxisTree& all_axes,
                     const std::vector<std::uint32_t>& all_members, Group& group,
                     std::uint64_t hash, std::vector<std::vector<Entry>>& rows) {
  const std::size_t members = group.member.size();
  if (members == 1) return;  // nobody to share with
  check_weights(group);
  Lattice lattice;
  {
    const SphereCells cells(group.axes, group.most_reach);
    std::vector<char> shares(members);
    parallel_for(std::size_t{0}, members, [&](std::size_t k) {
      shares[k] = sharing_gain(group, cells, k) > least_sharing_gain;
    });
    if (std::find(shares.begin(), shares.end(), 1) == shares.end()) return;
    group.shares = std::move(shares);
    lattice = make_lattice(group, cells, hash);
  }
  shared.directions_tried += lattice.tried;
  Eye along;
  for (const LatticeRay& ray : lattice.rays) {
    along.axis.push_back(to_float(ray.direction));
    along.eye_id.push_back(0);
  }
  std::vector<Vec3d> directions;
  std::vector<double> area_sr;
  std::vector<std::uint32_t> start(lattice.rays.size());
  const std::vector<std::uint32_t> order = order_along_curve(along);
  for (const std::uint32_t i : order) {
    directions.push_back(lattice.rays[i].direction);
    area_sr.push_back(lattice.rays[i].area_sr);
  }
  parallel_for(std::size_t{0}, start.size(), [&](std::size_t r) {
    const NearestAxes nearest = all_axes.nearest(directions[r], 1);
    start[r] = all_members[static_cast<std::size_t>(nearest.index[0])];
  });
  const SphereCells cells(directions, group.most_reach);
  parallel_for(std::size_t{0}, members, [&](std::size_t k) {
    if (group.shares[k] == 0) return;
    std::vector<Entry>& row = rows[group.member[k]];
    const DensityTable& own = group.densities[k]->weight;
    cells.for_each_near(group.axes[k], std::sqrt(own.reach_chord2),
                        [&](std::uint32_t ray, double chord2) {
                          if (chord2 > own.reach_chord2) return;
                          const float weight = own.at(chord2) * static_cast<float>(area_sr[ray]);
                          if (weight > 0) row.push_back({static_cast<std::int32_t>(ray), weight});
                        });
    // Fewer rays than its own may be left where a lattice is as coarse as it gets.
    if (row.size() < static_cast<std::size_t>(group.samples)) row.clear();
    std::sort(row.begin(), row.end(), [](Entry a, Entry b) { return a.ray < b.ray; });
  });
  // Only rays that somebody uses are traced; the rows count them from the first of all.
  std::vector<std::int32_t> index(order.size(), -1);
  for (const std::uint32_t i : group.member)
    for (const Entry& entry : rows[i]) index[static_cast<std::size_t>(entry.ray)] = 0;
  for (std::size_t r = 0; r < order.size(); ++r) {
    if (index[r] < 0) continue;
    index[r] = static_cast<std::int32_t>(shared.rays.size());
    add_ray(shared, eye, start[r], directions[r], lattice.rays[order[r]].warp);
  }
  for (const std::uint32_t i : group.member)
    for (Entry& entry : rows[i]) entry.ray = index[static_cast<std::size_t>(entry.ray)];
}

// Rays of its own, those that it would have if it did not share.
void add_own_rays(SharedRays& shared, const Eye& eye, const DirectionTables& tables,
                  std::uint32_t i, int set, std::vector<Entry>& row) {
  const Vec3d axis = to_double(eye.axis[i]);
  const std::uint32_t warp = tables.warp_of[i];
  const std::uint64_t hash = hash_combine(mix_bits(tables.seed), i);
  // Another pattern for each set.
  const std::uint64_t scramble = hash + static_cast<std::uint64_t>(set);
  const auto n = static_cast<std::size_t>(tables.samples);
  const auto patterns = static_cast<std::uint64_t>(tables.patterns);
  const Vec2 turn = tables.turns[mix_bits(scramble) % turn_count];
  // Along the axis all are the same.
  const bool single = tables.warps[warp].rows == nullptr;
  for (std::size_t k = 0; k < (single ? 1 : n); ++k) {
    float x = 0, y = 0, z = 1;
    if (patterns > 0 && !single) {
      const float* local =
          tables.local.data() + (warp * patterns + scramble % patterns) * 3 * n + k;
      x = turn.x * local[0] - turn.y * local[n];
      y = turn.y * local[0] + turn.x * local[n];
      z = local[2 * n];
    } else if (!single) {
      const Vec3 d = low_discrepancy_direction(
          tables.warp_views[warp], static_cast<std::uint32_t>(mix_bits(scramble)),
          static_cast<int>(k));
      x = d.x, y = d.y, z = d.z;
    }
    row.push_back({static_cast<std::int32_t>(shared.rays.size()), 1.0f});
    add_ray(shared, eye, i, direction_about(axis, to_double(Vec3{x, y, z})), warp);
  }
}

}  // namespace

SharedRays make_shared_rays(const Eye& eye, const DirectionTables& tables, int set) {
  const double most_rays = static_cast<double>(eye.size()) * tables.samples;
  if (most_rays > static_cast<double>(most_shared_rays))
    throw Error("sampling: Shared expects at most " + std::to_string(most_shared_rays) +
                " rays, found " + std::to_string(static_cast<long long>(most_rays)) + " (" +
                std::to_string(eye.size()) + " ommatidia, " + std::to_string(tables.samples) +
                " samples): take fewer samples");
  SharedRays shared;
  std::vector<std::vector<Entry>> rows(eye.size());
  const std::uint64_t hash =
      hash_combine(mix_bits(tables.seed ^ 0x73686172ull), static_cast<std::uint64_t>(set));
  const std::vector<SharingDensities> densities =
      make_sharing_densities(tables.warps, tables.samples);
  std::vector<double> width(eye.size());
  for (std::size_t i = 0; i < eye.size(); ++i) width[i] = densities[tables.warp_of[i]].width_rad;
  for (const std::vector<std::uint32_t>& members : sharing_groups(eye)) {
    std::vector<Vec3d> axes;
    for (const std::uint32_t i : members) axes.push_back(normalize(to_double(eye.axis[i])));
    const AxisTree tree(std::move(axes));
    for (std::vector<std::uint32_t>& one : width_classes(members, width)) {
      const std::uint64_t class_hash = hash_combine(hash, one.front());
      Group group = make_group(eye, tables, densities, std::move(one));
      add_shared_rays(shared, eye, tree, members, group, class_hash, rows);
    }
  }

  std::size_t weights = 0;
  for (const std::vector<Entry>& row : rows) weights += row.size() + weight_group;
  shared.ray.reserve(weights);
  shared.weight.reserve(weights);
  shared.first.push_back(0);
  for (std::uint32_t i = 0; i < eye.size(); ++i) {
    check_cancelled();
    std::vector<Entry>& row = rows[i];
    shared.is_shared.push_back(row.empty() ? 0 : 1);
    if (row.empty()) add_own_rays(shared, eye, tables, i, set, row);
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

SharedWeights view(const SharedRays& shared) {
  return {shared.first.data(),
          shared.ray.data(),
          shared.weight.data(),
          static_cast<std::int64_t>(shared.is_shared.size()),
          static_cast<std::int64_t>(shared.weight.size()),
          static_cast<std::int64_t>(shared.rays.size()),
          shared.version};
}

DirectionTables make_ray_tables(const DirectionTables& of_eye, const SharedRays& shared) {
  DirectionTables tables;
  tables.samples = 1;
  tables.patterns = 1;
  tables.seed = of_eye.seed;
  tables.warp_of = shared.warp;
  tables.footprint_rad = of_eye.footprint_rad;
  tables.fixed_turn = of_eye.fixed_turn;
  tables.turns = of_eye.turns;
  for (std::size_t i = 0; i < of_eye.warps.size(); ++i)
    tables.local.insert(tables.local.end(), {0.0f, 0.0f, 1.0f});
  return tables;
}

}  // namespace omma
