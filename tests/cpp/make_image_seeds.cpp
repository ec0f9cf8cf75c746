// Writes the images of every kind into a folder, for the fuzzers to start from:
//   cmake --build --preset default --target make_image_seeds
//   build/default/tests/cpp/make_image_seeds fuzz/seeds/image
#include <cstdio>
#include <fstream>

#include "encoded_images.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "expected a folder to write to\n");
    return 2;
  }
  for (const omma::test::EncodedKind& kind : omma::test::images_of_every_kind()) {
    std::ofstream file(std::string(argv[1]) + "/" + kind.name, std::ios::binary);
    file << kind.bytes;
    if (!file.flush()) return 1;
  }
}
