// Builds the Embree scene.
#include "backend/embree/embree_tracer.h"

#include <algorithm>
#include <type_traits>

#include "backend/embree/filter.h"
#include "backend/shading_data.h"
#include "omma/error.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Some ten microseconds of work.
constexpr std::size_t instances_per_task = 64, vertices_per_task = 4096;

void check(RTCDevice device, const char* doing) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  const char* what = code == RTC_ERROR_OUT_OF_MEMORY     ? "out of memory"
                     : code == RTC_ERROR_UNSUPPORTED_CPU ? "this processor is not supported"
                                                         : "internal error";
  throw Error(std::string("Embree, ") + doing + ": " + what + " (code " + std::to_string(code) +
              ")");
}

struct Release {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
// Released where it goes out of scope: scenes that it was attached to keep it.
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Release>;

bool is_identity(const Mat4& t) {
  const Mat4 identity;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      if (t.m[r][c] != identity.m[r][c]) return false;
  return true;
}

Mat4 translation(Vec3d by) {
  Mat4 t;
  t.m[0][3] = by.x, t.m[1][3] = by.y, t.m[2][3] = by.z;
  return t;
}

Geometry new_geometry(RTCDevice device, RTCGeometryType type) {
  Geometry geometry(rtcNewGeometry(device, type));
  check(device, "making a geometry");
  return geometry;
}

// A triangle geometry, its vertices transformed. Embree reads the Scene's own triangles, and its
// vertices where they stay where they are and memory that is theirs follows the last one: it loads
// 16 bytes for each vertex of 12. Its copies have a vertex more than there are, for the same
// reason.
//
// One that changes its shape gets vertices of its own, and a hierarchy whose boxes are fitted to
// them each time (refit).
Geometry make_geometry(EmbreeTracer& tracer, const Mesh& mesh, std::int32_t mesh_index,
                       const Mat4& placed, const SceneView& view, const Shape& shape) {
  Geometry geometry = new_geometry(tracer.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const bool deforms = !shape.positions.empty();
  const std::vector<Vec3>& given = deforms ? shape.positions : mesh.positions;
  const std::size_t vertices = given.size(), triangles = mesh.triangles.size();
  const Vec3* positions = given.data();
  if (deforms) rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_REFIT);
  if (!deforms && is_identity(placed) && given.capacity() > vertices) {
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               given.data(), 0, sizeof(Vec3), vertices);
  } else {
    auto* position = static_cast<Vec3*>(rtcSetNewGeometryBuffer(
        geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), vertices + 1));
    check(tracer.device, "making room for a mesh");
    position[vertices] = {};
    parallel_for(std::size_t{0}, vertices, [&](std::size_t i) {
      position[i] = to_float(transform_point(placed, to_double(given[i])));
    });
    positions = position;
  }
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.triangles.data(), 0, sizeof(mesh.triangles[0]), triangles);
  check(tracer.device, "taking a mesh");
  const RTCFilterFunctionN filter = filter_for(view.materials[view.meshes[mesh_index].material]);
  if (filter != nullptr) {
    tracer.filters.push_back(std::make_unique<FilterData>(
        FilterData{&view, mesh_index, &tracer, positions, mesh.triangles.data()}));
    rtcSetGeometryUserData(geometry.get(), tracer.filters.back().get());
    rtcSetGeometryOccludedFilterFunction(geometry.get(), filter);
    rtcSetGeometryIntersectFilterFunction(geometry.get(), filter);
  }
  // What hides things is the mask of their instances (place). Embree 4 gives a geometry the first
  // bit alone where none is set, Embree 3 all.
  rtcSetGeometryMask(geometry.get(), all_seen);
  rtcCommitGeometry(geometry.get());
  return geometry;
}

// Robust: without it two rays in a million slip between triangles that share an edge, and a closed
// surround of radiance 1 would not give 1. (Of rays aimed exactly at corners a few in a thousand
// still do.) It costs a tenth in light scenes, nothing in heavy ones.
// Compact, for large scenes: 33 bytes a triangle instead of 57, and 31 more while building; it is
// traced a sixth slower.
RTCScene new_scene(RTCDevice device, RTCSceneFlags more) {
  RTCScene scene = rtcNewScene(device);
  if (scene != nullptr)
    rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | more));
  check(device, "making a scene");
  return scene;
}

// Building, watched: each scene is a part of the work as large as its triangles.
struct Build {
  RTCDevice device;
  WorkState* work;                         // or null
  double finished = 0, part = 0, all = 1;  // triangles: of scenes built, of this one, of all

  void commit(RTCScene scene, std::size_t triangles) {
    part = static_cast<double>(triangles);
    if (work != nullptr) rtcSetSceneProgressMonitorFunction(scene, go_on, this);
    rtcCommitScene(scene);
    if (work != nullptr) rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    if (work != nullptr && work->cancelled) throw Cancelled();
    check(device, "building the acceleration structure");
    finished += part;
  }

  // Called by any of Embree's threads with the fraction of the scene that is built.
  static bool go_on(void* build, double fraction) {
    const auto& b = *static_cast<const Build*>(build);
    b.work->fraction = (b.finished + fraction * b.part) / b.all;
    return !b.work->cancelled;
  }
};

// A mesh in a scene of its own, to be instanced, about its own origin.
void build_mesh(EmbreeTracer& tracer, const Scene& scene, std::size_t m, const SceneView& view,
                const Shape& shape, RTCSceneFlags flags, Build& build) {
  if (tracer.scene_of_mesh[m] != nullptr) return;
  const Mesh& mesh = scene.meshes[m];
  const bool deforms = !shape.positions.empty();
  tracer.scene_of_mesh[m] = new_scene(tracer.device, deforms ? RTC_SCENE_FLAG_DYNAMIC : flags);
  // Embree fits the boxes of a geometry's hierarchy, which it builds well at first, in scenes of
  // low quality only: 2 ms for 100,000 triangles (one thread), where building it anew takes 33, or
  // 8 with low quality.
  if (deforms) rtcSetSceneBuildQuality(tracer.scene_of_mesh[m], RTC_BUILD_QUALITY_LOW);
  const Geometry geometry =
      make_geometry(tracer, mesh, static_cast<std::int32_t>(m),
                    translation(tracer.layout.mesh_origin_m[m] * -1.0), view, shape);
  rtcAttachGeometry(tracer.scene_of_mesh[m], geometry.get());
  build.commit(tracer.scene_of_mesh[m], mesh.triangles.size());
}

void place(const EmbreeTracer& tracer, RTCGeometry geometry, std::size_t index) {
  const Mat4& frame_from_mesh = tracer.layout.instances[index].frame_from_mesh;
  float columns[12];
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) columns[3 * c + r] = static_cast<float>(frame_from_mesh.m[r][c]);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  rtcSetGeometryMask(geometry, tracer.layout.placed[index].seen_by);
  rtcCommitGeometry(geometry);
}

void check_masks(const EmbreeTracer& tracer, const Placement& placement) {
  if (placement.seen_by.empty()) return;
  if (rtcGetDeviceProperty(tracer.device, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) == 0)
    throw Error(
        "unseen: expected an Embree that was built with ray masks (EMBREE_RAY_MASK), found " +
        tracer.name + " without; World(..., backend=\"portable\") has them");
}

// Puts an instance of the layout into one of the top scenes: as an instance of its mesh's scene, or
// as a copy.
void add_instance(EmbreeTracer& tracer, RTCScene top, std::size_t index, const Scene& scene,
                  const SceneView& view) {
  const PlacedInstance& instance = tracer.layout.instances[index];
  const auto m = static_cast<std::size_t>(instance.mesh);
  Geometry geometry;
  if (instance.is_shared) {
    geometry = new_geometry(tracer.device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry.get(), tracer.scene_of_mesh[m]);
    place(tracer, geometry.get(), index);
  } else {
    geometry =
        make_geometry(tracer, scene.meshes[m], instance.mesh, instance.frame_from_mesh, view, {});
    tracer.filter_of[index] =
        static_cast<const FilterData*>(rtcGetGeometryUserData(geometry.get()));
  }
  rtcAttachGeometryByID(top, geometry.get(), static_cast<unsigned>(index));
  check(tracer.device, "placing a mesh");
}

std::unique_ptr<EmbreeTracer> new_tracer(const Scene& scene, const Placement& placement) {
  auto tracer = std::make_unique<EmbreeTracer>();
  tracer->device = rtcNewDevice(nullptr);
  if (tracer->device == nullptr) check(nullptr, "starting");
  const auto version = rtcGetDeviceProperty(tracer->device, RTC_DEVICE_PROPERTY_VERSION);
  tracer->name = "embree " + std::to_string(version / 10000) + "." +
                 std::to_string(version / 100 % 100) + "." + std::to_string(version % 100);
  tracer->layout = lay_out_scene(scene, placement);
  tracer->scene_of_mesh.resize(scene.meshes.size(), nullptr);
  tracer->filter_of.resize(tracer->layout.instances.size(), nullptr);
  return tracer;
}

// Gives a mesh that changes its shape the one that it has now.
void reshape(EmbreeTracer& tracer, std::size_t mesh, const Placement& placement) {
  const RTCScene scene = tracer.scene_of_mesh[mesh];
  if (scene == nullptr) return;  // it has no triangles, or is placed nowhere
  const RTCGeometry geometry = rtcGetGeometry(scene, 0);
  auto* position =
      static_cast<Vec3*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  const std::vector<Vec3>& positions = placement.shapes[mesh].positions;
  const Vec3d origin = tracer.layout.mesh_origin_m[mesh];
  parallel_ranges(std::size_t{0}, positions.size(), vertices_per_task,
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i)
                      position[i] = to_float(to_double(positions[i]) - origin);
                  });
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  check(tracer.device, "giving a mesh another shape");
  // The boxes of its instances change too.
  for (std::size_t k = 0; k < tracer.layout.moving; ++k)
    if (tracer.layout.instances[k].mesh == static_cast<std::int32_t>(mesh))
      rtcCommitGeometry(rtcGetGeometry(tracer.moving, static_cast<unsigned>(k)));
}

}  // namespace

EmbreeTracer::~EmbreeTracer() {
  if (threads_are_gone()) return;  // some of them may have held Embree's locks
  for (const RTCScene top : {scene, moving})
    if (top != nullptr) rtcReleaseScene(top);
  for (const RTCScene mesh : scene_of_mesh)
    if (mesh != nullptr) rtcReleaseScene(mesh);
  if (device != nullptr) rtcReleaseDevice(device);
}

std::unique_ptr<EmbreeTracer> make_embree_tracer(const Scene& scene, const SceneView& view,
                                                 const Placement& placement, WorkState* work) {
  if (threads_are_gone())
    throw Error(
        "World: cannot build an acceleration structure here: this process was forked from one "
        "that had used its threads, which Embree needs. Render with a renderer made before the "
        "fork, or one of its world (with_eye), or start processes with 'spawn' or 'forkserver'");
  note_threads_are_used();
  auto tracer = new_tracer(scene, placement);
  check_masks(*tracer, placement);

  const SceneLayout& layout = tracer->layout;
  const RTCSceneFlags flags =
      layout.built_triangles > most_fast_triangles ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE;
  Build build{tracer->device, work};
  build.all = static_cast<double>(std::max<std::size_t>(layout.built_triangles, 1));
  for (const PlacedInstance& instance : layout.instances)
    if (instance.is_shared)
      build_mesh(*tracer, scene, static_cast<std::size_t>(instance.mesh), view,
                 placement.shapes[static_cast<std::size_t>(instance.mesh)], flags, build);

  tracer->scene = new_scene(tracer->device, flags);
  std::size_t copied_triangles = 0;
  for (std::size_t k = layout.moving; k < layout.instances.size(); ++k) {
    add_instance(*tracer, tracer->scene, k, scene, view);
    const auto m = static_cast<std::size_t>(layout.instances[k].mesh);
    if (!layout.instances[k].is_shared) copied_triangles += scene.meshes[m].triangles.size();
  }
  build.commit(tracer->scene, copied_triangles);
  if (layout.moving == 0) return tracer;

  // Moving instances have the lowest ids, as each commit visits all ids up to the largest of its
  // scene. A commit rebuilds the boxes, 1 µs per instance: a build of lower quality takes longer,
  // and Embree cannot refit instances.
  tracer->moving = new_scene(tracer->device, RTC_SCENE_FLAG_NONE);
  for (std::size_t k = 0; k < layout.moving; ++k)
    add_instance(*tracer, tracer->moving, k, scene, view);
  build.commit(tracer->moving, 0);
  return tracer;
}

void move_instances(EmbreeTracer& tracer, std::span<const int> instances,
                    std::span<const int> meshes, const Placement& placement) {
  check_masks(tracer, placement);
  for (const int mesh : meshes) reshape(tracer, static_cast<std::size_t>(mesh), placement);
  parallel_ranges(std::size_t{0}, instances.size(), instances_per_task,
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t k = begin; k < end; ++k) {
                      const std::int32_t index =
                          tracer.layout.index_of[static_cast<std::size_t>(instances[k])];
                      if (index < 0) continue;  // it has no triangles
                      const auto i = static_cast<std::size_t>(index);
                      place_instance(tracer.layout, i, placement);
                      place(tracer, rtcGetGeometry(tracer.moving, static_cast<unsigned>(index)), i);
                    }
                  });
  rtcCommitScene(tracer.moving);
  check(tracer.device, "moving what moves");
}

}  // namespace omma
