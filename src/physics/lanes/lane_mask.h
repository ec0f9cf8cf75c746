// Which lanes of a packet are on: a bit for each, the first lane lowest. The one type for that
// between functions; inside of a loop over vectors `at` turns it into a comparison's result, for
// `mask ? a : b`, keep and any_lane.
#pragma once

#include "physics/lanes/lanes.h"

namespace omma {

template <typename L>
struct LaneMask {
  static constexpr unsigned all_bits = (1u << L::count) - 1u;
  static constexpr unsigned vector_bits = (1u << L::width) - 1u;
  unsigned bits = 0;

  OMMA_HD static LaneMask all() { return {all_bits}; }
  // Lanes 0 to count - 1.
  OMMA_HD static LaneMask first(int count) {
    return {count >= L::count ? all_bits : (1u << count) - 1u};
  }
  OMMA_HD bool any() const { return bits != 0; }
  OMMA_HD bool has(int lane) const { return (bits >> lane & 1u) != 0; }
  OMMA_HD void add(int lane) { bits |= 1u << lane; }
  // The bits of the lanes that go at once from l on.
  OMMA_HD unsigned word(int l) const { return bits >> l & vector_bits; }
  // The same as a comparison's result.
  OMMA_HD auto at(int l) const {
    if constexpr (L::width == 1) {
      return has(l);
    } else {
      typename L::I bit;
      for (int i = 0; i < L::width; ++i) bit[i] = 1 << i;
      return (bit & static_cast<std::int32_t>(bits >> l)) != 0;
    }
  }
  template <typename Use>
  OMMA_HD void for_each(const Use& use) const {
    for (unsigned left = bits; left != 0; left &= left - 1) use(lowest_bit(left));
  }

  OMMA_HD LaneMask operator~() const { return {~bits & all_bits}; }
  OMMA_HD LaneMask& operator&=(LaneMask other) {
    bits &= other.bits;
    return *this;
  }
  OMMA_HD LaneMask& operator|=(LaneMask other) {
    bits |= other.bits;
    return *this;
  }
  friend OMMA_HD LaneMask operator&(LaneMask a, LaneMask b) { return {a.bits & b.bits}; }
  friend OMMA_HD LaneMask operator|(LaneMask a, LaneMask b) { return {a.bits | b.bits}; }
  friend OMMA_HD bool operator==(LaneMask a, LaneMask b) { return a.bits == b.bits; }
};

// The lanes for which `holds(l)` is so, of those that go at once from l on: a comparison's result.
template <typename L, typename Holds>
OMMA_HD LaneMask<L> lanes_where(const Holds& holds) {
  LaneMask<L> mask;
  for (int l = 0; l < L::count; l += L::width) mask.bits |= lane_bits(holds(l)) << l;
  return mask;
}

}  // namespace omma
