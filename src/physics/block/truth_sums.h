// Ground truth beside radiance (omma/truth.h): what each ray met first, how far away, and how it
// moves past, summed up over the rays of a replicate as radiance is.
#pragma once

#include "physics/block/block_memory.h"
#include "physics/lanes/vector3.h"
#include "physics/rays/hits.h"
#include "physics/views/truth_view.h"

namespace omma {

// A ray that starts on a surface counts as this far from it, so that inverses stay finite.
inline constexpr float least_distance_m = 1e-9f;

// The angular velocity of what some lanes see: right and up.
template <typename F>
struct Flow {
  F right, up;
};

// Of a point that moves with `velocity` relative to where the ray starts, at 1 / inverse_m; `right`
// and `up` lie across the ray.
template <typename F>
OMMA_HD Flow<F> flow_of(const Vector3<F>& velocity, const Vector3<F>& right, const Vector3<F>& up,
                        F inverse_m) {
  return {dot(velocity, right) * inverse_m, dot(velocity, up) * inverse_m};
}

// How what some lanes met moves of itself, at `place` in the traced frame; zeros where it does not.
template <typename F, typename I>
OMMA_HD Vector3<F> object_velocity(const TruthTask& task, I object, const Vector3<F>& place) {
  const auto moves = object > 0;  // one more than its index
  const I at = keep(moves, object - 1) * 9;
  const auto vector = [&](int first) {
    return Vector3<F>{gather(task.objects + first, at), gather(task.objects + first + 1, at),
                      gather(task.objects + first + 2, at)};
  };
  const Vector3<F> origin = vector(0), linear = vector(3), angular = vector(6);
  return keep(moves, cross(angular, place - origin) + linear);
}

// The rows of one packet, [row][lane]; see TruthRows.
template <typename L>
OMMA_HD_CALLED void eval_truth(const FrameView& frame, const BlockTask& task,
                               const FirstHits<L>& first, float* rows) {
  using F = typename L::F;
  using I = typename L::I;
  const TruthView& view = *frame.truth;
  const TruthTask& truth = *task.truth;
  const TruthRows at = rows_of(view);
  const RayPacket<L::count>& rays = first.packet.rays;
  HitGeometry<L> geometry;
  if (view.places) eval_geometry<L>(*frame.scene, rays, first.hits, geometry);
  for (int l = 0; l < L::count; l += L::width) {
    const auto set = [&](int row, F value) { store(rows + row * L::count + l, value); };
    const I mesh = load<I>(first.hits.mesh + l);
    const auto is_met = mesh != no_mesh;
    const F distance = keep(is_met, load<F>(rays.t_far_m + l));
    const F at_least = distance > least_distance_m ? distance : broadcast<F>(least_distance_m);
    const F inverse = keep(is_met, 1.0f / at_least);
    set(0, keep(is_met, broadcast<F>(1.0f)));
    set(1, distance);
    set(2, inverse);
    const auto d = load_vector<F>(rays.direction, l);
    if (view.places) {
      const auto n = load_vector<F>(geometry.normal, l);
      const F towards = dot(n, d) > 0.0f ? broadcast<F>(-1.0f) : broadcast<F>(1.0f);
      // Splats have no surface, and no normal.
      const auto is_splat = mesh == mesh_of_splats;
      const Vector3<F> along = load_vector<F>(rays.origin, l) + d * distance;
      for (int r = 0; r < 3; ++r) {
        set(at.places + r, is_splat ? along[r] : load<F>(geometry.position[r] + l));
        set(at.places + 3 + r, n[r] * towards);
      }
    }
    if (view.sources) {
      const bool splats = frame.scene->splats != nullptr;
      set(at.sources, splats ? load<F>(first.source_m + l) : distance);
      set(at.sources + 1,
          splats ? load<F>(first.source_weight + l) : keep(is_met, broadcast<F>(1.0f)));
    }
    if (!view.flow) continue;
    const auto origin = load_vector<F>(rays.origin, l),
               up = load_vector<F>(first.packet.reference, l);
    const Vector3<F> right = cross(d, up), place = origin + d * distance;
    const auto turn = Vector3<F>{} + vector_of(truth.angular_rad_s);
    const auto& m = task.world_from_head;
    const Vector3<F> arm = origin - Vector3<float>{m[0][3], m[1][3], m[2][3]};
    const Vector3<F> head = opposite(cross(turn, arm) + vector_of(truth.linear_m_s));
    Vector3<F> velocity = {};
    const Flow<F> passing = flow_of(head, right, up, inverse);
    if (view.object_of_instance != nullptr) {
      const I instance = keep(is_met, load<I>(first.hits.instance + l));
      velocity = object_velocity(truth, keep(is_met, gather(view.object_of_instance, instance) + 1),
                                 place);
    }
    const Flow<F> moving = flow_of(velocity, right, up, inverse);
    // -(w x d) along right and up, as right = d x up.
    set(at.flow, dot(turn, up));
    set(at.flow + 1, 0.0f - dot(turn, right));
    set(at.flow + 2, passing.right);
    set(at.flow + 3, passing.up);
    set(at.flow + 4, moving.right);
    set(at.flow + 5, moving.up);
  }
}

// What is not a mean: the nearest of a replicate's rays, and which group each ray met.
template <typename L>
OMMA_HD void add_met(const TruthView& view, const FirstHits<L>& first, int samples,
                     const PacketStart& start, const TruthSums& sums) {
  int replicate = start.replicate, sample = start.sample;
  for (int l = 0; l < start.filled; ++l) {
    if (first.hits.mesh[l] != no_mesh) {
      const float t = first.packet.rays.t_far_m[l];
      if (t < sums.nearest_m[replicate]) sums.nearest_m[replicate] = t;
      if (view.shares > 0) {
        const std::int32_t group = view.share_of_instance[first.hits.instance[l]];
        if (group >= 0) ++sums.shares[replicate * view.shares + group];
      }
    }
    if (++sample < samples) continue;
    sample = 0;
    ++replicate;
  }
}

// Those of replicate `first` and on.
OMMA_HD TruthSums sums_from(const TruthView& view, const TruthSums& sums, int first) {
  return {sums.stride, sums.rows + first, sums.nearest_m + first,
          sums.shares + first * view.shares};
}

OMMA_HD void clear(const TruthView& view, const TruthSums& sums, int replicates) {
  const int rows = rows_of(view).count;
  for (int o = 0; o < rows; ++o)
    for (int u = 0; u < replicates; ++u) sums.rows[o * sums.stride + u] = 0;
  for (int u = 0; u < replicates; ++u) sums.nearest_m[u] = INFINITY;
  for (int k = 0; k < replicates * view.shares; ++k) sums.shares[k] = 0;
}

// Adds what one replicate's rays met to another's.
OMMA_HD void add_truth(const TruthView& view, const TruthSums& from, int replicate,
                       const TruthSums& to, int to_replicate) {
  const int rows = rows_of(view).count;
  for (int o = 0; o < rows; ++o)
    to.rows[o * to.stride + to_replicate] += from.rows[o * from.stride + replicate];
  if (from.nearest_m[replicate] < to.nearest_m[to_replicate])
    to.nearest_m[to_replicate] = from.nearest_m[replicate];
  for (int k = 0; k < view.shares; ++k)
    to.shares[to_replicate * view.shares + k] += from.shares[replicate * view.shares + k];
}

// Which sums are of an ommatidium: those of its replicates, one for each scramble.
struct TruthOf {
  std::int32_t ordinal;  // of the ommatidium, in the eye's arrays
  int replicate, scrambles;
  int rays;  // in all
};

OMMA_HD void reduce_truth(const FrameView& frame, const BlockTask& task, const TruthSums& sums,
                          const TruthOf& of) {
  const TruthView& view = *frame.truth;
  const TruthTask& truth = *task.truth;
  const TruthRows at = rows_of(view);
  const auto out = static_cast<std::int64_t>(frame.eye->ommatidium[of.ordinal]);
  const int replicate = of.replicate;
  for (int r = 1; r < of.scrambles; ++r) add_truth(view, sums, replicate + r, sums, replicate);
  const auto sum = [&](int row) { return sums.rows[row * sums.stride + replicate]; };
  const double all = of.rays, met = sum(0);
  if (truth.met != nullptr) truth.met[out] = static_cast<float>(met / all);
  if (truth.distance_m != nullptr)
    truth.distance_m[out] = met > 0 ? static_cast<float>(sum(1) / met) : INFINITY;
  if (truth.source_distance_m != nullptr)
    truth.source_distance_m[out] = sum(at.sources + 1) > 0
                                       ? static_cast<float>(sum(at.sources) / sum(at.sources + 1))
                                       : INFINITY;
  if (truth.nearest_m != nullptr) truth.nearest_m[out] = sums.nearest_m[replicate];
  if (truth.inverse_distance_per_m != nullptr)
    truth.inverse_distance_per_m[out] = static_cast<float>(sum(2) / all);
  for (int r = 0; r < 3; ++r) {
    if (truth.position_m != nullptr)
      truth.position_m[out * 3 + r] =
          met > 0 ? sum(at.places + r) / met + truth.origin_m[r] : static_cast<double>(NAN);
    if (truth.normal != nullptr)
      truth.normal[out * 3 + r] = met > 0 ? static_cast<float>(sum(at.places + 3 + r) / met) : NAN;
  }
  for (int k = 0; k < view.shares; ++k)
    truth.shares[out * view.shares + k] =
        static_cast<float>(sums.shares[replicate * view.shares + k] / all);
  const auto mean_flow = [&](float* flow, int row) {
    if (flow == nullptr) return;
    for (int k = 0; k < 2; ++k) flow[out * 2 + k] = static_cast<float>(sum(row + k) / all);
  };
  mean_flow(truth.flow_rotation, at.flow);
  mean_flow(truth.flow_translation, at.flow + 2);
  mean_flow(truth.flow_objects, at.flow + 4);
}

}  // namespace omma
