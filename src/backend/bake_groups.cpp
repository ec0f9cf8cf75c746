// Groups of cells by a hash of where they lie; what they share is linear algebra of a few numbers.
#include "backend/bake_groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "backend/bake_within.h"
#include "physics/path/baked.h"
#include "physics/sampling/hash.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Cubes are at least so many cells wide, and less than twice as many; regions eight cubes.
constexpr double least_width = 3;
constexpr int region_bits = 3;
// From fewer cells it is not told how light varies among them.
constexpr std::int64_t least_members = 10;
// Of a plane through the light of a group, and the least spread of cells that it may lean by, over the
// largest.
constexpr double parameters = 4, least_spread = 1e-3;
// Weight of variation against noise in shrinking residuals. Residuals go with visibility: in grass
// what is bright is open. An ommatidium averages over many cells, so that bias costs it more than
// noise.
constexpr double weight_of_light = 16;
// A prior for variances of small groups: the median over all groups, with the weight of so many
// cells.
constexpr double cells_of_median = 4;

// Cells that are better than this, as a fraction of their light, get no more paths.
constexpr double fine_error = 0.02;
constexpr int least_paths = 4, most_paths = 4096;  // of a half, after the first pass

struct Key {
  std::uint64_t group, region;
  std::int32_t side;
  Vec3 middle;
  bool operator<(const Key& other) const {
    return group != other.group ? group < other.group : side < other.side;
  }
};

// The side of the cube that a direction points to most.
std::uint64_t facing(Vec3d normal) {
  const double size[3] = {std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)};
  const double along[3] = {normal.x, normal.y, normal.z};
  const auto a = static_cast<std::size_t>(std::max_element(size, size + 3) - size);
  return 2 * a + (along[a] < 0 ? 1 : 0);
}

Key key_of(const CellShape& shape, std::int32_t side) {
  Key key{0, 0, side, to_float(shape.middle)};
  if (!(shape.edge_m > 0) || !std::isfinite(shape.edge_m)) return key;
  const int level = static_cast<int>(std::ceil(std::log2(least_width * shape.edge_m)));
  const double width = std::ldexp(1.0, level);
  key.group = key.region = mix_bits(static_cast<std::uint64_t>(level + 4096));
  for (const double x : {shape.middle.x, shape.middle.y, shape.middle.z}) {
    const auto cube = static_cast<std::int64_t>(std::floor(std::clamp(x / width, -1e15, 1e15)));
    key.group = hash_combine(key.group, static_cast<std::uint64_t>(cube));
    key.region = hash_combine(key.region, static_cast<std::uint64_t>(cube >> region_bits));
  }
  key.group = hash_combine(key.group, facing(side % 2 == 0 ? shape.normal : shape.normal * -1.0));
  return key;
}

double decoded(const BakedLine* lines, std::int64_t side, int bands, int b) {
  return static_cast<double>(decode_baked(lines->values[side * bands + b]));
}

// The cells of a group, and how planes are laid through what they have: light = mean + slope * at.
class GroupPlanes {
 public:
  GroupPlanes(const BakeGroups& groups, std::size_t g)
      : sides_(groups.side.data() + groups.first[g]),
        at_(groups.middle.data() + groups.first[g], static_cast<std::size_t>(groups.members(g))) {
    for (const Vec3& at : at_) center_ = center_ + to_double(at) * (1.0 / many());
    if (count() < least_members) return;
    double c[3][3] = {};
    for (std::int64_t m = 0; m < count(); ++m) {
      const Vec3d d = offset(m);
      const double x[3] = {d.x, d.y, d.z};
      for (int r = 0; r < 3; ++r)
        for (int q = 0; q < 3; ++q) c[r][q] += x[r] * x[q] / many();
    }
    const double ridge = least_spread * (c[0][0] + c[1][1] + c[2][2]);
    if (!(ridge > 0)) return;
    for (int r = 0; r < 3; ++r) c[r][r] += ridge;
    invert(c);
  }
  std::int64_t count() const { return static_cast<std::int64_t>(at_.size()); }
  double many() const { return static_cast<double>(at_.size()); }
  std::int64_t side(std::int64_t m) const { return sides_[m]; }
  double free() const { return has_slope_ ? many() - parameters : many() - 1; }

  // Into `fitted` [member], of `light` [member]; returns the mean.
  double fit(const std::vector<double>& light, std::vector<double>& fitted) const {
    double mean = 0;
    for (const double x : light) mean += x / many();
    fitted.assign(light.size(), mean);
    if (!has_slope_) return mean;
    Vec3d moment{0, 0, 0};
    for (std::int64_t m = 0; m < count(); ++m)
      moment = moment + offset(m) * ((light[static_cast<std::size_t>(m)] - mean) / many());
    const double x[3] = {moment.x, moment.y, moment.z};
    double slope[3];
    for (int r = 0; r < 3; ++r)
      slope[r] = inverse_[r][0] * x[0] + inverse_[r][1] * x[1] + inverse_[r][2] * x[2];
    for (std::int64_t m = 0; m < count(); ++m) {
      const Vec3d d = offset(m);
      double& to = fitted[static_cast<std::size_t>(m)];
      to = std::max(0.0, to + slope[0] * d.x + slope[1] * d.y + slope[2] * d.z);
    }
    return mean;
  }

 private:
  Vec3d offset(std::int64_t m) const {
    return to_double(at_[static_cast<std::size_t>(m)]) - center_;
  }
  void invert(const double (&c)[3][3]) {
    const Vec3d a{c[0][0], c[0][1], c[0][2]}, b{c[1][0], c[1][1], c[1][2]},
        d{c[2][0], c[2][1], c[2][2]};
    const Vec3d rows[3] = {cross(b, d), cross(d, a), cross(a, b)};
    const double determinant = dot(a, rows[0]);
    if (!(determinant > 0)) return;
    for (int q = 0; q < 3; ++q) {
      inverse_[0][q] = rows[q].x / determinant;
      inverse_[1][q] = rows[q].y / determinant;
      inverse_[2][q] = rows[q].z / determinant;
    }
    has_slope_ = true;
  }

  const std::int32_t* sides_;
  std::span<const Vec3> at_;
  Vec3d center_{0, 0, 0};
  double inverse_[3][3] = {};
  bool has_slope_ = false;
};

GroupNoise noise_of(const BakeGroups& groups, std::size_t g, int bands,
                    const BakedLine* const (&half)[2]) {
  const GroupPlanes planes(groups, g);
  const auto count = static_cast<std::size_t>(planes.count());
  GroupNoise noise;
  std::vector<double> light[2] = {std::vector<double>(count), std::vector<double>(count)}, fitted[2];
  int lit = 0;
  for (int b = 0; b < bands; ++b) {
    double mean[2];
    for (std::size_t h = 0; h < 2; ++h) {
      for (std::size_t m = 0; m < count; ++m)
        light[h][m] = decoded(half[h], planes.side(static_cast<std::int64_t>(m)), bands, b);
      mean[h] = planes.fit(light[h], fitted[h]);
    }
    const double both = (mean[0] + mean[1]) / 2;
    if (!(both > 0)) continue;
    double products = 0, differences = 0;
    for (std::size_t m = 0; m < count; ++m) {
      const double x = light[0][m] - fitted[0][m], y = light[1][m] - fitted[1][m];
      products += x * y;
      differences += (x - y) * (x - y);
    }
    const double over = 1 / (both * both), half_apart = (mean[0] - mean[1]) / 2;
    noise.apart += half_apart * half_apart * over;
    if (count > 1) {
      noise.own += differences / (4 * planes.free()) * over;
      noise.varies += products / planes.free() * over;
    } else {
      noise.own += half_apart * half_apart * over;
    }
    ++lit;
  }
  if (lit == 0) return noise;
  noise.is_lit = true;
  noise.own /= lit;
  noise.varies = std::max(0.0, noise.varies / lit);
  noise.apart /= lit;
  return noise;
}

double share_of(double varies, double noise) {
  return varies + noise > 0 ? varies / (varies + noise) : 1.0;
}

// Shrinkage factor of a cell's residual (empirical Bayes: C. Morris, Parametric empirical Bayes
// inference, JASA 78, 1983).
double kept_share(const GroupNoise& noise, std::int64_t members) {
  return members < least_members ? 1.0 : share_of(weight_of_light * noise.varies, noise.own);
}

// The variance that is left of a cell's noise after shrinking: its own, and what its group has in
// common.
struct LeftNoise {
  double own, shared;
};

LeftNoise left_of(const GroupNoise& noise, double own, std::int64_t members) {
  const double kept = kept_share(noise, members), off = 1 - kept;
  const double of_plane = members < least_members ? 1 : parameters;
  return {kept * kept * own + off * off * noise.varies,
          (1 - kept * kept) * own * of_plane / static_cast<double>(members)};
}

double median_own(const std::vector<GroupNoise>& noise) {
  std::vector<double> own;
  for (const GroupNoise& one : noise)
    if (one.is_lit) own.push_back(one.own);
  if (own.empty()) return 0;
  const auto middle = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
  std::nth_element(own.begin(), middle, own.end());
  return *middle;
}

// [region], the variance that cells of a group have in common: that between the means of the
// halves, less the part that independent noise explains. Cells whose paths end on the same bright
// cell have correlated errors.
std::vector<double> find_common(const BakeGroups& groups, const std::vector<GroupNoise>& noise) {
  struct Sum {
    double apart = 0, own = 0;
    int groups = 0;
  };
  std::vector<Sum> sums(static_cast<std::size_t>(groups.regions));
  for (std::size_t g = 0; g < groups.count(); ++g) {
    if (!noise[g].is_lit) continue;
    Sum& sum = sums[static_cast<std::size_t>(groups.region[g])];
    sum.apart += noise[g].apart;
    sum.own += noise[g].own / static_cast<double>(groups.members(g));
    ++sum.groups;
  }
  std::vector<double> common;
  for (const Sum& sum : sums)
    common.push_back(sum.groups > 0 ? std::max(0.0, sum.apart - sum.own) / sum.groups : 0.0);
  return common;
}

std::uint8_t encode_error(double square) {
  return static_cast<std::uint8_t>(
      std::min(255.0, std::ceil(128 * std::sqrt(std::sqrt(std::max(0.0, square))))));
}

}  // namespace

BakeGroups group_cells(const BakedLight& plan, const CellOwners& owners, const SceneView& view,
                       const Scene& scene, const Placement& placement) {
  std::vector<std::array<Key, 2>> keys(static_cast<std::size_t>(plan.cells));
  parallel_ranges<std::int32_t>(0, plan.cells, 1024, [&](std::int32_t from, std::int32_t to) {
    for (std::int32_t cell = from; cell < to; ++cell) {
      const CellOwner owner = owners(cell);
      const CellShape shape = shape_of(scene, placement, owner);
      const BakedSides sides = baked_sides(view, scene.instances[owner.instance].mesh);
      auto& of_cell = keys[static_cast<std::size_t>(cell)];
      of_cell[0] = key_of(shape, sides.front ? 2 * cell : -1);
      of_cell[1] = key_of(shape, sides.back ? 2 * cell + 1 : -1);
    }
  });
  std::vector<Key> sorted;
  sorted.reserve(2 * keys.size());
  for (const auto& of_cell : keys)
    for (const Key& key : of_cell)
      if (key.side >= 0) sorted.push_back(key);
  keys = {};
  std::sort(sorted.begin(), sorted.end());
  BakeGroups groups;
  std::vector<std::uint64_t> regions;
  for (const Key& key : sorted) {
    const auto at = static_cast<std::int64_t>(groups.side.size());
    if (at == 0 || sorted[static_cast<std::size_t>(at) - 1].group != key.group) {
      groups.first.push_back(at);
      groups.signs.push_back(static_cast<std::uint16_t>(mix_bits(key.group) >> 48));
      regions.push_back(key.region);
    }
    groups.side.push_back(key.side);
    groups.middle.push_back(key.middle);
  }
  groups.first.push_back(static_cast<std::int64_t>(groups.side.size()));
  std::vector<std::uint64_t> known = regions;
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  groups.regions = static_cast<std::int32_t>(known.size());
  for (const std::uint64_t region : regions)
    groups.region.push_back(static_cast<std::int32_t>(
        std::lower_bound(known.begin(), known.end(), region) - known.begin()));
  return groups;
}

std::vector<GroupNoise> find_noise(const BakeGroups& groups, int bands,
                                   const BakedLine* const (&half)[2]) {
  std::vector<GroupNoise> noise(groups.count());
  parallel_ranges<std::size_t>(0, groups.count(), 256, [&](std::size_t from, std::size_t to) {
    for (std::size_t g = from; g < to; ++g) noise[g] = noise_of(groups, g, bands, half);
  });
  return noise;
}

void share_mean(const BakeGroups& groups, const std::vector<GroupNoise>& noise,
                const BakedLine* const (&half)[2], BakedLight& baked) {
  const int bands = baked.bands;
  const double median = median_own(noise);
  const std::vector<float> within = find_within(groups, bands, half);
  const std::vector<double> common = find_common(groups, noise);
  baked.errors.assign(2 * static_cast<std::size_t>(baked.cells), CellError{});
  std::fill(baked.lines.begin(), baked.lines.end(), BakedLine{});
  auto* const values = baked.lines.empty() ? nullptr : baked.lines.front().values;
  parallel_ranges<std::size_t>(0, groups.count(), 256, [&](std::size_t from, std::size_t to) {
    for (std::size_t g = from; g < to; ++g) {
      const std::int64_t members = groups.members(g);
      const auto many = static_cast<double>(members);
      const double kept = kept_share(noise[g], members);
      const double own = (many * noise[g].own + cells_of_median * median) / (many + cells_of_median);
      CellError error;
      const LeftNoise left = left_of(noise[g], own, members);
      error.shared = encode_error(left.shared + common[static_cast<std::size_t>(groups.region[g])]);
      error.signs = groups.signs[g];
      const GroupPlanes planes(groups, g);
      std::vector<double> light(static_cast<std::size_t>(members)), fitted;
      for (int b = 0; b < bands; ++b) {
        for (std::size_t m = 0; m < light.size(); ++m) {
          const std::int64_t side = planes.side(static_cast<std::int64_t>(m));
          light[m] = (decoded(half[0], side, bands, b) + decoded(half[1], side, bands, b)) / 2;
        }
        planes.fit(light, fitted);
        for (std::size_t m = 0; m < light.size(); ++m)
          values[planes.side(static_cast<std::int64_t>(m)) * bands + b] = encode_baked(
              static_cast<float>(fitted[m] + kept * (light[m] - fitted[m])));
      }
      for (std::int64_t m = groups.first[g]; m < groups.first[g + 1]; ++m) {
        const auto at = static_cast<std::size_t>(m);
        error.own = encode_error(left.own + static_cast<double>(within[at]));
        baked.errors[static_cast<std::size_t>(groups.side[at])] = error;
      }
    }
  });
  // Of sides that are lit.
  std::vector<double> all;
  for (std::size_t g = 0; g < groups.count(); ++g)
    for (std::int64_t m = groups.first[g]; noise[g].is_lit && m < groups.first[g + 1]; ++m) {
      const CellError& error =
          baked.errors[static_cast<std::size_t>(groups.side[static_cast<std::size_t>(m)])];
      all.push_back(std::hypot(static_cast<double>(decode_error(error.own)),
                               static_cast<double>(decode_error(error.shared))));
    }
  if (all.empty()) return;
  std::sort(all.begin(), all.end());
  baked.error_median = all[all.size() / 2];
  baked.error_95 = all[all.size() * 95 / 100];
}

std::vector<std::uint16_t> share_paths(const BakeGroups& groups,
                                       const std::vector<double>& variance_of_path, double most) {
  std::vector<std::uint16_t> of_group(groups.count());
  const auto choose = [&](double scale) {
    double all = 0;
    for (std::size_t g = 0; g < groups.count(); ++g) {
      const double wanted = std::min(scale * std::sqrt(variance_of_path[g]),
                                     variance_of_path[g] / (2 * fine_error * fine_error));
      const int chosen = static_cast<int>(std::clamp<double>(wanted, least_paths, most_paths));
      // Packets are full.
      of_group[g] = static_cast<std::uint16_t>(chosen < 16 ? chosen : chosen / 16 * 16);
      all += 2.0 * of_group[g] * static_cast<double>(groups.members(g));
    }
    return all;
  };
  double least = 0, largest = most_paths;
  for (int step = 0; step < 40; ++step) {
    const double middle = (least + largest) / 2;
    (choose(middle) <= most ? least : largest) = middle;
  }
  choose(least);
  return of_group;
}

}  // namespace omma
