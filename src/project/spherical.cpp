// Projections of the sphere of directions: equirectangular, split, Mollweide, Lambert, hemispheres.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "omma/error.h"
#include "omma/projection.h"
#include "project/sites.h"

namespace omma {
namespace {

// x from 0 to 1 from azimuth -180 to 180 degrees, y from 0 to 1 from elevation 90 to -90.
Vec3d equirectangular_direction(double x, double y) {
  const double azimuth = (x - 0.5) * 2 * pi, elevation = (0.5 - y) * pi;
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          -std::cos(azimuth) * std::cos(elevation)};
}

std::vector<std::int32_t> equirectangular_map(const Sites& sites, int width, int height) {
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) {
    return sites.nearest(equirectangular_direction((column + 0.5) / width, (row + 0.5) / height),
                         guess);
  });
}

// 5 is beyond any squared distance of two unit vectors.
double limit_squared(float max_angle_rad) {
  if (!(max_angle_rad >= 0))
    throw Error("equirectangular picture: max_angle_rad must not be negative, is " +
                std::to_string(max_angle_rad));
  const double chord = 2 * std::sin(std::min(double{max_angle_rad}, pi) / 2);
  return max_angle_rad >= static_cast<float>(pi) ? 5 : chord * chord;
}

// The largest upright figure `aspect` times as wide as it is high in the middle of a picture:
// x and y of a pixel's centre run from -1 to 1 across it.
struct Fitted {
  double middle_x, middle_y, half_width, half_height;  // pixels

  Fitted(double left, double right, double height, double aspect)
      : middle_x((left + right) / 2),
        middle_y(height / 2),
        half_width(std::min(right - left, aspect * height) / 2),
        half_height(half_width / aspect) {}

  Vec2d at(int column, int row) const {
    return {(column + 0.5 - middle_x) / half_width, (middle_y - (row + 0.5)) / half_height};
  }
};

Sites members_by_axis(const Eye& eye, const std::vector<std::int32_t>& members) {
  return sites_by_axis(eye, members, Reach::field_only);
}

}  // namespace

std::vector<std::int32_t> equirectangular_ids(const Eye& eye, int width, int height,
                                              float max_angle_rad) {
  check_picture("equirectangular picture", eye, width, height);
  Sites sites = sites_by_axis(eye, all_ommatidia(eye), Reach::everywhere);
  sites.limit_squared.assign(sites.member.size(), limit_squared(max_angle_rad));
  return equirectangular_map(sites, width, height);
}

std::vector<std::int32_t> equirectangular_ids_by_position(const Eye& eye, int width, int height,
                                                          float max_angle_rad) {
  check_picture("equirectangular picture by position", eye, width, height);
  Vec3d centroid;
  for (const Vec3 position : eye.position_m) centroid = centroid + to_double(position);
  Sites sites = sites_by_position(eye, centroid * (1.0 / static_cast<double>(eye.size())));
  if (sites.member.empty())
    throw Error(
        "equirectangular picture by position: all ommatidia lie in one point and so in no "
        "direction from it");
  sites.limit_squared.assign(sites.member.size(), limit_squared(max_angle_rad));
  return equirectangular_map(sites, width, height);
}

std::vector<std::int32_t> field_ids(const Eye& eye, int width, int height) {
  check_picture("visual field", eye, width, height);
  return equirectangular_map(members_by_axis(eye, all_ommatidia(eye)), width, height);
}

std::vector<std::int32_t> side_by_side_ids(const Eye& eye, int width, int height) {
  check_picture("visual fields side by side", eye, width, height);
  std::vector<Sites> eyes;
  for (const auto& members : eyes_of_head(eye)) eyes.push_back(members_by_axis(eye, members));
  const auto all = static_cast<std::int64_t>(eyes.size()) * width;
  if (all > std::numeric_limits<int>::max())
    throw Error("visual fields side by side: " + std::to_string(eyes.size()) + " eyes of " +
                std::to_string(width) + " pixels each are too wide");
  check_picture("visual fields side by side", eye, static_cast<int>(all), height);
  return fill_ids(static_cast<int>(all), height, [&](int column, int row, std::int32_t& guess) {
    return eyes[static_cast<std::size_t>(column / width)].nearest(
        equirectangular_direction((column % width + 0.5) / width, (row + 0.5) / height), guess);
  });
}

std::vector<std::int32_t> split_ids(const Eye& eye, int width, int height) {
  std::vector<std::int32_t> members[2];
  for (const std::int32_t i : all_ommatidia(eye)) {
    const float x = eye.position_m[static_cast<std::size_t>(i)].x;
    if (x <= 0) members[0].push_back(i);
    if (x >= 0) members[1].push_back(i);
  }
  const Sites sites[2] = {sites_by_axis(eye, members[0], Reach::everywhere),
                          sites_by_axis(eye, members[1], Reach::everywhere)};
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) {
    const double x = 2 * (column + 0.5) / width;
    const int side = x >= 1 ? 1 : 0;
    return sites[side].nearest(equirectangular_direction(x - side, (row + 0.5) / height), guess);
  });
}

// Snyder 1987, Map Projections, USGS PP 1395, section 31, with the ellipse's half axes as unit.
std::vector<std::int32_t> mollweide_ids(const Eye& eye, int width, int height) {
  const Sites sites = members_by_axis(eye, all_ommatidia(eye));
  const Fitted ellipse(0, width, height, 2);
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) -> std::int32_t {
    const auto [x, y] = ellipse.at(column, row);
    if (!(x * x + y * y < 1)) return -1;
    const double theta = std::asin(y);
    const double sine = (2 * theta + std::sin(2 * theta)) / pi;  // of the elevation
    const double level = std::sqrt(std::max(0.0, 1 - sine * sine));
    const double azimuth = pi * x / std::cos(theta);
    return sites.nearest({level * std::sin(azimuth), sine, -level * std::cos(azimuth)}, guess);
  });
}

std::vector<std::int32_t> lambert_ids(const Eye& eye, int width, int height) {
  const Sites sites = members_by_axis(eye, all_ommatidia(eye));
  const Fitted disc(0, width, height, 1);
  const View ahead = view_along({0, 0, -1});
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) -> std::int32_t {
    const auto [x, y] = disc.at(column, row);
    if (!(x * x + y * y < 1)) return -1;
    return sites.nearest(lambert_direction(ahead, 2 * x, 2 * y), guess);
  });
}

std::vector<std::int32_t> hemisphere_ids(const Eye& eye, int width, int height) {
  // An eye belongs to the side it looks to. One whose mean axis is less than 0.1 of a unit vector
  // off the midline, as for an eye that looks all around or ahead, is seen on both.
  std::vector<std::int32_t> members[2];
  for (const std::vector<std::int32_t>& one : eyes_of_head(eye)) {
    double x = 0;
    for (const std::int32_t i : one) x += eye.axis[static_cast<std::size_t>(i)].x;
    x /= static_cast<double>(one.size());
    if (x < 0.1) members[0].insert(members[0].end(), one.begin(), one.end());
    if (x > -0.1) members[1].insert(members[1].end(), one.begin(), one.end());
  }
  for (auto& side : members) std::sort(side.begin(), side.end());
  const Sites sites[2] = {members_by_axis(eye, members[0]), members_by_axis(eye, members[1])};
  const Fitted discs[2] = {{0, width / 2.0, double(height), 1},
                           {width / 2.0, double(width), double(height), 1}};
  const View views[2] = {view_along({-1, 0, 0}), view_along({1, 0, 0})};
  return fill_ids(width, height, [&](int column, int row, std::int32_t& guess) -> std::int32_t {
    const int side = 2 * column + 1 >= width ? 1 : 0;
    const auto [x, y] = discs[side].at(column, row);
    if (!(x * x + y * y < 1)) return -1;
    // 90 degrees from the middle is a distance of sqrt(2).
    const double rim = std::sqrt(2.0);
    return sites[side].nearest(lambert_direction(views[side], rim * x, rim * y), guess);
  });
}

}  // namespace omma
