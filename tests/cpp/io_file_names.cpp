// Files on every system: names in any script and of any length, replaced while they are open, locks,
// and where links and the URIs of a scene lead.
#include "gltf_builder.h"
#include "io/atomic_file.h"
#include "io/whole_files.h"

namespace omma::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::path& name : system::names_in(folder)) names.push_back(system::text_of(name));
  std::sort(names.begin(), names.end());
  return names;
}

// German, Japanese, a combining accent, and a letter of four bytes, which Windows keeps as two.
constexpr const char* any_script = "Auge \u00e4\u00df \u8907\u773c e\u0301 \U0001f41d";

TEST(FileNames, InAnyScript) {
  const TemporaryFolder folder;
  const fs::path inside = folder.path / system::path_of(any_script);
  fs::create_directory(inside);
  const std::string name = std::string(any_script) + ".csv";
  const std::string path = system::text_of(inside / system::path_of(name));
  for (const char* text : {"one\n", "two\r\n\x1a three"}) {  // bytes, not lines, on every system
    write_file_atomically(path, std::string(text));
    EXPECT_EQ(read_file(path), text);
  }
  EXPECT_EQ(names_in(inside), (std::vector<std::string>{name}));
  EXPECT_EQ(names_in(folder.path), (std::vector<std::string>{any_script}));
  const std::string missing = system::text_of(inside / system::path_of("\u8907"));
  expect_error([&] { read_file(missing); }, {missing + ": there is no such file"});
}

// Folders with a path of over 300 characters, of which Windows takes 260 as they come. Removed one by
// one: the standard library of MinGW cannot.
class LongNames : public testing::Test {
 protected:
  LongNames() : inside(folder.path) {
    for (int i = 0; i < 5; ++i) {
      inside /= system::path_of(std::string(60, static_cast<char>('a' + i)) + "\u00e4");
      fs::create_directory(system::reachable(inside));
    }
  }
  ~LongNames() override {
    for (const fs::path& name : system::names_in(inside)) system::remove_file(inside / name);
    for (; inside != folder.path; inside = inside.parent_path())
      fs::remove(system::reachable(inside));
  }
  std::string path_of(const char* name) const { return system::text_of(inside / name); }

  const TemporaryFolder folder;
  fs::path inside;
};

TEST_F(LongNames, OfWholeFiles) {
  const std::string path = path_of("file.csv");
  ASSERT_GT(path.size(), 300u);
  for (const char* text : {"one", "two"}) {
    write_file_atomically(path, std::string(text));
    EXPECT_EQ(read_file(path), text);
  }
  WholeFiles files;
  files.write(files.open_kept(path, 0), std::string("three"));
  EXPECT_EQ(names_in(inside), (std::vector<std::string>{"file.csv", "file.csv.partial"}));
  EXPECT_EQ(kept_bytes(path), 5u);
  write_file_atomically(path_of(".file.csv.0123456789ab.partial"), std::string("xyz"));
  ASSERT_EQ(left_behind({path}).size(), 1u);
  EXPECT_EQ(left_behind({path})[0].bytes, 3u);
  files.finish();
  EXPECT_EQ(read_file(path), "three");
}

TEST_F(LongNames, OfASceneWithABufferBesideIt) {
  if (std::getenv("WINEPREFIX") != nullptr)
    GTEST_SKIP() << "Wine 8 cannot say where paths of over 260 characters lead";
  GltfBuilder b = one_triangle();
  write_file_atomically(path_of("data.bin"), bytes_of(triangle_positions));
  b.push("buffers", {{"byteLength", 36}, {"uri", "data.bin"}});
  write_file_atomically(path_of("scene.gltf"), b.gltf());
  EXPECT_EQ(load_scene(path_of("scene.gltf")).meshes.at(0).positions.size(), 3u);
}

TEST(WholeFiles, GetTheirNamesTogetherOrAreRemoved) {
  const TemporaryFolder folder;
  const std::string old = folder.write("old", "as it was");
  {
    WholeFiles files;
    files.write(files.open(old), std::string("new"));
    const std::size_t other = files.open((folder.path / "other").string());
    files.write(other, std::string("new"));
    files.close(other);
    EXPECT_EQ(names_in(folder.path).size(), 3u);
    EXPECT_EQ(read_file(old), "as it was");
  }
  EXPECT_EQ(names_in(folder.path), (std::vector<std::string>{"old"}));
  EXPECT_EQ(read_file(old), "as it was");
}

TEST(WholeFiles, OneAtATimeGoesOnWithWhatIsKept) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / "a").string();
  {
    WholeFiles files;
    const std::size_t file = files.open_kept(path, 0);
    files.write(file, std::string("12345"));
    EXPECT_EQ(files.sync(file), 5u);
    WholeFiles others;
    expect_error([&] { others.open_kept(path, 0); }, {"another process is writing it"});
    // A lock keeps nobody from reading.
    EXPECT_EQ(read_file(path + ".partial"), "12345");
  }
  EXPECT_EQ(kept_bytes(path), 5u);
  WholeFiles files;
  files.write(files.open_kept(path, 3), std::string("67"));
  files.finish();
  EXPECT_EQ(read_file(path), "12367");
  EXPECT_EQ(kept_bytes(path), 0u);
}

TEST(WholeFiles, ThoseOfALivingRunAreNotLeftBehind) {
  const TemporaryFolder folder;
  const std::string one = (folder.path / "1").string(), two = (folder.path / "2").string();
  const std::string left = folder.write(".1.0123456789ab.partial", "xyz");
  WholeFiles files;
  for (const std::string& path : {one, two}) {
    const std::size_t file = files.open(path);
    files.write(file, std::string("x"));
    files.close(file);
  }
  const std::vector<LeftBehind> found = left_behind({one, two});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(fs::path(found[0].path), fs::path(left));
  EXPECT_EQ(found[0].bytes, 3u);
}

TEST(FileNames, UrisStayInTheFolder) {
  for (const char* uri : {"../data.bin", "/data.bin", "sub/../../data.bin", "%2E%2E/data.bin",
                          "C:/data.bin", "file:data.bin"}) {
    GltfBuilder b = one_triangle();
    b.push("buffers", {{"byteLength", 36}, {"uri", uri}});
    expect_load_error(b, {"URI \"" + std::string(uri) + "\""});
  }
}

}  // namespace
}  // namespace omma::test
