// What an eye's ommatidia can have besides an axis and an angle: up vectors, sensitivities,
// receptors, columns; that all of it is checked, and survives merging, mirroring and taking.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "omma/error.h"
#include "omma/eye.h"

namespace omma::test {
namespace {

Acceptance ellipse(double major_angle_rad) {
  Acceptance acceptance;
  acceptance.width_rad = 0.04;
  acceptance.minor_width_rad = 0.01;
  acceptance.major_angle_rad = major_angle_rad;
  return acceptance;
}

// Rises from left to right and from below to above.
Acceptance measured_map() {
  auto table = std::make_shared<SensitivityTable>();
  table->right_rad = {-0.02, 0.0, 0.04};
  table->up_rad = {-0.01, 0.01};
  table->sensitivity = {0.1, 0.2, 0.3, 0.4, 0.5, 1.0};
  Acceptance acceptance;
  acceptance.kernel = Kernel::table;
  acceptance.table = table;
  return acceptance;
}

// Three ommatidia that have everything.
Eye full_eye() {
  Eye eye;
  eye.path = "full.eye";
  eye.position_m = {{0, 0, 0}, {1e-3f, 0, 0}, {2e-3f, 0, 0}};
  eye.axis = {{0, 0, -1}, {0.6f, 0, -0.8f}, {0, 1, 0}};
  eye.acceptance_angle_rad = {0, 0.03f, 0};
  eye.focal_offset_m = {0, 0, 1e-5f};
  eye.eye_id = {0, 0, 1};
  eye.up = {{0.6f, 0.8f, 0}, {0, 0, 0}, {1, 0, 0}};
  eye.facet_diameter_m = {2e-5f, 3e-5f, 0};
  eye.aperture_diameter_m = {0, 0, 4e-4f};
  eye.acceptances = {ellipse(0.3), measured_map()};
  eye.acceptance_of = {0, -1, 1};
  ReceptorType green, ultraviolet;
  green.name = "green";
  green.peak_wavelength_nm = 544;
  green.microvillus_angle_rad = 0.2;
  green.right_rad = 0.01;
  ultraviolet.name = "uv";
  ultraviolet.peak_wavelength_nm = 344;
  ultraviolet.acceptance = ellipse(0.1);
  eye.receptor_types = {green, ultraviolet};
  eye.first_receptor = {0, 2, 2, 3};
  eye.receptor_type = {1, 0, 0};
  eye.columns = {{"region", {}, {"a", "b", "c"}}, {"length_um", {1.5, 2.5, 3.5}, {}}};
  return eye;
}

Eye valid_eye() {
  Eye eye = full_eye();
  validate_eye(eye);
  return eye;
}

std::string message_of(const std::function<void(Eye&)>& spoil) {
  Eye eye = full_eye();
  spoil(eye);
  try {
    validate_eye(eye);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

void expect_message(const std::function<void(Eye&)>& spoil, const std::string& part) {
  const std::string message = message_of(spoil);
  EXPECT_NE(message.find("full.eye"), std::string::npos) << message;
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(EyeProperties, GapsAreFilled) {
  Eye eye;
  eye.position_m = {{0, 0, 0}, {0, 0, 0}};
  eye.axis = {{0, 0, -2}, {0, -3, 0}};
  eye.focal_offset_m = {0, 0};
  eye.eye_id = {0, 0};
  validate_eye(eye);
  EXPECT_EQ(eye.acceptance_angle_rad, (std::vector<float>{0, 0}));
  EXPECT_EQ(eye.facet_diameter_m, (std::vector<float>{0, 0}));
  EXPECT_EQ(eye.aperture_diameter_m, (std::vector<float>{0, 0}));
  EXPECT_EQ(eye.acceptance_of, (std::vector<std::int32_t>{-1, -1}));
  EXPECT_EQ(eye.first_receptor, (std::vector<std::int32_t>{0, 0, 0}));
  EXPECT_EQ(eye.up[0].y, 1);
  EXPECT_EQ(eye.up[1].z, -1);  // looking straight down: ahead
}

TEST(EyeProperties, UpIsAcrossTheAxisAndKeptWhereItIs) {
  const Eye eye = valid_eye();
  EXPECT_EQ(eye.up[0].x, 0.6f);
  EXPECT_EQ(eye.up[0].y, 0.8f);
  EXPECT_EQ(eye.up[1].y, 1);
  // One that leans is put upright: (0, 1, 1) over the axis -z is +y.
  Eye leaning = full_eye();
  leaning.up[0] = {0, 1, 1};
  validate_eye(leaning);
  EXPECT_NEAR(leaning.up[0].y, 1, 1e-7);
  EXPECT_NEAR(leaning.up[0].z, 0, 1e-7);
  Eye twice = eye;
  validate_eye(twice);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    EXPECT_EQ(twice.up[i].x, eye.up[i].x);
    EXPECT_EQ(twice.up[i].y, eye.up[i].y);
    EXPECT_EQ(twice.up[i].z, eye.up[i].z);
  }
}

TEST(EyeProperties, AcceptanceAnglesAreTheMeanWidthsOfTheirSensitivities) {
  const Eye eye = valid_eye();
  EXPECT_FLOAT_EQ(eye.acceptance_angle_rad[0], 0.02f);  // sqrt(0.04 0.01)
  EXPECT_FLOAT_EQ(eye.acceptance_angle_rad[1], 0.03f);
  EXPECT_GT(eye.acceptance_angle_rad[2], 0);
  EXPECT_EQ(acceptance_at(eye, 0), ellipse(0.3));
  EXPECT_EQ(acceptance_at(eye, 1).kernel, Kernel::gaussian);
  EXPECT_FLOAT_EQ(static_cast<float>(acceptance_at(eye, 1).width_rad), 0.03f);
}

TEST(EyeProperties, WhatIsWrongIsNamed) {
  expect_message([](Eye& e) { e.up[0] = {0, 0, -1}; }, "ommatidium 0: the up vector");
  expect_message([](Eye& e) { e.up.pop_back(); }, "up must have");
  expect_message([](Eye& e) { e.facet_diameter_m[1] = -1; }, "ommatidium 1: the facet diameter");
  expect_message([](Eye& e) { e.aperture_diameter_m[2] = NAN; }, "the aperture diameter");
  expect_message([](Eye& e) { e.acceptance_of[1] = 2; }, "ommatidium 1: acceptance_of");
  expect_message([](Eye& e) { e.acceptances[0].minor_width_rad = 1; },
                 "acceptance 0: minor_width_rad");
  expect_message([](Eye& e) { e.receptor_types[1].peak_wavelength_nm = 20; },
                 "receptor type 1 ('uv'): peak_wavelength_nm: expected 300 to 800");
  expect_message([](Eye& e) { e.receptor_types[0].polarisation_sensitivity = 0.5; },
                 "polarisation_sensitivity: expected a number of at least 1");
  expect_message(
      [](Eye& e) {
        e.first_receptor = {0, 2, 1, 3};
      },
      "first_receptor must not decrease");
  expect_message([](Eye& e) { e.first_receptor.back() = 4; }, "first_receptor must end");
  expect_message([](Eye& e) { e.receptor_type[1] = 2; }, "receptor_type must be from 0");
  expect_message([](Eye& e) { e.columns[1].numbers.pop_back(); }, "column 'length_um'");
  expect_message([](Eye& e) { e.columns[1].name = "region"; }, "the name is there twice");
}

TEST(EyeProperties, TakingKeepsEverythingOfWhatIsTaken) {
  const Eye eye = valid_eye();
  const std::int64_t last_and_first[] = {2, 0};
  const Eye some = take_ommatidia(eye, last_and_first);
  ASSERT_EQ(some.size(), 2u);
  EXPECT_EQ(some.position_m[0].x, 2e-3f);
  EXPECT_EQ(some.eye_id, (std::vector<std::int32_t>{1, 0}));
  EXPECT_EQ(some.up[1].x, 0.6f);
  EXPECT_EQ(some.aperture_diameter_m, (std::vector<float>{4e-4f, 0}));
  EXPECT_EQ(acceptance_at(some, 1), ellipse(0.3));
  EXPECT_EQ(some.first_receptor, (std::vector<std::int32_t>{0, 1, 3}));
  EXPECT_EQ(some.receptor_type, (std::vector<std::int32_t>{0, 1, 0}));
  EXPECT_EQ(some.columns[0].texts, (std::vector<std::string>{"c", "a"}));
  EXPECT_EQ(some.columns[1].numbers, (std::vector<double>{3.5, 1.5}));
  const std::int64_t none[] = {3};
  EXPECT_THROW(take_ommatidia(eye, none), Error);
}

TEST(EyeProperties, MergingJoinsTypesReceptorsAndColumns) {
  Eye plain;
  plain.position_m = {{0, 0, 0}};
  plain.axis = {{0, 0, -1}};
  plain.acceptance_angle_rad = {0.02f};
  plain.focal_offset_m = {0};
  plain.eye_id = {0};
  plain.columns = {{"length_um", {9.5}, {}}, {"age", {4}, {}}};
  const PlacedEye eyes[] = {{valid_eye(), {}}, {plain, {}}, {valid_eye(), {}}};
  const Eye head = merge_eyes(eyes);
  ASSERT_EQ(head.size(), 7u);
  EXPECT_EQ(head.eye_id, (std::vector<std::int32_t>{0, 0, 0, 1, 2, 2, 2}));
  EXPECT_EQ(head.receptor_types.size(), 2u);
  EXPECT_EQ(head.first_receptor, (std::vector<std::int32_t>{0, 2, 2, 3, 3, 5, 5, 6}));
  EXPECT_EQ(head.receptor_type, (std::vector<std::int32_t>{1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(acceptance_at(head, 4), ellipse(0.3));
  EXPECT_EQ(head.acceptance_of[3], -1);
  ASSERT_EQ(head.columns.size(), 3u);
  EXPECT_EQ(head.columns[0].texts, (std::vector<std::string>{"a", "b", "c", "", "a", "b", "c"}));
  EXPECT_EQ(head.columns[1].numbers[3], 9.5);
  EXPECT_TRUE(std::isnan(head.columns[2].numbers[0]));
  EXPECT_EQ(head.columns[2].numbers[3], 4);
  EXPECT_TRUE(std::isnan(head.columns[2].numbers[6]));
}

TEST(EyeProperties, AMirrorTurnsLocalAnglesOver) {
  PlacedEye placed{valid_eye(), {}};
  placed.head_from_eye.m[0][0] = -1;
  const Eye mirrored = merge_eyes(std::span(&placed, 1));
  EXPECT_EQ(mirrored.axis[1].x, -0.6f);
  EXPECT_EQ(mirrored.up[0].x, -0.6f);
  EXPECT_EQ(mirrored.up[0].y, 0.8f);
  EXPECT_EQ(acceptance_at(mirrored, 0).major_angle_rad, -0.3);
  const SensitivityTable& table = *acceptance_at(mirrored, 2).table;
  EXPECT_EQ(table.right_rad, (std::vector<double>{-0.04, -0.0, 0.02}));
  EXPECT_EQ(table.sensitivity, (std::vector<double>{0.3, 0.2, 0.1, 1.0, 0.5, 0.4}));
  EXPECT_EQ(mirrored.receptor_types[0].microvillus_angle_rad, -0.2);
  EXPECT_EQ(mirrored.receptor_types[0].right_rad, -0.01);
  EXPECT_EQ(mirrored.receptor_types[1].acceptance->major_angle_rad, -0.1);
  // Twice is none at all.
  const PlacedEye again{mirrored, placed.head_from_eye};
  const Eye back = merge_eyes(std::span(&again, 1));
  EXPECT_EQ(acceptance_at(back, 2).table->sensitivity, measured_map().table->sensitivity);
}

TEST(EyeProperties, ScalingMovesLengthsNotSensitivities) {
  PlacedEye placed{valid_eye(), {}};
  for (int r = 0; r < 3; ++r) placed.head_from_eye.m[r][r] = 3;
  const Eye large = merge_eyes(std::span(&placed, 1));
  EXPECT_FLOAT_EQ(large.facet_diameter_m[1], 9e-5f);
  EXPECT_FLOAT_EQ(large.aperture_diameter_m[2], 1.2e-3f);
  EXPECT_FLOAT_EQ(large.focal_offset_m[2], 3e-5f);
  EXPECT_EQ(acceptance_at(large, 0), ellipse(0.3));
}

}  // namespace
}  // namespace omma::test
