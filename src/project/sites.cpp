// Ommatidia as points of which the nearest is sought, and the eyes of a head.
#include "project/sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "omma/error.h"

namespace omma {
namespace {

// Whether an eye's positions lie in two groups, left and right.
bool has_two_sides(const Eye& eye) {
  double left = -std::numeric_limits<double>::max(), right = std::numeric_limits<double>::max();
  double largest = 0;
  for (const Vec3 position : eye.position_m) {
    const double x = position.x;
    if (x < 0) left = std::max(left, x);
    if (x >= 0) right = std::min(right, x);
    largest = std::max(
        {largest, std::fabs(x), std::fabs(double{position.y}), std::fabs(double{position.z})});
  }
  if (left == -std::numeric_limits<double>::max() || right == std::numeric_limits<double>::max())
    return false;
  std::vector<Vec3d> points;  // about 1 in size, as the tree expects
  for (const Vec3 position : eye.position_m) points.push_back(to_double(position) * (1 / largest));
  std::vector<double> apart = spacing(AxisTree(points), points, 1);
  const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
  std::nth_element(apart.begin(), middle, apart.end());
  return (right - left) / largest > 4 * *middle;
}

}  // namespace

bool has_direction(Vec3d vector) {
  const double squared = dot(vector, vector);
  return squared > 0 && std::isfinite(squared);
}

std::int32_t Sites::nearest(Vec3d point, std::int32_t& guess) const {
  if (member.empty()) return -1;
  if (static_cast<std::size_t>(guess) >= member.size()) guess = 0;  // it was of other sites
  double squared = 0;
  guess = tree.nearest(point, guess, squared);
  const auto site = static_cast<std::size_t>(guess);
  return limit_squared.empty() || squared <= limit_squared[site] ? member[site] : -1;
}

Sites sites_by_direction(const std::vector<Vec3d>& directions,
                         const std::vector<std::int32_t>& members) {
  std::vector<Vec3d> points;
  std::vector<std::int32_t> kept;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (!has_direction(directions[i])) continue;
    points.push_back(normalize(directions[i]));
    kept.push_back(members[i]);
  }
  return {AxisTree(points), std::move(kept), {}, std::move(points)};
}

Sites sites_by_axis(const Eye& eye, const std::vector<std::int32_t>& members, Reach reach) {
  std::vector<Vec3d> axes;
  axes.reserve(members.size());
  for (const std::int32_t i : members)
    axes.push_back(to_double(eye.axis[static_cast<std::size_t>(i)]));
  Sites sites = sites_by_direction(axes, members);
  if (reach == Reach::everywhere) return sites;

  Eye numbered = eye;  // so that neighbours are sought in the same eye
  const auto eyes = eyes_of_head(eye);
  for (std::size_t e = 0; e < eyes.size(); ++e)
    for (const std::int32_t i : eyes[e])
      numbered.eye_id[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(e);
  const std::vector<float> apart_rad = interommatidial_angle_rad(numbered);
  for (const std::int32_t member : sites.member) {
    const auto i = static_cast<std::size_t>(member);
    const double limit_rad = std::max(apart_rad[i], eye.acceptance_angle_rad[i]);
    const double chord = 2 * std::sin(std::min(limit_rad, pi) / 2);
    sites.limit_squared.push_back(limit_rad >= pi ? 5 : chord * chord);
  }
  return sites;
}

Sites sites_by_position(const Eye& eye, Vec3d centre) {
  std::vector<Vec3d> seen;
  seen.reserve(eye.size());
  for (const Vec3 position : eye.position_m) seen.push_back(to_double(position) - centre);
  return sites_by_direction(seen, all_ommatidia(eye));
}

std::vector<double> spacing(const AxisTree& tree, const std::vector<Vec3d>& points, int count) {
  std::vector<double> mean(points.size(), 0.0);
  parallel_for(std::size_t{0}, points.size(), [&](std::size_t k) {
    const NearestAxes near = tree.nearest(points[k], count + 1);  // the point itself is among them
    double sum = 0;
    int found = 0;
    for (std::size_t n = 0; n < static_cast<std::size_t>(near.count) && found < count; ++n) {
      if (near.index[n] == static_cast<std::int32_t>(k)) continue;
      sum += std::sqrt(near.chord_squared[n]);
      ++found;
    }
    if (found > 0) mean[k] = sum / found;
  });
  return mean;
}

std::vector<std::vector<std::int32_t>> eyes_of_head(const Eye& eye) {
  std::map<std::int32_t, std::vector<std::int32_t>> by_id;
  for (const std::int32_t i : all_ommatidia(eye))
    by_id[eye.eye_id[static_cast<std::size_t>(i)]].push_back(i);
  if (by_id.size() == 1 && has_two_sides(eye)) {
    by_id.clear();
    for (const std::int32_t i : all_ommatidia(eye))
      by_id[eye.position_m[static_cast<std::size_t>(i)].x < 0 ? 0 : 1].push_back(i);
  }
  std::vector<std::vector<std::int32_t>> eyes;
  for (auto& entry : by_id) eyes.push_back(std::move(entry.second));
  const auto mean_x = [&](const std::vector<std::int32_t>& members) {
    double sum = 0;
    for (const std::int32_t i : members) sum += eye.axis[static_cast<std::size_t>(i)].x;
    return sum / static_cast<double>(members.size());
  };
  std::stable_sort(eyes.begin(), eyes.end(),
                   [&](const auto& a, const auto& b) { return mean_x(a) < mean_x(b); });
  return eyes;
}

std::vector<std::int32_t> all_ommatidia(const Eye& eye) {
  std::vector<std::int32_t> all(eye.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

void check_picture(const std::string& projection, const Eye& eye, int width, int height) {
  // A gigapixel: far above any picture, and no overflow anywhere.
  constexpr std::int64_t most_pixels = std::int64_t{1} << 30;
  if (width < 1 || height < 1 || std::int64_t{width} * height > most_pixels)
    throw Error(projection +
                ": width and height must be at least 1 and their product at most 2^30, are " +
                std::to_string(width) + " and " + std::to_string(height));
  if (eye.size() == 0) throw Error(projection + ": an eye must have at least one ommatidium");
}

View view_along(Vec3d ahead) {
  const bool vertical = std::hypot(ahead.x, ahead.z) < 1e-6 * std::fabs(ahead.y);
  const Vec3d right = vertical ? Vec3d{1, 0, 0} : normalize(cross(ahead, {0, 1, 0}));
  return {ahead, right, cross(right, ahead)};
}

Vec3d lambert_direction(const View& view, double x, double y) {
  // With r the distance from the middle and c the angle from `ahead`: r = 2 sin(c / 2), so that
  // sin c = r sqrt(1 - r^2 / 4) and cos c = 1 - r^2 / 2.
  const double squared = x * x + y * y;
  const double side = std::sqrt(std::max(0.0, 1 - squared / 4));
  return view.ahead * (1 - squared / 2) + view.right * (x * side) + view.up * (y * side);
}

Vec2d lambert_point(const View& view, Vec3d unit) {
  const double cosine = dot(unit, view.ahead);
  // 2 sin(c / 2) / sin c; straight behind, which is the whole rim, goes to its right end.
  const double scale = std::sqrt(2 / std::max(1 + cosine, 1e-15));
  const double x = dot(unit, view.right) * scale, y = dot(unit, view.up) * scale;
  return cosine < -1 + 1e-12 ? Vec2d{2, 0} : Vec2d{x, y};
}

}  // namespace omma
