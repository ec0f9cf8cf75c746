// Rays of a block, written straight into packets: packets run through the samples of one replicate
// (an ommatidium under one scramble) and on into the next, so that none is left half full. All of
// it runs in lanes, whether a packet holds one replicate or many.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/rays/pattern_parts.h"
#include "physics/rays/replicates.h"
#include "physics/sampling/low_discrepancy.h"
#include "physics/sampling/random_direction.h"
#include "physics/views/ray_packet.h"

namespace omma {

// Rays on their way, and how wide they are.
template <typename L>
struct Packet {
  RayPacket<L::count> rays;
  alignas(L::count * 4) float footprint_rad[L::count];  // width of each ray (footprint.h)
  // Of paths: what their choices are hashed from, which sample of its replicate each is, and the
  // reference axis of its polarisation: unit, across the ray.
  alignas(L::count * 4) std::int32_t hash[L::count];
  alignas(L::count * 4) std::int32_t sample[L::count];
  alignas(L::count * 4) float reference[3][L::count];
  alignas(L::count * 4) float acceptance_sr[L::count];  // of rays from the eye (counts_by_rays)
  std::int32_t ommatidium[L::count];    // in its block, where errors of cells are summed up
  std::uint32_t light_sees = all_seen;  // the mask of rays that go on from surfaces, and to lights
};

// What is the same for all rays.
template <typename L>
OMMA_HD void clear(RayPacket<L::count>& rays) {
  for (int l = 0; l < L::count; ++l) {
    rays.time[l] = 0;
    rays.mask[l] = all_seen;
    rays.flags[l] = 0;
    rays.id[l] = static_cast<unsigned>(l);  // candidates are asked about in any order
  }
}

// A component far below the rounding of a unit vector becomes zero: Embree's packets miss boxes
// where one is 1e-14 to 1e-17 (tests/cpp/render_surround.cpp), but not where it is zero.
template <typename F>
OMMA_HD F without_noise(F component) {
  return component < 1e-9f && component > -1e-9f ? component * 0.0f : component;
}
template <typename F>
OMMA_HD Vector3<F> without_noise(const Vector3<F>& v) {
  return {without_noise(v.x), without_noise(v.y), without_noise(v.z)};
}

// Points all over the unit disc for samples of replicates: a lattice of two irrational steps (the
// plastic number's, whose points stay apart at any count), shifted by the replicate's hash. Each
// point alone is uniform, so responses are unbiased.
template <typename F>
struct DiscPoints {
  F x, y;
};

template <typename L>
OMMA_HD DiscPoints<typename L::F> disc_points(typename L::I hash, typename L::I sample) {
  using F = typename L::F;
  using U = typename L::U;
  const U shift = mix_bits_32(uint_of(hash) + 0x68bc21ebu);
  const auto fraction = [&](U bits) { return (to_float(int_of(bits >> 8)) + 0.5f) * 0x1p-24f; };
  const F radius = sqrt_lanes(fraction(shift + uint_of(sample) * 3242174889u));
  const F turn = fraction(mix_bits_32(shift) + uint_of(sample) * 2447445414u);
  const SineCosine<F> a = sine_cosine((2.0f * turn - 1.0f) * 3.14159265f);
  return {radius * a.cosine, radius * a.sine};
}

// The up vector of an ommatidium carried along by the shortest turn from its axis to a ray: the
// lens bends light that comes along the ray into the rhabdom, which lies along the axis. All unit,
// up across the axis.
template <typename F>
OMMA_HD Vector3<F> turn_with(const Vector3<F>& axis, const Vector3<F>& ray, const Vector3<F>& up) {
  const F along = dot(up, ray), cosine = dot(axis, ray);
  // Straight behind the axis there are many shortest turns; the bound takes one of them.
  const F over = 1.0f + cosine;
  const F part = along / (over > 1e-6f ? over : broadcast<F>(1e-6f));
  const Vector3<F> turned = up - (axis + ray) * part;
  const F length = sqrt_lanes(dot(turned, turned));
  return {turned.x / length, turned.y / length, turned.z / length};
}

// Where a packet starts: its first ray is sample `sample` of replicate `replicate`; `filled` lanes
// hold rays.
struct PacketStart {
  int replicate, sample, filled;
};

// Writes L::width rays from lane l on, the first that of `start`.
template <typename L>
OMMA_HD_CALLED void write_rays(const DirectionsView& directions, const Replicates<L>& replicates,
                               int last_replicate, const PacketStart& start, Packet<L>& packet,
                               int l) {
  using F = typename L::F;
  using I = typename L::I;
  const int replicate = start.replicate, sample = start.sample;
  const auto write = [&](LocalDirection<F> d, const auto& of_replicate, const auto& points,
                         const auto& hash, I sample_of_replicate) {
    RayPacket<L::count>& rays = packet.rays;
    if (replicates.has_scales) {
      const F scale = of_replicate(replicates.scale);
      d.x *= scale;
      d.y *= scale;
      const F sine2 = d.x * d.x + d.y * d.y;
      const F cosine = sqrt_lanes(sine2 < 1.0f ? 1.0f - sine2 : 0.0f * sine2);
      d.z = d.z < 0.0f ? -cosine : cosine;
    }
    DiscPoints<F> disc{};
    if (replicates.has_apertures) {
      disc = points();
      const F radius = of_replicate(replicates.aperture_radius_m);
      disc = {disc.x * radius, disc.y * radius};
    }
    const auto vector_of_unit = [&](const float(&values)[3][Replicates<L>::padded]) {
      return Vector3<F>{of_replicate(values[0]), of_replicate(values[1]), of_replicate(values[2])};
    };
    const Vector3<F> s = vector_of_unit(replicates.s), t = vector_of_unit(replicates.t);
    const Vector3<F> axis = vector_of_unit(replicates.axis);
    Vector3<F> origin = vector_of_unit(replicates.origin);
    if (replicates.has_apertures) origin = origin + s * disc.x + t * disc.y;
    const Vector3<F> direction = without_noise(s * d.x + t * d.y + axis * d.z);
    store_vector(rays.origin, l, origin);
    store_vector(rays.direction, l, direction);
    store(rays.t_near_m + l, of_replicate(replicates.t_near_m));
    store(packet.footprint_rad + l, of_replicate(replicates.footprint_rad));
    if (replicates.needs.choices) {
      store(packet.hash + l, hash());
      store(packet.sample + l, sample_of_replicate);
      store(packet.acceptance_sr + l, of_replicate(replicates.acceptance_sr));
    }
    if (!replicates.needs.axes) return;
    store_vector(packet.reference, l, turn_with(axis, direction, vector_of_unit(replicates.up)));
  };

  // All lanes are one replicate's: straight from its pattern.
  const float* local = directions.local;
  const int samples = directions.samples, plane = directions.pattern_samples;
  if (directions.patterns > 0 && directions.part_bits == 0 && sample + L::width <= samples) {
    const float* p = local + replicates.directions[replicate] + sample;
    write(
        {load<F>(p), load<F>(p + plane), load<F>(p + 2 * plane)},
        [&](const float* values) { return broadcast<F>(values[replicate]); },
        [&] {
          return disc_points<L>(lane_numbers<L>() * 0 + replicates.hash[replicate],
                                lane_numbers<L>() + sample);
        },
        [&] { return lane_numbers<L>() * 0 + replicates.hash[replicate]; },
        lane_numbers<L>() + sample);
    return;
  }

  // Replicates that the lanes are ahead of the first one, and their sample within those.
  const I lane_sample = lane_numbers<L>() + sample;
  I ahead = to_int((to_float(lane_sample) + 0.5f) * (1.0f / static_cast<float>(samples)));
  const I number = lane_sample - ahead * samples;
  ahead = ahead > last_replicate - replicate ? ahead * 0 + (last_replicate - replicate) : ahead;
  const I local_sample =
      sample_of_part<L>(directions, number, gather(replicates.hash + replicate, ahead));
  LocalDirection<F> d;
  if (directions.patterns > 0) {
    const I p = gather(replicates.directions + replicate, ahead) + local_sample;
    d = {gather(local, p), gather(local, p + plane), gather(local, p + 2 * plane)};
  } else if (directions.random) {
    d = sample_random_direction<F>(
        directions.polar, gather(replicates.directions + replicate, ahead),
        uint_of(gather(replicates.hash + replicate, ahead)), uint_of(local_sample));
  } else {
    std::int32_t replicate_of[L::width], sample_of[L::width];
    store(replicate_of, ahead + replicate);
    store(sample_of, local_sample);
    float x[L::width], y[L::width], z[L::width];
    for (int k = 0; k < L::width; ++k) {
      const Vec3 made = low_discrepancy_direction(
          directions.warps[replicates.directions[replicate_of[k]]],
          static_cast<std::uint32_t>(replicates.hash[replicate_of[k]]), sample_of[k]);
      x[k] = made.x, y[k] = made.y, z[k] = made.z;
    }
    d = {load<F>(x), load<F>(y), load<F>(z)};
  }
  write(
      d, [&](const float* values) { return pick(values + replicate, ahead); },
      [&] { return disc_points<L>(gather(replicates.hash + replicate, ahead), local_sample); },
      [&] { return gather(replicates.hash + replicate, ahead); }, local_sample);
}

// Writes the rays of all replicates into packets, in order, and hands each one to `consume`.
template <typename L, typename Consume>
OMMA_HD void for_each_packet(const DirectionsView& directions, const Replicates<L>& replicates,
                             int replicate_count, Packet<L>& packet, const Consume& consume) {
  const int samples = directions.samples;
  const float per_sample = 1.0f / static_cast<float>(samples);
  PacketStart start{0, 0, L::count};
  for (std::int64_t left = std::int64_t{replicate_count} * samples; left > 0; left -= L::count) {
    if (left < L::count) start.filled = static_cast<int>(left);
    int replicate = start.replicate, sample = start.sample;
    for (int l = 0; l < L::count; l += L::width) {
      write_rays<L>(directions, replicates, replicate_count - 1, {replicate, sample, 0}, packet, l);
      sample += L::width;
      const int ahead = static_cast<int>((static_cast<float>(sample) + 0.5f) * per_sample);
      replicate += ahead;
      sample -= ahead * samples;
      if (replicate >= replicate_count) replicate = replicate_count - 1;
    }
    consume(start);
    start = {replicate, sample, L::count};
  }
}

}  // namespace omma
