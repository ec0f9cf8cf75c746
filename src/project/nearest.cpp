// Which ommatidium lies nearest each of many directions, by its axis or by its position.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <utility>

#include "model/nearest_axis.h"
#include "omma/projection.h"

namespace omma {
namespace {

// Neither zero nor infinite nor NaN; the square of any other float is in the range of double.
bool usable(Vec3d direction) {
  const double squared = dot(direction, direction);
  return squared > 0 && std::isfinite(squared);
}

// `sites` that point nowhere are never nearest.
std::vector<std::int32_t> nearest_site(const std::vector<Vec3d>& sites,
                                       std::span<const Vec3> directions) {
  std::vector<Vec3d> unit;
  std::vector<std::int32_t> member;  // in order, so that ties go to the lower index of the eye
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (!usable(sites[i])) continue;
    unit.push_back(normalize(sites[i]));
    member.push_back(static_cast<std::int32_t>(i));
  }
  std::vector<std::int32_t> ids(directions.size(), -1);
  if (unit.empty()) return ids;
  const AxisTree tree(std::move(unit));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, directions.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      std::int32_t nearest = 0;  // to the direction before, the likely neighbour
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const Vec3d direction = to_double(directions[i]);
                        if (!usable(direction)) continue;
                        double chord_squared = 0;
                        nearest = tree.nearest(normalize(direction), nearest, chord_squared);
                        ids[i] = member[static_cast<std::size_t>(nearest)];
                      }
                    });
  return ids;
}

}  // namespace

std::vector<std::int32_t> nearest_by_axis(const Eye& eye, std::span<const Vec3> directions) {
  std::vector<Vec3d> sites;
  sites.reserve(eye.size());
  for (const Vec3 axis : eye.axis) sites.push_back(to_double(axis));
  return nearest_site(sites, directions);
}

std::vector<std::int32_t> nearest_by_position(const Eye& eye, Vec3 centre,
                                              std::span<const Vec3> directions) {
  std::vector<Vec3d> sites;
  sites.reserve(eye.size());
  for (const Vec3 position : eye.position_m)
    sites.push_back(to_double(position) - to_double(centre));
  return nearest_site(sites, directions);
}

}  // namespace omma
