// The hot loop. Rays are written straight into packets of 16: packets run through the samples of an
// ommatidium and on into the next one, so that none is left half full. Nothing is allocated.
//
// This file is compiled once per instruction set (OMMA_ISA names the namespace). It calls nothing
// out of line that other files share, so that no code for a newer processor can leak into them.
#include "backend/embree/block.h"

#include <limits>

#include "kernel/hash.h"
#include "kernel/path.h"
#include "kernel/random_direction.h"

namespace omma::OMMA_ISA {
namespace {

constexpr int lanes = 16;

// What the lanes of one packet add to: consecutive lanes of one estimate.
struct Run {
  int unit;  // ommatidium in the block * scrambles + scramble
  int first, count;
  int sample;  // of the first lane
};

struct PacketLight {
  alignas(64) float channel[channel_count][lanes];
  alignas(64) float alpha[lanes];
};

struct Packet {
  RTCRayHit16 rays;
  PacketLight light;
  Run runs[lanes];
  int run_count = 0;
  int filled = 0;
};

// World frames of the ommatidia of a block; s and t lie across the axis.
struct Frames {
  alignas(64) float origin[3][block_capacity];
  alignas(64) float axis[3][block_capacity];
  alignas(64) float s[3][block_capacity];
  alignas(64) float t[3][block_capacity];
  alignas(64) float t_near[block_capacity];
};

template <typename Vector, typename T>
__attribute__((always_inline)) inline Vector load(const T* p) {
  Vector v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

template <typename Vector>
__attribute__((always_inline)) inline void store(float* p, Vector v) {
  __builtin_memcpy(p, &v, sizeof v);
}

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

void clear(Packet& packet) {
  for (int l = 0; l < lanes; ++l) {
    // A last packet may stay part empty: its idle lanes still go through the vector loops.
    packet.rays.ray.dir_x[l] = packet.rays.ray.dir_y[l] = packet.rays.ray.dir_z[l] = 0;
    packet.rays.ray.time[l] = 0;
    packet.rays.ray.mask[l] = 0xffffffffu;
    packet.rays.ray.id[l] = static_cast<unsigned>(l);
    packet.rays.ray.flags[l] = 0;
  }
}

void prepare(RTCRayHit16& rays) {
  for (int l = 0; l < lanes; ++l) {
    rays.ray.tfar[l] = std::numeric_limits<float>::infinity();
    rays.hit.geomID[l] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][l] = RTC_INVALID_GEOMETRY_ID;
  }
}

// Index of the mesh that each lane hit, -1 for none.
void find_meshes(const EmbreeTracer& tracer, const RTCHit16& hit, std::int32_t (&mesh)[lanes]) {
  for (int l = 0; l < lanes; l += lane_width) {
    const Ints geometry = load<Ints>(hit.geomID + l), instance = load<Ints>(hit.instID[0] + l);
    const Ints top = instance < 0 ? geometry : instance;  // an invalid id is -1
    const Ints found = gather(tracer.mesh_of_geometry.data(), top < 0 ? top * 0 : top);
    const Ints result = geometry < 0 ? geometry : found;
    __builtin_memcpy(mesh + l, &result, sizeof result);
  }
}

// Mesh by mesh: mostly all lanes see the same one.
void eval_surfaces(const SceneView& scene, const RTCHit16& hit, const std::int32_t (&mesh)[lanes],
                   PacketLight& light) {
  unsigned left = 0;
  for (int l = 0; l < lanes; l += lane_width) left |= lane_bits(load<Ints>(mesh + l) >= 0) << l;
  while (left != 0) {
    const std::int32_t current = mesh[__builtin_ctz(left)];
    unsigned members = 0;
    for (int l = 0; l < lanes; l += lane_width)
      members |= lane_bits(load<Ints>(mesh + l) == current) << l;
    left &= ~members;
    for (int l = 0; l < lanes; l += lane_width) {
      if ((members >> l & ((1u << lane_width) - 1)) == 0) continue;
      const Ints is_member = load<Ints>(mesh + l) == current;
      // Lanes of other meshes, and without a hit, hold anything; they go through as zeros.
      const Ints triangle = load<Ints>(hit.primID + l) & is_member;
      const Ints u = load<Ints>(hit.u + l) & is_member, v = load<Ints>(hit.v + l) & is_member;
      const SurfaceLight<Floats> s =
          eval_surface(scene, scene.meshes[current], triangle, (Floats)u, (Floats)v);
      for (int c = 0; c < channel_count; ++c)
        store(light.channel[c] + l, is_member ? s.channel[c] : load<Floats>(light.channel[c] + l));
      store(light.alpha + l, is_member ? s.alpha : load<Floats>(light.alpha + l));
    }
  }
}

// Background of all lanes at once.
void background_radiance(const SceneView& scene, const RTCRay16& ray,
                         float (&out)[channel_count][lanes]) {
  switch (scene.background.type) {
    case BackgroundType::constant:
      for (int l = 0; l < lanes; ++l) {
        out[0][l] = scene.background.color.x;
        out[1][l] = scene.background.color.y;
        out[2][l] = scene.background.color.z;
      }
      return;
    case BackgroundType::simple_sky:
      for (int l = 0; l < lanes; ++l) {
        const Radiance r = eval_simple_sky({ray.dir_x[l], ray.dir_y[l], ray.dir_z[l]});
        for (int c = 0; c < channel_count; ++c) out[c][l] = r.channel[c];
      }
      return;
    case BackgroundType::test_pattern:
    case BackgroundType::image:
      for (int l = 0; l < lanes; ++l) {
        const Radiance r = eval_background(scene, {ray.dir_x[l], ray.dir_y[l], ray.dir_z[l]});
        for (int c = 0; c < channel_count; ++c) out[c][l] = r.channel[c];
      }
      return;
  }
}

// Opaque scenes: one trace, one surface or the background.
void shade_opaque(const BlockContext& context, Packet& packet, const int* valid,
                  IntersectArguments& arguments) {
  prepare(packet.rays);
  intersect_16(context.tracer->scene, valid, packet.rays, arguments);
  alignas(64) std::int32_t mesh[lanes];
  find_meshes(*context.tracer, packet.rays.hit, mesh);
  unsigned misses = 0;
  for (int l = 0; l < lanes; l += lane_width) misses |= lane_bits(load<Ints>(mesh + l) < 0) << l;
  if (misses != 0) background_radiance(*context.scene, packet.rays.ray, packet.light.channel);
  eval_surfaces(*context.scene, packet.rays.hit, mesh, packet.light);
}

// Scenes with surfaces that let light through: on behind each, until nothing gets through.
void shade_blended(const BlockContext& context, Packet& packet, const int* valid,
                   IntersectArguments& arguments) {
  Path paths[lanes];
  alignas(64) float background[channel_count][lanes];
  alignas(64) int active[lanes];
  for (int l = 0; l < lanes; ++l) active[l] = valid[l];
  bool any = true;
  while (any) {
    prepare(packet.rays);
    intersect_16(context.tracer->scene, active, packet.rays, arguments);
    background_radiance(*context.scene, packet.rays.ray, background);
    alignas(64) std::int32_t mesh[lanes];
    find_meshes(*context.tracer, packet.rays.hit, mesh);
    eval_surfaces(*context.scene, packet.rays.hit, mesh, packet.light);
    any = false;
    for (int l = 0; l < lanes; ++l) {
      if (active[l] == 0) continue;
      if (mesh[l] < 0) {
        add_background(paths[l], {{background[0][l], background[1][l], background[2][l]}});
        active[l] = 0;
        continue;
      }
      SurfaceLight<float> light;
      for (int c = 0; c < channel_count; ++c) light.channel[c] = packet.light.channel[c][l];
      light.alpha = packet.light.alpha[l];
      const bool on = add_surface(paths[l], light);
      active[l] = on ? -1 : 0;
      any = any || on;
      packet.rays.ray.tnear[l] = step_behind(packet.rays.ray.tfar[l]);
    }
  }
  for (int l = 0; l < lanes; ++l)
    for (int c = 0; c < channel_count; ++c)
      packet.light.channel[c][l] = paths[l].radiance.channel[c];
}

// What each single ray brought, where the caller asks; there is one scramble then.
void keep_rays(const BlockContext& context, const BlockTask& task, const Packet& packet) {
  for (int r = 0; r < packet.run_count; ++r) {
    const Run run = packet.runs[r];
    const std::size_t ommatidium = context.eye->ommatidium.data()[task.first + run.unit];
    const std::size_t first = ommatidium * static_cast<std::size_t>(context.directions->samples) +
                              static_cast<std::size_t>(run.sample);
    float* out = task.ray_radiance + first * channel_count;
    for (int l = 0; l < run.count; ++l)
      for (int c = 0; c < channel_count; ++c) *out++ = packet.light.channel[c][run.first + l];
  }
}

// Traces and shades what the packet holds and adds it to the sums of its estimates, always in the
// same order.
void trace_and_add(const BlockContext& context, const BlockTask& task, Packet& packet,
                   double (*sums)[channel_count], IntersectArguments& arguments) {
  alignas(64) static constexpr int all[lanes] = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                 -1, -1, -1, -1, -1, -1, -1, -1};
  alignas(64) int some[lanes];
  const int* valid = all;
  if (packet.filled < lanes) {
    for (int l = 0; l < lanes; ++l) some[l] = l < packet.filled ? -1 : 0;
    valid = some;
  }
  if (context.scene->has_blend)
    shade_blended(context, packet, valid, arguments);
  else
    shade_opaque(context, packet, valid, arguments);
  for (int r = 0; r < packet.run_count; ++r) {
    const Run run = packet.runs[r];
    for (int c = 0; c < channel_count; ++c) {
      const float* x = packet.light.channel[c] + run.first;
      float sum = 0;
      if (run.count == lanes) {
        using Quad = float __attribute__((vector_size(16)));
        const Quad quad =
            (load<Quad>(x) + load<Quad>(x + 8)) + (load<Quad>(x + 4) + load<Quad>(x + 12));
        sum = (quad[0] + quad[1]) + (quad[2] + quad[3]);
      } else {
        for (int l = 0; l < run.count; ++l) sum += x[l];
      }
      sums[run.unit][c] += sum;
    }
  }
  if (task.ray_radiance != nullptr) keep_rays(context, task, packet);
}

// One ommatidium as a ray source: its frame with the scramble's turn about the axis applied.
struct RaySource {
  float origin[3], axis[3], s[3], t[3], t_near;
};

RaySource make_ray_source(const Frames& frames, int i, Vec2 turn) {
  RaySource source;
  for (int r = 0; r < 3; ++r) {
    source.origin[r] = frames.origin[r][i];
    source.axis[r] = frames.axis[r][i];
    source.s[r] = frames.s[r][i] * turn.x + frames.t[r][i] * turn.y;
    source.t[r] = frames.t[r][i] * turn.x - frames.s[r][i] * turn.y;
  }
  source.t_near = frames.t_near[i];
  return source;
}

// A component far below the rounding of a unit vector becomes zero: Embree's packets miss boxes
// where one is 1e-14 to 1e-17 (tests/cpp/render_surround.cpp), but not where it is zero.
__attribute__((always_inline)) inline float without_noise(float component) {
  return component < 1e-9f && component > -1e-9f ? 0.0f : component;
}

// Writes lanes [first, first + count) from local directions.
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
  }
}

// Responses from the sums of a block: the mean over all scrambles and, where asked for, its
// standard error from their spread.
void reduce(const BlockContext& context, const BlockTask& task,
            const double (*sums)[channel_count]) {
  const double samples = context.directions->samples;
  const int scrambles = context.scrambles;
  for (int i = 0; i < task.count; ++i) {
    const std::size_t out =
        static_cast<std::size_t>(context.eye->ommatidium.data()[task.first + i]) * channel_count;
    for (int c = 0; c < channel_count; ++c) {
      double mean = 0;
      for (int r = 0; r < scrambles; ++r) mean += sums[i * scrambles + r][c];
      mean /= samples * scrambles;
      task.responses[out + static_cast<std::size_t>(c)] = static_cast<float>(mean);
      if (task.standard_error == nullptr) continue;
      double squares = 0;
      for (int r = 0; r < scrambles; ++r) {
        const double d = sums[i * scrambles + r][c] / samples - mean;
        squares += d * d;
      }
      task.standard_error[out + static_cast<std::size_t>(c)] =
          static_cast<float>(sqrt(squares / (scrambles * (scrambles - 1.0))));
    }
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
    for (int scramble = 0; scramble < context.scrambles; ++scramble) {
      const RaySource source = make_ray_source(frames, i, find_turn(tables, hash, scramble));
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

void render_block(const BlockContext& context, const BlockTask& task) {
  const DenormalsAreZero denormals_are_zero;
  double sums[block_capacity][channel_count];
  for (int u = 0; u < task.count * context.scrambles; ++u)
    for (double& sum : sums[u]) sum = 0;
  IntersectArguments arguments;
  for_each_packet(context, task,
                  [&](Packet& packet) { trace_and_add(context, task, packet, sums, arguments); });
  reduce(context, task, sums);
}

void prepare_block(const BlockContext& context, const BlockTask& task, RTCRayHit16* packets) {
  for_each_packet(context, task, [&](Packet& packet) {
    prepare(packet.rays);
    *packets++ = packet.rays;
  });
}

}  // namespace omma::OMMA_ISA
