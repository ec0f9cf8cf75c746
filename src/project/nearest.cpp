// Which ommatidium lies nearest each of many directions, by its axis or by its position.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "omma/projection.h"
#include "project/sites.h"

namespace omma {
namespace {

std::vector<std::int32_t> nearest_site(const Sites& sites, std::span<const Vec3> directions) {
  std::vector<std::int32_t> ids(directions.size());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, directions.size(), 256),
      [&](const tbb::blocked_range<std::size_t>& range) {
        std::int32_t guess = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const Vec3d direction = to_double(directions[i]);
          ids[i] = has_direction(direction) ? sites.nearest(normalize(direction), guess) : -1;
        }
      });
  return ids;
}

}  // namespace

std::vector<std::int32_t> nearest_by_axis(const Eye& eye, std::span<const Vec3> directions) {
  return nearest_site(sites_by_axis(eye, all_ommatidia(eye), Reach::everywhere), directions);
}

std::vector<std::int32_t> nearest_by_position(const Eye& eye, Vec3 centre,
                                              std::span<const Vec3> directions) {
  return nearest_site(sites_by_position(eye, to_double(centre)), directions);
}

}  // namespace omma
