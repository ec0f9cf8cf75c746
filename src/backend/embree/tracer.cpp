// Builds the Embree scene.
#include "backend/embree/tracer.h"

#include <algorithm>
#include <cmath>

#include "backend/embree/filter.h"
#include "model/scene_place.h"
#include "omma/error.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Embree inverts transforms in single precision; smaller determinants would underflow there.
constexpr double least_determinant = 1e-30;

// About 75 MB of acceleration structure.
constexpr std::size_t most_copied_triangles = std::size_t(1) << 20;

void check(RTCDevice device, const char* doing) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  const char* what = code == RTC_ERROR_OUT_OF_MEMORY     ? "out of memory"
                     : code == RTC_ERROR_UNSUPPORTED_CPU ? "this processor is not supported"
                                                         : "internal error";
  throw Error(std::string("Embree, ") + doing + ": " + what + " (code " + std::to_string(code) +
              ")");
}

bool is_identity(const Mat4& t) {
  const Mat4 identity;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      if (t.m[r][c] != identity.m[r][c]) return false;
  return true;
}

Mat4 moved(Mat4 t, Vec3d by) {
  t.m[0][3] += by.x, t.m[1][3] += by.y, t.m[2][3] += by.z;
  return t;
}

// A triangle geometry, its vertices transformed. Embree reads the Scene's own triangles, and its
// vertices where they stay where they are.
RTCGeometry make_geometry(EmbreeTracer& tracer, const Mesh& mesh, std::int32_t mesh_index,
                          const Mat4& placed, const SceneView& view) {
  RTCGeometry geometry = rtcNewGeometry(tracer.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const std::size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
  const Vec3* positions = mesh.positions.data();
  // Embree loads 16 bytes for a vertex of 12, so memory must follow the last one.
  if (is_identity(placed) && mesh.positions.capacity() > vertices) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh.positions.data(), 0, sizeof(Vec3), vertices);
  } else {
    auto* position = static_cast<Vec3*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), vertices));
    check(tracer.device, "making room for a mesh");
    parallel_for(std::size_t{0}, vertices, [&](std::size_t i) {
      position[i] = to_float(transform_point(placed, to_double(mesh.positions[i])));
    });
    positions = position;
  }
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.triangles.data(), 0, sizeof(mesh.triangles[0]), triangles);
  check(tracer.device, "taking a mesh");
  const RTCFilterFunctionN filter = filter_for(view.materials[view.meshes[mesh_index].material]);
  if (filter != nullptr) {
    tracer.filters.push_back(std::make_unique<FilterData>(
        FilterData{&view, mesh_index, &tracer, positions, mesh.triangles.data()}));
    rtcSetGeometryUserData(geometry, tracer.filters.back().get());
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
  }
  rtcCommitGeometry(geometry);
  return geometry;
}

// Robust: without it two rays in a million slip between triangles that share an edge, and a closed
// surround of radiance 1 would not give 1. (Of rays aimed exactly at corners a few in a thousand
// still do.) It costs a tenth in light scenes, nothing in heavy ones.
// Compact, for large scenes: 33 bytes a triangle instead of 57, and 31 more while building; it is
// traced a sixth slower.
RTCScene new_scene(RTCDevice device, bool compact) {
  RTCScene scene = rtcNewScene(device);
  if (scene != nullptr)
    rtcSetSceneFlags(
        scene, compact ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_ROBUST);
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

  // Called by any of Embree's threads with the share of the scene that is built.
  static bool go_on(void* build, double share) {
    const auto& b = *static_cast<const Build*>(build);
    b.work->share = (b.finished + share * b.part) / b.all;
    return !b.work->cancelled;
  }
};

// Scenes of meshes used several times, [mesh] or null; the instances hold them in the end.
struct SharedScenes {
  std::vector<RTCScene> of_mesh;
  explicit SharedScenes(std::size_t meshes) : of_mesh(meshes, nullptr) {}
  SharedScenes(const SharedScenes&) = delete;
  SharedScenes& operator=(const SharedScenes&) = delete;
  ~SharedScenes() {
    for (RTCScene scene : of_mesh)
      if (scene != nullptr) rtcReleaseScene(scene);
  }
};

// Metres of a mesh per metre of the world, along the direction that its transform stretches most:
// one over the largest singular value of A, whose square is the largest eigenvalue of B = A^T A
// (closed form of a symmetric 3x3: O. K. Smith 1961, doi:10.1145/355578.366316).
float mesh_per_world(const Mat4& world_from_mesh) {
  double b[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) b[i][j] += world_from_mesh.m[k][i] * world_from_mesh.m[k][j];
  const double mean = (b[0][0] + b[1][1] + b[2][2]) / 3;
  for (int i = 0; i < 3; ++i) b[i][i] -= mean;
  double squares = 0;
  for (const auto& row : b)
    for (const double value : row) squares += value * value;
  const double spread = std::sqrt(squares / 6);
  const double det = b[0][0] * (b[1][1] * b[2][2] - b[1][2] * b[2][1]) -
                     b[0][1] * (b[1][0] * b[2][2] - b[1][2] * b[2][0]) +
                     b[0][2] * (b[1][0] * b[2][1] - b[1][1] * b[2][0]);
  const double cosine =
      spread > 0 ? std::clamp(det / (2 * spread * spread * spread), -1.0, 1.0) : 1.0;
  const double largest = mean + 2 * spread * std::cos(std::acos(cosine) / 3);
  return largest > 0 ? static_cast<float>(1 / std::sqrt(largest)) : 0.0f;
}

void attach(EmbreeTracer& tracer, RTCScene scene, RTCGeometry geometry, std::int32_t mesh,
            const Mat4& world_from_mesh) {
  const unsigned id = rtcAttachGeometry(scene, geometry);
  const auto* filter = static_cast<const FilterData*>(rtcGetGeometryUserData(geometry));
  rtcReleaseGeometry(geometry);
  if (scene != tracer.scene) return;
  if (tracer.placed.size() <= id) tracer.placed.resize(id + 1);
  if (tracer.filter_of.size() <= id) tracer.filter_of.resize(id + 1);
  tracer.filter_of[id] = filter;
  tracer.placed[id] = {mesh, mesh_per_world(world_from_mesh)};
}

}  // namespace

EmbreeTracer::~EmbreeTracer() {
  if (threads_are_gone()) return;  // some of them may have held Embree's locks
  if (scene != nullptr) rtcReleaseScene(scene);
  if (device != nullptr) rtcReleaseDevice(device);
}

std::unique_ptr<EmbreeTracer> make_embree_tracer(const Scene& scene, const SceneView& view,
                                                 WorkState* work) {
  if (threads_are_gone())
    throw Error(
        "Renderer: cannot build an acceleration structure here: this process was forked from one "
        "that had used its threads, which Embree needs. Render with a renderer made before the "
        "fork, or one of its scene (with_eye), or start processes with 'spawn' or 'forkserver'");
  note_threads_are_used();
  auto tracer = std::make_unique<EmbreeTracer>();
  tracer->device = rtcNewDevice(nullptr);
  if (tracer->device == nullptr) check(nullptr, "starting");
  const auto version = rtcGetDeviceProperty(tracer->device, RTC_DEVICE_PROPERTY_VERSION);
  tracer->name = "embree " + std::to_string(version / 10000) + "." +
                 std::to_string(version / 100 % 100) + "." + std::to_string(version % 100);

  // Copies of small meshes trace up to three times as fast as instances, whose boxes overlap in
  // grass and foliage; where copies would take much memory, meshes are instanced.
  std::vector<int> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[static_cast<std::size_t>(instance.mesh)];
  std::size_t copied_triangles = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    if (uses[m] > 1)
      copied_triangles += static_cast<std::size_t>(uses[m]) * scene.meshes[m].triangles.size();
  const bool share = copied_triangles > most_copied_triangles;
  std::size_t built_triangles = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    built_triangles += scene.meshes[m].triangles.size() *
                       static_cast<std::size_t>(share ? std::min(uses[m], 1) : uses[m]);
  const Bounds box = rough_scene_bounds(scene);
  tracer->origin_m = origin_near(box);
  tracer->half_size_m = half_size_m(box);
  const bool compact = built_triangles > most_fast_triangles;
  Build build{tracer->device, work};
  build.all = static_cast<double>(std::max<std::size_t>(built_triangles, 1));
  tracer->scene = new_scene(tracer->device, compact);

  // A mesh in a scene of its own, to be instanced; about its own origin where it has one.
  std::vector<Vec3d> shared_origin_m(scene.meshes.size());
  SharedScenes shared_scenes(scene.meshes.size());
  std::vector<RTCScene>& shared = shared_scenes.of_mesh;
  const auto build_shared = [&](std::size_t m) {
    shared[m] = new_scene(tracer->device, compact);
    const auto mesh = static_cast<std::int32_t>(m);
    shared_origin_m[m] = origin_near(mesh_bounds(scene.meshes[m]));
    const Mat4 about_origin = moved({}, shared_origin_m[m] * -1.0);
    attach(*tracer, shared[m], make_geometry(*tracer, scene.meshes[m], mesh, about_origin, view),
           mesh, {});
    build.commit(shared[m], scene.meshes[m].triangles.size());
  };
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    if (share && uses[m] > 1 && !scene.meshes[m].triangles.empty()) build_shared(m);

  std::size_t placed_triangles = 0;

  for (const Instance& instance : scene.instances) {
    const auto m = static_cast<std::size_t>(instance.mesh);
    const Mesh& mesh = scene.meshes[m];
    if (mesh.triangles.empty()) continue;
    Mat4 t = moved(instance.world_from_mesh, tracer->origin_m * -1.0);
    // A mirrored mesh is instanced even when used once: put into the world directly, its triangles
    // would face the wrong way. A flattened one never is: instancing needs the inverse.
    const double det = determinant(t);
    const bool invertible = std::fabs(det) > least_determinant;
    if (!invertible || (shared[m] == nullptr && det > 0)) {
      attach(*tracer, tracer->scene, make_geometry(*tracer, mesh, instance.mesh, t, view),
             instance.mesh, t);
      placed_triangles += mesh.triangles.size();
      continue;
    }
    if (shared[m] == nullptr) build_shared(m);
    t = moved(t, transform_vector(t, shared_origin_m[m]));
    RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, shared[m]);
    float columns[12];
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) columns[3 * c + r] = static_cast<float>(t.m[r][c]);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
    rtcCommitGeometry(geometry);
    attach(*tracer, tracer->scene, geometry, instance.mesh, t);
  }
  build.commit(tracer->scene, placed_triangles);
  return tracer;
}

}  // namespace omma
