// Files with very many of one thing. Each loads in seconds, where a look through all for every one
// would take longer than the time after which a test counts as hanging.

#include "gltf_builder.h"
#include "io/csv_text.h"
#include "io/eye_csv.h"
#include "io/oces.h"

namespace omma::test {
namespace {

TEST(ManyInGltf, ExtensionsUsed) {
  constexpr int count = 1200000;
  GltfBuilder b = one_triangle();
  json names = json::array(), had = json::object();
  for (int i = 0; i < count; ++i) {
    names.push_back("E_" + std::to_string(i));
    had[names.back()] = json::object();
  }
  b.document["extensionsUsed"] = std::move(names);
  b.document["nodes"][0]["extensions"] = std::move(had);
  EXPECT_EQ(load(b).warnings.size(), static_cast<std::size_t>(count));
}

TEST(ManyInGltf, PrimitivesOfOneSparseAccessor) {
  constexpr int vertices = 1000000, primitives = 100000;
  GltfBuilder b;
  std::vector<std::uint32_t> replaced(vertices);
  std::vector<float> values(3 * vertices);
  for (std::uint32_t i = 0; i < vertices; ++i) {
    replaced[i] = i;
    values[3 * i] = static_cast<float>(i);
  }
  b.push("accessors",
         {{"componentType", 5126},
          {"count", vertices},
          {"type", "VEC3"},
          {"sparse",
           {{"count", vertices},
            {"indices", {{"bufferView", b.view(bytes_of(replaced))}, {"componentType", 5125}}},
            {"values", {{"bufferView", b.view(bytes_of(values))}}}}}});
  const int corners = b.accessor<std::uint32_t>({5, 900000, 70}, "SCALAR");
  b.document["meshes"] = {{{"primitives", json::array()}}};
  for (int i = 0; i < primitives; ++i)
    b.document["meshes"][0]["primitives"].push_back(
        {{"attributes", {{"POSITION", 0}}}, {"indices", corners}});
  b.root({{"mesh", 0}});
  const TemporaryFolder folder;
  const Scene scene = load_scene(folder.write("scene.glb", b.glb()));
  ASSERT_EQ(scene.meshes.size(), static_cast<std::size_t>(primitives));
  expect_near(scene.meshes.back().positions.at(2), {900000, 0, 0});
}

// One ommatidium in CSV with these extra columns and receptors.
std::string one_row(const std::string& header, const std::string& cells) {
  return "azimuth_deg,elevation_deg,acceptance_angle_deg" + header + "\n0,0,1" + cells + "\n";
}

TEST(ManyInEyes, Columns) {
  constexpr int count = 500000;
  std::string header, cells;
  for (int i = 0; i < count; ++i) {
    header += ",c" + std::to_string(i);
    cells += ",t";
  }
  const Eye eye = parse_eye_csv(one_row(header, cells), "eye.csv");
  ASSERT_EQ(eye.columns.size(), static_cast<std::size_t>(count));
  EXPECT_EQ(eye.columns.back().name, "c" + std::to_string(count - 1));
  expect_error([&] { parse_eye_csv(one_row(header + ",c7", cells + ",t"), "eye.csv"); },
               {"eye.csv, line 1, column 500004", "\"c7\" is there twice, in column 11 too"});
}

TEST(ManyInEyes, ColumnsOfOces) {
  constexpr int count = 200000;
  Eye eye;
  eye.position_m = {{0, 0, 0}};
  eye.axis = {{0, 0, -1}};
  eye.acceptance_angle_rad = {0.1f};
  eye.focal_offset_m = {0};
  eye.eye_id = {0};
  for (int i = count; i > 0; --i) eye.columns.push_back({"c" + std::to_string(i), {}, {"t"}});
  const Eye read = parse_oces(oces_bytes(eye, false), "eye.gltf");
  ASSERT_EQ(read.columns.size(), eye.columns.size());
  EXPECT_EQ(read.columns.front().name, "c" + std::to_string(count));  // in their order
  EXPECT_EQ(read.columns.back().name, "c1");
}

TEST(ManyInEyes, ReceptorTypes) {
  constexpr int count = 200000;
  std::string text, receptors;
  for (int i = 0; i < count; ++i) {
    const std::string name = "r" + std::to_string(i);
    text += "# receptor_type {\"name\":\"" + name + "\",\"peak_wavelength_nm\":500}\n";
    receptors += (i > 0 ? ";" : "") + name;
  }
  const Eye eye = parse_eye_csv(text + one_row(",receptors", "," + receptors), "eye.csv");
  ASSERT_EQ(eye.receptor_types.size(), static_cast<std::size_t>(count));
  EXPECT_EQ(eye.receptor_type.back(), count - 1);
  const Eye read = parse_eye_csv(eye_csv_text(eye), "again.csv");
  EXPECT_EQ(read.receptor_type, eye.receptor_type);
  const PlacedEye twice[] = {{eye, {}}, {eye, {}}};
  EXPECT_EQ(merge_eyes(twice).receptor_types.size(), eye.receptor_types.size());
}

TEST(ManyInEyes, Acceptances) {
  // All of one width and facet: they differ in what light passes.
  constexpr int count = 200000;
  std::string text =
      "azimuth_deg,elevation_deg,acceptance_angle_deg,kernel,kernel_facet_diameter_um,"
      "kernel_wavelength_nm\n";
  for (int i = 0; i < count; ++i) text += "0,0,1,airy,20," + decimal_text(400 + i / 1000.0) + "\n";
  const Eye eye = parse_eye_csv(text, "eye.csv");
  EXPECT_EQ(eye.acceptances.size(), static_cast<std::size_t>(count));
  const PlacedEye twice[] = {{eye, {}}, {eye, {}}};
  EXPECT_EQ(merge_eyes(twice).acceptances.size(), static_cast<std::size_t>(count));
}

TEST(ManyInEyes, MirrorPlanesAndPlaces) {
  // One eye of many ommatidia under many nodes is placed once for each, but grown once.
  json document = {{"asset", {{"version", "2.0"}}}};
  json& extension = document["extensions"]["OCES_eyes"];
  extension = {{"version", "0.4.0"},
               {"ommatidialProperties", {{{"type", "COARSE"}, {"value", 0.1}}}},
               {"eyes",
                {{{"ommatidialCount", 2000},
                  {"type", "SPHERICAL"},
                  {"ommatidialProperties", {{"DIAMETER", 0}}}}}}};
  document["nodes"] = {{{"extensions", {{"OCES_eyes", {{"head", true}}}}}}};
  for (int i = 1; i <= 300; ++i) {
    document["nodes"].push_back({{"extensions", {{"OCES_eyes", {{"eye", 0}}}}}});
    document["nodes"][0]["children"].push_back(i);
  }
  EXPECT_EQ(parse_oces(document.dump(), "eye.gltf").size(), 600000u);

  constexpr int planes = 100000;
  extension["eyes"][0]["ommatidialCount"] = 1;
  document["nodes"].erase(2);
  document["nodes"] = {document["nodes"][0], document["nodes"][1]};
  document["nodes"][0]["children"] = {1};
  for (int i = 0; i < planes; ++i) {
    extension["mirrorPlanes"].push_back({{"normal", "X"}});
    extension["eyes"][0]["mirrorPlanes"].push_back(i);
  }
  EXPECT_EQ(parse_oces(document.dump(), "eye.gltf").size(), planes + 1u);
}

}  // namespace
}  // namespace omma::test
