// The way of the head, and of things, while what is seen goes into a frame, for
// physics/head_motion.h.
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

// A part of a frame that lasts, for things that move meanwhile: where they are at its middle they are
// for all its rays, one of each `count` of an ommatidium (rays.h). The whole frame is one part.
struct TimePart {
  int index = 0, count = 1;    // a power of two
  double first = 0, size = 1;  // its delays, as quantiles: `size` is how much it counts
};

// As many parts as so many rays can have.
int parts_for(int samples);

// Parts are alike in a mean of how probable their delays are and how long they last: a long tail of
// few rays moves too far to be one. `delays_s`: see RenderSettings.
TimePart time_part(int index, int count, std::span<const double> delays_s);

// So many rays of an ommatidium are in a part.
int samples_in(const TimePart& part, int samples);

// How long before the frame the middle of a part is, s.
double delay_of(const TimePart& part, std::span<const double> delays_s);

// Null where the head stands still for as long as the frame sees.
const HeadMotion* motion_of(const HeadPath& path, std::size_t frame, const TimePart& part,
                            FrameMotion& kept);

// From one transform to another: positions and stretches linearly, turns by slerp.
Mat4 transform_between(const Mat4& from, const Mat4& to, double part);

}  // namespace omma
