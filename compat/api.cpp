// The C functions of libEyeRenderer.h, over the state of state.h. CompoundRay's prints go to the
// same streams in the same form; where it would throw or crash, an ERROR line is printed and the
// call changes nothing.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>

#include "libEyeRenderer.h"
#include "state.h"

namespace {

using namespace omma;
using namespace omma::compat;

// Made at the first call and never destroyed: at the end of a program other libraries, of which
// threads may be needed to take it down, may be gone already.
State& the_state() {
  static State& state = *new State;
  return state;
}

// What every function does: one caller at a time, and no exception leaves.
template <typename Result, typename Action>
Result guarded(Result otherwise, Action action) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  try {
    return action(the_state());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ERROR: %s\n", error.what());
  } catch (...) {
    std::fputs("ERROR: something unknown went wrong\n", stderr);
  }
  return otherwise;
}

template <typename Action>
void guarded(Action action) {
  guarded(false, [&](State& state) {
    action(state);
    return false;
  });
}

template <typename... Values>
void notify(const State& state, const char* format, Values... values) {
  if (!state.verbose) return;
  std::printf("[PyEye] ");
  if constexpr (sizeof...(values) == 0)
    std::fputs(format, stdout);
  else
    std::printf(format, values...);
  std::printf("\n");
  std::fflush(stdout);
}

std::string text(const char* argument) {
  return argument == nullptr ? "" : argument;
}

float3 to_float3(Vec3 v) {
  return {v.x, v.y, v.z};
}

Eye eye_from(const OmmatidiumPacket* packets, std::size_t count) {
  Eye eye;
  eye.path = "setOmmatidia";
  for (std::size_t i = 0; i < count; ++i) {
    const OmmatidiumPacket& p = packets[i];
    eye.position_m.push_back({p.posX, p.posY, -p.posZ});
    eye.axis.push_back({p.dirX, p.dirY, -p.dirZ});
    // Only its square counts, and above a full turn all directions count alike.
    eye.acceptance_angle_rad.push_back(
        std::min(std::fabs(p.acceptanceAngle), static_cast<float>(2 * pi)));
    eye.focal_offset_m.push_back(p.focalpointOffset);
    eye.eye_id.push_back(0);
  }
  return eye;
}

}  // namespace

extern "C" {

// --- Running

void setVerbosity(bool v) {
  guarded([&](State& state) { state.verbose = v; });
}

void loadGlTFscene(const char* filepath) {
  guarded([&](State& state) {
    try {
      load(state, text(filepath));
    } catch (const Error& error) {
      throw Error("Failed to load GLTF scene '" + text(filepath) + "': " + error.what());
    }
  });
}

void stop() {
  guarded([](State& state) {
    notify(state, "Cleaning eye renderer resources.");
    for (CompatCamera& camera : state.cameras) camera.renderer.reset();
    state.world.reset();
  });
}

void setRenderSize(int w, int h) {
  guarded([&](State& state) {
    notify(state, "Resizing rendering buffer to (%d, %d).", w, h);
    resize(state.frame, w, h);
  });
}

double renderFrame() {
  return guarded(0.0, [](State& state) {
    const auto start = std::chrono::steady_clock::now();
    render_frame(state);
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - start;
    notify(state, "Rendered frame in %gms.", taken.count());
    return taken.count();
  });
}

void displayFrame() {}

void saveFrameAs(const char* ppmFilename) {
  guarded([&](State& state) {
    const std::string path = text(ppmFilename);
    const std::string end = path.size() < 4 ? "" : path.substr(path.size() - 4);
    if (end != ".ppm" && end != ".PPM")
      throw Error("frames are saved as .ppm, \"" + path + "\" is something else");
    save_ppm(path, state.frame);
    notify(state, "Saved render as '%s'", path.c_str());
  });
}

unsigned char* getFramePointer() {
  return guarded(static_cast<unsigned char*>(nullptr), [](State& state) {
    notify(state, "Retrieving frame pointer...");
    return state.frame.pixels[0].data();
  });
}

void getFrame(unsigned char* frame) {
  guarded([&](State& state) {
    notify(state, "Retrieving frame...");
    if (frame == nullptr) throw Error("getFrame: the buffer is null");
    for (const Rgba& pixel : state.frame.pixels)
      for (std::size_t k = 0; k < 3; ++k) *frame++ = pixel[k];
  });
}

// --- Cameras

size_t getCameraCount() {
  return guarded(size_t{0}, [](State& state) { return state.cameras.size(); });
}

void nextCamera() {
  guarded([](State& state) { go_to_camera(state, static_cast<long long>(state.current) + 1); });
}

void previousCamera() {
  guarded([](State& state) { go_to_camera(state, static_cast<long long>(state.current) - 1); });
}

size_t getCurrentCameraIndex() {
  return guarded(size_t{0}, [](State& state) { return state.current; });
}

const char* getCurrentCameraName() {
  return guarded("", [](State& state) { return current_camera(state).name.c_str(); });
}

void gotoCamera(int index) {
  guarded([&](State& state) { go_to_camera(state, index); });
}

bool gotoCameraByName(const char* name) {
  return guarded(false, [&](State& state) { return go_to_camera(state, name); });
}

void setCameraPosition(float x, float y, float z) {
  guarded([&](State& state) { current_camera(state).position = {x, y, z}; });
}

void getCameraPosition(float* x, float* y, float* z) {
  guarded([&](State& state) {
    const Vec3 position = current_camera(state).position;
    if (x != nullptr) *x = position.x;
    if (y != nullptr) *y = position.y;
    if (z != nullptr) *z = position.z;
  });
}

void setCameraLocalSpace(float lxx, float lxy, float lxz, float lyx, float lyy, float lyz,
                         float lzx, float lzy, float lzz) {
  guarded([&](State& state) {
    current_camera(state).space = {{lxx, lxy, lxz}, {lyx, lyy, lyz}, {lzx, lzy, lzz}};
  });
}

void rotateCameraAround(float angle, float axisX, float axisY, float axisZ) {
  guarded([&](State& state) {
    rotate_around(current_camera(state), angle, {axisX, axisY, axisZ});
  });
}

void rotateCameraLocallyAround(float angle, float axisX, float axisY, float axisZ) {
  guarded([&](State& state) {
    CompatCamera& camera = current_camera(state);
    rotate_around(camera, angle, to_world(camera, {axisX, axisY, axisZ}));
  });
}

void translateCamera(float x, float y, float z) {
  guarded([&](State& state) {
    CompatCamera& camera = current_camera(state);
    camera.position = camera.position + Vec3{x, y, z};
  });
}

void translateCameraLocally(float x, float y, float z) {
  guarded([&](State& state) {
    CompatCamera& camera = current_camera(state);
    camera.position = camera.position + to_world(camera, {x, y, z});
  });
}

void resetCameraPose() {
  guarded([](State& state) {
    CompatCamera& camera = current_camera(state);
    camera.space = {};
    camera.position = {};
  });
}

void setCameraPose(float posX, float posY, float posZ, float rotX, float rotY, float rotZ) {
  guarded([&](State& state) {
    CompatCamera& camera = current_camera(state);
    camera.space = {};
    rotate_around(camera, rotX, {1, 0, 0});
    rotate_around(camera, rotY, {0, 1, 0});
    rotate_around(camera, rotZ, {0, 0, 1});
    camera.position = {posX, posY, posZ};
  });
}

// --- Compound eyes

bool isCompoundEyeActive() {
  return guarded(false, [](State& state) { return current_eye(state) != nullptr; });
}

void setCurrentEyeSamplesPerOmmatidium(int s) {
  guarded([&](State& state) {
    if (current_eye(state) != nullptr) set_samples(current_camera(state), s);
  });
}

int getCurrentEyeSamplesPerOmmatidium() {
  return guarded(-1, [](State& state) {
    const CompoundEye* eye = current_eye(state);
    return eye == nullptr ? -1 : eye->samples;
  });
}

void changeCurrentEyeSamplesPerOmmatidiumBy(int s) {
  guarded([&](State& state) {
    if (const CompoundEye* eye = current_eye(state))
      set_samples(current_camera(state), static_cast<long long>(eye->samples) + s);
  });
}

size_t getCurrentEyeOmmatidialCount() {
  return guarded(size_t{0}, [](State& state) {
    const CompoundEye* eye = current_eye(state);
    return eye == nullptr ? size_t{0} : eye->eye.size();
  });
}

void setOmmatidia(OmmatidiumPacket* omms, size_t count) {
  guarded([&](State& state) {
    if (current_eye(state) == nullptr) return;
    if (omms == nullptr || count == 0)
      throw Error("setOmmatidia: there are no ommatidia; the eye stays as it was");
    set_eye(current_camera(state), eye_from(omms, count));
  });
}

const char* getCurrentEyeDataPath() {
  return guarded("", [](State& state) {
    const CompoundEye* eye = current_eye(state);
    return eye == nullptr ? "" : eye->path.c_str();
  });
}

void setCurrentEyeShaderName(const char* name) {
  guarded([&](State& state) {
    CompoundEye* eye = current_eye(state);
    if (eye == nullptr) return;
    const auto projection = find_projection(text(name));
    if (!projection)
      throw Error("the projection shader '" + text(name) + "' is not known; the eye keeps its own");
    eye->projection = *projection;
  });
}

// --- Geometry

bool isInsideHitGeometry(float x, float y, float z, const char* name) {
  return guarded(false, [&](State& state) {
    return is_inside_hit_geometry(state, {x, y, z}, text(name));
  });
}

float3 getGeometryMaxBounds(const char* name) {
  return guarded(float3{},
                 [&](State& state) { return to_float3(geometry_bounds(state, text(name)).upper); });
}

float3 getGeometryMinBounds(const char* name) {
  return guarded(float3{},
                 [&](State& state) { return to_float3(geometry_bounds(state, text(name)).lower); });
}

// getWindowPointer for C and ctypes; the header gives C++ the other one.
void* c_window_pointer() __asm__("getWindowPointer");
void* c_window_pointer() {
  return nullptr;
}

}  // extern "C"

void* getWindowPointer() {
  return nullptr;
}
