// Which ommatidium lies nearest each of many directions, by its axis or by its position.
#include "omma/projection.h"
#include "project/sites.h"
#include "threads/parallel.h"

namespace omma {
namespace {

std::vector<std::int32_t> nearest_site(const Sites& sites, std::span<const Vec3> directions) {
  std::vector<std::int32_t> ids(directions.size());
  parallel_ranges(
      std::size_t{0}, directions.size(), std::size_t{256}, [&](std::size_t begin, std::size_t end) {
        std::int32_t guess = 0;
        for (std::size_t i = begin; i < end; ++i) {
          check_cancelled();
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
