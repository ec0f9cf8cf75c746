// What light needs that goes on from a surface, with each backend's search: where it was met, its
// normal and instance, rays that leave it, and whether anything is in their way.
#include <gtest/gtest.h>

#include "backend/embree/embree_backend.h"
#include "backend/embree/embree_search.h"
#include "backend/portable/portable_backend.h"
#include "backend/portable/portable_tracer.h"
#include "backend/shading_data.h"
#include "physics/rays/hits.h"
#include "physics/surface/scene_search.h"
#include "test_scenes.h"

namespace omma::test {
namespace {

using L = Lanes<16, lane_width>;

// A scene built by one of the backends.
template <typename Search>
struct Built {
  Scene scene;
  std::unique_ptr<ShadingData> shading;
  Placement placement;
  Acceleration acceleration;
  std::vector<float> frames;
  SceneView view;

  explicit Built(Scene given) : scene(std::move(given)) {
    shading = make_shading_data(scene);
    placement = placement_of(scene);
    const bool embree = std::is_same_v<Search, EmbreeSearch<L>>;
    acceleration = (embree ? embree_backend() : portable_backend())
                       .build(scene, shading->view, placement, {}, nullptr);
    const double origin[3] = {placement.origin_m.x, placement.origin_m.y, placement.origin_m.z};
    for (const Mat4& t : placement.world_from_mesh)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
          frames.push_back(static_cast<float>(t.m[r][c] - (c == 3 ? origin[r] : 0)));
    view = shading->view;
    view.frame_from_mesh = frames.data();
  }
  Built(const Built&) = delete;
  Built& operator=(const Built&) = delete;

  Search search() const {
    if constexpr (std::is_same_v<Search, EmbreeSearch<L>>) {
      return {static_cast<const EmbreeTracer*>(acceleration.tracer.get()), {}};
    } else {
      const auto& tracer = *static_cast<const PortableTracer*>(acceleration.tracer.get());
      return {tracer.scene_view, &tracer.view};
    }
  }
};

void set_ray(RayPacket<16>& rays, int lane, Vec3d origin, Vec3d direction) {
  const double o[3] = {origin.x, origin.y, origin.z};
  const double d[3] = {direction.x, direction.y, direction.z};
  for (int r = 0; r < 3; ++r) {
    rays.origin[r][lane] = static_cast<float>(o[r]);
    rays.direction[r][lane] = static_cast<float>(d[r]);
  }
  rays.t_near_m[lane] = 0;
}

template <typename Search>
class SearchHits : public testing::Test {};
using Searches = testing::Types<EmbreeSearch<L>, SceneSearch<L>>;
TYPED_TEST_SUITE(SearchHits, Searches);

// Positions and normals from the corners of the mesh, in double precision, through all kinds of
// transforms; and what is met says where the ray is.
TYPED_TEST(SearchHits, LieWhereRaysMeetSurfaces) {
  int met = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const Built<TypeParam> built(random_scene(seed));
    TypeParam search = built.search();
    Random random{seed};
    for (int k = 0; k < 200; ++k) {
      Packet<L> packet{};
      clear<L>(packet.rays);
      clear_hits<L>(packet.rays);
      for (int l = 0; l < 16; ++l) set_ray(packet.rays, l, {}, random.direction());
      search.closest(LaneMask<L>::all(), packet.rays, nullptr);
      Hits<L> hits;
      find_hits<L>(search.placed(), packet, hits);
      HitGeometry<L> geometry;
      eval_geometry<L>(built.view, packet.rays, hits, geometry);
      for (int l = 0; l < 16; ++l) {
        if (hits.mesh[l] < 0) continue;
        ++met;
        const auto instance = static_cast<std::size_t>(hits.instance[l]);
        ASSERT_EQ(built.scene.instances[instance].mesh, hits.mesh[l]);
        const Mesh& mesh = built.scene.meshes[static_cast<std::size_t>(hits.mesh[l])];
        const Mat4& t = built.scene.instances[instance].world_from_mesh;
        Vec3d corner[3];
        for (std::size_t c = 0; c < 3; ++c)
          corner[c] = transform_point(
              t, to_double(mesh.positions[mesh.triangles[packet.rays.triangle[l]][c]]));
        const Vec3d n = normalize(cross(corner[1] - corner[0], corner[2] - corner[0])) *
                        (determinant(t) < 0 ? -1.0 : 1.0);
        const Vec3d normal{geometry.normal[0][l], geometry.normal[1][l], geometry.normal[2][l]};
        EXPECT_GT(dot(n, normal), 1 - 1e-5);
        EXPECT_NEAR(length(normal), 1, 1e-6);
        const Vec3d position{geometry.position[0][l], geometry.position[1][l],
                             geometry.position[2][l]};
        const double reach = geometry.reach_m[l];
        EXPECT_LE(std::fabs(dot(n, position - corner[0])), 16 * float_rounding * reach);
        const Vec3d along{packet.rays.direction[0][l], packet.rays.direction[1][l],
                          packet.rays.direction[2][l]};
        EXPECT_LE(length(position - along * packet.rays.t_far_m[l]), 1e-4);
      }
    }
  }
  EXPECT_GT(met, 1500);
}

// Floors of a micrometre to a kilometre, and as far away: rays that leave one of them do not meet
// it again on the side that they leave to, nor do they step over another that lies a little above
// it.
TYPED_TEST(SearchHits, RaysThatLeaveASurfaceDoNotMeetItAgain) {
  for (const double size : {1e-6, 1e-3, 1.0, 1e3})
    for (const double away : {0.0, 1.0, 3.0}) {  // further away they are traced about themselves
      Random random{17};
      const Mat4 turn = random_rotation(random);
      const Vec3d centre = transform_vector(turn, Vec3d{0.3, 0.5, 0.8}) * (away * size);
      // Above by 2^-16 of how far its corners are from the origin: eight times the step.
      const double gap = (1 + away) * size * 0x1p-16;
      const Vec3d u = transform_vector(turn, {size, 0, 0}),
                  v = transform_vector(turn, {0, 0, -size});
      const Vec3d up = normalize(cross(u, v));
      Scene floor, both;
      const int material = add_color(floor, {1, 1, 1});
      add_color(both, {1, 1, 1});
      floor.materials[0].double_sided = both.materials[0].double_sided = true;
      add_instance(floor, add_mesh(floor, quad(centre, u, v, material)));
      add_instance(both, add_mesh(both, quad(centre, u, v, material)));
      add_instance(both, add_mesh(both, quad(centre + up * gap, u * 3.0, v * 3.0, material)));
      const Built<TypeParam> alone(floor), covered(both);
      TypeParam one = alone.search(), two = covered.search();
      int met = 0, again = 0, over = 0;
      for (int k = 0; k < 2000; ++k) {
        Packet<L> packet{};
        clear<L>(packet.rays);
        clear_hits<L>(packet.rays);
        for (int l = 0; l < 16; ++l) {
          const Vec3d aim = centre + u * random.uniform(-0.9, 0.9) + v * random.uniform(-0.9, 0.9);
          const Vec3d from = aim + (up + random.direction() * 0.9) * size;
          set_ray(packet.rays, l, from, normalize(aim - from));
        }
        one.closest(LaneMask<L>::all(), packet.rays, nullptr);
        Hits<L> hits;
        find_hits<L>(one.placed(), packet, hits);
        HitGeometry<L> geometry;
        eval_geometry<L>(alone.view, packet.rays, hits, geometry);
        RayPacket<16> leaving = packet.rays;
        const LaneMask<L> asked = lanes_met(hits);
        met += bits_in(asked.bits);
        for (int l = 0; l < 16; ++l) {
          Vec3d d = random.direction();
          // Some nearly along the surface.
          if (k % 2 == 0) d = normalize(d + up * (1e-4 - dot(d, up)));
          if (dot(d, up) < 0) d = d * -1.0;
          const Vector3<float> towards = vector_of(to_float(d));
          store_vector(
              leaving.origin, l,
              leave_surface(load_vector<float>(geometry.position, l),
                            load_vector<float>(geometry.normal, l), geometry.reach_m[l], towards));
          store_vector(leaving.direction, l, towards);
          leaving.t_far_m[l] = INFINITY;
        }
        again += bits_in(one.occluded(asked, leaving).bits);
        // Straight up, what lies above is met.
        for (int l = 0; l < 16; ++l) {
          const float towards[3] = {static_cast<float>(up.x), static_cast<float>(up.y),
                                    static_cast<float>(up.z)};
          for (int r = 0; r < 3; ++r) leaving.direction[r][l] = towards[r];
        }
        over += bits_in((asked & ~two.occluded(asked, leaving)).bits);
      }
      EXPECT_GT(met, 15000) << size << ' ' << away;
      EXPECT_EQ(again, 0) << size << ' ' << away;
      EXPECT_EQ(over, 0) << size << ' ' << away;
    }
}

// What is in the way is what the closest hit finds: cut-outs let light through where they are not,
// backs of single-sided surfaces are not there.
TYPED_TEST(SearchHits, OccludedIsWhereSomethingIsMet) {
  int met = 0, open = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Built<TypeParam> built(random_scene(seed));
    TypeParam search = built.search();
    Random random{seed};
    for (int k = 0; k < 200; ++k) {
      RayPacket<16> rays{};
      clear<L>(rays);
      clear_hits<L>(rays);
      for (int l = 0; l < 16; ++l) {
        set_ray(rays, l, random.direction() * random.uniform(0, 3), random.direction());
        if (k % 2 == 0) rays.t_far_m[l] = static_cast<float>(random.uniform(0.5, 3));
      }
      const RayPacket<16> asked = rays;
      search.closest(LaneMask<L>::all(), rays, nullptr);
      const LaneMask<L> occluded = search.occluded(LaneMask<L>::all(), asked);
      for (int l = 0; l < 16; ++l) {
        EXPECT_EQ(rays.geometry[l] != none, occluded.has(l));
        (rays.geometry[l] != none ? met : open) += 1;
      }
    }
  }
  EXPECT_GT(met, 2500);
  EXPECT_GT(open, 2500);
}

}  // namespace
}  // namespace omma::test
