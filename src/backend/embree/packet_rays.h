// Rays of a block, written straight into packets of 16: packets run through the samples of an
// ommatidium and on into the next one, so that none is left half full. Included by block.cpp alone,
// once per instruction set.
#pragma once

#include "backend/embree/packet.h"
#include "kernel/hash.h"
#include "kernel/random_direction.h"

namespace omma::OMMA_ISA {
namespace {

// World frames of the ommatidia of a block; s and t lie across the axis.
struct Frames {
  alignas(64) float origin[3][block_capacity];
  alignas(64) float axis[3][block_capacity];
  alignas(64) float s[3][block_capacity];
  alignas(64) float t[3][block_capacity];
  alignas(64) float t_near[block_capacity];
};

// The eye's arrays are padded, so that the last lanes read something.
void make_frames(const EyeArrays& eye, const BlockTask& task, Frames& frames) {
  const float(&m)[3][4] = task.world_from_head;
  for (int i = 0; i < task.count; i += lane_width) {
    const std::size_t e = static_cast<std::size_t>(task.first + i);
    const auto at = [&](const std::vector<float>& values) { return load<Floats>(&values[e]); };
    const Floats origin[3] = {at(eye.origin_x), at(eye.origin_y), at(eye.origin_z)};
    const Floats axis[3] = {at(eye.axis_x), at(eye.axis_y), at(eye.axis_z)};
    const Floats side[3] = {at(eye.side_x), at(eye.side_y), at(eye.side_z)};
    Floats a[3], s[3];
    for (int r = 0; r < 3; ++r) {
      store(frames.origin[r] + i,
            m[r][0] * origin[0] + m[r][1] * origin[1] + m[r][2] * origin[2] + m[r][3]);
      a[r] = m[r][0] * axis[0] + m[r][1] * axis[1] + m[r][2] * axis[2];
      s[r] = m[r][0] * side[0] + m[r][1] * side[1] + m[r][2] * side[2];
    }
    // Orthonormal again after the pose, which may scale.
    const Floats length_a = sqrt_lanes(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    store(frames.t_near + i, at(eye.focal_offset_m) * length_a);
    for (Floats& x : a) x /= length_a;
    const Floats along = s[0] * a[0] + s[1] * a[1] + s[2] * a[2];
    for (int r = 0; r < 3; ++r) s[r] -= along * a[r];
    const Floats length_s = sqrt_lanes(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (Floats& x : s) x /= length_s;
    const Floats t[3] = {a[1] * s[2] - a[2] * s[1], a[2] * s[0] - a[0] * s[2],
                         a[0] * s[1] - a[1] * s[0]};
    for (int r = 0; r < 3; ++r) {
      store(frames.axis[r] + i, a[r]);
      store(frames.s[r] + i, s[r]);
      store(frames.t[r] + i, t[r]);
    }
  }
}

// One ommatidium as a ray source: its frame with the scramble's turn about the axis applied.
struct RaySource {
  float origin[3], axis[3], s[3], t[3], t_near, footprint_rad;
};

RaySource make_ray_source(const Frames& frames, int i, Vec2 turn, float footprint_rad) {
  RaySource source;
  for (int r = 0; r < 3; ++r) {
    source.origin[r] = frames.origin[r][i];
    source.axis[r] = frames.axis[r][i];
    source.s[r] = frames.s[r][i] * turn.x + frames.t[r][i] * turn.y;
    source.t[r] = frames.t[r][i] * turn.x - frames.s[r][i] * turn.y;
  }
  source.t_near = frames.t_near[i];
  source.footprint_rad = footprint_rad;
  return source;
}

// A component far below the rounding of a unit vector becomes zero: Embree's packets miss boxes
// where one is 1e-14 to 1e-17 (tests/cpp/render_surround.cpp), but not where it is zero.
__attribute__((always_inline)) inline float without_noise(float component) {
  return component < 1e-9f && component > -1e-9f ? 0.0f : component;
}

// Writes lanes [first, first + count) from local directions. The ray's id holds the bits of its
// footprint's width (rad), where the candidate filter finds it too.
__attribute__((always_inline)) inline void write_rays(RTCRay16& ray, const RaySource& source,
                                                      const float* x, const float* y,
                                                      const float* z, int first, int count) {
  for (int k = 0; k < count; ++k) {
    const int l = first + k;
    ray.org_x[l] = source.origin[0];
    ray.org_y[l] = source.origin[1];
    ray.org_z[l] = source.origin[2];
    ray.dir_x[l] = without_noise(source.s[0] * x[k] + source.t[0] * y[k] + source.axis[0] * z[k]);
    ray.dir_y[l] = without_noise(source.s[1] * x[k] + source.t[1] * y[k] + source.axis[1] * z[k]);
    ray.dir_z[l] = without_noise(source.s[2] * x[k] + source.t[2] * y[k] + source.axis[2] * z[k]);
    ray.tnear[l] = source.t_near;
    ray.id[l] = static_cast<unsigned>(bits_of(source.footprint_rad));
  }
}

// Directions `first` to `first + count` of an estimate with random sampling; x, y, z have room for
// a whole packet.
void make_random_directions(const DirectionTables& tables, std::uint32_t warp, std::uint64_t hash,
                            int scramble, int first, int count, float* x, float* y, float* z) {
  const std::uint64_t estimate = hash_combine(hash, static_cast<std::uint64_t>(scramble));
  const float* polar = find_polar(tables, warp);
  Uints index;
  for (int l = 0; l < lane_width; ++l) index[l] = static_cast<std::uint32_t>(first + l);
  for (int l = 0; l < count; l += lane_width) {
    const LocalDirection<Floats> d =
        sample_random_direction<Floats>(polar, static_cast<std::uint32_t>(estimate),
                                        static_cast<std::uint32_t>(estimate >> 32), index);
    store(x + l, d.x);
    store(y + l, d.y);
    store(z + l, d.z);
    index += static_cast<std::uint32_t>(lane_width);
  }
}

// Writes the rays of a block into packets, in a fixed order, and hands each full one (and the last)
// to `consume`.
template <typename Consume>
__attribute__((always_inline)) inline void for_each_packet(const BlockContext& context,
                                                           const BlockTask& task,
                                                           const Consume& consume) {
  const DirectionTables& tables = *context.directions;
  Frames frames;
  make_frames(*context.eye, task, frames);
  Packet packet;
  clear(packet);
  const std::uint64_t pose_bits = pose_hash(tables.seed, task.pose);
  for (int i = 0; i < task.count; ++i) {
    const std::uint32_t warp = context.eye->warp.data()[task.first + i];
    const std::uint64_t hash =
        scramble_hash(pose_bits, context.eye->ommatidium.data()[task.first + i]);
    const float footprint_rad = context.eye->footprint_rad.data()[task.first + i];
    for (int scramble = 0; scramble < context.scrambles; ++scramble) {
      const RaySource source =
          make_ray_source(frames, i, find_turn(tables, hash, scramble), footprint_rad);
      DirectionPattern pattern;
      if (tables.patterns > 0) pattern = find_pattern(tables, warp, hash, scramble);
      for (int sample = 0; sample < tables.samples;) {
        const int room = lanes - packet.filled;
        const int count = tables.samples - sample < room ? tables.samples - sample : room;
        float x[lanes], y[lanes], z[lanes];
        DirectionPattern d{x, y, z};
        if (tables.patterns > 0)
          d = {pattern.x + sample, pattern.y + sample, pattern.z + sample};
        else if (tables.sampling == Sampling::random)
          make_random_directions(tables, warp, hash, scramble, sample, count, x, y, z);
        else
          make_directions(tables, warp, hash, scramble, sample, count, x, y, z);
        if (count == lanes)
          write_rays(packet.rays.ray, source, d.x, d.y, d.z, 0, lanes);
        else
          write_rays(packet.rays.ray, source, d.x, d.y, d.z, packet.filled, count);
        packet.runs[packet.run_count++] = {i * context.scrambles + scramble, packet.filled, count,
                                           sample};
        packet.filled += count;
        sample += count;
        if (packet.filled < lanes) continue;
        consume(packet);
        packet.filled = 0;
        packet.run_count = 0;
      }
    }
  }
  if (packet.filled > 0) consume(packet);
}

}  // namespace
}  // namespace omma::OMMA_ISA
