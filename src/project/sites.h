// What the projections share: ommatidia as points of which the nearest is sought, the eyes of a
// head, and the loop over the pixels of an id map.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/nearest_axis.h"
#include "omma/eye.h"
#include "threads/parallel.h"

namespace omma {

// Ommatidia as points, most often on the unit sphere, for AxisTree.
struct Sites {
  AxisTree tree;
  std::vector<std::int32_t> member;   // [site], index into the eye, ascending
  std::vector<double> limit_squared;  // [site], largest squared distance; empty: none
  std::vector<Vec3d> points;          // [site]

  // Index into the eye of the site nearest to a point, ties to the lower one; -1 beyond its limit
  // or where there are no sites. `guess` is the site of the pixel before; it only saves time.
  std::int32_t nearest(Vec3d point, std::int32_t& guess) const;
};

// Neither zero nor infinite nor NaN; the square of any other float is in the range of double.
bool has_direction(Vec3d vector);

// Points that have a direction, on the unit sphere; those that are zero or not finite are left out.
Sites sites_by_direction(const std::vector<Vec3d>& directions,
                         const std::vector<std::int32_t>& members);

// The axes of these ommatidia. Within the field only: a limit for each, its interommatidial angle
// or its acceptance angle, whichever is larger, so that the field ends about one facet beyond the
// last axis.
enum class Reach { everywhere, field_only };
Sites sites_by_axis(const Eye& eye, const std::vector<std::int32_t>& members, Reach reach);

// The positions of all ommatidia as seen from a centre.
Sites sites_by_position(const Eye& eye, Vec3d centre);

// Mean distance of each point to its `count` (at most 6) nearest others. [site]; 0 for a single
// one.
std::vector<double> spacing(const AxisTree& tree, const std::vector<Vec3d>& points, int count);

// The ommatidia of each eye of a head, the eye that looks farthest to the left first. Eyes are told
// apart by eye_id. A file has no eye numbers, so that an animal read from one file is a single one:
// where its positions leave a gap of more than four facet spacings around the plane x = 0, its two
// sides are two eyes.
std::vector<std::vector<std::int32_t>> eyes_of_head(const Eye& eye);

std::vector<std::int32_t> all_ommatidia(const Eye& eye);

// Throws omma::Error where the eye is empty or the picture is none or far too large.
void check_picture(const std::string& projection, const Eye& eye, int width, int height);

// An id map [height][width] from id_at(column, row, guess); rows are done in parallel.
template <typename IdAt>
std::vector<std::int32_t> fill_ids(int width, int height, const IdAt& id_at) {
  std::vector<std::int32_t> ids(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  parallel_ranges(0, height, 1, [&](int begin, int end) {
    std::int32_t guess = 0;
    for (int row = begin; row < end; ++row)
      for (int column = 0; column < width; ++column) {
        check_cancelled();
        ids[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(column)] = id_at(column, row, guess);
      }
  });
  return ids;
}

// A right-handed set of directions: `ahead` is looked along, `right` and `up` are those of the
// picture. Up is the head's; straight up or down is seen as by a head tilted there.
struct Vec2d {
  double x = 0, y = 0;
};
struct View {
  Vec3d ahead, right, up;
};
View view_along(Vec3d ahead);

// The direction at (x, y) of a Lambert azimuthal equal-area picture around `view.ahead`; the whole
// sphere is the disc of radius 2 (Snyder 1987, Map Projections, USGS PP 1395, section 24).
Vec3d lambert_direction(const View& view, double x, double y);
Vec2d lambert_point(const View& view, Vec3d unit);

// The functions of each kind, called by projection_ids once the size is checked.
std::vector<std::int32_t> split_ids(const Eye& eye, int width, int height);
std::vector<std::int32_t> mollweide_ids(const Eye& eye, int width, int height);
std::vector<std::int32_t> lambert_ids(const Eye& eye, int width, int height);
std::vector<std::int32_t> hemisphere_ids(const Eye& eye, int width, int height);
std::vector<std::int32_t> cylindrical_ids(const Eye& eye, int width, int height);
std::vector<std::int32_t> facet_ids(const Eye& eye, int width, int height);

}  // namespace omma
