// What scripts/bench runs: measures one thing and prints it as CSV.
//
//   omma_bench ceiling|error|frames|latency|threads|kernels|moving|search|closed|worlds|
//              sun_map [--quick]
//   omma_bench build NAME SCENE
//   omma_bench instructions 1|16|16-plain|16-random|16-shared|target
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "scenes.h"

int main(int argc, char** argv) {
  using namespace omma::bench;
  const std::string part = argc > 1 ? argv[1] : "";
  const bool quick = argc == 3 && std::strcmp(argv[2], "--quick") == 0;
  try {
    if (part == "build" && argc == 4) {
      build(argv[2], argv[3]);
      return 0;
    }
    if (part == "instructions" && argc == 3) {
      instructions(argv[2]);
      return 0;
    }
    if (argc == 2 || quick) {
      if (part == "ceiling") return ceiling(quick), 0;
      if (part == "error") return error(quick), 0;
      if (part == "frames") return frames(quick), 0;
      if (part == "latency") return latency(quick), 0;
      if (part == "threads") return threads(quick), 0;
      if (part == "kernels") return kernels(quick), 0;
      if (part == "search") return search(quick), 0;
      if (part == "moving") return moving(quick), 0;
      if (part == "closed") return closed(quick), 0;
      if (part == "worlds") return worlds(quick), 0;
      if (part == "sun_map") return sun_map(quick), 0;
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "omma_bench: %s\n", e.what());
    return 1;
  }
  std::fprintf(stderr,
               "omma_bench ceiling|error|frames|latency|threads|kernels|moving|search|closed|worlds|sun_map "
               "[--quick]\n"
               "omma_bench build NAME SCENE\n"
               "omma_bench instructions 1|16|16-plain|16-random|16-shared|target\n");
  return 2;
}
