// Parts of patterns of rays: where things move while a frame lasts, each of a few steps of its time
// has some of the rays.
#pragma once

#include "physics/sampling/hash.h"
#include "physics/views/frame_view.h"

namespace omma {

// Sample `number` of a part of a replicate's pattern. Samples that follow each other are near each
// other, so that of each 2^part_bits of them one belongs to a part, by the bits of the part's
// number reversed: few that follow each other are of parts that are far apart (van der Corput's
// sequence). A digital shift by the replicate's hash, another one for each 2^part_bits, makes each
// of them of any part alike. What is left of a pattern behind the last 2^part_bits goes to the
// first parts; the hash says where a pattern begins, as its samples differ in how far off the axis
// they are.
template <typename L>
OMMA_HD typename L::I sample_of_part(const DirectionsView& directions, typename L::I number,
                                     typename L::I hash) {
  using I = typename L::I;
  using U = typename L::U;
  const int bits = directions.part_bits, count = directions.pattern_samples;
  if (bits == 0) return number;
  const U begin = mix_bits_32(uint_of(hash) + 0x2545f491u);
  const U shift = mix_bits_32(begin + uint_of(number) * 0x9e3779b9u);
  const I shifted = int_of(shift >> (32 - bits)) ^ directions.part;
  I own = number * 0;
  for (int b = 0; b < bits; ++b) own = own | ((shifted >> b & 1) << (bits - 1 - b));
  own = number < count >> bits ? own : number * 0 + directions.part;
  const I first = to_int(to_float(int_of(begin >> 8)) * (0x1p-24f * static_cast<float>(count)));
  const I sample = number * (1 << bits) + own + first;
  return sample - keep(sample >= count, number * 0 + count);
}

}  // namespace omma
