// Runs the tests of rendering with one of the backends that are built in: --backend=NAME.
#include <gtest/gtest.h>

#include <cstring>

#include "test_scenes.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  constexpr const char* option = "--backend=";
  for (int i = 1; i < argc; ++i)
    if (std::strncmp(argv[i], option, std::strlen(option)) == 0)
      omma::test::backend_under_test = argv[i] + std::strlen(option);
  return RUN_ALL_TESTS();
}
