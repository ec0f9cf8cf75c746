// The portable search meets what Embree meets: on the bundled meadow, CompoundRay's scenes, and
// made ones with everything that a scene can hold. What differs is counted: rays that graze an edge
// within rounding, and may meet the surface on one side of it or the other.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "backend/embree/embree_tracer.h"
#include "omma/io.h"
#include "portable_rays.h"

namespace omma::test {
namespace {

struct Agreement {
  std::size_t rays = 0, hits = 0;
  std::size_t missed = 0;      // met by Embree alone
  std::size_t added = 0;       // met by us alone
  std::size_t elsewhere = 0;   // met at another distance
  std::size_t neighbours = 0;  // another triangle at the same distance
};

TestHit embree_hit(const RayPacket<16>& packet, const EmbreeTracer& tracer, int l) {
  TestHit hit = hit_of(packet, l);
  if (hit.placed == none) return hit;
  const std::uint32_t top = packet.instance[l] != none ? packet.instance[l] : hit.placed;
  hit.placed = static_cast<std::uint32_t>(tracer.layout.placed[top].mesh);
  return hit;
}

Agreement compare(const Scene& from, int packets, std::uint64_t seed) {
  const TracedScene traced(from);
  const auto embree = make_embree_tracer(traced.scene, traced.shading->view, traced.placement);
  const Bounds box = scene_bounds(traced.scene);
  const Vec3d middle = (box.lower + box.upper) * 0.5 - traced.placement.origin_m,
              half = (box.upper - box.lower) * 0.5;
  Random random{seed};
  Agreement a;
  const SearchFunctions search = portable_searches().back();
  for (int p = 0; p < packets; ++p) {
    const Vec3d place =
        middle + Vec3d{half.x * random.uniform(-0.7, 0.7), half.y * random.uniform(-0.9, 0.9),
                       half.z * random.uniform(-0.7, 0.7)};
    const Vec3d towards = random.direction();
    RayPacket<16> ours{};
    alignas(64) int valid[16];
    for (int l = 0; l < 16; ++l) {
      valid[l] = -1;
      put_ray(ours, l, {to_float(place), to_float(normalize(towards + random.direction() * 0.03))});
      ours.mask[l] = 0xffffffffu;
      ours.id[l] = static_cast<std::uint32_t>(l);
    }
    RayPacket<16> theirs = ours;
    IntersectArguments arguments;
    RTCRayHit16 rays;
    std::memcpy(&rays, &theirs, sizeof rays);
    intersect_16(embree->scene, valid, rays, arguments);
    std::memcpy(static_cast<void*>(&theirs), &rays, sizeof rays);
    search.closest_16(*traced.tracer, valid, &ours, 1);
    for (int l = 0; l < 16; ++l) {
      TestHit own = hit_of(ours, l);
      const TestHit their = embree_hit(theirs, *embree, l);
      ++a.rays;
      a.missed += own.placed == none && their.placed != none;
      a.added += own.placed != none && their.placed == none;
      if (own.placed == none || their.placed == none) continue;
      ++a.hits;
      own.placed = static_cast<std::uint32_t>(traced.tracer->layout.placed[own.placed].mesh);
      // Places are rounded too, to about 1e-7 of the scene's size.
      const double apart_m =
          std::fabs(static_cast<double>(own.t_m) - static_cast<double>(their.t_m));
      if (apart_m > 1e-4 * static_cast<double>(their.t_m) + 1e-6 * length(half))
        ++a.elsewhere;
      else if (own.triangle != their.triangle || own.placed != their.placed)
        ++a.neighbours;
      else
        EXPECT_GT(own.normal[0] * their.normal[0] + own.normal[1] * their.normal[1] +
                      own.normal[2] * their.normal[2],
                  0)
            << "normals look opposite ways";
    }
  }
  return a;
}

// Of 1.9 million rays, on the day this was written, none met anything else, and one the neighbour
// on the other side of an edge. Embree rounds otherwise on other processors, so a few may graze an
// edge to another outcome.
void expect_agreement(const std::string& name, const Agreement& a) {
  EXPECT_GT(a.hits, a.rays / 20) << name;
  EXPECT_LE(a.missed + a.added + a.elsewhere, a.rays / 20000) << name;
  EXPECT_LE(a.neighbours, 1 + a.rays / 20000) << name;
}

TEST(PortableEmbree, BundledMeadow) {
  expect_agreement("meadow.glb", compare(load_scene(OMMA_EXAMPLES "/meadow.glb"), 12000, 1));
}

TEST(PortableEmbree, CompoundRaysScenes) {
  const std::filesystem::path folder = std::string(OMMA_SHARED_DATA) + "/compound-ray/scenes";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no scenes in " << folder;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string kind = entry.path().extension().string();
    if (kind != ".gltf" && kind != ".glb") continue;
    expect_agreement(entry.path().filename().string(),
                     compare(load_scene(entry.path().string()), 12000, 2));
  }
}

TEST(PortableEmbree, ScenesOfEverything) {
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    expect_agreement("random scene " + std::to_string(seed),
                     compare(random_scene(seed), 3000, seed));
}

}  // namespace
}  // namespace omma::test
