// Eyes in CSV and OCES from C++: the format follows the name, and what is wrong in a file is named
// with its place.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "gltf_builder.h"
#include "io/csv_text.h"
#include "io/eye_csv.h"
#include "io/oces.h"
#include "omma/io.h"

namespace {

using nlohmann::json;
using omma::Eye;
using omma::parse_eye_csv;
using omma::test::expect_error;
using omma::test::GltfBuilder;
using omma::test::TemporaryFolder;

const std::string axis_header = "axis_x,axis_y,axis_z,acceptance_angle_deg";

void expect_csv_error(const std::string& text, std::vector<std::string> parts) {
  parts.push_back("bee.csv");
  expect_error([&] { parse_eye_csv(text, "bee.csv"); }, parts);
}

TEST(DecimalText, MovesThePointAndLosesNothing) {
  EXPECT_EQ(omma::decimal_text(2e-5, 6), "20");
  EXPECT_EQ(omma::decimal_text(2e-5f, 6), "20");
  EXPECT_EQ(omma::decimal_text(1.9e-6, 6), "1.9");
  EXPECT_EQ(omma::decimal_text(-0.0, 3), "-0");
  EXPECT_EQ(omma::decimal_text(1e-30, 3), "1e-27");
  EXPECT_EQ(omma::decimal_text(0.00125, 0), "0.00125");
  EXPECT_EQ(omma::decimal_text(123456.5, 0), "123456.5");
  EXPECT_EQ(omma::decimal_text(1e10, 3), "10000000000000");
  double value = 0;
  for (const double exact : {0.1, 1.0 / 3, 1.363, 5e-324, 1.7e308, 2.5e-7}) {
    for (const int shift : {0, 3, 6}) {
      const double small = exact > 1e300 ? exact / 1e7 : exact;
      ASSERT_TRUE(omma::parse_decimal(omma::decimal_text(small, shift), -shift, value));
      EXPECT_EQ(value, small);
    }
  }
  EXPECT_TRUE(omma::parse_decimal(" +2.5e3 ", -3, value));
  EXPECT_EQ(value, 2.5);
  for (const char* text : {"", " ", "x", "1x", "+-1", "--1", "1e", "1e+", "1 2", "0x10", "inf"})
    EXPECT_FALSE(omma::parse_decimal(text, -3, value)) << text;
  EXPECT_TRUE(omma::parse_decimal("nan", 0, value));
  EXPECT_TRUE(std::isnan(value));
}

TEST(EyeCsv, ReadsWhatAPersonWrites) {
  const Eye eye = parse_eye_csv(
      "\xef\xbb\xbf# my eye\r\n"
      "azimuth_deg, elevation_deg ,acceptance_angle_rad,facet_diameter_mm,position_x_um,"
      "position_y_um,position_z_um,side,age\r\n"
      "90,0,0.05,0.02,1,2,3,\"left, \"\"l\"\"\",4\r\n"
      "\r\n"
      "0,30,0.06,,4,5,6,right,\r\n",
      "bee.csv");
  ASSERT_EQ(eye.size(), 2u);
  EXPECT_NEAR(eye.axis[0].x, 1, 1e-7);  // to the right
  EXPECT_NEAR(eye.axis[1].y, 0.5, 1e-7);
  EXPECT_NEAR(eye.axis[1].z, -std::sqrt(0.75), 1e-7);
  EXPECT_EQ(eye.acceptance_angle_rad[0], 0.05f);
  EXPECT_EQ(eye.facet_diameter_m[0], 2e-5f);
  EXPECT_EQ(eye.facet_diameter_m[1], 0.0f);
  EXPECT_EQ(eye.position_m[0].z, 3e-6f);
  ASSERT_EQ(eye.columns.size(), 2u);
  EXPECT_EQ(eye.columns[0].texts[0], "left, \"l\"");
  EXPECT_EQ(eye.columns[1].numbers[0], 4);
  EXPECT_TRUE(std::isnan(eye.columns[1].numbers[1]));
}

TEST(EyeCsv, ReadsTablesAsPandasWritesThem) {
  // Rows have labels, in a column without a name; whole numbers a point, where some are missing.
  const Eye eye = parse_eye_csv(
      ",azimuth_deg,elevation_deg,acceptance_angle_deg,eye_id\n"
      "3,0,0,2,1.0\n"
      "17,0,30,2,\n",
      "bee.csv");
  ASSERT_EQ(eye.size(), 2u);
  EXPECT_EQ(eye.eye_id, (std::vector<std::int32_t>{1, 0}));
  EXPECT_TRUE(eye.columns.empty());
  for (const char* wrong : {",azimuth_deg,elevation_deg,acceptance_angle_deg\n0.5,0,0,2\n",
                            "azimuth_deg,,elevation_deg,acceptance_angle_deg\n0,1,0,2\n",
                            "azimuth_deg,elevation_deg,acceptance_angle_deg,eye_id\n0,0,2,1.5\n",
                            "azimuth_deg,elevation_deg,acceptance_angle_deg,eye_id\n0,0,2,3e9\n"})
    EXPECT_THROW(parse_eye_csv(wrong, "bee.csv"), omma::Error) << wrong;
}

TEST(EyeCsv, KernelsTakeWhatTheOmmatidiumHas) {
  const Eye eye = parse_eye_csv(
      "# receptor_type {\"name\": \"green\", \"peak_wavelength_nm\": 544}\n"
      "# kernel_table \"narrow\" {\"right_rad\": [0, 0.01], \"sensitivity\": [1, 0]}\n" +
          axis_header +
          ",kernel,kernel_wavelength_nm,facet_diameter_um,kernel_table,receptors\n"
          "0,0,-1,2,pillbox,,,,green; green\n"
          "0,0,-1,,airy,500,25,,\n"
          "0,0,-1,3,,,,,\"#0\"\n"
          "0,0,-1,,table,,,narrow,\n",
      "bee.csv");
  EXPECT_EQ(eye.acceptance_of, (std::vector<std::int32_t>{0, 1, -1, 2}));
  EXPECT_EQ(eye.acceptances[0].width_rad, static_cast<double>(eye.acceptance_angle_rad[0]));
  EXPECT_EQ(static_cast<float>(eye.acceptances[1].facet_diameter_m), 25e-6f);
  // 1.0290 lambda / D
  EXPECT_NEAR(eye.acceptance_angle_rad[1], 1.029 * 500e-9 / 25e-6, 1e-4);
  EXPECT_EQ(eye.first_receptor, (std::vector<std::int32_t>{0, 2, 2, 3, 3}));
  EXPECT_EQ(eye.acceptances[2].table->right_rad[1], 0.01);
}

TEST(EyeCsv, NamesWhatIsWrongAndWhere) {
  const std::string line = "\n0,0,-1,5";
  expect_csv_error("", {"header"});
  expect_csv_error("# only\n", {"header"});
  expect_csv_error(axis_header + "\n", {"at least one ommatidium"});
  expect_csv_error("axis_x,axis_y,acceptance_angle_deg\n0,0,1\n", {"line 1", "axis_z"});
  expect_csv_error("axis_x,axis_y,axis_z\n0,0,1\n", {"line 1", "acceptance_angle_deg"});
  expect_csv_error("axis_x,axis_y,axis_z,acceptance_angle\n0,0,1,1\n",
                   {"line 1, column 4", "acceptance_angle_deg or acceptance_angle_rad"});
  expect_csv_error(axis_header + ",position_x_inch,position_y_mm,position_z_mm" + line + ",1,1,1",
                   {"line 1, column 5", "position_x_um or position_x_mm or position_x_m", "inch"});
  expect_csv_error(axis_header + ",axis_x" + line + ",1",
                   {"line 1, column 5", "twice", "column 1"});
  expect_csv_error(axis_header + ",acceptance_angle_rad" + line + ",1", {"column 5", "twice"});
  expect_csv_error(axis_header + ",a,a" + line + ",1,2", {"line 1, column 6", "\"a\"", "twice"});
  expect_csv_error(axis_header + "," + line + ",1", {"line 1, column 5", "a name"});
  expect_csv_error(axis_header + ",azimuth_deg" + line + ",1", {"both"});
  expect_csv_error(axis_header + ",up_x" + line + ",1", {"up_x, up_y and up_z"});
  expect_csv_error(axis_header + line + ",6", {"line 2", "4 cells", "5"});
  expect_csv_error(axis_header + line + "\n0,0,-1", {"line 3", "4 cells", "3"});
  expect_csv_error(axis_header + "\n0,0,x,5", {"line 2", "axis_z", "a number", "\"x\""});
  expect_csv_error(axis_header + "\n0,0,inf,5", {"line 2", "axis_z", "a number"});
  expect_csv_error(axis_header + "\n0,0,,5", {"line 2", "axis_z", "none"});
  expect_csv_error(axis_header + "\n0,0,0,5", {"line 2", "axis_x", "zero"});
  expect_csv_error(axis_header + "\n0,0,1,-5", {"line 2", "acceptance_angle_deg", "at least 0"});
  expect_csv_error(axis_header + "\n0,0,1,400", {"ommatidium 0", "2 pi"});
  expect_csv_error(axis_header + "\n0,0,1,", {"line 2", "acceptance angle or a kernel"});
  expect_csv_error(axis_header + ",eye_id" + line + ",1.5", {"line 2", "eye_id", "whole number"});
  expect_csv_error(axis_header + ",eye_id" + line + ",-1", {"line 2", "eye_id", "whole number"});
  expect_csv_error(axis_header + ",kernel" + line + ",round",
                   {"line 2", "kernel", "gaussian, pillbox", "\"round\""});
  expect_csv_error(axis_header + ",kernel" + line + ",airy", {"line 2", "kernel"});
  expect_csv_error(axis_header + ",kernel_width_deg" + line + ",2",
                   {"line 2, column \"kernel_width_deg\"", "column \"kernel\"", "found none"});
  expect_csv_error(axis_header + ",kernel,kernel_table" + line + ",table,t",
                   {"line 2", "kernel_table", "\"t\""});
  expect_csv_error(axis_header + ",receptors" + line + ",green", {"line 2", "receptors", "green"});
  expect_csv_error(axis_header + ",receptors" + line + ",#0", {"line 2", "receptors", "#0"});
  expect_csv_error("# receptor_type {\n" + axis_header + line, {"line 1", "receptor_type", "JSON"});
  expect_csv_error("# receptor_type {\"nom\": 1}\n" + axis_header + line, {"line 1", "\"nom\""});
  expect_csv_error("# receptor_type {\"name\": 1}\n" + axis_header + line, {"name", "a text"});
  expect_csv_error("# kernel_table {}\n" + axis_header + line, {"line 1", "no name"});
  expect_csv_error(axis_header + "\n0,0,-1,\"5", {"line 2", "nothing closes"});
  expect_csv_error(axis_header + "\n0,0,-1,\"5\"5", {"line 2", "comma after the closing quote"});
  expect_csv_error(axis_header + ",a" + line + ",\xff", {"line 2", "UTF-8"});
}

TEST(EyeFormats, FollowTheName) {
  const TemporaryFolder folder;
  Eye eye;
  eye.position_m = {{1e-3f, 0, 0}, {0, 2e-3f, 0}};
  eye.axis = {{0, 0, -1}, {0, 1, 0}};
  eye.acceptance_angle_rad = {0.05f, 0.06f};
  eye.focal_offset_m = {0, 1e-5f};
  eye.eye_id = {0, 1};
  eye.facet_diameter_m = {2e-5f, 3e-5f};
  for (const char* name : {"a.csv", "a.gltf", "a.GLB"}) {
    const std::string path = (folder.path / name).string();
    EXPECT_TRUE(omma::eye_file_losses(path, eye).empty());
    omma::save_eye(path, eye);
    const Eye back = omma::load_eye(path);
    EXPECT_EQ(back.path, path);
    EXPECT_EQ(back.facet_diameter_m, eye.facet_diameter_m);
    EXPECT_EQ(back.eye_id, eye.eye_id);
    EXPECT_EQ(back.focal_offset_m, eye.focal_offset_m);
    EXPECT_EQ(back.acceptance_angle_rad, eye.acceptance_angle_rad);
  }
  const std::string path = (folder.path / "a.eye").string();
  EXPECT_EQ(omma::eye_file_losses(path, eye).size(), 2u);
  expect_error([&] { omma::save_eye(path, eye); },
               {"a.eye", "facet diameters (2 of 2", "which eye", "lossy"});
  EXPECT_FALSE(std::filesystem::exists(path));
  omma::save_eye(path, eye, 1e-3, true);
  EXPECT_EQ(omma::load_eye(path).acceptance_angle_rad, eye.acceptance_angle_rad);
}

// A file of one head and one eye, to be broken in one place.
json good_oces() {
  return json::parse(R"({
    "asset": {"version": "2.0"},
    "nodes": [{"children": [1], "extensions": {"OCES_eyes": {"head": true}}},
              {"extensions": {"OCES_eyes": {"eye": 0, "mirrorPlanes": [0]}}}],
    "extensions": {"OCES_eyes": {"version": "0.3.0", "mirrorPlanes": [{"normal": "X"}],
      "ommatidialProperties": [{"type": "COARSE", "value": [0, 0, 1]},
                               {"type": "COARSE", "value": 2e-5},
                               {"type": "COARSE", "value": -1e-4}],
      "eyes": [{"type": "POINT_OMMATIDIAL", "ommatidialProperties":
        {"POSITION": 0, "ORIENTATION": 0, "DIAMETER": 1, "FOCAL_OFFSET": 2}}]}}})");
}

void expect_oces_error(const std::string& pointer, const json& value,
                       std::vector<std::string> parts) {
  json document = good_oces();
  document[json::json_pointer(pointer)] = value;
  parts.push_back("bee.gltf");
  SCOPED_TRACE(pointer + " " + value.dump());
  expect_error([&] { omma::parse_oces(document.dump(), "bee.gltf"); }, parts);
}

TEST(Oces, NamesWhatIsWrongAndWhere) {
  ASSERT_EQ(omma::parse_oces(good_oces().dump(), "bee.gltf").size(), 2u);
  const std::string oces = "/extensions/OCES_eyes";
  expect_oces_error(oces, 3, {"OCES_eyes", "an object"});
  expect_oces_error(oces + "/version", "1.0.0", {"version", "0.x.x", "1.0.0"});
  expect_oces_error(oces + "/version", 3, {"version", "a text"});
  expect_oces_error("/nodes/0/extensions/OCES_eyes/head", "yes", {"node 0", "head", "true or"});
  expect_oces_error("/nodes/0/extensions/OCES_eyes/head", false, {"node 1", "below a head"});
  expect_oces_error("/nodes/1/extensions/OCES_eyes/head", true, {"node 1", "found both"});
  expect_oces_error("/nodes/1/extensions/OCES_eyes", {{"head", true}}, {"node 1", "another head"});
  expect_oces_error("/nodes/1/extensions/OCES_eyes/eye", 1, {"node 1", "eyes", "1 there"});
  expect_oces_error("/nodes/1/extensions/OCES_eyes/eye", -1, {"node 1", "index"});
  expect_oces_error("/nodes/1/extensions/OCES_eyes/enabled", false, {"node 0", "no eye"});
  expect_oces_error("/nodes/1/extensions/OCES_eyes/mirrorPlanes/0", 4, {"mirrorPlanes", "1 there"});
  expect_oces_error("/nodes/1/scale", {1, 0, 1}, {"node 1", "not invertible"});
  expect_oces_error("/nodes/1/children", {0}, {"cycle"});
  expect_oces_error(oces + "/mirrorPlanes/0/normal", "UPWARDS", {"mirrorPlanes[0].normal", "UPW"});
  expect_oces_error(oces + "/mirrorPlanes/0/normal", {0, 0, 0}, {"mirrorPlanes[0].normal"});
  expect_oces_error(oces + "/mirrorPlanes/0/position", {0, 0}, {"mirrorPlanes[0].position"});
  expect_oces_error(oces + "/eyes/0", 7, {"eyes[0]", "an object"});
  expect_oces_error(oces + "/eyes/0/type", "ROUND", {"eyes[0]", "POINT_OMMATIDIAL", "ROUND"});
  expect_oces_error(oces + "/eyes/0/enabled", 1, {"eyes[0]", "enabled"});
  expect_oces_error(oces + "/eyes/0/ommatidialProperties/DIAMETER", 9, {"DIAMETER", "3 there"});
  expect_oces_error(oces + "/ommatidialProperties/1/type", "FINE", {"DIAMETER", "type", "FINE"});
  expect_oces_error(oces + "/ommatidialProperties/1/type", "ACCESSOR", {"accessors", "0 there"});
  expect_oces_error(oces + "/ommatidialProperties/1/type", "TEXTURE", {"type", "ACCESSOR"});
  expect_oces_error(oces + "/ommatidialProperties/1/value", "wide", {"DIAMETER", "a number"});
  expect_oces_error(oces + "/ommatidialProperties/1/value", {1, 2}, {"DIAMETER", "one number"});
  expect_oces_error(oces + "/ommatidialProperties/1/value", -1, {"DIAMETER", "at least 0"});
  expect_oces_error(oces + "/ommatidialProperties/0/value", {0, 0, 0}, {"orientation", "zero"});
  expect_oces_error(oces + "/ommatidialProperties/0/value", {0, 1}, {"POSITION", "three numbers"});
  expect_oces_error(oces + "/ommatidialProperties/2/value", 0, {"FOCAL_OFFSET", "below 0"});
  expect_oces_error(oces + "/ommatidialProperties/2/value", 1, {"FOCAL_OFFSET", "below 0"});
  expect_oces_error(oces + "/eyes/0/type", "SPHERICAL", {"ommatidialCount"});
  expect_oces_error(oces + "/eyes/0/type", "SURFACE", {"ommatidialCount"});
  json surface = good_oces()["extensions"]["OCES_eyes"]["eyes"][0];
  surface["type"] = "SURFACE";
  surface["ommatidialCount"] = 5;
  expect_oces_error(oces + "/eyes/0", surface, {"surface: is missing"});
  surface["ommatidialCount"] = 2000000000;
  expect_oces_error(oces + "/eyes/0", surface, {"ommatidialCount", "1 to 200000"});
  expect_oces_error("/extensions", json::object(), {"has no eyes", "OCES_eyes"});
}

TEST(Oces, AccessorsMustFitOneAnother) {
  GltfBuilder builder;
  builder.document = good_oces();
  json& oces = builder.document["extensions"]["OCES_eyes"];
  const auto use = [&](std::size_t property, int accessor, int stride = 1) {
    oces["ommatidialProperties"][property] = {
        {"type", "ACCESSOR"}, {"value", accessor}, {"dataStride", stride}};
  };
  use(1, builder.accessor<float>({1e-5f, 2e-5f, 3e-5f}, "SCALAR"));
  EXPECT_EQ(omma::parse_oces(builder.gltf(), "bee.gltf").size(), 6u);
  use(2, builder.accessor<float>({-1, -1}, "SCALAR"));
  expect_error([&] { omma::parse_oces(builder.gltf(), "bee.gltf"); },
               {"bee.gltf", "FOCAL_OFFSET", "as many ommatidia", "(3)", "2"});
  use(2, builder.accessor<float>({-1, -1, -1, -1}, "SCALAR"), 3);
  expect_error([&] { omma::parse_oces(builder.gltf(), "bee.gltf"); },
               {"bee.gltf", "4 elements", "dataStride (3)"});
  use(2, builder.accessor<float>({-1, NAN, -1}, "SCALAR"));
  expect_error([&] { omma::parse_oces(builder.gltf(), "bee.gltf"); }, {"accessor", "not finite"});
  builder.document["accessors"].push_back(
      {{"componentType", 5126}, {"count", std::uint64_t{1} << 60}, {"type", "SCALAR"}});
  use(2, static_cast<int>(builder.document["accessors"].size()) - 1);
  expect_error([&] { omma::parse_oces(builder.gltf(), "bee.gltf"); }, {"bee.gltf"});
}

}  // namespace
