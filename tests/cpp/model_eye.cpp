// Eyes as values: validation, several eyes on a head, interommatidial angles; and poses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "omma/error.h"
#include "omma/eye.h"
#include "omma/pose.h"

namespace {

using omma::degree;
using omma::Error;
using omma::Eye;
using omma::Mat4;
using omma::PlacedEye;
using omma::Vec3;
using omma::Vec3d;

Eye eye_of(const std::vector<Vec3>& axes) {
  Eye eye;
  for (const Vec3 axis : axes) {
    eye.position_m.push_back(axis * 1e-3f);
    eye.axis.push_back(axis);
    eye.acceptance_angle_rad.push_back(0.045f);
    eye.focal_offset_m.push_back(1e-4f);
    eye.eye_id.push_back(0);
  }
  return eye;
}

std::string error_of(Eye eye) {
  try {
    omma::validate_eye(eye);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_near(Vec3d a, Vec3d b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(ValidateEye, NormalisesAndIsIdempotent) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<Vec3> axes;
  for (int i = 0; i < 1000; ++i) axes.push_back({normal(random), normal(random), normal(random)});
  Eye eye = eye_of(axes);
  omma::validate_eye(eye);
  const Eye once = eye;
  omma::validate_eye(eye);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    // Rounding to float moves the length by at most sqrt(3) * 2^-25.
    EXPECT_NEAR(length(to_double(once.axis[i])), 1.0, 6e-8);
    EXPECT_LT(length(cross(normalize(to_double(axes[i])), to_double(once.axis[i]))), 6e-8);
    EXPECT_EQ(eye.axis[i].x, once.axis[i].x);
    EXPECT_EQ(eye.axis[i].y, once.axis[i].y);
    EXPECT_EQ(eye.axis[i].z, once.axis[i].z);
  }
}

TEST(ValidateEye, NamesThePlace) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eye good = eye_of({{0, 0, -1}, {1, 0, 0}});
  EXPECT_EQ(error_of(good), "no error");
  const auto expect = [&](const char* what, const auto& spoil) {
    Eye eye = good;
    eye.path = "bee.eye";
    spoil(eye);
    const std::string message = error_of(eye);
    EXPECT_NE(message.find("bee.eye"), std::string::npos) << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  expect("position_m", [](Eye& eye) { eye.position_m.pop_back(); });
  expect("acceptance_angle_rad", [](Eye& eye) { eye.acceptance_angle_rad.push_back(0); });
  expect("focal_offset_m", [](Eye& eye) { eye.focal_offset_m.clear(); });
  expect("eye_id", [](Eye& eye) { eye.eye_id.clear(); });
  expect("at least one", [](Eye& eye) {
    const std::string path = eye.path;
    eye = {};
    eye.path = path;
  });
  expect("ommatidium 1: the position", [=](Eye& eye) { eye.position_m[1].y = nan; });
  expect("ommatidium 1: the axis", [](Eye& eye) { eye.axis[1] = {0, 0, 0}; });
  expect("ommatidium 0: the axis", [=](Eye& eye) { eye.axis[0].z = nan; });
  expect("ommatidium 0: the axis", [](Eye& eye) { eye.axis[0].z = -HUGE_VALF; });
  expect("ommatidium 1: the acceptance", [](Eye& eye) { eye.acceptance_angle_rad[1] = -0.1f; });
  expect("ommatidium 1: the acceptance", [](Eye& eye) { eye.acceptance_angle_rad[1] = 6.29f; });
  expect("ommatidium 1: the acceptance", [=](Eye& eye) { eye.acceptance_angle_rad[1] = nan; });
  expect("ommatidium 1: the focal offset", [](Eye& eye) { eye.focal_offset_m[1] = -1e-6f; });
  expect("ommatidium 1: the focal offset", [](Eye& eye) { eye.focal_offset_m[1] = HUGE_VALF; });
  expect("ommatidium 1: eye_id", [](Eye& eye) { eye.eye_id[1] = -1; });
}

TEST(MergeEyes, TransformsEachEyeAndNumbersIt) {
  PlacedEye left{eye_of({{0, 0, -1}}), {}};
  // A quarter turn to the left about +Y, twice the size, moved.
  left.head_from_eye.m[0][0] = 0;
  left.head_from_eye.m[0][2] = 2;
  left.head_from_eye.m[1][1] = 2;
  left.head_from_eye.m[2][0] = -2;
  left.head_from_eye.m[2][2] = 0;
  left.head_from_eye.m[0][3] = -0.5;
  left.eye.path = "left.eye";
  PlacedEye right{eye_of({{1, 0, 0}, {0, 1, 0}}), {}};
  right.eye.eye_id = {7, 7};
  right.eye.path = "right.eye";
  const PlacedEye placed[] = {left, right};
  const Eye head = omma::merge_eyes(placed);
  ASSERT_EQ(head.size(), 3u);
  EXPECT_EQ(head.path, "left.eye + right.eye");
  EXPECT_EQ(head.eye_id, (std::vector<std::int32_t>{0, 1, 1}));
  expect_near(to_double(head.axis[0]), {-1, 0, 0}, 0);
  // The float nearest -0.502 is within 3e-8 of it.
  expect_near(to_double(head.position_m[0]), {-0.502, 0, 0}, 3e-8);
  EXPECT_FLOAT_EQ(head.focal_offset_m[0], 2e-4f);
  EXPECT_FLOAT_EQ(head.focal_offset_m[1], 1e-4f);
  EXPECT_EQ(head.acceptance_angle_rad[0], 0.045f);

  const Eye second = omma::select_eye(head, 1);
  ASSERT_EQ(second.size(), 2u);
  expect_near(to_double(second.axis[1]), {0, 1, 0}, 0);
  EXPECT_THROW(omma::select_eye(head, 2), Error);
}

TEST(MergeEyes, MovesTheRayOriginWithTheEyeUnderUnevenScale) {
  PlacedEye placed{eye_of({{0.6f, 0, -0.8f}}), {}};
  placed.head_from_eye.m[0][0] = 3;
  const Eye head = omma::merge_eyes({&placed, 1});
  const auto origin = [](const Eye& eye) {
    return to_double(eye.position_m[0]) - to_double(eye.axis[0]) * eye.focal_offset_m[0];
  };
  // Lengths are about 1e-3, in float: 1e-9 is some ten of their last bits.
  expect_near(origin(head), transform_point(placed.head_from_eye, origin(placed.eye)), 1e-9);
}

TEST(MergeEyes, RefusesBadTransforms) {
  PlacedEye placed{eye_of({{0, 0, -1}}), {}};
  EXPECT_THROW(omma::merge_eyes({}), Error);
  const auto refuses = [&](int row, int column, double value) {
    PlacedEye bad = placed;
    bad.head_from_eye.m[row][column] = value;
    EXPECT_THROW(omma::merge_eyes({&bad, 1}), Error) << row << column << value;
  };
  refuses(0, 3, std::nan(""));
  refuses(1, 1, 0.0);
  refuses(3, 3, 2.0);
  refuses(3, 0, 1.0);
  refuses(0, 3, 1e300);
}

// A patch of a hexagonal lattice of axes, `pitch_rad` apart, around straight ahead.
std::vector<Vec3> hexagonal_axes(double pitch_rad, int rings) {
  std::vector<Vec3> axes;
  for (int q = -rings; q <= rings; ++q)
    for (int r = -rings; r <= rings; ++r) {
      if (std::abs(q + r) > rings) continue;
      const double x = pitch_rad * (q + r / 2.0);
      const double y = pitch_rad * r * std::sqrt(3.0) / 2;
      axes.push_back(to_float(normalize(Vec3d{x, y, -1})));
    }
  return axes;
}

TEST(InterommatidialAngle, IsThePitchOfAHexagonalLattice) {
  const std::vector<Vec3> axes = hexagonal_axes(1 * degree, 3);
  const std::vector<float> angle = omma::interommatidial_angle_rad(eye_of(axes));
  const auto middle = static_cast<std::size_t>(
      std::find_if(axes.begin(), axes.end(), [](Vec3 a) { return a.x == 0 && a.y == 0; }) -
      axes.begin());
  ASSERT_LT(middle, axes.size());
  // tan(1 deg) is 1.0001 of 1 deg; float axes are good to 1e-7 rad.
  EXPECT_NEAR(angle[middle], 1 * degree, 1.1e-4 * degree + 1e-7);
}

TEST(InterommatidialAngle, LooksOnlyWithinTheSameEye) {
  Eye eye = eye_of({{0, 0, -1}, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}});
  eye.eye_id = {0, 1, 0, 0, 2};
  const std::vector<float> angle = omma::interommatidial_angle_rad(eye);
  const float quarter = static_cast<float>(90 * degree);
  EXPECT_FLOAT_EQ(angle[0], quarter);
  EXPECT_FLOAT_EQ(angle[1], 0.0f);  // alone in its eye
  EXPECT_FLOAT_EQ(angle[2], quarter);
  EXPECT_FLOAT_EQ(angle[4], 0.0f);
}

TEST(InterommatidialAngle, AgreesWithBruteForce) {
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  std::vector<Vec3> axes;
  for (int i = 0; i < 800; ++i) axes.push_back({normal(random), normal(random), normal(random)});
  axes.insert(axes.end(), 9, axes[3]);  // more of one axis than there are neighbours
  Eye eye = eye_of(axes);
  omma::validate_eye(eye);
  for (std::size_t i = 0; i < eye.size(); ++i) eye.eye_id[i] = static_cast<std::int32_t>(i % 3);
  const std::vector<float> angle = omma::interommatidial_angle_rad(eye);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    std::vector<double> others;
    const Vec3d a = normalize(to_double(eye.axis[i]));
    for (std::size_t j = 0; j < eye.size(); ++j) {
      const Vec3d b = normalize(to_double(eye.axis[j]));
      if (j != i && eye.eye_id[j] == eye.eye_id[i])
        others.push_back(std::atan2(length(cross(a, b)), dot(a, b)));
    }
    std::partial_sort(others.begin(), others.begin() + 6, others.end());
    double sum = 0;
    for (int k = 0; k < 6; ++k) sum += others[static_cast<std::size_t>(k)];
    // The result is rounded to float once; angles go up to about 0.5 rad.
    EXPECT_NEAR(angle[i], sum / 6, 5e-8) << i;
  }
}

TEST(AzimuthElevation, FollowsTheHeadFrame) {
  const auto degrees = [](Vec3 d) {
    const omma::Vec2 a = omma::azimuth_elevation_rad(d);
    return std::pair(std::lround(a.x / degree), std::lround(a.y / degree));
  };
  EXPECT_EQ(degrees({0, 0, -1}), std::pair(0L, 0L));
  EXPECT_EQ(degrees({2, 0, 0}), std::pair(90L, 0L));
  EXPECT_EQ(degrees({-1, 0, 0}), std::pair(-90L, 0L));
  EXPECT_EQ(degrees({0, 0, 1}), std::pair(180L, 0L));
  EXPECT_EQ(degrees({-0.0f, 0, 1}), std::pair(180L, 0L));  // in (-pi, pi]
  EXPECT_EQ(degrees({0, 1, 0}).second, 90L);
  EXPECT_EQ(degrees({0, -3, 0}).second, -90L);
  EXPECT_EQ(degrees({1, 1, 0}), std::pair(90L, 45L));
}

// Rotations built in double are orthonormal to a few of its last bits.
constexpr double rounding = 1e-12;

TEST(Pose, QuaternionTurnsAsItShould) {
  const double half = std::sqrt(0.5);
  // A quarter turn about +Y takes ahead (-Z) to the left (-X); any length of quaternion will do.
  for (const double scale : {1.0, 3.0, -2.0, 1e-200, 1e200}) {
    const Mat4 t = omma::pose_from_quaternion({1, 2, 3}, 0, half * scale, 0, half * scale);
    expect_near(transform_vector(t, {0, 0, -1}), {-1, 0, 0}, rounding);
    expect_near(transform_vector(t, {1, 0, 0}), {0, 0, -1}, rounding);
    expect_near(transform_point(t, {0, 0, 0}), {1, 2, 3}, 0);
    EXPECT_NEAR(determinant(t), 1, rounding);
  }
  // About +X: ahead goes up. About +Z: right goes up.
  expect_near(transform_vector(omma::pose_from_quaternion({}, half, 0, 0, half), {0, 0, -1}),
              {0, 1, 0}, rounding);
  expect_near(transform_vector(omma::pose_from_quaternion({}, 0, 0, half, half), {1, 0, 0}),
              {0, 1, 0}, rounding);
  // An uneven rotation against Rodrigues' formula.
  const Vec3d k = normalize(Vec3d{1, -2, 0.5});
  const double angle = 0.7;
  const double s = std::sin(angle / 2);
  const Mat4 t = omma::pose_from_quaternion({}, k.x * s, k.y * s, k.z * s, std::cos(angle / 2));
  const Vec3d v{0.3, 0.4, -2};
  const Vec3d turned =
      v * std::cos(angle) + cross(k, v) * std::sin(angle) + k * (dot(k, v) * (1 - std::cos(angle)));
  expect_near(transform_vector(t, v), turned, rounding);
}

TEST(Pose, BadQuaternionsAreErrors) {
  const double nan = std::nan("");
  EXPECT_THROW(omma::pose_from_quaternion({}, 0, 0, 0, 0), Error);
  EXPECT_THROW(omma::pose_from_quaternion({}, nan, 0, 0, 1), Error);
  EXPECT_THROW(omma::pose_from_quaternion({}, 0, HUGE_VAL, 0, 1), Error);
  EXPECT_THROW(omma::pose_from_quaternion({nan, 0, 0}, 0, 0, 0, 1), Error);
}

TEST(Pose, LookAtLooksAtTheTargetWithUpUp) {
  const Vec3d position{1, 2, 3};
  const Vec3d target{-4, 2.5, 7};
  const Mat4 t = omma::look_at(position, target);
  expect_near(transform_point(t, {0, 0, 0}), position, 0);
  expect_near(transform_vector(t, {0, 0, -1}), normalize(target - position), rounding);
  EXPECT_NEAR(transform_vector(t, {1, 0, 0}).y, 0, rounding);  // the right is level
  EXPECT_GT(transform_vector(t, {0, 1, 0}).y, 0);
  EXPECT_NEAR(determinant(t), 1, rounding);
  // Ahead along -Z is the identity.
  const Mat4 ahead = omma::look_at({0, 0, 0}, {0, 0, -5});
  expect_near(transform_vector(ahead, {1, 2, 3}), {1, 2, 3}, rounding);
  // Looking down, with the top of the picture to the north (-Z); sizes far from 1.
  const Mat4 down = omma::look_at({0, 1e200, 0}, {0, -1e200, 0}, {0, 0, -1e-200});
  expect_near(transform_vector(down, {0, 1, 0}), {0, 0, -1}, rounding);
  expect_near(transform_vector(down, {1, 0, 0}), {1, 0, 0}, rounding);
}

TEST(Pose, BadLookAtsAreErrors) {
  EXPECT_THROW(omma::look_at({1, 2, 3}, {1, 2, 3}), Error);
  EXPECT_THROW(omma::look_at({0, 0, 0}, {0, 5, 0}), Error);
  EXPECT_THROW(omma::look_at({0, 0, 0}, {0, -5, 0}), Error);
  EXPECT_THROW(omma::look_at({0, 0, 0}, {0, 0, -1}, {0, 0, 0}), Error);
  EXPECT_THROW(omma::look_at({0, 0, 0}, {0, 0, std::nan("")}), Error);
  EXPECT_THROW(omma::look_at({HUGE_VAL, 0, 0}, {0, 0, 0}), Error);
  EXPECT_THROW(omma::look_at({0, 0, 0}, {0, 0, -1}, {0, std::nan(""), 0}), Error);
}

}  // namespace
