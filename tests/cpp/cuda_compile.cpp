// How kernels of a card are compiled and kept, with a stand-in for NVRTC; that the real one
// compiles them is tested in tests/python/test_kernels.py.
#include "backend/cuda/compile.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "backend/cuda/kernel_sources.h"
#include "io/atomic_file.h"
#include "omma/error.h"
#include "omma/io.h"
#include "threads/parallel.h"

namespace omma {
namespace {

namespace fs = std::filesystem;

class CudaCompile : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::temp_directory_path() / ("omma-kernels-" + std::to_string(getpid()) + name);
    fs::remove_all(folder_);
    unsetenv("OMMA_NVRTC");
    unsetenv("STAND_IN_NVRTC");
  }
  void TearDown() override {
    std::error_code error;
    fs::permissions(folder_, fs::perms::owner_all, error);
    fs::remove_all(folder_);
    unsetenv("OMMA_NVRTC");
    unsetenv("STAND_IN_NVRTC");
  }

  std::string cache() const { return (folder_ / "cache/kernels").string(); }
  // The one file that is kept.
  std::string kept() const { return fs::directory_iterator(cache())->path().string(); }
  static std::string error_of(int capability, const std::string& nvrtc) {
    try {
      compile_kernels(capability, nvrtc, "");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

const std::string stand_in = OMMA_STAND_IN_NVRTC;

TEST(KernelSources, AreThoseOnDisk) {
  std::set<std::string> names;
  for (const KernelSource& source : kernel_sources()) {
    names.insert(source.name);
    std::string path;
    for (const char* room : {"/src/", "/include/", "/src/backend/cuda/device_headers/"})
      if (path.empty() && fs::exists(OMMA_ROOT + std::string(room) + source.name))
        path = OMMA_ROOT + std::string(room) + source.name;
    ASSERT_FALSE(path.empty()) << source.name;
    EXPECT_EQ(source.text, read_file(path)) << path;
  }
  EXPECT_STREQ(kernel_sources()[0].name, "backend/cuda/kernels.cu");
  EXPECT_TRUE(names.contains("physics/block/grid.h"));
  EXPECT_TRUE(names.contains("omma/vec.h"));
  EXPECT_TRUE(names.contains("cstdint"));
}

TEST_F(CudaCompile, IsForTheCard) {
  const CompiledKernels compiled = compile_kernels(80, stand_in, "");
  EXPECT_NE(compiled.cubin.find("--fmad=false "), std::string::npos) << compiled.cubin;
  EXPECT_NE(compiled.cubin.find("-arch=sm_80 "), std::string::npos) << compiled.cubin;
  EXPECT_EQ(compiled.note, "");
  // What is compiled for a card runs on later ones of its generation.
  EXPECT_NE(compile_kernels(89, stand_in, "").cubin.find("-arch=sm_86 "), std::string::npos);
}

TEST_F(CudaCompile, CardsThatNvrtcDoesNotKnow) {
  for (const int capability : {70, 90, 121}) {
    const std::string error = error_of(capability, stand_in);
    EXPECT_NE(error.find("NVRTC 13.0 does not compile for a card of compute capability " +
                         std::to_string(capability / 10) + "." + std::to_string(capability % 10)),
              std::string::npos)
        << error;
  }
}

TEST_F(CudaCompile, NvrtcIsMissing) {
  const std::string error = error_of(80, "/nowhere/libnvrtc.so.13");
  EXPECT_NE(error.find("/nowhere/libnvrtc.so.13"), std::string::npos) << error;
  EXPECT_NE(error.find("pip install 'omma[cuda]'"), std::string::npos) << error;
}

TEST_F(CudaCompile, TheEnvironmentNamesNvrtc) {
  setenv("OMMA_NVRTC", stand_in.c_str(), 1);
  EXPECT_EQ(error_of(80, "/nowhere/libnvrtc.so.13"), "");
  setenv("OMMA_NVRTC", "/other/libnvrtc.so", 1);
  EXPECT_NE(error_of(80, stand_in).find("/other/libnvrtc.so"), std::string::npos);
}

TEST_F(CudaCompile, FilesThatAreNotNvrtc) {
  fs::create_directories(folder_);
  const std::string text = (folder_ / "libnvrtc.so.13").string();
  std::ofstream(text) << "not a library";
  EXPECT_NE(error_of(80, text).find(text), std::string::npos);
  const std::string error = error_of(80, "libm.so.6");
  EXPECT_NE(error.find("libm.so.6: is not NVRTC"), std::string::npos) << error;
}

TEST_F(CudaCompile, FailuresSayTheLog) {
  setenv("STAND_IN_NVRTC", "fails", 1);
  const std::string error = error_of(80, stand_in);
  EXPECT_NE(error.find("grid.h(1): error: the stand-in fails"), std::string::npos) << error;
  EXPECT_THROW(compile_kernels(80, stand_in, cache()), Error);
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(CudaCompile, IsCancelled) {
  const std::atomic<bool> cancelled = true;
  const TakingPart part(&cancelled);
  EXPECT_THROW(compile_kernels(80, stand_in, cache()), Cancelled);
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(CudaCompile, IsKept) {
  const std::string first = compile_kernels(80, stand_in, cache()).cubin;
  EXPECT_EQ(compile_kernels(80, stand_in, cache()).cubin, first);
  EXPECT_NE(compile_kernels(80, stand_in, "").cubin, first);
  EXPECT_NE(compile_kernels(75, stand_in, cache()).cubin, first);
  const auto files = std::distance(fs::directory_iterator(cache()), fs::directory_iterator());
  EXPECT_EQ(files, 2);
}

TEST_F(CudaCompile, DamagedFilesAreCompiledAnew) {
  const std::string whole = [&] {
    compile_kernels(80, stand_in, cache());
    return read_file(kept());
  }();
  std::string changed = whole;
  changed.back() ^= 1;
  std::string last = whole;
  for (const std::string& damaged : {whole.substr(0, whole.size() - 1), whole.substr(0, 20),
                                     changed, std::string(), "x" + whole}) {
    write_file_atomically(kept(), damaged);
    const CompiledKernels compiled = compile_kernels(80, stand_in, cache());
    EXPECT_EQ(compiled.note, "");
    EXPECT_NE(read_file(kept()), damaged);
    EXPECT_NE(read_file(kept()), last);  // it counts
    last = read_file(kept());
    EXPECT_EQ(compile_kernels(80, stand_in, cache()).cubin, compiled.cubin);
  }
}

TEST_F(CudaCompile, FoldersThatCannotBeWritten) {
  // A file where the folder is to be: root may write into every folder.
  fs::create_directories(folder_);
  std::ofstream(folder_ / "cache") << "a file";
  const CompiledKernels compiled = compile_kernels(80, stand_in, cache());
  EXPECT_FALSE(compiled.cubin.empty());
  EXPECT_NE(compiled.note.find(cache() + ": cannot be made"), std::string::npos) << compiled.note;
}

}  // namespace
}  // namespace omma
