// Equirectangular pictures: which pixel shows which ommatidium, against known eyes and against
// trying all; and the display values.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "omma/error.h"
#include "omma/projection.h"

namespace {

using omma::degree;
using omma::Error;
using omma::Eye;
using omma::pi;
using omma::Vec3;
using omma::Vec3d;

Eye eye_of(const std::vector<Vec3>& axes) {
  Eye eye;
  eye.axis = axes;
  eye.position_m = axes;
  eye.acceptance_angle_rad.assign(axes.size(), 0.1f);
  eye.focal_offset_m.assign(axes.size(), 0.0f);
  eye.eye_id.assign(axes.size(), 0);
  omma::validate_eye(eye);
  return eye;
}

Eye random_eye(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<Vec3> axes;
  for (std::size_t i = 0; i < count; ++i)
    axes.push_back({normal(random), normal(random), normal(random)});
  return eye_of(axes);
}

Vec3d pixel_direction(int column, int row, int width, int height) {
  const double azimuth = ((column + 0.5) / width - 0.5) * 2 * pi;
  const double elevation = (0.5 - (row + 0.5) / height) * pi;
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          -std::cos(azimuth) * std::cos(elevation)};
}

enum : std::int32_t { ahead, right, back, left, up, down };
const std::vector<Vec3> six_axes = {{0, 0, -1}, {1, 0, 0}, {0, 0, 1},
                                    {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};

TEST(Equirectangular, SixAxesLieWhereTheHeaderSays) {
  const int width = 360, height = 180;
  for (const auto& ids : {omma::equirectangular_ids(eye_of(six_axes), width, height),
                          omma::equirectangular_ids_by_position(eye_of(six_axes), width, height)}) {
    ASSERT_EQ(ids.size(), 360u * 180u);
    const auto at = [&](int azimuth_deg, int elevation_deg) {
      const int column = std::min(azimuth_deg + 180, width - 1);
      const int row = std::min(90 - elevation_deg, height - 1);
      return ids[static_cast<std::size_t>(row * width + column)];
    };
    EXPECT_EQ(at(0, 0), ahead);
    EXPECT_EQ(at(90, 0), right);
    EXPECT_EQ(at(-90, 0), left);
    EXPECT_EQ(at(-180, 0), back);
    EXPECT_EQ(at(179, 0), back);
    EXPECT_EQ(at(40, 0), ahead);
    EXPECT_EQ(at(50, 0), right);
    EXPECT_EQ(at(0, 40), ahead);
    EXPECT_EQ(at(0, 50), up);
    EXPECT_EQ(at(0, -50), down);
    for (int azimuth = -180; azimuth < 180; azimuth += 30) {
      EXPECT_EQ(at(azimuth, 90), up);
      EXPECT_EQ(at(azimuth, -90), down);
    }
  }
}

TEST(Equirectangular, AgreesWithTryingAll) {
  for (const auto& [count, width, height] : {std::tuple(1, 7, 5), std::tuple(2, 16, 8),
                                             std::tuple(37, 33, 17), std::tuple(3000, 120, 61)}) {
    Eye eye = random_eye(static_cast<std::size_t>(count), static_cast<unsigned>(count));
    if (count > 10) {  // doubles: ties that must go to the lower index
      eye.axis[static_cast<std::size_t>(count) - 1] = eye.axis[2];
      eye.axis[7] = eye.axis[3];
    }
    const auto ids = omma::equirectangular_ids(eye, width, height);
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        const Vec3d direction = pixel_direction(column, row, width, height);
        double least = std::numeric_limits<double>::max();
        std::int32_t nearest = -1;
        for (std::size_t i = 0; i < eye.size(); ++i) {
          const Vec3d apart = direction - normalize(to_double(eye.axis[i]));
          if (dot(apart, apart) < least) {
            least = dot(apart, apart);
            nearest = static_cast<std::int32_t>(i);
          }
        }
        ASSERT_EQ(ids[static_cast<std::size_t>(row * width + column)], nearest)
            << count << " axes, column " << column << " row " << row;
      }
  }
}

TEST(Equirectangular, TiesGoToTheLowerIndex) {
  // More of the same axis than fit a leaf of the tree.
  for (const int id : omma::equirectangular_ids(eye_of(std::vector<Vec3>(50, {0, 0, -1})), 31, 15))
    ASSERT_EQ(id, 0);
}

TEST(Equirectangular, BeyondTheLargestAngleIsNothing) {
  const int width = 360, height = 181;  // the middle row is the horizon
  const auto ids = omma::equirectangular_ids(eye_of({{0, 0, -1}}), width, height,
                                             static_cast<float>(10 * degree));
  for (int column = 0; column < width; ++column) {
    const double azimuth_deg = column + 0.5 - 180;
    const int id = ids[static_cast<std::size_t>(90 * width + column)];
    EXPECT_EQ(id, std::fabs(azimuth_deg) < 10 ? 0 : -1) << azimuth_deg;
  }
  const auto by_position = omma::equirectangular_ids_by_position(eye_of(six_axes), width, height,
                                                                 static_cast<float>(10 * degree));
  EXPECT_EQ(by_position[90u * 360u + 180u], ahead);
  EXPECT_EQ(by_position[90u * 360u + 200u], -1);
  // Half a turn reaches everything.
  for (const int id :
       omma::equirectangular_ids(eye_of({{0, 0, -1}}), 64, 32, static_cast<float>(pi)))
    ASSERT_EQ(id, 0);
}

TEST(Equirectangular, PositionsAreSeenFromTheirCentroid) {
  Eye eye = eye_of(six_axes);
  for (Vec3& position : eye.position_m) position = position * 0.25f + Vec3{5, -2, 1};
  std::swap(eye.axis[ahead], eye.axis[up]);  // must not matter
  // A size in which no pixel lies halfway between two axes.
  EXPECT_EQ(omma::equirectangular_ids_by_position(eye, 101, 51),
            omma::equirectangular_ids_by_position(eye_of(six_axes), 101, 51));
}

TEST(Equirectangular, BadArgumentsAreErrors) {
  const Eye eye = eye_of(six_axes);
  EXPECT_THROW(omma::equirectangular_ids(eye, 0, 10), Error);
  EXPECT_THROW(omma::equirectangular_ids(eye, 10, -1), Error);
  EXPECT_THROW(omma::equirectangular_ids(eye, 1 << 30, 1 << 30), Error);
  EXPECT_THROW(omma::equirectangular_ids(eye, 10, 10, -0.1f), Error);
  EXPECT_THROW(omma::equirectangular_ids(eye, 10, 10, std::nanf("")), Error);
  EXPECT_THROW(omma::equirectangular_ids(Eye{}, 10, 10), Error);
  EXPECT_THROW(omma::equirectangular_ids_by_position(Eye{}, 10, 10), Error);
  EXPECT_THROW(omma::equirectangular_ids_by_position(eye_of({{0, 0, -1}}), 10, 10), Error);
}

TEST(Nearest, ByAxisAgreesWithTryingAll) {
  const Eye eye = random_eye(800, 3);
  const std::vector<Vec3> directions = random_eye(3000, 4).axis;
  std::vector<Vec3> longer;
  for (const Vec3 direction : directions) longer.push_back(direction * 40.0f);
  const auto ids = omma::nearest_by_axis(eye, longer);
  ASSERT_EQ(ids.size(), directions.size());
  for (std::size_t d = 0; d < directions.size(); ++d) {
    double most = -2;
    std::int32_t nearest = -1;
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const double cosine =
          dot(normalize(to_double(eye.axis[i])), normalize(to_double(directions[d])));
      if (cosine > most) {
        most = cosine;
        nearest = static_cast<std::int32_t>(i);
      }
    }
    ASSERT_EQ(ids[d], nearest) << d;
  }
}

TEST(Nearest, ByPositionIsSeenFromTheCentre) {
  Eye eye = eye_of(six_axes);
  const Vec3 centre{3, -1, 2};
  for (Vec3& position : eye.position_m) position = position * 0.5f + centre;
  std::swap(eye.axis[ahead], eye.axis[up]);  // must not matter
  EXPECT_EQ(omma::nearest_by_position(eye, centre, six_axes),
            (std::vector<std::int32_t>{ahead, right, back, left, up, down}));
  // From farther back both ends of the line of sight lie ahead, a tie.
  EXPECT_EQ(omma::nearest_by_position(eye, centre + Vec3{0, 0, 10}, std::vector<Vec3>{{0, 0, -1}}),
            (std::vector<std::int32_t>{ahead}));
}

TEST(Nearest, TiesZerosAndTheCentre) {
  const float nan = std::nanf("");
  const std::vector<Vec3> odd = {{0, 0, 0}, {nan, 0, 1}, {0, HUGE_VALF, 0}, {0, 0, -1e-30f}};
  EXPECT_EQ(omma::nearest_by_axis(eye_of(six_axes), odd),
            (std::vector<std::int32_t>{-1, -1, -1, ahead}));
  // Halfway between ahead (0) and right (1), and doubles of one axis.
  const std::vector<Vec3> halfway = {{1, 0, -1}};
  EXPECT_EQ(omma::nearest_by_axis(eye_of(six_axes), halfway)[0], ahead);
  EXPECT_EQ(omma::nearest_by_axis(eye_of(std::vector<Vec3>(50, {0, 1, 0})), halfway)[0], 0);

  Eye eye = eye_of(six_axes);
  eye.position_m[ahead] = {0, 0, 0};
  const auto ids = omma::nearest_by_position(eye, {0, 0, 0}, six_axes);
  EXPECT_EQ(ids[right], right);
  EXPECT_NE(ids[ahead], ahead);
  EXPECT_GE(ids[ahead], 0);
  eye.position_m.assign(6, {1, 2, 3});
  for (const int id : omma::nearest_by_position(eye, {1, 2, 3}, six_axes)) EXPECT_EQ(id, -1);
  EXPECT_EQ(omma::nearest_by_axis(Eye{}, halfway)[0], -1);
  EXPECT_TRUE(omma::nearest_by_axis(eye, {}).empty());
}

TEST(Paint, DisplayValuesFollowTheGamma) {
  const std::vector<std::int32_t> ids = {1, -1, 0};
  const float nan = std::nanf("");
  const std::vector<float> responses = {0.0f, 1.0f, 0.5f, 7.0f, -1.0f, nan};
  EXPECT_EQ(omma::paint(ids, responses, 1.0),
            (std::vector<std::uint8_t>{255, 0, 0, 128, 128, 128, 0, 255, 128}));
  // 255 * 0.5^(1/2.2) = 186.08
  EXPECT_EQ(omma::paint(ids, responses).back(), 186);
}

TEST(Paint, BadArgumentsAreErrors) {
  const std::vector<float> responses = {0, 0, 0, 1, 1, 1};
  const std::vector<std::int32_t> beyond = {2};
  const std::vector<std::int32_t> negative = {-2};
  const std::vector<std::int32_t> good = {1};
  EXPECT_THROW(omma::paint(beyond, responses), Error);
  EXPECT_THROW(omma::paint(negative, responses), Error);
  EXPECT_THROW(omma::paint(good, {responses.data(), 4}), Error);
  for (const double gamma : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(omma::paint(good, responses, gamma), Error) << gamma;
}

}  // namespace
