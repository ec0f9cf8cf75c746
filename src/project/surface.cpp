// Projections of the eye's own surface: cylindrical semi-orthogonal, and the facets themselves.
#include <algorithm>
#include <cmath>
#include <string>

#include "omma/error.h"
#include "project/sites.h"

namespace omma {
namespace {

// Radius of a facet at the rim, in mean distances to its four nearest neighbours. The corners of a
// regular hexagon lie at 0.577; more keeps those of stretched facets.
constexpr double facet_reach = 0.9;

[[noreturn]] void fail_flat(const Eye& eye, std::int32_t member) {
  const std::string number = std::to_string(eye.eye_id[static_cast<std::size_t>(member)]);
  throw Error("facets: the positions of eye " + number +
              (eye.path.empty() ? "" : " (" + eye.path + ")") +
              " lie in one point, line or plane; the facets are drawn on the surface that the "
              "positions span, which takes four that do not");
}

// The centre of the least-squares sphere through an eye's positions: of all spheres
// |p|^2 = 2 c.p + k the one with the least squared error in |p|^2, which takes a linear equation
// (Kasa 1976, IEEE Trans. Instrum. Meas. 25:8, for circles).
Vec3d sphere_centre(const Eye& eye, const std::vector<std::int32_t>& members) {
  const auto position = [&](std::int32_t i) {
    return to_double(eye.position_m[static_cast<std::size_t>(i)]);
  };
  const double weight = 1.0 / static_cast<double>(members.size());
  Vec3d middle;
  for (const std::int32_t i : members) middle = middle + position(i) * weight;
  Vec3d rows[3], right_side;
  double trace = 0;
  for (const std::int32_t i : members) {
    const Vec3d p = position(i) - middle;
    const double squared = dot(p, p);
    rows[0] = rows[0] + p * (p.x * weight);
    rows[1] = rows[1] + p * (p.y * weight);
    rows[2] = rows[2] + p * (p.z * weight);
    right_side = right_side + p * (squared * weight / 2);
    trace += squared * weight;
  }
  // The determinant is the product of the mean squared extents along three axes. Positions in
  // float32 that should lie in a plane leave 1e-14 of it.
  const double determinant = dot(rows[0], cross(rows[1], rows[2]));
  if (!(determinant > 1e-11 * trace * trace * trace)) fail_flat(eye, members.front());
  const Vec3d centre{dot(right_side, cross(rows[1], rows[2])),
                     dot(right_side, cross(rows[2], rows[0])),
                     dot(right_side, cross(rows[0], rows[1]))};
  return middle + centre * (1 / determinant);
}

// One eye's facets on the sphere, and the part of the plane that its picture shows.
struct Panel {
  Sites sites;
  View view;
  double radius_m = 0;  // of the sphere, for the scale
  Vec2d low, high;      // of the plane in which the sphere is the disc of radius 2
};

Panel make_panel(const Eye& eye, const std::vector<std::int32_t>& members) {
  const Vec3d centre = sphere_centre(eye, members);
  std::vector<Vec3d> seen;
  seen.reserve(members.size());
  double radius_m = 0;
  for (const std::int32_t i : members) {
    seen.push_back(to_double(eye.position_m[static_cast<std::size_t>(i)]) - centre);
    radius_m += length(seen.back()) / static_cast<double>(members.size());
  }
  Panel panel{sites_by_direction(seen, members), {}, radius_m, {2, 2}, {-2, -2}};
  const std::vector<Vec3d>& points = panel.sites.points;

  Vec3d mean;
  for (const Vec3d point : points) mean = mean + point * (1.0 / static_cast<double>(points.size()));
  // An eye all around has no side it lies on: it is seen straight ahead.
  panel.view = view_along(length(mean) > 0.1 ? normalize(mean) : Vec3d{0, 0, -1});

  const std::vector<double> apart = spacing(panel.sites.tree, points, 4);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double reach = facet_reach * apart[k];
    panel.sites.limit_squared.push_back(reach * reach);
    const Vec2d at = lambert_point(panel.view, points[k]);
    // Beyond 120 degrees from the middle facets may lie around the rim: all of it is shown.
    const bool around = dot(points[k], panel.view.ahead) < -0.5;
    panel.low = {std::min(panel.low.x, around ? -2 : std::max(-2.0, at.x - reach)),
                 std::min(panel.low.y, around ? -2 : std::max(-2.0, at.y - reach))};
    panel.high = {std::max(panel.high.x, around ? 2 : std::min(2.0, at.x + reach)),
                  std::max(panel.high.y, around ? 2 : std::min(2.0, at.y + reach))};
  }
  return panel;
}

}  // namespace

std::vector<std::int32_t> cylindrical_ids(const Eye& eye, int width, int height) {
  double low = eye.position_m[0].y, high = low;
  for (const Vec3 position : eye.position_m) {
    low = std::min(low, double{position.y});
    high = std::max(high, double{position.y});
  }
  if (!(high > low))
    throw Error("cylindrical: all positions of the eye" + (eye.path.empty() ? "" : " " + eye.path) +
                " are at the same height; the projection draws ommatidia by height");
  // A cylinder of radius 1 and height 2, so that a spherical eye keeps its areas.
  Sites sites{AxisTree({}), all_ommatidia(eye), {}, {}};
  for (std::size_t i = 0; i < eye.size(); ++i) {
    const Vec3d axis = to_double(eye.axis[i]);
    const double level = std::hypot(axis.x, axis.z);
    const double y = (eye.position_m[i].y - (low + high) / 2) / ((high - low) / 2);
    // Straight up and down have no azimuth and lie straight ahead.
    const bool vertical = level < 1e-6;
    sites.points.push_back(vertical ? Vec3d{0, y, -1} : Vec3d{axis.x / level, y, axis.z / level});
  }
  sites.tree = AxisTree(sites.points);
  // Twice the spacing: where the eye is not a sphere azimuth and height spread facets unevenly, and
  // less would leave holes between them.
  for (const double apart : spacing(sites.tree, sites.points, 6))
    sites.limit_squared.push_back(4 * apart * apart);
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) {
    const double azimuth = ((column + 0.5) / width - 0.5) * 2 * pi;
    const double y = 1 - 2 * (row + 0.5) / height;
    return sites.nearest({std::sin(azimuth), y, -std::cos(azimuth)}, guess);
  });
}

std::vector<std::int32_t> facet_ids(const Eye& eye, int width, int height) {
  std::vector<Panel> panels;
  for (const auto& members : eyes_of_head(eye)) panels.push_back(make_panel(eye, members));
  const double panel_width = static_cast<double>(width) / static_cast<double>(panels.size());
  double m_per_pixel = 0;  // the same for all eyes
  for (const Panel& panel : panels)
    m_per_pixel =
        std::max({m_per_pixel, panel.radius_m * (panel.high.x - panel.low.x) / panel_width,
                  panel.radius_m * (panel.high.y - panel.low.y) / height});
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) -> std::int32_t {
    const auto number =
        std::min(static_cast<std::size_t>((column + 0.5) / panel_width), panels.size() - 1);
    const Panel& panel = panels[number];
    const double scale = m_per_pixel / panel.radius_m;
    const double x = (panel.low.x + panel.high.x) / 2 +
                     (column + 0.5 - (static_cast<double>(number) + 0.5) * panel_width) * scale;
    const double y = (panel.low.y + panel.high.y) / 2 + (height / 2.0 - (row + 0.5)) * scale;
    if (!(x * x + y * y < 4)) return -1;
    return panel.sites.nearest(lambert_direction(panel.view, x, y), guess);
  });
}

}  // namespace omma
