// The one writer on POSIX systems: what is on the disk when, links, permissions, and what killed runs
// leave behind. What all systems have is in io_file_names.cpp.
#include "io/whole_files.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <memory>

#include "gltf_builder.h"
#include "io/atomic_file.h"

namespace {

// What was synced and renamed, in this order: instead of the system's own, which it calls.
std::vector<std::string>& calls() {
  static std::vector<std::string> made;
  return made;
}

}  // namespace

extern "C" int fsync(int descriptor) {
  const std::filesystem::path link = "/proc/self/fd/" + std::to_string(descriptor);
  calls().push_back("sync " + std::filesystem::read_symlink(link).string());
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

extern "C" int rename(const char* from, const char* to) {
  calls().push_back(std::string("rename ") + to);
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

namespace omma::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

mode_t mode_of(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(stat(path.c_str(), &status), 0);
  return status.st_mode & 07777;
}

// Runs something in a process of its own that ends without cleaning up, as one that is killed.
template <typename Work>
void in_killed_process(const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(WholeFiles, AreOnTheDiskBeforeTheyGetTheirNames) {
  const TemporaryFolder folder;
  const fs::path where = fs::canonical(folder.path);
  WholeFiles files;
  files.write(files.open((where / "a").string()), std::string("1"));
  files.write(files.open((where / "b").string()), std::string("2"));
  calls().clear();
  files.finish();
  ASSERT_EQ(calls().size(), 5u);
  EXPECT_TRUE(calls()[0].starts_with("sync " + (where / ".a.").string())) << calls()[0];
  EXPECT_TRUE(calls()[1].starts_with("sync " + (where / ".b.").string())) << calls()[1];
  EXPECT_EQ(calls()[2], "rename " + (where / "a").string());
  EXPECT_EQ(calls()[3], "rename " + (where / "b").string());
  EXPECT_EQ(calls()[4], "sync " + where.string());
  EXPECT_EQ(names_in(where), (std::vector<std::string>{"a", "b"}));
}

TEST(WholeFiles, MoreThanAProcessMayHaveOpen) {
  const TemporaryFolder folder;
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  rlimit small = limit;
  small.rlim_cur = 64;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &small), 0);
  WholeFiles files;
  for (int i = 0; i < 200; ++i) {
    const std::size_t file = files.open((folder.path / std::to_string(i)).string());
    files.write(file, std::string("x"));
    files.close(file);
  }
  files.finish();
  setrlimit(RLIMIT_NOFILE, &limit);
  EXPECT_EQ(names_in(folder.path).size(), 200u);
}

TEST(WholeFiles, WhatTheDiskHasNoPlaceForLeavesNothing) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / "large").string();
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  rlimit small = limit;
  small.rlim_cur = 1000;
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_file_atomically(path, std::string(2000, 'x')), Error);
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(names_in(folder.path).empty());
}

TEST(WholeFiles, LinksStayAlsoWhereTheyLeadToNothingYet) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path / "far");
  fs::create_symlink("far/target", folder.path / "link");
  fs::create_symlink("link", folder.path / "chain");
  for (const char* text : {"first", "second"}) {
    write_file_atomically((folder.path / "chain").string(), std::string(text));
    EXPECT_TRUE(fs::is_symlink(folder.path / "link"));
    EXPECT_TRUE(fs::is_symlink(folder.path / "chain"));
    EXPECT_EQ(read_file((folder.path / "far/target").string()), text);
  }
  fs::create_symlink("round", folder.path / "round");
  EXPECT_THROW(write_file_atomically((folder.path / "round").string(), std::string("x")), Error);
}

TEST(WholeFiles, PermissionsAreKept) {
  const TemporaryFolder folder;
  const std::string path = folder.write("old", "x"), fresh = (folder.path / "new").string();
  const mode_t mask = umask(027);
  for (const mode_t mode : {0600u, 0644u, 0666u, 0755u}) {
    ASSERT_EQ(chmod(path.c_str(), mode), 0);
    write_file_atomically(path, std::string("y"));
    EXPECT_EQ(mode_of(path), mode);
  }
  write_file_atomically(fresh, std::string("y"));
  umask(mask);
  EXPECT_EQ(mode_of(fresh), 0640u);
}

TEST(WholeFiles, OwnersAreKept) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  const TemporaryFolder folder;
  const std::string path = folder.write("old", "x");
  ASSERT_EQ(chown(path.c_str(), 1234, 2345), 0);
  write_file_atomically(path, std::string("y"));
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 1234u);
  EXPECT_EQ(status.st_gid, 2345u);
}

TEST(WholeFiles, PipesAndDevicesAreRefused) {
  const TemporaryFolder folder;
  const std::string pipe = (folder.path / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path : {pipe, std::string("/dev/null"), std::string("/dev/stdout")}) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode)) continue;  // > into a file
    try {
      write_file_atomically(path, std::string("x"));
      ADD_FAILURE() << path << " was written";
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), path + ": cannot be written: it is not a regular file");
    }
  }
  EXPECT_EQ(names_in(folder.path), (std::vector<std::string>{"pipe"}));
}

TEST(WholeFiles, LongNames) {
  const TemporaryFolder folder;
  std::string name(255, 'a');
  for (std::size_t i = 1; i + 1 < name.size(); i += 2) name.replace(i, 2, "\u00e4");
  write_file_atomically((folder.path / name).string(), std::string("x"));
  EXPECT_EQ(names_in(folder.path), (std::vector<std::string>{name}));
  in_killed_process([&] {
    auto* files = new WholeFiles;
    files->open((folder.path / name).string());
  });
  EXPECT_EQ(left_behind({(folder.path / name).string()}).size(), 1u);
  // Files of one call that differ in their ends.
  const std::string first = std::string(246, 'b') + ".npy",
                    second = std::string(246, 'b') + ".json";
  WholeFiles both;
  for (const std::string& one : {first, second})
    both.close(both.open((folder.path / one).string()));
  both.finish();
  EXPECT_TRUE(fs::exists(folder.path / first) && fs::exists(folder.path / second));
}

TEST(WholeFiles, WhatKilledRunsLeaveIsFound) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path / "series");
  const std::string a = (folder.path / "a.npy").string(), b = (folder.path / "b.npy").string(),
                    one = (folder.path / "series/1.png").string(),
                    two = (folder.path / "series/2.png").string();
  in_killed_process([&] {
    auto* files = new WholeFiles;
    files->write(files->open(a), std::string(1000, 'x'));
    files->open(b);
  });
  ASSERT_EQ(left_behind({a}).size(), 1u);
  EXPECT_EQ(left_behind({a})[0].bytes, 1000u);
  EXPECT_EQ(left_behind({a, b}).size(), 2u);
  EXPECT_TRUE(left_behind({one}).empty());
  EXPECT_TRUE(fs::exists(left_behind({a})[0].path));

  // One that still goes on is none of them, its closed files neither.
  WholeFiles files;
  files.open(a);
  for (const std::string& path : {one, two}) files.close(files.open(path));
  EXPECT_EQ(left_behind({a}).size(), 1u);
  EXPECT_TRUE(left_behind({one, two}).empty());
  // What only looks alike is not either.
  folder.write(".a.npy.partial", "");
  folder.write(".a.npy.0123456789ax.partial", "");
  folder.write(".a.npyx.0123456789ab.partial", "");
  EXPECT_EQ(left_behind({a}).size(), 1u);
}

TEST(WholeFiles, AForkedChildRemovesNothingOfItsParents) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / "a").string();
  auto files = std::make_unique<WholeFiles>();
  files->write(files->open(path), std::string("x"));
  in_killed_process([&] { files.reset(); });
  files->finish();
  EXPECT_EQ(read_file(path), "x");
}

}  // namespace
}  // namespace omma::test
