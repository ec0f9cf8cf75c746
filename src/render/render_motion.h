// The way of the head, and of things, while what is seen goes into a frame, for
// physics/rays/head_motion.h.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "omma/render.h"
#include "physics/rays/head_motion.h"

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

// The motion of one frame, with its tables.
struct FrameMotion {
  std::vector<float> delay, node;
  HeadMotion motion;
  bool stands = true;  // the head, for as long as the frame sees
};

// A time interval of a frame, for things that move: all rays of it see them where they are at its
// middle, one ray of each `count` of an ommatidium (rays.h). The whole frame is one interval.
struct TimePart {
  int index = 0, count = 1;    // a power of two
  double first = 0, size = 1;  // its delays, as quantiles: `size` is how much it counts
};

// The number of intervals for so many rays of an ommatidium.
int parts_for(int samples);

// Intervals are equal in a mixture of probability and length: by probability alone the long tail
// would be one interval, in which things move too far. `delays_s`: see RenderSettings.
TimePart time_part(int index, int count, std::span<const double> delays_s);

// The number of an ommatidium's rays in an interval.
int samples_in(const TimePart& part, int samples);

// The delay at the middle of an interval, s.
double delay_of(const TimePart& part, std::span<const double> delays_s);

void set_motion(const HeadPath& path, std::size_t frame, const TimePart& part, FrameMotion& made);

// Null where the head stands still for as long as the frame sees.
inline const HeadMotion* motion_of(const FrameMotion& made) {
  return made.stands ? nullptr : &made.motion;
}

// From one transform to another: positions and stretches linearly, turns by slerp.
Mat4 transform_between(const Mat4& from, const Mat4& to, double part);

}  // namespace omma
