// Where the rays of a block start and what their directions turn about: the world frame of each
// replicate, which is an ommatidium under one scramble, at one pose.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/sampling/hash.h"
#include "physics/views/frame_view.h"

namespace omma {

// Most ommatidia in one block, times their scrambles.
inline constexpr int block_capacity = 256;
// Most ommatidia at one ray each, so that a thousand keep sixteen cores busy; 256 gain 2 %.
inline constexpr int most_per_block = 64;
// Rays that a block has about; it has no more where an ommatidium has less than a packet's.
inline constexpr int block_rays = 512;

// Replicates that are traced together, where vector loops read a packet's width past the last one:
// in packets those of a block; in one lane one, so that a thread of a graphics card needs little
// memory.
OMMA_HD constexpr int padded_replicates(int lanes) {
  return lanes > 1 ? block_capacity + lanes : 1;
}

// Which ommatidia of a block are rendered, each under which scrambles: replicate u is the
// ommatidium ordinal[u / scrambles] of the eye's arrays under scramble first_scramble + u %
// scrambles.
struct ReplicateList {
  const std::int32_t* ordinal = nullptr;  // null: task.first and on
  int first_scramble = 0, scrambles = 1;
  int count = 0;    // of replicates
  int before = 0;   // replicates of the block before these, whose rays come first
  int sums_at = 0;  // where their sums begin, of those of all replicates that a thread keeps
};

// Where in the eye's arrays the ommatidium of a replicate is.
OMMA_HD std::int32_t ordinal_of(const BlockTask& task, const ReplicateList& list, int replicate) {
  const int listed = replicate / list.scrambles;
  return list.ordinal == nullptr ? task.first + listed : list.ordinal[listed];
}

// What rays carry besides where they start and look.
struct RayNeeds {
  bool choices = false;  // hashes: those that choose ways of paths or times
  bool axes = false;     // up vectors: those of light that is polarised, and of optic flow
};

// World frames of replicates; s and t lie across the axis, the scramble's turn about it applied.
template <typename L>
struct Replicates {
  static constexpr int padded = padded_replicates(L::count);
  alignas(L::count * 4) float origin[3][padded];
  alignas(L::count * 4) float axis[3][padded];
  alignas(L::count * 4) float s[3][padded];
  alignas(L::count * 4) float t[3][padded];
  alignas(L::count * 4) float t_near_m[padded];
  alignas(L::count * 4) float footprint_rad[padded];  // width of each ray (footprint.h)
  alignas(L::count * 4) float aperture_radius_m[padded];
  alignas(L::count * 4) float scale[padded];              // of sines of polar angles
  alignas(L::count * 4) std::int32_t directions[padded];  // where its pattern begins, or which warp
  alignas(L::count * 4) std::int32_t hash[padded];        // of its scramble
  alignas(L::count * 4) std::int32_t warp[padded];
  alignas(L::count * 4) float acceptance_sr[padded];  // counts_by_rays; find_acceptances
  alignas(L::count * 4) float up[3][padded];          // across the axis, before any turn
  bool has_apertures, has_scales;
  RayNeeds needs;
};

// The eye's arrays are padded, so that the last lanes read something; lanes behind the last
// replicate repeat it.
template <typename L>
OMMA_HD_CALLED void make_replicates(const EyeView& eye, const BlockTask& task,
                                    const DirectionsView& directions, const ReplicateList& list,
                                    RayNeeds needs, Replicates<L>& replicates) {
  using F = typename L::F;
  using I = typename L::I;
  using U = typename L::U;
  const float(&m)[3][4] = task.world_from_head;
  const std::uint64_t pose = pose_hash(directions.seed, task.pose);
  const bool in_order = list.ordinal == nullptr && list.scrambles == 1;
  replicates.has_apertures = eye.has_apertures;
  replicates.has_scales = eye.has_scales;
  replicates.needs = needs;
  const float per_scramble = 1.0f / static_cast<float>(list.scrambles);
  for (int u = 0; u < list.count; u += L::width) {
    I replicate = lane_numbers<L>() + u;
    replicate = replicate < list.count ? replicate : replicate * 0 + (list.count - 1);
    const I listed = to_int((to_float(replicate) + 0.5f) * per_scramble);
    const U scramble = uint_of(replicate - listed * list.scrambles + list.first_scramble);
    const I e = list.ordinal == nullptr ? listed + task.first : gather(list.ordinal, listed);
    const auto at = [&](const auto* values) {
      using Vector = decltype(gather(values, e));
      return in_order ? load<Vector>(values + task.first + u) : gather(values, e);
    };

    // The frame at this pose; orthonormal again, as a pose may scale.
    const auto vector_at = [&](const float* const(&values)[3]) {
      return Vector3<F>{at(values[0]), at(values[1]), at(values[2])};
    };
    store_vector(replicates.origin, u, transform_point(m, vector_at(eye.origin)));
    const Vector3<F> axis = transform_direction(m, vector_at(eye.axis));
    const F length_a = sqrt_lanes(dot(axis, axis));
    store(replicates.t_near_m + u, at(eye.focal_offset_m) * length_a);
    const Vector3<F> a = axis * (1.0f / length_a);
    Vector3<F> s = transform_direction(m, vector_at(eye.up));
    s = s - a * dot(s, a);
    s = s * (1.0f / sqrt_lanes(dot(s, s)));
    const Vector3<F> t = cross(a, s);

    // Its pattern, and its turn about the axis from other bits; scrambles of one ommatidium differ
    // in both.
    const U hash = ommatidium_hash(pose, uint_of(at(eye.number)));
    const I warp = at(eye.warp);
    const I fixed_turn = gather(directions.fixed_turn, warp);
    const I own_turn =
        int_of(((hash >> 20) + scramble * 389u) & static_cast<std::uint32_t>(turn_count - 1));
    const I turn = fixed_turn < 0 ? own_turn : fixed_turn;
    const float* turns = &directions.turns->x;
    const F cosine = gather(turns, turn * 2), sine = gather(turns, turn * 2 + 1);
    store_vector(replicates.axis, u, a);
    store_vector(replicates.s, u, s * cosine + t * sine);
    store_vector(replicates.t, u, t * cosine - s * sine);
    if (needs.axes) store_vector(replicates.up, u, s);
    store(replicates.warp + u, warp);
    store(replicates.footprint_rad + u, gather(directions.footprint_rad, warp));
    if (directions.patterns > 0) {
      const U pattern = (hash + scramble) & static_cast<std::uint32_t>(directions.patterns - 1);
      store(replicates.directions + u,
            (warp * directions.patterns + int_of(pattern)) * (3 * directions.pattern_samples));
    } else {
      store(replicates.directions + u, warp);
    }
    store(replicates.hash + u, scramble_hash(hash, scramble));
    store(replicates.aperture_radius_m + u, at(eye.aperture_radius_m) * length_a);
    store(replicates.scale + u, at(eye.scale));
  }
}

// By which rays of an ommatidium count discs of the sky (counts_by_rays): the integral of S; 0 of
// one without an acceptance, and of the kernel compoundray, which is infinite at its axis: their
// rays count all discs. `scale`: EyeView::scale.
OMMA_HD float acceptance_sr(const AcceptanceWarpView& warp, float scale) {
  if (warp.intervals == 0 || warp.sensitivity.kernel == Kernel::compoundray) return 0;
  return static_cast<float>(warp.integral_sr) * scale * scale;
}

template <typename L>
OMMA_HD void find_acceptances(const FrameView& frame, Replicates<L>& replicates, int count) {
  for (int u = 0; u < count; ++u)
    replicates.acceptance_sr[u] =
        frame.acceptance_sr >= 0
            ? frame.acceptance_sr
            : acceptance_sr(frame.directions->warps[replicates.warp[u]], replicates.scale[u]);
}

// One replicate of them.
struct Replicate {
  Vector3<float> origin, axis, s, t, up;
  float t_near_m, footprint_rad, aperture_radius_m, scale, acceptance_sr;
  std::uint32_t hash;
  std::int32_t warp;
};

template <typename L>
OMMA_HD Replicate replicate_at(const Replicates<L>& all, int u) {
  return {load_vector<float>(all.origin, u),
          load_vector<float>(all.axis, u),
          load_vector<float>(all.s, u),
          load_vector<float>(all.t, u),
          all.needs.axes ? load_vector<float>(all.up, u) : Vector3<float>{},
          all.t_near_m[u],
          all.footprint_rad[u],
          all.aperture_radius_m[u],
          all.scale[u],
          all.acceptance_sr[u],
          uint_of(all.hash[u]),
          all.warp[u]};
}

}  // namespace omma
