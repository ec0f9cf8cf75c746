// Memory of the tracer and of renders: enough behind what Embree reads, given back where building
// ends early, and no longer held than who needs it.
#include <gtest/gtest.h>
#include <malloc.h>

#include "backend/embree/embree_tracer.h"
#include "backend/shading_data.h"
#include "test_scenes.h"
#include "threads/parallel.h"

namespace omma::test {
namespace {

// Bytes that are allocated, in the heap or as mappings of their own.
std::size_t allocated() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

Mesh many_vertices(std::size_t count) {
  Mesh mesh;
  mesh.positions.resize(count, {1, 2, 3});
  mesh.positions[0] = {-1, -2, -3};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

// Embree loads 16 bytes for a vertex of 12. Whoever made a scene, its vertices are read where they
// are only if memory that is theirs follows them; copies have a vertex more. Both are looked at
// through a mesh that has a filter, which knows where they are. (Embree 3.13 pads its own memory,
// and the C library gives more than it was asked for.)
TEST(TracerMemory, ThereIsMoreBehindTheLastVertex) {
  for (const std::size_t vertices : {3u, 4u, 5u, 8u, 16u, 1024u}) {
    Scene scene;
    Mesh mesh = many_vertices(vertices);
    mesh.positions.shrink_to_fit();
    mesh.material = add_material(scene, {});  // single-sided
    scene.materials[0].alpha_mode = AlphaMode::blend;
    add_instance(scene, add_mesh(scene, std::move(mesh)));  // nothing behind: copied
    add_instance(scene, 0, translation({1, 0, 0}));         // moved: copied
    const auto shading = make_shading_data(scene);
    const auto tracer = make_embree_tracer(scene, shading->view, placement_of(scene));
    ASSERT_EQ(tracer->filters.size(), 2u);
    for (const auto& filter : tracer->filters) {
      EXPECT_NE(filter->position_m, scene.meshes[0].positions.data());
      EXPECT_GE(malloc_usable_size(const_cast<Vec3*>(filter->position_m)),
                sizeof(Vec3) * (vertices - 1) + 16);
    }
    // Copies of a scene have no room behind, whatever the original had: they are not shared.
    scene.meshes[0].positions.reserve(2 * vertices);
    scene.instances.pop_back();
    const auto with_room = make_embree_tracer(scene, shading->view, placement_of(scene));
    EXPECT_EQ(with_room->filters[0]->position_m, scene.meshes[0].positions.data());
    const Scene copy = scene;
    const auto of_copy = make_embree_tracer(copy, shading->view, placement_of(copy));
    EXPECT_NE(of_copy->filters[0]->position_m, copy.meshes[0].positions.data());
  }
}

TEST(TracerMemory, IsGivenBackWhereBuildingEnds) {
  Scene scene;
  add_instance(scene, add_mesh(scene, many_vertices(1u << 20)), translation({1, 0, 0}));
  const auto shading = make_shading_data(scene);
  const Placement placement = placement_of(scene);
  const std::atomic<bool> cancelled = true;
  const auto build = [&] {
    const TakingPart part(&cancelled);
    EXPECT_THROW((void)make_embree_tracer(scene, shading->view, placement), Cancelled);
  };
  build();  // what is made once in a process
  const std::size_t before = allocated();
  for (int i = 0; i < 8; ++i) build();
  // The copy of the vertices has 12 MB each time.
  EXPECT_LT(allocated(), before + (1u << 20));
}

TEST(RenderMemory, OfSharedRaysGoesWithTheRenderer) {
  const Eye eye = make_eye(sphere_directions(1000), 20 * degree);
  const std::vector<Mat4> poses(8);
  const World world(std::make_shared<const Scene>(flat_triangles(1, 10)));
  std::vector<float> responses(poses.size() * eye.size() * rgb_bands);
  const auto render_once = [&](int samples) {
    RenderSettings settings;
    settings.sampling = Shared{samples};
    settings.threads = 2;
    Renderer(world, eye, settings).render(poses, responses);
  };
  render_once(1);  // threads, and their room for few rays
  const std::size_t before = allocated();
  render_once(64);  // 64,000 rays, 0.8 MB of radiance for each thread
  EXPECT_LT(allocated(), before + (1u << 18));
}

}  // namespace
}  // namespace omma::test
