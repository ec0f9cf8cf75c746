// Rays of a block, written straight into packets of 16: packets run through the samples of one unit
// (an ommatidium under one scramble) and on into the next, so that none is left half full. All of
// it runs in lanes, whether a packet holds one unit or sixteen. Included by block.cpp alone, once
// per instruction set.
#pragma once

#include "backend/embree/packet.h"
#include "physics/hash.h"
#include "physics/random_direction.h"

namespace omma::OMMA_ISA {
namespace {

// Vector loops read a packet's width past the last unit.
constexpr int unit_room = block_capacity + lanes;

// Which ommatidia of a block are rendered, each under which scrambles: unit u is the ommatidium
// ordinal[u / scrambles] of the eye's arrays under scramble first_scramble + u % scrambles.
struct UnitList {
  const std::int32_t* ordinal = nullptr;  // null: task.first and on
  int first_scramble = 0, scrambles = 1;
  int count = 0;  // of units
};

// World frames of units; s and t lie across the axis, the scramble's turn about it applied.
struct Units {
  alignas(64) float origin[3][unit_room];
  alignas(64) float axis[3][unit_room];
  alignas(64) float s[3][unit_room];
  alignas(64) float t[3][unit_room];
  alignas(64) float t_near[unit_room];
  alignas(64) float footprint_rad[unit_room];  // width of each ray (physics/footprint.h)
  alignas(64) float aperture_radius[unit_room];
  alignas(64) float scale[unit_room];              // of sines of polar angles
  alignas(64) std::int32_t directions[unit_room];  // where its pattern begins, or which warp
  alignas(64) std::int32_t hash[unit_room];        // of its scramble
  bool has_apertures, has_scales;
  PolarTablesView polar;
};

// The eye's arrays are padded, so that the last lanes read something; lanes behind the last unit
// repeat it.
void make_units(const BlockContext& context, const BlockTask& task, const DirectionTables& tables,
                const UnitList& list, Units& units) {
  const EyeArrays& eye = *context.eye;
  const float(&m)[3][4] = task.world_from_head;
  const std::uint64_t pose = pose_hash(tables.seed, task.pose);
  const bool in_order = list.ordinal == nullptr && list.scrambles == 1;
  units.has_apertures = eye.has_apertures;
  units.has_scales = eye.has_scales;
  units.polar = view(tables.polar);
  const float per_scramble = 1.0f / static_cast<float>(list.scrambles);
  for (int u = 0; u < list.count; u += lane_width) {
    Ints unit = lane_numbers() + u;
    unit = unit < list.count ? unit : unit * 0 + (list.count - 1);
    const Ints listed = to_int((to_float(unit) + 0.5f) * per_scramble);
    const Uints scramble = (Uints)(unit - listed * list.scrambles + list.first_scramble);
    const Ints e = list.ordinal == nullptr ? listed + task.first : gather(list.ordinal, listed);
    const auto at = [&](const auto& values) {
      using Vector = decltype(gather(values.data(), e));
      return in_order ? load<Vector>(values.data() + task.first + u) : gather(values.data(), e);
    };

    // The frame at this pose; orthonormal again, as a pose may scale.
    const Floats origin[3] = {at(eye.origin_x), at(eye.origin_y), at(eye.origin_z)};
    const Floats axis[3] = {at(eye.axis_x), at(eye.axis_y), at(eye.axis_z)};
    const Floats up[3] = {at(eye.up_x), at(eye.up_y), at(eye.up_z)};
    Floats a[3], s[3];
    for (int r = 0; r < 3; ++r) {
      store(units.origin[r] + u,
            m[r][0] * origin[0] + m[r][1] * origin[1] + m[r][2] * origin[2] + m[r][3]);
      a[r] = m[r][0] * axis[0] + m[r][1] * axis[1] + m[r][2] * axis[2];
      s[r] = m[r][0] * up[0] + m[r][1] * up[1] + m[r][2] * up[2];
    }
    const Floats length_a = sqrt_lanes(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    store(units.t_near + u, at(eye.focal_offset_m) * length_a);
    const Floats scale_a = 1.0f / length_a;
    for (Floats& x : a) x *= scale_a;
    const Floats along = s[0] * a[0] + s[1] * a[1] + s[2] * a[2];
    for (int r = 0; r < 3; ++r) s[r] -= along * a[r];
    const Floats scale_s = 1.0f / sqrt_lanes(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (Floats& x : s) x *= scale_s;
    const Floats t[3] = {a[1] * s[2] - a[2] * s[1], a[2] * s[0] - a[0] * s[2],
                         a[0] * s[1] - a[1] * s[0]};

    // Its pattern, and its turn about the axis from other bits; scrambles of one ommatidium differ
    // in both.
    const Uints hash = ommatidium_hash(pose, (Uints)at(eye.ommatidium));
    const Ints warp = at(eye.warp);
    const Ints fixed_turn = gather(tables.fixed_turn.data(), warp);
    const Ints own_turn =
        (Ints)(((hash >> 20) + scramble * 389u) & static_cast<std::uint32_t>(turn_count - 1));
    const Ints turn = fixed_turn < 0 ? own_turn : fixed_turn;
    const float* turns = &tables.turns.data()->x;
    const Floats cosine = gather(turns, turn * 2), sine = gather(turns, turn * 2 + 1);
    for (int r = 0; r < 3; ++r) {
      store(units.axis[r] + u, a[r]);
      store(units.s[r] + u, s[r] * cosine + t[r] * sine);
      store(units.t[r] + u, t[r] * cosine - s[r] * sine);
    }
    store(units.footprint_rad + u, gather(tables.footprint_rad.data(), warp));
    if (tables.patterns > 0) {
      const Uints pattern = (hash + scramble) & static_cast<std::uint32_t>(tables.patterns - 1);
      store(units.directions + u, (warp * tables.patterns + (Ints)pattern) * (3 * tables.samples));
    } else {
      store(units.directions + u, warp);
    }
    store(units.hash + u, scramble_hash(hash, scramble));
    store(units.aperture_radius + u, at(eye.aperture_radius_m) * length_a);
    store(units.scale + u, at(eye.scale));
  }
}

// A component far below the rounding of a unit vector becomes zero: Embree's packets miss boxes
// where one is 1e-14 to 1e-17 (tests/cpp/render_surround.cpp), but not where it is zero.
__attribute__((always_inline)) inline Floats without_noise(Floats component) {
  return component < 1e-9f && component > -1e-9f ? component * 0.0f : component;
}

// Points all over the unit disc for samples of units: a lattice of two irrational steps (the
// plastic number's, whose points stay apart at any count), shifted by the unit's hash. Each point
// alone is uniform, so responses are unbiased.
struct DiscPoints {
  Floats x, y;
};

__attribute__((always_inline)) inline DiscPoints disc_points(Ints hash, Ints sample) {
  const Uints shift = mix_bits_32((Uints)hash + 0x68bc21ebu);
  const auto fraction = [&](Uints bits) { return (to_float((Ints)(bits >> 8)) + 0.5f) * 0x1p-24f; };
  const Floats radius = sqrt_lanes(fraction(shift + (Uints)sample * 3242174889u));
  const Floats turn = fraction(mix_bits_32(shift) + (Uints)sample * 2447445414u);
  const SineCosine<Floats> a = sine_cosine((2.0f * turn - 1.0f) * 3.14159265f);
  return {radius * a.cosine, radius * a.sine};
}

// Writes lane_width rays from lane l on: the first is sample `sample` of unit `unit`.
__attribute__((always_inline)) inline void write_rays(const DirectionTables& tables,
                                                      const Units& units, int last_unit, int unit,
                                                      int sample, float per_sample, Packet& packet,
                                                      int l) {
  const auto write = [&](LocalDirection<Floats> d, const auto& of_unit, const auto& points) {
    RTCRay16& ray = packet.rays.ray;
    if (units.has_scales) {
      const Floats scale = of_unit(units.scale);
      d.x *= scale;
      d.y *= scale;
      const Floats sine2 = d.x * d.x + d.y * d.y;
      const Floats cosine = sqrt_lanes(sine2 < 1.0f ? 1.0f - sine2 : 0.0f * sine2);
      d.z = d.z < 0.0f ? -cosine : cosine;
    }
    DiscPoints disc{};
    if (units.has_apertures) {
      disc = points();
      const Floats radius = of_unit(units.aperture_radius);
      disc = {disc.x * radius, disc.y * radius};
    }
    float* const direction[3] = {ray.dir_x + l, ray.dir_y + l, ray.dir_z + l};
    float* const origin[3] = {ray.org_x + l, ray.org_y + l, ray.org_z + l};
    for (int r = 0; r < 3; ++r) {
      const Floats from = of_unit(units.origin[r]);
      store(origin[r], units.has_apertures
                           ? from + of_unit(units.s[r]) * disc.x + of_unit(units.t[r]) * disc.y
                           : from);
      store(direction[r], without_noise(of_unit(units.s[r]) * d.x + of_unit(units.t[r]) * d.y +
                                        of_unit(units.axis[r]) * d.z));
    }
    store(ray.tnear + l, of_unit(units.t_near));
    store(packet.footprint_rad + l, of_unit(units.footprint_rad));
  };

  // All lanes are one unit's: straight from its pattern.
  const float* local = tables.local.data();
  if (tables.patterns > 0 && sample + lane_width <= tables.samples) {
    const float* p = local + units.directions[unit] + sample;
    write(
        {load<Floats>(p), load<Floats>(p + tables.samples), load<Floats>(p + 2 * tables.samples)},
        [&](const float* values) { return broadcast<Floats>(values[unit]); },
        [&] {
          return disc_points(lane_numbers() * 0 + units.hash[unit], lane_numbers() + sample);
        });
    return;
  }

  // Units that the lanes are ahead of the first one, and their sample within those.
  const Ints lane_sample = lane_numbers() + sample;
  Ints ahead = to_int((to_float(lane_sample) + 0.5f) * per_sample);
  const Ints local_sample = lane_sample - ahead * tables.samples;
  ahead = ahead > last_unit - unit ? ahead * 0 + (last_unit - unit) : ahead;
  LocalDirection<Floats> d;
  if (tables.patterns > 0) {
    const Ints p = gather(units.directions + unit, ahead) + local_sample;
    d = {gather(local, p), gather(local, p + tables.samples),
         gather(local, p + 2 * tables.samples)};
  } else if (tables.sampling == Sampling::random) {
    d = sample_random_direction<Floats>(units.polar, gather(units.directions + unit, ahead),
                                        (Uints)gather(units.hash + unit, ahead),
                                        (Uints)local_sample);
  } else {
    float x[lane_width], y[lane_width], z[lane_width];
    for (int k = 0; k < lane_width; ++k)
      make_direction(tables, units.directions[unit + ahead[k]],
                     static_cast<std::uint32_t>(units.hash[unit + ahead[k]]), local_sample[k], x[k],
                     y[k], z[k]);
    d = {load<Floats>(x), load<Floats>(y), load<Floats>(z)};
  }
  write(
      d, [&](const float* values) { return pick(values + unit, ahead); },
      [&] { return disc_points(gather(units.hash + unit, ahead), local_sample); });
}

// Where a packet stands: its first ray is sample `sample` of unit `unit`; `filled` lanes hold rays.
struct PacketPlace {
  int unit, sample, filled;
};

// Writes the rays of all units into packets, in order, and hands each one to `consume`.
template <typename Consume>
__attribute__((always_inline)) inline void for_each_packet(const DirectionTables& tables,
                                                           const Units& units, int unit_count,
                                                           Packet& packet, const Consume& consume) {
  const float per_sample = 1.0f / static_cast<float>(tables.samples);
  PacketPlace place{0, 0, lanes};
  for (std::int64_t left = std::int64_t{unit_count} * tables.samples; left > 0; left -= lanes) {
    if (left < lanes) place.filled = static_cast<int>(left);
    int unit = place.unit, sample = place.sample;
    for (int l = 0; l < lanes; l += lane_width) {
      write_rays(tables, units, unit_count - 1, unit, sample, per_sample, packet, l);
      sample += lane_width;
      const int ahead = static_cast<int>((static_cast<float>(sample) + 0.5f) * per_sample);
      unit += ahead;
      sample -= ahead * tables.samples;
      if (unit >= unit_count) unit = unit_count - 1;
    }
    consume(place);
    place = {unit, sample, lanes};
  }
}

}  // namespace
}  // namespace omma::OMMA_ISA
