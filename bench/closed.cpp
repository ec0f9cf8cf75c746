// A hundred million rays from inside a closed surface, aimed at edges, faces and just beside
// corners, and ten million more at corners themselves: how many get out, of the portable search and
// of Embree. Of every sixteen one is also searched for alone.
#include <oneapi/tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "backend/denormals.h"
#include "backend/embree/embree_tracer.h"
#include "backend/shading_data.h"
#include "packet_search.h"
#include "physics/sampling/hash.h"
#include "scenes.h"

namespace omma::bench {
namespace {

// A bumpy ball without gaps, half a million triangles.
Scene bumpy_ball(std::uint32_t n) {
  Scene scene;
  Mesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i < 2 * n; ++i) {
      const double theta = pi * j / n, phi = pi * (j == 0 || j == n ? 0 : i) / n;
      const double ring = j == n ? 0 : std::sin(theta);
      const double r = 5 + 0.3 * std::sin(9 * phi) * ring * std::sin(7 * theta);
      mesh.positions.push_back(
          to_float({r * ring * std::cos(phi), r * std::cos(theta), r * ring * std::sin(phi)}));
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < 2 * n; ++i) {
      const std::uint32_t next = (i + 1) % (2 * n);
      const std::uint32_t a = j * 2 * n + i, b = j * 2 * n + next, c = a + 2 * n, d = b + 2 * n;
      if (j > 0) mesh.triangles.push_back({a, b, c});
      if (j < n - 1) mesh.triangles.push_back({b, d, c});
    }
  Material material;
  material.double_sided = true;
  scene.materials.push_back(material);
  mesh.material = 0;
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({"ball", 0, {}});
  return scene;
}

struct Draw {
  std::uint64_t state;
  double uniform() {
    state = hash_combine(state, 1);
    return static_cast<double>(state >> 11) * 0x1p-53;
  }
};

// Sixteen rays from one place: at an edge, along it; at a face; beside a corner; at corners.
void aim(const Mesh& mesh, int kind, Draw& draw, RayPacket<16>& packet) {
  const auto& t = mesh.triangles[static_cast<std::size_t>(
      draw.uniform() * static_cast<double>(mesh.triangles.size()))];
  const Vec3 origin = to_float({draw.uniform() - 0.5, draw.uniform() - 0.5, draw.uniform() - 0.5});
  for (int l = 0; l < 16; ++l) {
    Vec3d corner[3];
    for (std::size_t i = 0; i < 3; ++i) corner[i] = to_double(mesh.positions[t[i]]);
    const double u = draw.uniform(), v = kind == 1 ? (1 - u) * draw.uniform() : 0;
    Vec3d at = corner[0] * (1 - u - v) + corner[1] * u + corner[2] * v;
    if (kind == 2)
      at = corner[0] + Vec3d{draw.uniform() - 0.5, draw.uniform() - 0.5, draw.uniform() - 0.5} *
                           std::pow(10, -3 - l % 3);
    if (kind == 3) at = corner[l % 3];
    const Vec3 d = to_float(normalize(at - to_double(origin)));
    packet.origin[0][l] = origin.x, packet.origin[1][l] = origin.y, packet.origin[2][l] = origin.z;
    packet.direction[0][l] = d.x, packet.direction[1][l] = d.y, packet.direction[2][l] = d.z;
    packet.t_near_m[l] = 0;
    packet.t_far_m[l] = std::numeric_limits<float>::infinity();
    packet.mask[l] = 0xffffffffu;
    packet.geometry[l] = packet.instance[l] = none;
  }
}

}  // namespace

void closed(bool quick) {
  const std::int64_t rays = quick ? 1'000'000 : 100'000'000;
  const Scene scene = bumpy_ball(360);
  const auto shading = make_shading_data(scene);
  const Placement placement = placement_of(scene);
  const auto embree = make_embree_tracer(scene, shading->view, placement);
  const auto portable = make_portable_tracer(scene, shading->view, placement);
  const SearchFunctions search = portable_searches().back();
  const char* names[] = {"edges", "faces", "beside corners", "corners"};
  std::printf("aimed at,rays,portable lets out,one lane differs,embree lets out\n");
  for (int kind = 0; kind < 4; ++kind) {
    const std::int64_t packets = (kind < 3 ? rays / 3 : rays / 10) / 16, chunk = 1000;
    std::atomic<std::int64_t> out{0}, out_single{0}, out_embree{0};
    oneapi::tbb::parallel_for(std::int64_t{0}, (packets + chunk - 1) / chunk, [&](std::int64_t k) {
      const DenormalsAreZero denormals_are_zero;
      IntersectArguments arguments;
      alignas(64) int valid[16];
      for (int& v : valid) v = -1;
      Draw draw{hash_combine(static_cast<std::uint64_t>(kind), static_cast<std::uint64_t>(k))};
      for (std::int64_t p = k * chunk; p < std::min(packets, (k + 1) * chunk); ++p) {
        RayPacket<16> packet{};
        aim(scene.meshes[0], kind, draw, packet);
        RTCRayHit16 theirs;
        std::memcpy(&theirs, &packet, sizeof theirs);
        intersect_16(embree->scene, valid, theirs, arguments);
        const RayPacket<16> made = packet;
        search.closest_16(*portable, valid, &packet, 1);
        for (int l = 0; l < 16; ++l) {
          out += packet.geometry[l] == none;
          out_embree += theirs.hit.geomID[l] == RTC_INVALID_GEOMETRY_ID;
          if (l != p % 16) continue;  // one of sixteen, in one lane
          RayPacket<1> single{};
          for (int a = 0; a < 3; ++a) single.origin[a][0] = made.origin[a][l];
          for (int a = 0; a < 3; ++a) single.direction[a][0] = made.direction[a][l];
          single.t_far_m[0] = made.t_far_m[l];
          single.geometry[0] = none;
          search.closest_1(*portable, valid, &single, 1);
          out_single += (single.geometry[0] == none) != (packet.geometry[l] == none);
        }
      }
    });
    std::printf("%s,%lld,%lld,%lld,%lld\n", names[kind], static_cast<long long>(packets * 16),
                static_cast<long long>(out), static_cast<long long>(out_single),
                static_cast<long long>(out_embree));
    std::fflush(stdout);
  }
}

}  // namespace omma::bench
