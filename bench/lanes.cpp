// A fixed small render on one thread by the portable search, in one build of the hot loop: how many
// instructions a build takes is counted by scripts/lanes (callgrind, or QEMU where the processor is
// another). Prints a hash of the responses, the same for every build and processor.
//
//   omma_lanes baseline|plain|avx2|avx512 unlit|lit POSES
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "backend/eye_arrays.h"
#include "backend/portable/portable_builds.h"
#include "backend/processor.h"
#include "light_maps.h"
#include "omma/error.h"
#include "sampling/directions.h"
#include "scenes.h"
#include "threads/thread_memory.h"
#include "world/world_state.h"

namespace omma::bench {
namespace {

BlockFunctions block_of(const std::string& build) {
  if (build == "baseline") return baseline::portable_block();
  if (build == "plain") return plain::portable_block();
#if defined(__x86_64__)
  if (build == "avx2" && has_avx2()) return avx2::portable_block();
  if (build == "avx512" && has_avx512()) return avx512::portable_block();
#endif
  throw Error("expected a build that runs on this processor, found " + build);
}

// A sky that is bright above and dim below, polarised, in three bands.
Lighting sky() {
  Lighting lighting;
  lighting.light.bands = test::narrow_bands(3);
  lighting.light.sky = test::made_sky(24, 7, 3, 3, [](int half, int row, int column, int k, int) {
    return (half == 0 ? 1.0 : 0.2) * (k == 0 ? 1.0 + 0.1 * row : 0.02 * ((column + k) % 5));
  });
  lighting.polarized = true;
  lighting.depth = 2;
  return lighting;
}

void render(const std::string& build, bool is_lit, int poses) {
  const BlockFunctions block = block_of(build);
  const Setup setup = hills(100);
  WorldSettings settings;
  settings.threads = 1;
  settings.backend = "portable";
  if (is_lit) settings.lighting = sky();
  const World world(setup.scene, settings);
  const Eye eye = even_eye(512);
  const DirectionTables directions = make_direction_tables(eye, {}, 16);
  const EyeArrays arrays = make_eye_arrays(eye, directions);
  const DirectionsView directions_view = view(directions);
  const EyeView eye_view = view(arrays);
  FrameView frame{&world.state().view, &eye_view, &directions_view};
  frame.outputs = world.bands() * (is_lit ? 3 : 1);
  std::vector<float> responses(eye.size() * static_cast<std::size_t>(frame.outputs));
  std::uint64_t hash = 0xCBF29CE484222325u;  // FNV-1a
  const std::vector<Mat4> path = flight(setup, static_cast<std::size_t>(poses));
  for (std::size_t p = 0; p < path.size(); ++p) {
    BlockTask task;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 4; ++k)
        task.world_from_head[i][k] = static_cast<float>(path[p].m[i][k]);
    task.pose = p;
    task.count = 64;
    task.responses = responses.data();
    for (; task.first < static_cast<int>(eye.size()); task.first += task.count)
      block.render(frame, task, world.state().built->acceleration.tracer.get(),
                   thread_memory(block_memory_bytes(frame)));
    for (const float value : responses) {
      unsigned char bytes[sizeof value];
      std::memcpy(bytes, &value, sizeof value);
      for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001B3u;
    }
  }
  std::printf("%016llx\n", static_cast<unsigned long long>(hash));
}

}  // namespace
}  // namespace omma::bench

int main(int argc, char** argv) {
  const std::string light = argc == 4 ? argv[2] : "";
  if (light != "unlit" && light != "lit") {
    std::fprintf(stderr, "omma_lanes baseline|plain|avx2|avx512 unlit|lit POSES\n");
    return 2;
  }
  try {
    omma::bench::render(argv[1], light == "lit", std::atoi(argv[3]));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "omma_lanes: %s\n", e.what());
    return 1;
  }
}
