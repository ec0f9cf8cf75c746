// Loading that is watched and ended, and what loading in parallel must not change.
#include <random>
#include <thread>

#include "gltf_builder.h"

namespace omma::test {
namespace {

// A triangle with a material for each of the images, all of them read.
GltfBuilder with_images(const std::vector<std::string>& files) {
  GltfBuilder b = one_triangle();
  for (std::size_t i = 0; i < files.size(); ++i) {
    b.push("images", {{"uri", data_uri(files[i], "image/png")}});
    b.push("textures", {{"source", i}});
    b.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
  }
  return b;
}

// More vertices than one thread takes at a time, in more base64 than is decoded at a time.
GltfBuilder many_vertices(std::vector<float>& positions) {
  std::mt19937 random(1);
  positions.resize(3 * 150000);
  for (float& p : positions) p = static_cast<float>(random() % 20001) / 100 - 100;
  std::vector<std::uint32_t> indices(3 * 200000);
  for (std::uint32_t& i : indices) i = static_cast<std::uint32_t>(random() % 150000);
  GltfBuilder b;
  const int position = b.accessor<float>(positions, "VEC3");
  const int index = b.accessor<std::uint32_t>(indices, "SCALAR");
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", position}}}, {"indices", index}})}});
  return b;
}

TEST(GltfProgress, EndsAtOneOnTheCallersThread) {
  std::vector<double> shares;
  std::thread::id where;
  SceneOptions options;
  options.progress = [&](double share) {
    shares.push_back(share);
    where = std::this_thread::get_id();
    return true;
  };
  std::vector<float> positions;
  const Scene scene = load(many_vertices(positions), options);
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GE(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
  EXPECT_EQ(where, std::this_thread::get_id());
  EXPECT_EQ(triangle_count(scene), 200000u);
}

TEST(GltfProgress, FalseCancels) {
  SceneOptions options;
  options.progress = [](double) { return false; };
  EXPECT_THROW(load(one_triangle(), options), Cancelled);
  options.progress = [](double) -> bool { throw std::range_error("enough"); };
  EXPECT_THROW(load(one_triangle(), options), std::range_error);
}

TEST(GltfProgress, ErrorsAreStillErrors) {
  TemporaryFolder folder;
  SceneOptions options;
  options.progress = [](double) { return true; };
  EXPECT_THROW(load_scene((folder.path / "not-there.gltf").string(), options), Error);
  EXPECT_THROW(load_scene(folder.write("broken.gltf", "{"), options), Error);
}

TEST(GltfParallel, NumbersAreThoseOfTheFile) {
  std::vector<float> positions;
  const Scene scene = load(many_vertices(positions));
  const std::vector<Vec3>& loaded = scene.meshes.at(0).positions;
  ASSERT_EQ(loaded.size(), 150000u);
  for (std::size_t i = 0; i < loaded.size(); ++i)
    ASSERT_TRUE(loaded[i].x == positions[3 * i] && loaded[i].y == positions[3 * i + 1] &&
                loaded[i].z == positions[3 * i + 2])
        << "vertex " << i;
  // What Embree reads beyond the last vertex is there.
  EXPECT_GT(loaded.capacity(), loaded.size());
}

TEST(GltfParallel, TheFirstBadNumberIsNamed) {
  std::vector<float> positions;
  GltfBuilder b = many_vertices(positions);
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  for (const std::size_t vertex : {149000u, 140000u, 100001u})
    std::memcpy(b.binary.data() + 12 * vertex + 4, &not_a_number, 4);
  for (int i = 0; i < 5; ++i) expect_load_error(b, {"accessor 0", "element 100001 ", "not finite"});
}

TEST(GltfParallel, ImagesKeepTheirOrder) {
  std::vector<std::string> files;
  for (int i = 0; i < 24; ++i) {
    // Of very different sizes, so that they are not done in order.
    const int side = i % 3 == 0 ? 200 : 1;
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(4 * side * side),
                                     static_cast<std::uint8_t>(10 * i));
    files.push_back(png<std::uint8_t>(side, side, 4, pixels));
  }
  const Scene scene = load(with_images(files));
  ASSERT_EQ(scene.images.size(), files.size());
  for (int i = 0; i < 24; ++i) {
    const Image& image = scene.images[static_cast<std::size_t>(i)];
    EXPECT_EQ(image.width, i % 3 == 0 ? 200 : 1);
    EXPECT_EQ(image.rgba_srgb8.back(), 10 * i);
  }
}

TEST(GltfParallel, TheFirstBadImageIsNamed) {
  std::vector<std::string> files(24, png_1x1(1, 2, 3));
  for (const std::size_t bad : {23u, 5u, 17u}) files[bad] = files[bad].substr(0, 30);
  for (int i = 0; i < 5; ++i) expect_load_error(with_images(files), {"image 5"});
}

TEST(GltfGeometry, FewVerticesOfASparseAccessor) {
  // One triangle of 40 vertices, some of them replaced; two of its three are.
  GltfBuilder b;
  std::vector<float> positions(3 * 40);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = static_cast<float>(i);
  const int position = b.accessor<float>(positions, "VEC3");
  b.document["accessors"][0]["sparse"] = {
      {"count", 3},
      {"indices",
       {{"bufferView", b.view(bytes_of(std::vector<std::uint16_t>{2, 7, 30}))},
        {"componentType", 5123}}},
      {"values",
       {{"bufferView", b.view(bytes_of(std::vector<float>{-1, -2, -3, -4, -5, -6, -7, -8, -9}))}}}};
  const int index = b.accessor<std::uint16_t>({30, 2, 39}, "SCALAR");
  b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", position}}}, {"indices", index}})}});
  const Mesh mesh = load(b).meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 3u);  // in the order of the file
  expect_near(mesh.positions[0], Vec3{-1, -2, -3});
  expect_near(mesh.positions[1], Vec3{-7, -8, -9});
  expect_near(mesh.positions[2], Vec3{117, 118, 119});
  EXPECT_EQ(mesh.triangles.at(0), (std::array<std::uint32_t, 3>{1, 0, 2}));
}

}  // namespace
}  // namespace omma::test
