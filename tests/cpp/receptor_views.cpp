// Views of receptors, against rotations done by hand, and the matrix applied to what they see.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "omma/error.h"
#include "omma/receptor_views.h"

namespace omma {
namespace {

ReceptorType looking(double right_rad, double up_rad) {
  ReceptorType type;
  type.name = "looking";
  type.peak_wavelength_nm = 500;
  type.right_rad = right_rad;
  type.up_rad = up_rad;
  return type;
}

ReceptorType wide(double width_rad) {
  ReceptorType type = looking(0, 0);
  type.acceptance = Acceptance{};
  type.acceptance->kernel = Kernel::pillbox;
  type.acceptance->width_rad = width_rad;
  return type;
}

// Three ommatidia, looking ahead, right and aslant; lists of types for each.
Eye make_eye(std::vector<ReceptorType> types, const std::vector<std::vector<int>>& receptors) {
  Eye eye;
  eye.position_m = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  eye.axis = {{0, 0, -1}, {1, 0, 0}, {0.3f, 0.5f, -0.4f}};
  eye.acceptance_angle_rad = {0.02f, 0.03f, 0.04f};
  eye.focal_offset_m = {0.1f, 0.2f, 0.3f};
  eye.eye_id = {0, 1, 1};
  eye.facet_diameter_m = {10e-6f, 20e-6f, 30e-6f};
  eye.aperture_diameter_m = {0, 1e-4f, 2e-4f};
  eye.receptor_types = std::move(types);
  eye.first_receptor = {0};
  for (const std::vector<int>& list : receptors) {
    eye.receptor_type.insert(eye.receptor_type.end(), list.begin(), list.end());
    eye.first_receptor.push_back(static_cast<std::int32_t>(eye.receptor_type.size()));
  }
  validate_eye(eye);
  return eye;
}

TEST(ReceptorViews, AlongTheAxisTheyAreTheOmmatidia) {
  const Eye eye = make_eye({looking(0, 0), looking(0, 0)}, {{0, 1, 0}, {}, {1}});
  const ReceptorViews views = receptor_views(eye);
  ASSERT_EQ(views.eye.size(), 3u);
  EXPECT_EQ(views.view_of_receptor, (std::vector<std::int32_t>{0, 0, 0, 2}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(views.eye.axis[i].x, eye.axis[i].x);
    EXPECT_EQ(views.eye.axis[i].y, eye.axis[i].y);
    EXPECT_EQ(views.eye.position_m[i].z, eye.position_m[i].z);
    EXPECT_EQ(views.eye.acceptance_angle_rad[i], eye.acceptance_angle_rad[i]);
    EXPECT_EQ(views.eye.focal_offset_m[i], eye.focal_offset_m[i]);
    EXPECT_EQ(views.eye.eye_id[i], eye.eye_id[i]);
    EXPECT_EQ(views.eye.aperture_diameter_m[i], eye.aperture_diameter_m[i]);
  }
  EXPECT_TRUE(views.eye.receptor_type.empty());
}

TEST(ReceptorViews, BesideTheAxisTheyAreTurnedThroughTheNodalPoint) {
  const double right = 0.03, up = -0.04, angle = 0.05;
  const Eye eye = make_eye({looking(right, up)}, {{0}, {0}, {0}});
  const ReceptorViews views = receptor_views(eye);
  ASSERT_EQ(views.eye.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d axis = to_double(eye.axis[i]), u = to_double(eye.up[i]), r = cross(axis, u);
    const Vec3d view = to_double(views.eye.axis[i]), view_up = to_double(views.eye.up[i]);
    // Single precision.
    EXPECT_NEAR(dot(view, axis), std::cos(angle), 1e-6);
    EXPECT_NEAR(dot(view, r), std::sin(angle) * right / angle, 1e-6);
    EXPECT_NEAR(dot(view, u), std::sin(angle) * up / angle, 1e-6);
    // The up vector is turned by the same rotation, about r * up - u * right: what lies along that
    // stays, and it leans along the axis by what it has in common with the turn.
    EXPECT_NEAR(dot(view_up, view), 0, 1e-6);
    const Vec3d about = (r * up - u * right) * (1 / angle);
    EXPECT_NEAR(dot(view_up, about), dot(u, about), 1e-6);
    EXPECT_NEAR(dot(view_up, axis), -std::sin(angle) * up / angle, 1e-6);
    EXPECT_EQ(views.eye.position_m[i].x, eye.position_m[i].x);
    EXPECT_EQ(views.eye.focal_offset_m[i], eye.focal_offset_m[i]);
    EXPECT_EQ(views.eye.facet_diameter_m[i], eye.facet_diameter_m[i]);
  }
}

TEST(ReceptorViews, SharedWhereTheyAreTheSame) {
  ReceptorType other = looking(0.1, 0);
  other.name = "another name and pigment";
  other.peak_wavelength_nm = 350;
  const Eye eye = make_eye({looking(0.1, 0), other, looking(0, 0), wide(0.2), wide(0.2), wide(0.3)},
                           {{0, 1, 2, 0}, {1, 3, 4, 5}, {2}});
  const ReceptorViews views = receptor_views(eye);
  EXPECT_EQ(views.view_of_receptor, (std::vector<std::int32_t>{3, 3, 0, 3, 4, 5, 5, 6, 2}));
  ASSERT_EQ(views.eye.size(), 7u);
  EXPECT_FLOAT_EQ(views.eye.acceptance_angle_rad[4], 0.03f);
  EXPECT_FLOAT_EQ(views.eye.acceptance_angle_rad[5], 0.2f);
  EXPECT_FLOAT_EQ(views.eye.acceptance_angle_rad[6], 0.3f);
  EXPECT_EQ(acceptance_at(views.eye, 5).kernel, Kernel::pillbox);
  EXPECT_EQ(acceptance_at(views.eye, 4).kernel, Kernel::gaussian);
  EXPECT_EQ(views.eye.acceptances.size(), 2u);
  EXPECT_EQ(views.eye.axis[5].x, eye.axis[1].x);
}

TEST(ReceptorViews, DifferByEachOfTheirAngles) {
  const Eye eye =
      make_eye({looking(0.1, 0), looking(0.1, 0.1), looking(0, 0.1)}, {{0, 1, 2}, {2, 1}, {}});
  EXPECT_EQ(receptor_views(eye).view_of_receptor, (std::vector<std::int32_t>{0, 1, 2, 3, 4}));
}

TEST(ReceptorViews, HaveTheAcceptanceOfTheirTypeWhicheverComesFirst) {
  const Eye eye = make_eye({wide(0.2), wide(0.2)}, {{1}, {0, 1}, {1}});
  const ReceptorViews views = receptor_views(eye);
  EXPECT_EQ(views.view_of_receptor, (std::vector<std::int32_t>{0, 1, 1, 2}));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(acceptance_at(views.eye, i).kernel, Kernel::pillbox) << i;
}

TEST(ReceptorViews, KeepTheOmmatidiumsOwnAcceptance) {
  Eye eye = make_eye({looking(0.1, 0)}, {{0}, {0}, {0}});
  Acceptance ellipse;
  ellipse.width_rad = 0.08;
  ellipse.minor_width_rad = 0.02;
  eye.acceptances = {ellipse};
  eye.acceptance_of = {-1, 0, -1};
  eye.acceptance_angle_rad[1] = 0;
  validate_eye(eye);
  const ReceptorViews views = receptor_views(eye);
  EXPECT_EQ(acceptance_at(views.eye, 1), ellipse);
  EXPECT_FLOAT_EQ(views.eye.acceptance_angle_rad[0], 0.02f);
}

TEST(ReceptorViews, NeedReceptors) {
  const Eye eye = make_eye({looking(0, 0)}, {{}, {}, {}});
  EXPECT_THROW(receptor_views(eye), Error);
}

}  // namespace
}  // namespace omma
