// How much memory a file takes while it is read, as POSIX systems tell it.
#include <sys/resource.h>

#include "gltf_builder.h"

namespace omma::test {
namespace {

long peak_memory_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(GltfBudget, BuffersThatNameOneFileShareIt) {
  // 200 buffers, one file of 8 MiB, under several of its names: 1.6 GB if each were read.
  constexpr std::size_t count = 200, size = std::size_t{1} << 23;
  const TemporaryFolder folder;
  folder.write("data.bin", bytes_of(triangle_positions));
  std::filesystem::resize_file(folder.path / "data.bin", size);
  std::filesystem::create_directory(folder.path / "sub");
  std::filesystem::create_symlink("data.bin", folder.path / "link.bin");
  GltfBuilder b;
  for (std::size_t i = 0; i < count; ++i) {
    constexpr std::array<const char*, 4> names = {"data.bin", "./data.bin", "sub/../data%2Ebin",
                                                  "link.bin"};
    b.push("buffers", {{"byteLength", size}, {"uri", names[i % names.size()]}});
    const int view = b.push("bufferViews", {{"buffer", i}, {"byteLength", 36}});
    const int positions =
        b.push("accessors",
               {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
    b.root({{"mesh", b.mesh({{"attributes", {{"POSITION", positions}}}})}});
  }
  const long before_kb = peak_memory_kb();
  EXPECT_EQ(triangle_count(load_scene(folder.write("scene.gltf", b.gltf()))), count);
  EXPECT_LT(peak_memory_kb() - before_kb, 400000);  // ample for one, a quarter of all
}

}  // namespace
}  // namespace omma::test
