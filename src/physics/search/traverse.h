// The search of a hierarchy of boxes (physics/search/bvh.h) for what rays meet: plain C++ for host
// and device. One algorithm for a bundle of `count` rays, which may be one.
//
// The rays of a packet belong to one narrow ommatidium, or to neighbours. So those whose directions
// have the same signs go through a tree together: the eight children of a node are tested at once
// against an interval of rays, which misses none of them, then those that may be hit against each
// ray (as coherent packets in Wald et al. 2014, doi:10.1145/2601097.2601199). For one ray interval
// and ray are the same.
//
// Nothing that a ray meets is lost: boxes are widened by more than all rounding
// (physics/search/ray_bundle.h), and on which side a ray passes an edge is told by numbers that are
// exactly opposite for the two triangles that share it (physics/search/triangle_hit.h).
//
// Of hits at the same distance the one on the lower placed mesh, then the lower triangle, counts,
// so that the order of the search does not matter.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/search/ray_bundle.h"
#include "physics/search/triangle_hit.h"
#include "physics/views/ray_packet.h"

namespace omma {

// What is still to be visited: a node's index, or the first quad of a leaf with the number of its
// triangles above it.
template <int count>
struct Visit {
  std::uint32_t at;
  float near_m;
  unsigned lanes;  // of the rays that may meet it
};
// Of one ray: shorter, as a thread of a graphics card has a small stack.
template <>
struct Visit<1> {
  std::uint32_t at;
  float near_m;
  static constexpr unsigned lanes = 1;
  Visit() = default;
  OMMA_HD Visit(std::uint32_t what, float from_m, unsigned) : at(what), near_m(from_m) {}
};
inline constexpr int visit_index_bits = 28;

// Where a search of one lane keeps what is still to be visited of a tree and of the tree of trees:
// memory of its thread. Packets have that on the stack, which is faster, and nothing here.
template <int count>
struct Visits {
  Visit<count>* tree = nullptr;  // [stack_capacity(most_tree_depth)]
  Visit<count>* top = nullptr;   // [stack_capacity(most_top_depth)]
};

// A tree that is searched; `visits` as in Visits.
template <typename L>
struct SearchedTree {
  const WideNode* nodes;
  std::uint32_t root;
  Visit<L::count>* visits;
};

// Goes through a tree with those lanes of a bundle, nearer nodes first. `leaf(index, triangles,
// asked)` is called for each leaf that a ray of the lanes `asked` may meet, and returns those of
// them that search on.
template <typename L, int tree_depth, typename Leaf>
OMMA_HD void search_tree(const SearchedTree<L>& tree, const RayBundle<L>& bundle, unsigned lanes,
                         const float (&t_far_m)[L::count], Leaf leaf) {
  constexpr std::uint32_t index_mask = (1u << visit_index_bits) - 1;
  constexpr bool is_packet = L::count > 1;
  Visit<L::count> own[is_packet ? stack_capacity(tree_depth) : 1];
  Visit<L::count>* const stack = is_packet ? own : tree.visits;
  int depth = 0;
  float far_m = furthest<L>(t_far_m, lanes);
  stack[depth++] = {tree.root, 0, lanes};
  while (depth > 0) {
    const Visit<L::count> visit = stack[--depth];
    if (visit.near_m > far_m) continue;
    const std::uint32_t triangles = visit.at >> visit_index_bits;
    if (triangles != 0) {
      const unsigned asked = visit.lanes & lanes;
      if (asked == 0) continue;
      lanes &= ~asked | leaf(visit.at & index_mask, triangles, asked);
      if (lanes == 0) return;
      far_m = furthest<L>(t_far_m, lanes);
      continue;
    }
    const WideNode& node = tree.nodes[visit.at];
    ChildSlabs<L> slabs;
    unsigned bits = hit_children<L>(node, bundle, far_m, slabs);
    const int first = depth;
    while (bits != 0) {
      const int c = lowest_bit(bits);
      bits &= bits - 1;
      const unsigned meeting = hits_child<L>(bundle, lanes, slabs, c, t_far_m);
      if (meeting == 0) continue;
      const int inner = node.counts & 15;
      const Visit<L::count> child{c < inner ? node.first_child + static_cast<std::uint32_t>(c)
                                            : (node.first_leaf + (node.leaf[c] >> 4)) |
                                                  static_cast<std::uint32_t>(node.leaf[c] & 15)
                                                      << visit_index_bits,
                                  slabs.near[c], meeting};
      int k = depth++;
      for (; k > first && stack[k - 1].near_m < child.near_m; --k) stack[k] = stack[k - 1];
      stack[k] = child;
    }
  }
}

// A leaf that rays may meet.
struct Leaf {
  const TriangleQuad* quads;
  int triangles;
  std::uint32_t placed;  // as in PlacedTree
  bool one_origin;       // of all rays that ask
};

// The k-th triangle of a quad.
struct LeafTriangle {
  const TriangleQuad& quad;
  int k;
};

// What packets know of the triangles of a quad, worked out side by side: normals and, where all
// rays start in one place, what is seen from there. One lane takes one triangle after another.
template <typename L>
inline constexpr bool shares_quads = L::count > 1;

struct SeenQuad {
  alignas(16) float normal[3][quad_width];
  alignas(16) float edge[3][3][quad_width], height[quad_width];
};

template <typename L>
OMMA_HD void see_quad(const RayFrame<L>& frame, const TriangleQuad& quad, bool one_origin,
                      unsigned lanes, SeenQuad& to) {
  for (int k = 0; k < quad_width; k += quad_lanes) {
    Vector3<QuadFloats> corner[3];
    for (int i = 0; i < 3; ++i) corner[i] = load_vector<QuadFloats>(quad.corner[i], k);
    const Vector3<QuadFloats> normal = triangle_normal(corner);
    store_vector(to.normal, k, normal);
    if (!one_origin) continue;
    const int ray = lowest_bit(lanes);
    const Vector3<float> origin{frame.origin[0][ray], frame.origin[1][ray], frame.origin[2][ray]};
    for (Vector3<QuadFloats>& c : corner) c = c - origin;
    const SeenTriangle<QuadFloats> seen = see_from_origin(corner, normal);
    for (int i = 0; i < 3; ++i) store_vector(to.edge[i], k, seen.edge[i]);
    store(to.height + k, seen.height);
  }
}

// Calls `found(first lane, bits, crossing, normal, triangle)` for what lanes meet of a triangle,
// where it may lie at any distance; it returns the lanes that search on.
template <typename L, typename Found>
OMMA_HD unsigned search_leaf(const RayFrame<L>& frame, const Leaf& leaf, unsigned lanes,
                             Found found) {
  using F = typename L::F;
  for (int first = 0; first < leaf.triangles; first += quad_width) {
    const TriangleQuad& quad = leaf.quads[first / quad_width];
    SeenQuad seen_quad;
    if constexpr (shares_quads<L>) see_quad<L>(frame, quad, leaf.one_origin, lanes, seen_quad);
    const int last = leaf.triangles - first < quad_width ? leaf.triangles - first : quad_width;
    for (int k = 0; k < last; ++k) {
      Vector3<float> normal;
      if constexpr (shares_quads<L>) {
        normal = load_vector<float>(seen_quad.normal, k);
      } else {
        Vector3<float> corner[3];
        for (int i = 0; i < 3; ++i) corner[i] = load_vector<float>(quad.corner[i], k);
        normal = triangle_normal(corner);
      }
      for (int l = 0; l < L::count; l += L::width) {
        if constexpr (L::count > L::width)
          if ((lanes >> l & ((1u << L::width) - 1)) == 0) continue;
        const Vector3<F> direction = frame.load_direction(l);
        Crossing<F> crossing;
        unsigned bits;
        if (shares_quads<L> && leaf.one_origin) {
          SeenTriangle<float> seen;
          for (int i = 0; i < 3; ++i) seen.edge[i] = load_vector<float>(seen_quad.edge[i], k);
          seen.height = seen_quad.height[k];
          bits = cross_triangle(seen, normal, direction, crossing);
        } else {
          const Vector3<F> origin = frame.load_origin(l);
          Vector3<F> corner[3];
          for (int i = 0; i < 3; ++i) corner[i] = load_vector<float>(quad.corner[i], k) - origin;
          const SeenTriangle<F> seen = see_from_origin(corner, normal);
          bits = cross_triangle(seen, normal, direction, crossing);
        }
        bits &= lanes >> l;
        if (bits != 0) lanes = found(l, bits, crossing, normal, LeafTriangle{quad, k});
      }
      if (lanes == 0) return 0;
    }
  }
  return lanes;
}

// Rays in the frame of a placed tree: origins, then directions, which keep their length so that
// distances along them stay what they are.
template <typename L, typename Packet>
OMMA_HD void move_rays(const float (&m)[3][4], const Packet& rays, float (&origin)[3][L::count],
                       float (&direction)[3][L::count]) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    store_vector(origin, l, transform_point(m, load_vector<F>(rays.origin, l)));
    store_vector(direction, l, transform_direction(m, load_vector<F>(rays.direction, l)));
  }
}

// Of those lanes, the ones whose rays meet a placed tree.
template <typename L, typename Packet>
OMMA_HD unsigned seeing(const Packet& rays, const PlacedTree& tree, unsigned lanes) {
  if (tree.seen_by == all_seen) return lanes;
  for (int l = 0; l < L::count; ++l)
    if ((rays.mask[l] & tree.seen_by) == 0) lanes &= ~(1u << l);
  return lanes;
}

// Goes through what is placed. `found(tree, lanes, ...)` is called for what the lanes of `bits`
// meet of a triangle, as in search_leaf; it returns those of `lanes` that search on.
template <typename L, typename Packet, typename Found>
OMMA_HD void search(const BvhView& bvh, const Visits<L::count>& visits, unsigned on, Packet& rays,
                    Found found) {
  if (bvh.top_nodes == nullptr) return;
  const RayFrame<L> world{rays.origin, rays.direction};
  while (on != 0) {
    RayBundle<L> bundle;
    make_bundle<L>(world, rays.t_near_m, on, bundle);
    on &= ~bundle.lanes;
    const auto search_placed = [&](std::uint32_t index, std::uint32_t, unsigned lanes) {
      const PlacedTree& tree = bvh.trees[index];
      const bool is_moved = tree.placed != none;
      RayFrame<L> frame = world;
      alignas(L::count >= 16 ? 64 : 4) float origin[3][L::count], direction[3][L::count];
      if (is_moved) {
        move_rays<L>(tree.tree_from_frame, rays, origin, direction);
        frame = {origin, direction};
      }
      for (unsigned left = seeing<L>(rays, tree, lanes); left != 0;) {
        RayBundle<L> moved_bundle;
        if (is_moved) make_bundle<L>(frame, rays.t_near_m, left, moved_bundle);
        const RayBundle<L>& own = is_moved ? moved_bundle : bundle;
        const unsigned asked = left & own.lanes;
        left &= ~asked;
        unsigned searching = asked;
        search_tree<L, most_tree_depth>(
            {bvh.nodes, tree.root, visits.tree}, own, asked, rays.t_far_m,
            [&](std::uint32_t first, std::uint32_t triangles,
                unsigned meeting) __attribute__((always_inline)) {  // as OMMA_HD, of one lane too
              const Leaf leaf{bvh.quads + first, static_cast<int>(triangles), tree.placed,
                              own.one_origin};
              unsigned still = meeting;
              still = search_leaf<L>(frame, leaf, meeting, [&](auto&&... crossing) {
                return still = found(tree, still, crossing...);
              });
              searching &= ~meeting | still;
              return still;
            });
        lanes &= ~asked | searching;
      }
      return lanes;
    };
    search_tree<L, most_top_depth>({bvh.top_nodes, 0, visits.top}, bundle, bundle.lanes,
                                   rays.t_far_m, search_placed);
  }
}

// Of lanes that cross a triangle, those that do where they look.
template <typename L, typename Packet>
OMMA_HD unsigned in_reach(const Packet& rays, int l, unsigned bits,
                          const Crossing<typename L::F>& crossing) {
  using F = typename L::F;
  return bits & lane_bits(crossing.t_m > load<F>(rays.t_near_m + l)) &
         lane_bits(crossing.t_m <= load<F>(rays.t_far_m + l));
}

OMMA_HD std::uint32_t placed_of(const PlacedTree& tree, const LeafTriangle& at) {
  return tree.placed != none ? tree.placed : at.quad.placed[at.k] & ~ask_flag;
}

// Of those, the ones that have not met what counts instead in the same place.
template <typename L, typename Packet>
OMMA_HD unsigned first_in_place(const Packet& rays, int l, unsigned bits,
                                const Crossing<typename L::F>& crossing, std::uint32_t placed,
                                std::uint32_t triangle) {
  using F = typename L::F;
  unsigned ties = bits & lane_bits(crossing.t_m == load<F>(rays.t_far_m + l));
  for (; ties != 0; ties &= ties - 1) {
    const int i = lowest_bit(ties);
    const std::uint32_t other = rays.geometry[l + i];
    if (other < placed || (other == placed && rays.triangle[l + i] <= triangle)) bits &= ~(1u << i);
  }
  return bits;
}

// Of those, the ones for which the surface counts.
template <typename L, typename Accept>
OMMA_HD unsigned accepted(int l, unsigned bits, const Crossing<typename L::F>& crossing,
                          const PlacedTree& tree, const LeafTriangle& at, const Accept& accept) {
  constexpr int width = L::width;
  const TriangleQuad& quad = at.quad;
  const int k = at.k;
  if ((quad.placed[k] & ask_flag) == 0 || bits == 0) return bits;
  float t_m[width], u[width], v[width], facing[width];
  store(t_m, crossing.t_m);
  store(u, weight_fraction(crossing, 1));
  store(v, weight_fraction(crossing, 2));
  store(facing, crossing.facing);
  for (unsigned asked = bits; asked != 0; asked &= asked - 1) {
    const int i = lowest_bit(asked);
    if (!accept(l + i, t_m[i], u[i], v[i], quad.triangle[k], placed_of(tree, at), facing[i] > 0))
      bits &= ~(1u << i);
  }
  return bits;
}

// The closest accepted hit of each ray that is on, behind its t_near and up to its t_far, which
// becomes the hit's distance; weights, triangle, normal and placed mesh are filled in. Where
// nothing is met nothing changes, so `geometry` must be `none` before. `accept(lane, t, u, v,
// triangle, placed, from_behind)` is asked of each candidate on meshes that may say no; u and v are
// the weights of the second and third vertex.
template <typename L, typename Accept>
OMMA_HD void closest(const BvhView& bvh, const Visits<L::count>& visits, LaneMask<L> lanes_on,
                     RayPacket<L::count>& rays, Accept accept) {
  using F = typename L::F;
  using I = typename L::I;
  search<L>(bvh, visits, lanes_on.bits, rays,
            [&](const PlacedTree& tree, unsigned lanes, int l, unsigned bits,
                const Crossing<F>& crossing, const Vector3<float>& normal, const LeafTriangle& at) {
              bits = in_reach<L>(rays, l, bits, crossing);
              if (bits == 0) return lanes;
              const std::uint32_t placed = placed_of(tree, at), triangle = at.quad.triangle[at.k];
              bits = first_in_place<L>(rays, l, bits, crossing, placed, triangle);
              bits = accepted<L>(l, bits, crossing, tree, at, accept);
              if (bits == 0) return lanes;
              const auto hit = LaneMask<L>{bits}.at(0);
              const auto set = [&](float* values, F value) {
                store(values + l, hit ? value : load<F>(values + l));
              };
              const auto set_number = [&](std::uint32_t* values, std::uint32_t value) {
                const I number = I{} + static_cast<std::int32_t>(value);
                store(values + l, hit ? number : load<I>(values + l));
              };
              set(rays.t_far_m, crossing.t_m);
              set(rays.u, weight_fraction(crossing, 1));
              set(rays.v, weight_fraction(crossing, 2));
              for (int a = 0; a < 3; ++a) set(rays.normal[a], broadcast<F>(normal[a]));
              set_number(rays.triangle, triangle);
              set_number(rays.geometry, placed);
              set_number(rays.instance, none);
              return lanes;
            });
}

// Those of the rays that are on which meet anything accepted behind their t_near and up to their
// t_far. `accept` as in closest.
template <typename L, typename Accept>
OMMA_HD LaneMask<L> occluded(const BvhView& bvh, const Visits<L::count>& visits,
                             LaneMask<L> lanes_on, const RayPacket<L::count>& rays, Accept accept) {
  using F = typename L::F;
  LaneMask<L> found;
  search<L>(bvh, visits, lanes_on.bits, rays,
            [&](const PlacedTree& tree, unsigned lanes, int l, unsigned bits,
                const Crossing<F>& crossing, const Vector3<float>&, const LeafTriangle& at) {
              bits = in_reach<L>(rays, l, bits, crossing);
              bits = accepted<L>(l, bits, crossing, tree, at, accept);
              found.bits |= bits << l;
              return lanes & ~(bits << l);
            });
  return found;
}

}  // namespace omma
