// How kernels of a card are compiled and kept, with a stand-in for NVRTC; that the real one
// compiles them is tested in tests/python/test_kernels.py.
#include "backend/cuda/compile.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
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
      compile_kernels({capability, nvrtc});
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
  const CompiledKernels compiled = compile_kernels({80, stand_in});
  EXPECT_NE(compiled.cubin.find("--fmad=false "), std::string::npos) << compiled.cubin;
  EXPECT_NE(compiled.cubin.find("-arch=sm_80 "), std::string::npos) << compiled.cubin;
  EXPECT_EQ(compiled.note, "");
  // What is compiled for a card runs on later ones of its generation.
  EXPECT_NE(compile_kernels({89, stand_in}).cubin.find("-arch=sm_86 "), std::string::npos);
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
  const std::string error = error_of(80, stand_in);
  EXPECT_NE(error.find("/other/libnvrtc.so"), std::string::npos) << error;
  EXPECT_NE(error.find("OMMA_NVRTC names it"), std::string::npos) << error;
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
  EXPECT_THROW(compile_kernels({80, stand_in, cache()}), Error);
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(CudaCompile, IsCancelled) {
  const std::atomic<bool> cancelled = true;
  const TakingPart part(&cancelled);
  EXPECT_THROW(compile_kernels({80, stand_in, cache()}), Cancelled);
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(CudaCompile, IsKept) {
  const std::string first = compile_kernels({80, stand_in, cache()}).cubin;
  EXPECT_EQ(compile_kernels({80, stand_in, cache()}).cubin, first);
  EXPECT_NE(compile_kernels({80, stand_in}).cubin, first);
  EXPECT_NE(compile_kernels({75, stand_in, cache()}).cubin, first);
  const auto files = std::distance(fs::directory_iterator(cache()), fs::directory_iterator());
  EXPECT_EQ(files, 2);
}

// Kernels that came with Omma: what was kept, in a folder that is only read.
class PackagedKernels : public CudaCompile {
 protected:
  // For these architectures; each is another cubin.
  void package(std::initializer_list<int> capabilities) {
    for (const int capability : capabilities)
      cubins_[capability] = compile_kernels({capability, stand_in, cache()}).cubin;
  }
  // By a driver of CUDA 13, without NVRTC.
  std::string found(int capability, int cuda = 13) const {
    return packaged_kernels({capability, nowhere, "", cache(), cuda}, render_program).value_or("");
  }

  const std::string nowhere = "/nowhere/libnvrtc.so.13";
  std::map<int, std::string> cubins_;
};

TEST_F(PackagedKernels, NeedNoNvrtc) {
  package({80});
  EXPECT_EQ(compile_kernels({80, nowhere, "", cache(), 13}).cubin, cubins_[80]);
  EXPECT_FALSE(compiling_kernels());
  // The other program is not there.
  EXPECT_THROW(compile_kernels({80, nowhere, "", cache(), 13}, gather_program), Error);
}

TEST_F(PackagedKernels, AreForTheNearestArchitecture) {
  package({75, 80});
  EXPECT_EQ(found(86), cubins_[80]);
  package({86});
  EXPECT_EQ(found(86), cubins_[86]);
  EXPECT_EQ(found(89), cubins_[86]);
  EXPECT_EQ(found(80), cubins_[80]);
  EXPECT_EQ(found(75), cubins_[75]);
  for (const int capability : {70, 90, 120}) EXPECT_EQ(found(capability), "");
}

TEST_F(PackagedKernels, AreNotOfANewerCudaThanTheDrivers) {
  package({80});
  EXPECT_EQ(found(80, 12), "");
  EXPECT_EQ(found(80, 14), cubins_[80]);
}

TEST_F(PackagedKernels, OfOtherSourcesAreLeft) {
  package({80});
  const fs::path own = kept();
  std::string name = own.filename().string();
  name[name.find('-') + 1] ^= 1;  // of the hash
  fs::rename(own, own.parent_path() / name);
  EXPECT_EQ(found(80), "");
  const CompiledKernels compiled = compile_kernels({80, stand_in, "", cache(), 13});
  EXPECT_NE(compiled.cubin, cubins_[80]);
}

TEST_F(PackagedKernels, DamagedOnesAreCompiled) {
  package({80, 86});
  for (const auto& entry : fs::directory_iterator(cache())) {
    const std::string path = entry.path().string();
    if (path.find("sm_86") != std::string::npos)
      write_file_atomically(path, read_file(path) + "more");
  }
  EXPECT_EQ(found(86), cubins_[80]);  // which runs there too
  for (const auto& entry : fs::directory_iterator(cache()))
    write_file_atomically(entry.path().string(), "");
  EXPECT_EQ(found(86), "");
  const std::string own = (folder_ / "own").string();
  const std::string compiled = compile_kernels({86, stand_in, own, cache(), 13}).cubin;
  EXPECT_NE(compiled.find("-arch=sm_86 "), std::string::npos) << compiled;
  EXPECT_TRUE(fs::exists(own));  // kept in the user's folder
}

TEST_F(CudaCompile, DamagedFilesAreCompiledAnew) {
  const std::string whole = [&] {
    compile_kernels({80, stand_in, cache()});
    return read_file(kept());
  }();
  std::string changed = whole;
  changed.back() ^= 1;
  std::string last = whole;
  for (const std::string& damaged : {whole.substr(0, whole.size() - 1), whole.substr(0, 20),
                                     changed, std::string(), "x" + whole}) {
    write_file_atomically(kept(), damaged);
    const CompiledKernels compiled = compile_kernels({80, stand_in, cache()});
    EXPECT_EQ(compiled.note, "");
    EXPECT_NE(read_file(kept()), damaged);
    EXPECT_NE(read_file(kept()), last);  // it counts
    last = read_file(kept());
    EXPECT_EQ(compile_kernels({80, stand_in, cache()}).cubin, compiled.cubin);
  }
}

TEST_F(CudaCompile, FoldersThatCannotBeWritten) {
  // A file where the folder is to be: root may write into every folder.
  fs::create_directories(folder_);
  std::ofstream(folder_ / "cache") << "a file";
  const CompiledKernels compiled = compile_kernels({80, stand_in, cache()});
  EXPECT_FALSE(compiled.cubin.empty());
  EXPECT_NE(compiled.note.find(cache() + ": cannot be made"), std::string::npos) << compiled.note;
}

}  // namespace
}  // namespace omma
