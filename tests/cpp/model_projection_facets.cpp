// The facets of an eye as a picture: one region for each ommatidium however skewed the axes are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "omma/error.h"
#include "omma/io.h"
#include "projection_map.h"

namespace {

using namespace omma::test;
using omma::Error;
using omma::Eye;
using omma::Projection;
using omma::projection_ids;
using omma::Vec3;
using omma::Vec3d;

// How many regions of pixels that touch along an edge each ommatidium has.
std::map<std::int32_t, int> regions(const Map& map) {
  std::map<std::int32_t, int> count;
  std::vector<bool> seen(map.ids.size(), false);
  std::vector<std::size_t> todo;
  const auto width = static_cast<std::size_t>(map.width);
  for (std::size_t start = 0; start < map.ids.size(); ++start) {
    if (seen[start] || map.ids[start] == none) continue;
    ++count[map.ids[start]];
    seen[start] = true;
    todo.push_back(start);
    while (!todo.empty()) {
      const std::size_t pixel = todo.back();
      todo.pop_back();
      const auto visit = [&](bool inside, std::size_t next) {
        if (!inside || seen[next] || map.ids[next] != map.ids[pixel]) return;
        seen[next] = true;
        todo.push_back(next);
      };
      visit(pixel % width > 0, pixel - 1);
      visit(pixel % width + 1 < width, pixel + 1);
      visit(pixel >= width, pixel - width);
      visit(pixel + width < map.ids.size(), pixel + width);
    }
  }
  return count;
}

// Pairs of ommatidia that are next to each other somewhere.
std::set<std::pair<std::int32_t, std::int32_t>> neighbours(const Map& map) {
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (int row = 0; row + 1 < map.height; ++row)
    for (int column = 0; column + 1 < map.width; ++column)
      for (const int other : {map.pixel(column + 1, row), map.pixel(column, row + 1)})
        if (const int id = map.pixel(column, row); id != other && id != none && other != none)
          pairs.insert(std::minmax(id, other));
  return pairs;
}

void expect_one_region_each(const Eye& eye, const Map& map) {
  const auto count = regions(map);
  EXPECT_EQ(count.size(), eye.size());
  for (const auto& [id, number] : count) EXPECT_EQ(number, 1) << "ommatidium " << id;
}

// Points spread evenly over a cap of an ellipsoid around `side`: a golden spiral.
std::vector<Vec3> cap(int count, double side, Vec3d shift) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = 1 - 0.9 * (i + 0.5) / count;  // from the pole to near the equator
    const double angle = i * omma::pi * (3 - std::sqrt(5.0)), ring = std::sqrt(1 - x * x);
    points.push_back(to_float(
        Vec3d{side * x * 0.8, ring * std::sin(angle) * 1.3, ring * std::cos(angle)} + shift));
  }
  return points;
}

// A head of two eyes whose axes are skewed so far that many cross: they swirl and are squeezed.
Eye skewed_head(int count, float distance) {
  std::vector<Vec3> positions, axes;
  for (const float side : {-1.0f, 1.0f})
    for (const Vec3 point : cap(count, side, {})) {
      positions.push_back(point + Vec3{side * distance, 0, 0});
      axes.push_back({point.x + 0.8f * point.y, 0.2f * point.y - point.z,
                      point.z * point.z - 0.5f + 0.7f * point.x});
    }
  return eye_of(positions, axes);
}

TEST(Facets, EachOmmatidiumOfASkewedEyeIsOneRegion) {
  Eye eye = skewed_head(700, 3);
  for (std::size_t i = 700; i < 1400; ++i) eye.eye_id[i] = 1;
  const Map map(eye, Projection::facets, 1200, 600);
  expect_one_region_each(eye, map);
  for (int row = 0; row < 600; ++row)
    for (int column = 0; column < 1200; ++column)
      if (const int id = map.pixel(column, row); id != none) {
        ASSERT_EQ(id >= 700, column >= 600);  // the left eye on the left
      }
  // The axes do tear a picture, or there would be no test: few neighbours stay neighbours there.
  const auto on_the_eye = neighbours(map);
  const auto by_axis = neighbours(Map(eye, Projection::spherical_orientationwise, 1200, 600));
  int kept = 0;
  for (const auto& pair : on_the_eye) kept += by_axis.contains(pair) ? 1 : 0;
  EXPECT_LT(kept, static_cast<int>(on_the_eye.size()) * 2 / 3);
}

TEST(Facets, OneFileWithBothEyesIsTwoEyes) {
  const Eye both = skewed_head(300, 3);
  Eye numbered = both;
  for (std::size_t i = 300; i < 600; ++i) numbered.eye_id[i] = 9;
  EXPECT_EQ(projection_ids(both, Projection::facets, 400, 200),
            projection_ids(numbered, Projection::facets, 400, 200));
  // Caps that meet in the middle are one eye, numbers or not.
  const Eye closed = skewed_head(300, -0.08f);
  Eye closed_numbered = closed;
  for (std::size_t i = 300; i < 600; ++i) closed_numbered.eye_id[i] = 9;
  EXPECT_NE(projection_ids(closed, Projection::facets, 400, 200),
            projection_ids(closed_numbered, Projection::facets, 400, 200));
}

TEST(Facets, AreSeenFromWithinAndNotChangedByTheAxes) {
  // The right side of a sphere, and marks up, down, ahead and back on it.
  std::vector<Vec3> positions = cap(400, 1, {});
  const auto mark = [&](Vec3 towards) {
    std::int32_t best = 0;
    for (std::size_t i = 0; i < positions.size(); ++i)
      if (dot(positions[i], towards) > dot(positions[static_cast<std::size_t>(best)], towards))
        best = static_cast<std::int32_t>(i);
    return best;
  };
  Eye eye = eye_of(positions, positions);
  const Map map(eye, Projection::facets, 500, 500);
  std::map<std::int32_t, std::pair<double, double>> middle;  // of each facet's pixels
  std::map<std::int32_t, int> pixels;
  for (int row = 0; row < 500; ++row)
    for (int column = 0; column < 500; ++column) {
      const int id = map.pixel(column, row);
      middle[id].first += column, middle[id].second += row, pixels[id]++;
    }
  for (auto& [id, at] : middle) at.first /= pixels[id], at.second /= pixels[id];
  EXPECT_LT(middle[mark({0, 1, 0})].second, 100);   // up at the top
  EXPECT_GT(middle[mark({0, -1, 0})].second, 400);  // down at the bottom
  EXPECT_LT(middle[mark({0, 0, -1})].first, 150);   // right eye: ahead is to the left
  EXPECT_GT(middle[mark({0, 0, 1})].first, 350);
  EXPECT_NEAR(middle[mark({1, 0, 0})].first, 250, 25);
  Eye other = eye;
  for (Vec3& axis : other.axis) axis = {0, 1, 0};
  EXPECT_EQ(map.ids, projection_ids(other, Projection::facets, 500, 500));
}

TEST(Facets, SixAllAround) {
  std::vector<Vec3> shifted;
  for (const Vec3 position : six) shifted.push_back(position * 0.002f + Vec3{0.1f, 0.2f, 0.3f});
  const Map map(eye_of(shifted, {6, Vec3{0, 0, 1}}), Projection::facets, 401, 401);
  EXPECT_EQ(map.at(0.5, 0.5), ahead);
  EXPECT_EQ(map.at(0.85, 0.5), right);
  EXPECT_EQ(map.at(0.15, 0.5), left);
  EXPECT_EQ(map.at(0.5, 0.15), up);
  EXPECT_EQ(map.at(0.5, 0.85), down);
  EXPECT_EQ(map.at(0.005, 0.5), back);
  EXPECT_EQ(map.at(0.5, 0.995), back);
  EXPECT_EQ(map.at(0.02, 0.02), none);
  for (const auto& [id, share] : map.shares(0, 401)) EXPECT_NEAR(share, 1 / 6.0, 1e-3) << id;
}

TEST(Facets, AnEyeWithoutASurfaceIsAnError) {
  const std::vector<Vec3> axes(9, {0, 0, -1});
  std::vector<Vec3> point(9, {1, 2, 3}), line, plane;
  for (int i = 0; i < 9; ++i) {
    const auto x = static_cast<float>(i % 3), y = static_cast<float>(i / 3);
    line.push_back({0.1f * x + y, 0.2f * x + 2 * y, 0.7f});
    plane.push_back({0.1f * x, 0.3f * y, 0.5f + 0.17f * x + 0.31f * y});
  }
  for (const auto& positions : {point, line, plane})
    EXPECT_THROW(projection_ids(eye_of(positions, axes), Projection::facets, 20, 10), Error);
  try {
    projection_ids(eye_of({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}, {3, Vec3{0, 0, -1}}),
                   Projection::facets, 20, 10);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("facets: the positions of eye 0"), std::string::npos)
        << error.what();
  }
}

TEST(Facets, EachOmmatidiumOfARealBeeIsOneRegion) {
  const std::string path = OMMA_SHARED_DATA "/compound-ray/bees/AM_60185-real.eye";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "there is no " << path;
  const Eye eye = omma::load_eye(path);
  ASSERT_EQ(eye.size(), 6374u);
  expect_one_region_each(eye, Map(eye, Projection::facets, 3000, 1500));
}

}  // namespace
