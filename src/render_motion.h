// The way of the head while what is seen goes into a frame, for physics/head_motion.h.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "omma/render.h"
#include "physics/head_motion.h"

namespace omma {

// Where the head is at a time: traced_from_head = position * turn * stretch.
struct HeadKey {
  double time_s = 0;
  Mat4 traced_from_head;
  std::array<double, 4> turn;  // unit quaternion x, y, z, w
  Mat4 stretch;
};

// What a call says of time, checked against its poses.
struct HeadPath {
  std::vector<HeadKey> keys;  // those before the call's poses, then these; times grow
  std::size_t past = 0;       // so many are before the first frame
  std::vector<float> delay;   // quantiles, as parts of the longest
  double longest_s = 0;       // delay
};

// Empty where frames are instants. Throws omma::Error where times and poses do not fit.
HeadPath head_path(const RenderSettings& settings, const RenderCall& call,
                   std::span<const Mat4> traced_past, std::span<const Mat4> traced);

// The motion of one frame; its tables stay where they are until the next is asked for.
struct FrameMotion {
  std::vector<float> delay, node;
  HeadMotion motion;
  bool stands = true;  // the head, for as long as the frame sees
  std::size_t frame = ~std::size_t{0};
};

// Null where the head stands still for as long as the frame sees.
const HeadMotion* motion_of(const HeadPath& path, std::size_t frame, FrameMotion& kept);

}  // namespace omma
