// Where the head is while what is seen goes into a frame: each ray draws how long before the frame
// it looks, by the impulse response of a photoreceptor, and starts from where the head was then.
#pragma once

#include "physics/rays/rays.h"
#include "physics/sampling/path_points.h"

namespace omma {

// Of one frame.
struct HeadMotion {
  // [delays + 1], quantiles of the delay at equal steps of probability, in nodes.
  const float* delay = nullptr;
  int delays = 0;
  // Of them those from `first` on, as fractions of all, for rays of which one in 2^shift is there.
  float first = 0, size = 1;
  int shift = 0;
  // [nodes][3][4], row major: from where a ray is at the frame itself, less `centre`, to where it
  // is so many nodes before; at least two.
  const float* node = nullptr;
  int nodes = 0;
  float centre[3] = {};  // m, traced frame
};

// Numbers in (0, 1) of samples of replicates: steps of the golden ratio, so that any run of
// samples, whose directions are neighbours, has times from all over; shifted by the replicate's
// hash.
template <typename U>
OMMA_HD auto time_fraction(U hash, U sample) {
  return open_unit(mix_bits_32(hash + 0x3c6ef372u) + sample * 2654435769u);
}

// Where the head is when a sample of a replicate looks: what HeadMotion::node says, between two
// nodes.
template <typename F, typename I, typename U>
OMMA_HD void head_turn(const HeadMotion& motion, U hash, U sample, F (&turn)[3][4]) {
  const F drawn = time_fraction(hash, sample >> motion.shift);
  const F step = (motion.first + motion.size * drawn) * to_float(motion.delays);
  I first = to_int(step);
  first = first > motion.delays - 1 ? first * 0 + (motion.delays - 1) : first;
  const F early = gather(motion.delay, first), late = gather(motion.delay + 1, first);
  const F at = early + (late - early) * (step - to_float(first));
  I before = to_int(at);
  before = before > motion.nodes - 2 ? before * 0 + (motion.nodes - 2) : before;
  const F part = at - to_float(before);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) {
      const float* node = motion.node + 4 * r + c;
      const F a = gather(node, before * 12), b = gather(node + 12, before * 12);
      turn[r][c] = a + (b - a) * part;
    }
}

// A point that is as at the frame itself, where it is when the head is turned so.
OMMA_HD Vector3<float> move_point(const HeadMotion& motion, const float (&turn)[3][4],
                                  const Vector3<float>& point) {
  return transform_point(turn, point - vector_of(motion.centre));
}

// Moves the rays of a packet, which are as at the frame itself, to where they are when they look.
template <typename L>
OMMA_HD_CALLED void move_with_head(const HeadMotion& motion, Packet<L>& packet) {
  using F = typename L::F;
  using I = typename L::I;
  using U = typename L::U;
  for (int l = 0; l < L::count; l += L::width) {
    F turn[3][4];
    head_turn<F, I>(motion, load<U>(packet.hash + l), load<U>(packet.sample + l), turn);
    const auto from = load_vector<F>(packet.rays.origin, l) - vector_of(motion.centre);
    store_vector(packet.rays.origin, l, transform_point(turn, from));
    // Between nodes, and where a pose stretches, turned vectors are not quite of unit length.
    const auto direction = transform_direction(turn, load_vector<F>(packet.rays.direction, l));
    const auto reference = transform_direction(turn, load_vector<F>(packet.reference, l));
    const F scale = 1.0f / sqrt_lanes(dot(direction, direction));
    const F of_axis = 1.0f / sqrt_lanes(dot(reference, reference));
    store_vector(packet.rays.direction, l, without_noise(direction * scale));
    store_vector(packet.reference, l, reference * of_axis);
  }
}

}  // namespace omma
