// The shadow map of the sun in the bundled meadow: time and memory to make it, what a bee sees by
// it against shadow rays to the middle of the sun, and the time to look a hit up.
#include "backend/make_sun_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "backend/embree/embree_backend.h"
#include "backend/embree/embree_tracer.h"
#include "backend/shading_data.h"
#include "physics/path/path.h"
#include "physics/sampling/hash.h"
#include "scenes.h"

namespace omma::bench {
namespace {

using L = Lanes<16, lane_width>;
constexpr int packets_each = 4;  // of an ommatidium

struct Draw {
  std::uint64_t state;
  double uniform() {
    state = hash_combine(state, 1);
    return static_cast<double>(state >> 11) * 0x1p-53;
  }
};

// What the rays of all ommatidia met, and how much of the light of the sun arrives there.
struct Seen {
  std::vector<HitGeometry<L>> geometry;     // [ommatidium][packets_each]
  std::vector<std::array<float, 16>> full;  // the same: cosine to the sun, 0 where nothing was met
  std::vector<std::array<float, 16>> lit;   // 1 where nothing lies between
};

Seen look(const Setup& setup, const EmbreeTracer& tracer, const SceneView& view,
          const Placement& placement, const BlockFunctions& functions, Vec3d sun) {
  Seen seen;
  Draw draw{7};
  const Mat4& pose = setup.poses.front();
  for (std::size_t o = 0; o < setup.eye.size(); ++o) {
    const Vec3d from =
        transform_point(pose, to_double(setup.eye.position_m[o])) - placement.origin_m;
    const Vec3d axis = normalize(transform_vector(pose, to_double(setup.eye.axis[o])));
    const Vec3d u =
        normalize(cross(std::fabs(axis.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}, axis));
    const Vec3d v = cross(axis, u);
    const double sigma = static_cast<double>(setup.eye.acceptance_angle_rad[o]) / 2.3548;
    for (int k = 0; k < packets_each; ++k) {
      Packet<L> packet{};
      clear<L>(packet.rays);
      for (int l = 0; l < 16; ++l) {
        const double r = sigma * std::sqrt(-2 * std::log(1 - draw.uniform()));
        const double phi = 2 * pi * draw.uniform();
        const Vec3 d =
            to_float(normalize(axis + u * (r * std::cos(phi)) + v * (r * std::sin(phi))));
        const Vec3 p = to_float(from);
        packet.rays.origin[0][l] = p.x, packet.rays.origin[1][l] = p.y;
        packet.rays.origin[2][l] = p.z;
        packet.rays.direction[0][l] = d.x, packet.rays.direction[1][l] = d.y;
        packet.rays.direction[2][l] = d.z;
        packet.rays.t_far_m[l] = INFINITY;
      }
      functions.closest(&tracer, LaneMask<L>::all_bits, packet.rays);
      Hits<L> hits;
      find_hits<L>(tracer.layout.placed.data(), packet, hits);
      HitGeometry<L>& geometry = seen.geometry.emplace_back();
      eval_geometry<L>(view, packet.rays, hits, geometry);
      const Vector3<float> towards = vector_of(to_float(sun));
      for (int l = 0; l < 16; ++l) {
        store_vector(
            packet.rays.origin, l,
            leave_surface(load_vector<float>(geometry.position, l),
                          load_vector<float>(geometry.normal, l), geometry.reach_m[l], towards));
        store_vector(packet.rays.direction, l, towards);
        packet.rays.t_far_m[l] = INFINITY;
      }
      const LaneMask<L> met = lanes_met(hits);
      functions.closest(&tracer, met.bits, packet.rays);
      auto& full = seen.full.emplace_back();
      auto& lit = seen.lit.emplace_back();
      for (std::size_t l = 0; l < 16; ++l) {
        const Vec3d normal{geometry.normal[0][l], geometry.normal[1][l], geometry.normal[2][l]};
        full[l] =
            met.has(static_cast<int>(l)) ? static_cast<float>(std::fabs(dot(normal, sun))) : 0;
        lit[l] = packet.rays.geometry[l] == none ? 1.0f : 0.0f;
      }
    }
  }
  return seen;
}

struct Row {
  SunMapData map;
  double made_s = 0, lookup_s = 1e9;
};

void print(double elevation_deg, const Row& row, const Seen& seen) {
  double error_2 = 0, bias = 0, wrong = 0, all = 0, hits = 0;
  const std::size_t ommatidia = seen.full.size() / packets_each;
  for (std::size_t o = 0; o < ommatidia; ++o) {
    double off = 0;
    for (std::size_t k = o * packets_each; k < (o + 1) * packets_each; ++k) {
      alignas(64) float visible[16];
      eval_sun_map(row.map.view, seen.geometry[k], visible);
      for (std::size_t l = 0; l < 16; ++l) {
        const auto full = static_cast<double>(seen.full[k][l]);
        const double difference = full * static_cast<double>(visible[l] - seen.lit[k][l]);
        off += difference;
        wrong += std::fabs(difference);
        all += full * static_cast<double>(seen.lit[k][l]);
        hits += full > 0;
      }
    }
    error_2 += off * off;
    bias += off;
  }
  const double n = static_cast<double>(ommatidia), mean = all / n;
  std::printf("%g,%.4g,%.4g,%.1f,%.2f,%.2f,%.2f,%.2f,%.2f\n", elevation_deg, row.map.finest_texel_m,
              row.map.coarsest_texel_m, static_cast<double>(row.map.bytes()) / 1e6, row.made_s,
              100 * std::sqrt(error_2 / n) / mean, 100 * bias / all, 100 * wrong / all,
              1e9 * row.lookup_s / hits);
}

}  // namespace

void sun_map(bool quick) {
  Setup setup = bundled_lit();
  setup.eye = sector(setup.eye, quick ? 64 : 4);
  const auto shading = make_shading_data(*setup.scene);
  const Placement placement = placement_of(*setup.scene);
  const auto tracer = make_embree_tracer(*setup.scene, shading->view, placement);
  const BlockFunctions functions = embree_block_functions();
  const Launches launches = launch_on_threads(functions);
  std::vector<float> frames;
  const double origin[3] = {placement.origin_m.x, placement.origin_m.y, placement.origin_m.z};
  for (const Mat4& m : placement.world_from_mesh)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        frames.push_back(static_cast<float>(m.m[r][c] - (c == 3 ? origin[r] : 0)));
  SceneView view = shading->view;
  view.frame_from_mesh = frames.data();
  std::printf(
      "sun_deg,finest_texel_m,coarsest_texel_m,MB,made_s,error_percent,bias_percent,"
      "wrong_percent,lookup_ns\n");
  for (const double elevation_deg : {20.0, 40.0, 70.0}) {
    const double e = elevation_deg * degree;
    const Vec3d sun{0.6 * std::cos(e), std::sin(e), -0.8 * std::cos(e)};
    const Seen seen = look(setup, *tracer, view, placement, functions, sun);
    std::vector<Row> rows;
    for (const double texel_m : {0.02, 0.01, 0.005})
      for (const std::size_t mib : {16, 64, 256}) {
        if (quick && mib > 16) continue;
        const auto start = Clock::now();
        Row& row = rows.emplace_back();
        row.map = make_sun_map({launches.closest, tracer.get()}, *setup.scene, placement,
                               to_float(sun), {texel_m, mib << 20});
        row.made_s = seconds_since(start);
      }
    // In turns, so that a disturbance meets all; the processor's time.
    for (int turn = 0; turn < 7; ++turn)
      for (Row& row : rows) {
        const std::clock_t start = std::clock();
        alignas(64) float visible[16];
        for (const HitGeometry<L>& geometry : seen.geometry) {
          eval_sun_map(row.map.view, geometry, visible);
          asm volatile("" : : "r"(visible) : "memory");
        }
        const auto ticks = static_cast<double>(std::clock() - start);
        row.lookup_s = std::min(row.lookup_s, ticks / CLOCKS_PER_SEC);
      }
    for (const Row& row : rows) print(elevation_deg, row, seen);
  }
}

}  // namespace omma::bench
