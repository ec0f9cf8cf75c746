// What frames are rendered from besides the scene (scene_view.h), as the physics sees it: an eye
// and its patterns of directions, as flat arrays behind pointers, the same on host and device. Made
// by backend/eye_arrays and sampling/directions.
#pragma once

#include <cstdint>

#include "physics/sampling/acceptance_sampling.h"
#include "physics/sampling/random_direction.h"
#include "physics/views/ray_packet.h"
#include "physics/views/scene_view.h"

namespace omma {

// Turns about the axis that a scramble can have; a power of two.
inline constexpr std::uint64_t turn_count = 1024;

// All arrays [ommatidium + zeros_behind], in an order along which neighbours in memory are
// neighbours in direction; vector loops may read the zeros. Frame: head.
inline constexpr int zeros_behind = 16;
struct EyeView {
  const float* origin[3] = {};  // m, position - axis * focal offset
  const float* axis[3] = {};    // unit
  const float* up[3] = {};      // unit, across the axis
  const float* focal_offset_m = nullptr;
  const float* aperture_radius_m = nullptr;
  const float* scale = nullptr;              // of its warp: sines of polar angles times this
  const std::int32_t* warp = nullptr;        // index into the warps of DirectionsView
  const std::int32_t* ommatidium = nullptr;  // index in the Eye
  const std::int32_t* number = nullptr;      // in its own eye of a population, for random numbers
  bool has_apertures = false;                // whether any radius is above 0
  bool has_scales = false;                   // whether any scale is not 1
  std::int32_t ommatidium_count = 0;
  Version version = 0;  // of FrameView::nearest too
};

struct DirectionsView {
  int samples = 0;
  // They are those of a pattern of pattern_samples that belong to one of 2^part_bits parts
  // (pattern_parts.h): all of them, but where frames last while things move.
  int pattern_samples = 0, part = 0, part_bits = 0;
  bool random = false;  // independent directions; else low-discrepancy patterns
  std::uint64_t seed = 0;
  int patterns = 0;  // per warp, a power of two; 0: directions are made on the way
  // [warp][pattern][x, y, z][pattern_samples], unit, in a frame with x up, y right, z along the
  // axis.
  const float* local = nullptr;
  const Vec2* turns = nullptr;                // [turn_count + 1], cosine, sine; the last is no turn
  const std::int32_t* fixed_turn = nullptr;   // [warp], the turn that all have, or -1
  const float* footprint_rad = nullptr;       // [warp], width of each ray (footprint.h)
  const AcceptanceWarpView* warps = nullptr;  // [warp]
  PolarTablesView polar;                      // with random sampling
  std::int32_t warp_count = 0;
  Version version = 0;
};

// Ommatidia that each listens to where rays go on to an error.
inline constexpr int listened_to = 8;

struct HeadMotion;  // head_motion.h
struct TruthTask;   // truth_view.h
struct TruthView;   // the same

// Everything that stays the same between frames.
struct FrameView {
  const SceneView* scene = nullptr;
  const EyeView* eye = nullptr;
  const DirectionsView* directions = nullptr;  // [rounds]
  int scrambles = 1;                           // independent estimates of each response
  // Responses have so many numbers: the bands of the scene, in a polarised world those of I or of
  // I, Q and U one behind the other, or where there is a matrix its rows.
  int outputs = 3;
  // [output][component][band], or null: the bands themselves.
  const float* output_from_band = nullptr;
  // What a radiance of 1 is on the way, so that squares stay in single precision; a power of two.
  double radiance_unit = 1;
  // Rendering to an error: a round of directions[k].samples rays, twice as many for each k, goes to
  // the ommatidia that need it until their standard error is the larger of `error` and
  // `relative_error` times the response, or their rays are most_samples.
  int rounds = 1;
  double error = 0, relative_error = 0;
  int most_samples = 0;                   // 0: not rendered to an error
  const std::uint8_t* nearest = nullptr;  // [ommatidium][listened_to], place in its block
  const TruthView* truth = nullptr;       // null: none is asked for
  bool beside_moments = false;            // whether BlockTask::beside_rays is asked for
  // By which rays count discs of the sky (counts_by_rays), the same for all; -1: each ommatidium's
  // own.
  float acceptance_sr = -1;
};

inline constexpr int axis_moments = 4;

// RayPacket::mask of rays on their way from the eye, and of those that go on from surfaces and to
// lights.
struct SeenMasks {
  std::uint32_t from_eye = all_seen, by_light = all_seen;
};

// A block of neighbouring ommatidia at one pose.
struct BlockTask {
  float world_from_head[3][4] = {};  // row major
  // How the head moves while what is seen goes into the frame; null: it does not.
  const HeadMotion* motion = nullptr;
  std::uint64_t pose = 0;           // index, for the random numbers
  SeenMasks sees;                   // of its rays
  int first = 0, count = 0;         // ommatidia, in the order of EyeView
  float* responses = nullptr;       // [ommatidium][output] of this pose
  float* standard_error = nullptr;  // the same, or null
  std::int32_t* rays = nullptr;     // [ommatidium] of this pose, spent; or null
  float* ray_radiance = nullptr;    // [ommatidium][sample][output] of this pose, or null
  // Or null: what is seen beside rays, and its moments (disc_density.h), of this pose,
  // [ommatidium][1 + axis_moments][output].
  float* beside_rays = nullptr;
  const TruthTask* truth = nullptr;  // of this pose, where it is asked for
};

}  // namespace omma
