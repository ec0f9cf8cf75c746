// The table of arrays (backend/view_arrays.h): frames, their tasks and what traces them are copied
// by it, all that they were copied from is overwritten, and what is rendered from the copies has
// the same bits. Copies end where nothing may be read, so that a count too small ends the program.
#include <gtest/gtest.h>

#include <string>

#include "backend/portable/portable_backend.h"
#include "backend/portable/portable_builds.h"
#include "lit_everything.h"
#include "optics_acceptances.h"
#include "physics/path/baked.h"
#include "sampling/shared_rays.h"
#include "view_copies.h"
#include "world/bake_gather.h"

namespace omma::test {
namespace {

struct Build {
  const char* name;
  BlockFunctions functions;
};
// The processor's own loop, and the one in which each lane goes by itself.
std::vector<Build> builds() {
  return {{"of the processor", portable_block_functions()}, {"plain", plain::portable_block()}};
}

// Copies of views, checked.
struct Copies {
  FencedMemory memory;
  ArrayCopies<FencedMemory> copies{memory};
  Poison poison;

  template <typename View, typename... More>
  View of(const View& view, const More&... more) {
    View copied = view;
    copies.point_to_copies(copied, more...);
    for (const ArrayList::Entry& entry : ArrayList::of(copied, more...).entries)
      EXPECT_TRUE(entry.array == nullptr || memory.holds(entry.array, entry.bytes));
    EXPECT_TRUE(same_arrays(copied, view, more...));
    poison.add(view, more...);
    return copied;
  }
};

using RunTask = void (*)(const BlockFunctions&, const FrameView&, const BlockTask&, const void*,
                         std::byte*);

void render_task(const BlockFunctions& functions, const FrameView& frame, const BlockTask& task,
                 const void* tracer, std::byte* memory) {
  functions.render(frame, task, tracer, memory);
}

void expect_same_from_copies(FrameSetup& setup, RunTask run = render_task) {
  const Results before = setup.results;
  const BvhView& bvh = setup.tracer().view;
  const auto run_all = [&](const Build& build, const FrameView& frame,
                           const std::vector<BlockTask>& tasks, const BvhView& placed) {
    PortableTracer tracer;
    tracer.view = placed;
    tracer.scene_view = frame.scene;
    for (const BlockTask& task : tasks)
      run(build.functions, frame, task, &tracer, thread_memory(block_memory_bytes(frame)));
  };
  for (const Build& build : builds()) {
    SCOPED_TRACE(build.name);
    setup.results = before;  // where they are
    run_all(build, setup.frame, setup.tasks, bvh);
    const Results expected = setup.results;
    ASSERT_FALSE(expected == before);
    setup.results = before;

    Copies copies;
    const FrameView frame = copies.of(setup.frame);
    EXPECT_EQ(copies.memory.bytes(), bytes_of(setup.frame));
    const BvhView placed = copies.of(bvh);
    std::vector<BlockTask> tasks;
    for (const BlockTask& task : setup.tasks) tasks.push_back(copies.of(task, setup.frame));
    copies.poison.take_effect();
    EXPECT_FALSE(same_arrays(placed, bvh));
    run_all(build, frame, tasks, placed);
    copies.memory.bring_back();
    EXPECT_TRUE(setup.results == expected);
  }
}

World portable_world(Scene scene, std::optional<Lighting> lighting = std::nullopt,
                     std::vector<double> band_from_rgb = {}) {
  WorldSettings settings;
  settings.backend = "portable";
  settings.lighting = std::move(lighting);
  settings.band_from_rgb = std::move(band_from_rgb);
  return World(std::make_shared<const Scene>(std::move(scene)), settings);
}

Eye some_eye() {
  return make_eye(sphere_directions(40), 12 * degree);
}

// Its ommatidia have all acceptances in turns.
Eye eye_of_every_kind() {
  Eye eye = some_eye();
  const std::vector<NamedAcceptance> kinds = acceptances_of_every_kind();
  for (const NamedAcceptance& kind : kinds) eye.acceptances.push_back(kind.acceptance);
  for (std::size_t i = 0; i < eye.size(); ++i)
    eye.acceptance_of[i] = static_cast<std::int32_t>(i % (kinds.size() + 1)) - 1;
  validate_eye(eye);
  return eye;
}

// --- Unlit worlds.

TEST(ViewArrays, OfScenesThatAreNotLit) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Asked asked;
    asked.with_rays = true;
    FrameSetup setup(portable_world(random_scene(seed)), some_eye(), asked);
    expect_same_from_copies(setup);
  }
}

TEST(ViewArrays, OfCompoundRaysColors) {
  Scene scene = random_scene(2);
  scene.color_rule = ColorRule::compoundray;
  FrameSetup setup(portable_world(scene), some_eye(), {});
  EXPECT_NE(setup.frame.scene->power_22, nullptr);
  expect_same_from_copies(setup);
}

TEST(ViewArrays, OfBandsAndOutputs) {
  Asked asked;
  asked.mixes = true;
  FrameSetup setup(portable_world(random_scene(1), {}, std::vector<double>(15, 0.2)), some_eye(),
                   asked);
  expect_same_from_copies(setup);
}

TEST(ViewArrays, OfCutOuts) {
  Scene scene;
  Material material;
  material.alpha_mode = AlphaMode::mask;
  material.double_sided = true;
  material.base_color_texture.texture =
      add_texture(scene, make_image(64, 64, [](int x, int y) {
                    return Vec4{0.9f, 0.5f, 0.1f, (x / 8 + y / 8) % 2 == 0 ? 1.0f : 0.0f};
                  }));
  add_quad(scene, {0, 0, -2}, {1, 0, 0}, {0, 1, 0}, add_material(scene, material));
  FrameSetup setup(portable_world(scene), some_eye(), {});
  EXPECT_GT(setup.frame.scene->opacity_word_count, 0);
  expect_same_from_copies(setup);
}

// Hit on the edge between two triangles, where the search asks where these are.
TEST(ViewArrays, OfLayers) {
  Scene scene;
  const int clear = add_color(scene, {0.5f, 0.25f, 1});
  scene.materials.back().alpha_mode = AlphaMode::blend;
  scene.materials.back().base_color.w = 0.5f;
  for (const double z : {2.0, -2.0, -3.0}) add_quad(scene, {0, 0, z}, {1, 0, 0}, {0, 1, 0}, clear);
  FrameSetup setup(portable_world(scene), make_eye(Vec3d{0, 0, -1}, 0), {});
  expect_same_from_copies(setup);
}

TEST(ViewArrays, OfSplats) {
  Scene scene;
  for (int i = 0; i < 2; ++i) {
    SplatCloud& cloud = scene.splats.emplace_back();
    cloud.terms = i == 0 ? 1 : 4;
    for (int k = 0; k < 30; ++k) {
      cloud.positions.push_back({0.2f * static_cast<float>(k % 5), 0, -1 - static_cast<float>(k)});
      cloud.scales.push_back({0.3f, 0.2f, 0.1f});
      cloud.rotations.push_back({0, 0, 0, 1});
      cloud.opacities.push_back(0.2f);
      cloud.harmonics.resize(cloud.harmonics.size() + 3 * static_cast<std::size_t>(cloud.terms),
                             0.1f);
    }
  }
  FrameSetup setup(portable_world(scene), some_eye(), {});
  EXPECT_NE(setup.frame.scene->splats, nullptr);
  expect_same_from_copies(setup);
}

TEST(ViewArrays, OfNothing) {
  Scene scene;
  scene.background = constant_background({1, 0.5f, 0.25f});
  FrameSetup setup(portable_world(scene), some_eye(), {});
  expect_same_from_copies(setup);
}

// As in large scenes: vertices in place of corners, level 0 of images in 8 bits.
TEST(ViewArrays, OfLargeScenes) {
  Scene scene = random_scene(1);
  Image image;
  image.width = 7, image.height = 5;
  for (int i = 0; i < 4 * 7 * 5; ++i) image.rgba_srgb8.push_back(static_cast<std::uint8_t>(7 * i));
  const TextureLevels levels = make_texture_levels(image, ImageCodes::srgb, {}, true, true);
  FrameSetup setup(portable_world(scene), some_eye(), {});
  SceneView view = *setup.frame.scene;
  view.background.type = BackgroundType::image;
  view.background.image = view_levels(image, levels);
  view.background.image_density = panorama_density(view.background.image);
  std::vector<MeshView> meshes(view.meshes, view.meshes + view.mesh_count);
  std::vector<std::vector<float>> of_vertices;
  for (MeshView& mesh : meshes) {
    mesh.vertex_of_corner = mesh.triangles;
    for (const float** values : {&mesh.base_uv, &mesh.emissive_uv, &mesh.colors}) {
      if (*values == nullptr) continue;
      of_vertices.emplace_back(4 * static_cast<std::size_t>(mesh.vertex_count), 0.5f);
      *values = of_vertices.back().data();
    }
  }
  view.meshes = meshes.data();
  setup.frame.scene = &view;
  EXPECT_NE(view.background.image.codes, nullptr);
  expect_same_from_copies(setup);
}

// --- What is asked for.

TEST(ViewArrays, OfWhatIsAskedFor) {
  for (const bool to_error : {false, true}) {
    SCOPED_TRACE(to_error);
    Asked asked;
    if (to_error)
      asked.sampling = ToError{0.02, 8};
    else
      asked.sampling = Fixed{4};
    asked.with_error = true;
    asked.with_truth = true;
    asked.moves = true;
    FrameSetup setup(portable_world(random_scene(4)), some_eye(), asked);
    EXPECT_NE(setup.frame.truth->object_of_instance, nullptr);
    expect_same_from_copies(setup);
  }
}

TEST(ViewArrays, OfAcceptancesOfEveryKind) {
  const Eye eye = eye_of_every_kind();
  FrameSetup patterns(portable_world(random_scene(5)), eye, {});
  expect_same_from_copies(patterns);
  // Directions that are made on the way, as where tables would be too large.
  patterns.directions.front().patterns = 0;
  patterns.directions.front().local = nullptr;
  expect_same_from_copies(patterns);
  Asked asked;
  asked.points = Points::random;
  FrameSetup random(portable_world(random_scene(5)), eye, asked);
  EXPECT_NE(random.directions.front().polar.azimuth, nullptr);
  expect_same_from_copies(random);
  FrameSetup round(portable_world(random_scene(5)), some_eye(), asked);
  EXPECT_EQ(round.directions.front().polar.azimuth, nullptr);
  expect_same_from_copies(round);
}

TEST(ViewArrays, OfSharedRays) {
  const Eye eye = make_eye(sphere_directions(600), 20 * degree);
  const DirectionTables tables = make_direction_tables(eye, {.sampling = Shared{4}}, 4);
  const SharedRays rays = make_shared_rays(eye, tables, 0);
  const SharedWeights weights = view(rays);
  std::vector<float> radiance;
  for (std::size_t i = 0; i < 3 * rays.rays.size(); ++i)
    radiance.push_back(static_cast<float>(i % 17));
  for (const Build& build : builds()) {
    std::vector<float> expected(3 * eye.size()), responses(expected);
    const auto ommatidia = static_cast<std::int64_t>(eye.size());
    build.functions.weigh(weights, radiance.data(), 3, 0, ommatidia, expected.data());
    Copies copies;
    const SharedWeights copied = copies.of(weights);
    copies.poison.take_effect();
    build.functions.weigh(copied, radiance.data(), 3, 0, ommatidia, responses.data());
    EXPECT_TRUE(same_bits(responses, expected));
  }
}

// --- Lit worlds.

TEST(ViewArrays, OfLitWorlds) {
  for (const bool polarized : {false, true}) {
    SCOPED_TRACE(polarized);
    Asked asked;
    asked.sampling = Fixed{4};
    asked.with_error = polarized;
    asked.with_truth = !polarized;
    asked.mixes = polarized;
    FrameSetup setup(
        portable_world(scene_with_everything(true), lighting_with_everything(polarized, 2)),
        some_eye(), asked);
    EXPECT_GT(setup.frame.scene->light->emissive_count, 0);
    EXPECT_GT(setup.frame.scene->light->aim_count, 0);
    expect_same_from_copies(setup);
  }
}

// Which sensitivities are asked what they are there.
TEST(ViewArrays, OfDiscsSeenBesideRays) {
  const RunTask add_discs = [](const BlockFunctions& functions, const FrameView& frame,
                               const BlockTask& task, const void* tracer,
                               std::byte* memory) { functions.discs(frame, task, tracer, memory); };
  Scene empty;
  Lighting lighting = lighting_with_everything(false, 0);
  for (const Vec3d towards : sphere_directions(40)) {
    Disc disc;
    disc.direction = to_float(towards);
    disc.angular_radius_rad = 0.001;
    disc.radiance.assign(5, 2e4);
    lighting.light.discs.push_back(disc);
  }
  FrameSetup setup(portable_world(empty, lighting), eye_of_every_kind(), {});
  expect_same_from_copies(setup, add_discs);
}

// Of a world that something moved in, its light by cells, by probes, and the sun's by a map.
TEST(ViewArrays, OfBakedLight) {
  const Scene scene = scene_with_everything(false);
  Lighting lighting = lighting_with_everything(false, 1);
  BakeSettings settings;
  settings.cell_m = 0.4;
  settings.paths = 64;
  lighting.baked =
      std::make_shared<const BakedLight>(bake_light(portable_world(scene, lighting), settings));
  lighting.sun_map = true;
  Asked asked;
  asked.sampling = Fixed{4};
  asked.with_error = true;
  World world = portable_world(scene, lighting);
  const int moved = 0;
  const Mat4 place = translation({0, 0.5, 3});
  world.set_transforms({&moved, 1}, {&place, 1});
  FrameSetup setup(world, some_eye(), asked);
  const BakedView& baked = *setup.frame.scene->baked;
  EXPECT_TRUE(baked.errors != nullptr && setup.frame.scene->sun_map != nullptr);
  EXPECT_TRUE(std::any_of(baked.mesh_cells, baked.mesh_cells + baked.mesh_count,
                          [](const MeshCells& cells) { return cells.first != nullptr; }));
  expect_same_from_copies(setup);
}

TEST(ViewArrays, OfLightThatIsGathered) {
  const World world =
      portable_world(scene_with_everything(true), lighting_with_everything(false, 1));
  BakeSettings settings;
  settings.cell_m = 1;
  settings.paths = 16;
  const BakedLight baked = bake_light(world, settings);
  std::vector<Receiver> receivers(4);
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    receivers[i].normal = to_float(sphere_directions(4)[i]);
    receivers[i].hash = static_cast<std::uint32_t>(i);
  }
  for (const BakedLine* read : {static_cast<const BakedLine*>(nullptr), baked.lines.data()}) {
    const GatherWorld gathered(world, baked, read);
    std::vector<double> mean(receivers.size() * static_cast<std::size_t>(world.bands()));
    const GatherTask task{receivers.data(), static_cast<int>(receivers.size()), 4,
                          &gathered.by_paths, mean.data()};
    const auto run = [&](const Build& build, const FrameView& frame, const GatherTask& of,
                         const void* tracer) {
      build.functions.gather(frame, of, tracer, thread_memory(block_memory_bytes(frame)));
      return std::vector<double>(of.mean, of.mean + mean.size());
    };
    const auto& of_world =
        *static_cast<const PortableTracer*>(gathered.built.acceleration.tracer.get());
    for (const Build& build : builds()) {
      const std::vector<double> expected = run(build, gathered.frame, task, &of_world);
      EXPECT_GT(expected.front(), 0);
      Copies copies;
      const FrameView frame = copies.of(gathered.frame);
      PortableTracer tracer;
      tracer.view = copies.of(of_world.view);
      tracer.scene_view = frame.scene;
      const GatherTask copied = copies.of(task, world.bands());
      copies.poison.take_effect();
      EXPECT_EQ(run(build, frame, copied, &tracer), expected);
    }
  }
}

}  // namespace
}  // namespace omma::test
