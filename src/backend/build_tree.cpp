// Boxes into a tree: from the top down, every node's range split in two until it has eight
// children.
#include "backend/build_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <span>
#include <string>

#include "omma/error.h"
#include "physics/search/traverse.h"
#include "physics/views/ray_packet.h"
#include "threads/parallel.h"

namespace omma {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr int bin_count = 32;
constexpr std::size_t parallel_binning = 1 << 17;  // boxes, from which on threads share the work
constexpr std::size_t parallel_children = 1 << 12;

struct Box {
  float lower[3] = {infinity, infinity, infinity};
  float upper[3] = {-infinity, -infinity, -infinity};

  void include(const float (&low)[3], const float (&high)[3]) {
    for (int a = 0; a < 3; ++a) {
      lower[a] = std::min(lower[a], low[a]);
      upper[a] = std::max(upper[a], high[a]);
    }
  }
  void include(const Box& other) { include(other.lower, other.upper); }
  // Half its surface, as a double: coordinates may be as large as 1e12.
  double area() const {
    if (!(lower[0] <= upper[0])) return 0;
    double side[3];
    for (int a = 0; a < 3; ++a)
      side[a] = static_cast<double>(upper[a]) - static_cast<double>(lower[a]);
    return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
  }
};

// Twice a box's middle, which is as good as the middle to tell boxes apart.
float middle(const BuildBox& box, int axis) {
  return box.lower[axis] + box.upper[axis];
}

// Boxes begin to end.
struct Range {
  std::size_t begin = 0, end = 0;
  Box box;

  std::size_t size() const { return end - begin; }
};

struct Bins {
  Box box[3][bin_count];
  std::size_t count[3][bin_count] = {};

  void add(const Bins& other) {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < bin_count; ++b) {
        box[a][b].include(other.box[a][b]);
        count[a][b] += other.count[a][b];
      }
  }
};

// Which bin a middle falls into, along an axis.
struct Binning {
  float first[3] = {}, per_width[3] = {};
  int bins = bin_count;

  Binning(const Box& middles, std::size_t boxes)
      : bins(static_cast<int>(std::min<std::size_t>(bin_count, 4 + boxes / 2))) {
    for (int a = 0; a < 3; ++a) {
      first[a] = middles.lower[a];
      const float width = middles.upper[a] - middles.lower[a];
      const float scale = static_cast<float>(bins) * 0.9999f / width;
      per_width[a] = width > 0 && scale < infinity ? scale : 0.0f;
    }
  }
  int of(const BuildBox& box, int axis) const {
    return static_cast<int>((middle(box, axis) - first[axis]) * per_width[axis]);
  }
};

// Parallel reduction over a range; part(sum, begin, end) adds to a sum.
template <typename Sum, typename Part>
Sum sum_over(const Range& range, const Part& part) {
  Sum sum;
  if (range.size() < parallel_binning) {
    part(sum, range.begin, range.end);
    return sum;
  }
  std::mutex mutex;
  parallel_ranges(range.begin, range.end, parallel_binning / 4,
                  [&](std::size_t begin, std::size_t end) {
                    Sum own;
                    part(own, begin, end);
                    const std::lock_guard lock(mutex);
                    sum.add(own);
                  });
  return sum;
}

struct SumOfBoxes {
  Box box;
  void add(const SumOfBoxes& other) { box.include(other.box); }
};

struct Tree {
  std::vector<BuildBox>& boxes;
  std::size_t most_in_leaf, block;

  double blocks_of(std::size_t boxes_in_leaf) const {
    return static_cast<double>((boxes_in_leaf + block - 1) / block);
  }
  // Boxes of a full tree.
  std::uint64_t capacity(int depth) const {
    constexpr int most = 19;  // times 8 in 64 bits, with room for the boxes of a leaf
    return std::uint64_t{most_in_leaf} << 3 * std::min(depth, most);
  }
};

Box box_of(const Tree& tree, std::size_t begin, std::size_t end) {
  Box box;
  for (std::size_t i = begin; i < end; ++i) box.include(tree.boxes[i].lower, tree.boxes[i].upper);
  return box;
}

Box middles_of(const Tree& tree, const Range& range) {
  return sum_over<SumOfBoxes>(range,
                              [&](SumOfBoxes& sum, std::size_t begin, std::size_t end) {
                                for (std::size_t i = begin; i < end; ++i) {
                                  float m[3];
                                  for (int a = 0; a < 3; ++a) m[a] = middle(tree.boxes[i], a);
                                  sum.box.include(m, m);
                                }
                              })
      .box;
}

struct Split {
  int axis = -1;  // none found
  int bin = 0;    // the first on the right
  Box left, right;
};

// The binned split of least cost by the surface area heuristic: area times blocks, summed over both
// sides.
Split find_split(const Tree& tree, const Range& range, const Binning& binning) {
  const Bins bins = sum_over<Bins>(range, [&](Bins& sum, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (int a = 0; a < 3; ++a) {
        const BuildBox& box = tree.boxes[i];
        const int b = binning.of(box, a);
        sum.box[a][b].include(box.lower, box.upper);
        ++sum.count[a][b];
      }
  });
  Split best;
  double least_cost = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    Box right[bin_count + 1];
    for (int b = binning.bins - 1; b > 0; --b) {
      right[b] = right[b + 1 <= binning.bins - 1 ? b + 1 : bin_count];
      right[b].include(bins.box[a][b]);
    }
    Box left;
    std::size_t count = 0;
    for (int b = 1; b < binning.bins; ++b) {
      left.include(bins.box[a][b - 1]);
      count += bins.count[a][b - 1];
      if (count == 0 || count == range.size()) continue;
      const double cost = left.area() * tree.blocks_of(count) +
                          right[b].area() * tree.blocks_of(range.size() - count);
      if (cost < least_cost) {
        least_cost = cost;
        best = {a, b, left, right[b]};
      }
    }
  }
  return best;
}

// Half of the boxes each, along the axis where their middles spread most.
std::pair<Range, Range> halve(const Tree& tree, const Range& range, const Box& middles) {
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (middles.upper[a] - middles.lower[a] > middles.upper[axis] - middles.lower[axis]) axis = a;
  const std::size_t half = range.begin + range.size() / 2;
  const auto at = [&](std::size_t i) {
    return tree.boxes.begin() + static_cast<std::ptrdiff_t>(i);
  };
  std::nth_element(at(range.begin), at(half), at(range.end),
                   [&](const BuildBox& p, const BuildBox& q) {
                     const float x = middle(p, axis), y = middle(q, axis);
                     return x != y ? x < y : p.index < q.index;
                   });
  return {{range.begin, half, box_of(tree, range.begin, half)},
          {half, range.end, box_of(tree, half, range.end)}};
}

std::pair<Range, Range> split(const Tree& tree, const Range& range, bool in_halves) {
  check_cancelled();
  const Box middles = middles_of(tree, range);
  if (in_halves) return halve(tree, range, middles);
  const Binning binning(middles, range.size());
  const Split best = find_split(tree, range, binning);
  if (best.axis < 0) return halve(tree, range, middles);
  const auto begin = tree.boxes.begin() + static_cast<std::ptrdiff_t>(range.begin);
  const auto end = tree.boxes.begin() + static_cast<std::ptrdiff_t>(range.end);
  const auto right = std::partition(
      begin, end, [&](const BuildBox& box) { return binning.of(box, best.axis) < best.bin; });
  const std::size_t at = range.begin + static_cast<std::size_t>(right - begin);
  return {{range.begin, at, best.left}, {at, range.end, best.right}};
}

// A node as it is found: its leaves are ranges of boxes.
struct FoundNode {
  WideNode node;
  std::size_t leaf_begin[node_width];  // where the child is a leaf
  std::vector<FoundNode> children;     // those that are nodes
};

// The smallest power of two of which 255 reach from end to end, as a float's exponent bits.
std::uint8_t step_exponent(double extent) {
  if (!(extent > 0)) return 1;
  int exponent = 0;
  std::frexp(extent / 255, &exponent);  // extent / 255 < 2^exponent
  return static_cast<std::uint8_t>(std::clamp(exponent + 127, 1, 254));
}

void compress_boxes(const Box& own, std::span<const Box> children, WideNode& node) {
  for (int a = 0; a < 3; ++a) {
    const double origin = static_cast<double>(own.lower[a]);
    node.origin[a] = own.lower[a];
    node.exponent[a] = step_exponent(static_cast<double>(own.upper[a]) - origin);
    const double step = std::ldexp(1.0, node.exponent[a] - 127);
    for (std::size_t c = 0; c < children.size(); ++c) {
      // Neither is below 0, so that what is cut off rounds down.
      const auto steps = [&](float x) { return (static_cast<double>(x) - origin) / step; };
      const double last = steps(children[c].upper[a]);
      const auto whole = static_cast<int>(last);
      node.lower[a][c] = static_cast<std::uint8_t>(steps(children[c].lower[a]));
      node.upper[a][c] = static_cast<std::uint8_t>(whole + (last > whole ? 1 : 0));
    }
  }
}

// `depth`: how deep the tree below may be, this node included, of which it has room for the range.
void build_node(const Tree& tree, const Range& range, int depth, FoundNode& found) {
  // Where a child may be given more than a tree less deep has room for, all are given an eighth.
  const bool in_eighths = range.size() > tree.capacity(depth - 1);
  std::vector<Range> children{range};
  while (children.size() < node_width) {
    const auto widest =
        std::max_element(children.begin(), children.end(), [&](const Range& p, const Range& q) {
          const auto rank = [&](const Range& r) {
            if (r.size() <= tree.most_in_leaf) return -1.0;
            return in_eighths ? static_cast<double>(r.size()) : r.box.area();
          };
          return rank(p) < rank(q);
        });
    if (widest->size() <= tree.most_in_leaf) break;
    const auto [left, right] = split(tree, *widest, in_eighths);
    *widest = left;
    children.push_back(right);
  }
  const auto leaves = std::stable_partition(children.begin(), children.end(), [&](const Range& r) {
    return r.size() > tree.most_in_leaf;
  });
  const auto inner = static_cast<std::size_t>(leaves - children.begin());
  found.node = {};
  std::array<Box, node_width> boxes;
  std::transform(children.begin(), children.end(), boxes.begin(),
                 [](const Range& child) { return child.box; });
  compress_boxes(range.box, {boxes.data(), children.size()}, found.node);
  found.node.counts = static_cast<std::uint8_t>(children.size() << 4 | inner);
  for (std::size_t c = inner; c < children.size(); ++c) {
    found.leaf_begin[c] = children[c].begin;
    found.node.leaf[c] = static_cast<std::uint8_t>(children[c].size());
  }
  found.children.resize(inner);
  if (range.size() < parallel_children) {
    for (std::size_t c = 0; c < inner; ++c)
      build_node(tree, children[c], depth - 1, found.children[c]);
  } else {
    parallel_for(std::size_t{0}, inner, [&](std::size_t c) {
      build_node(tree, children[c], depth - 1, found.children[c]);
    });
  }
}

// Writes a node's children next to each other, then each subtree in turn, and leaves in the order
// in which they are searched.
void write_node(const Tree& tree, FoundNode& found, std::size_t at, BuiltTree& out) {
  WideNode node = found.node;
  node.first_child = static_cast<std::uint32_t>(out.nodes.size());
  node.first_leaf = static_cast<std::uint32_t>(out.order.size() / tree.block);
  std::size_t blocks = 0;
  for (std::size_t c = found.children.size(); c < static_cast<std::size_t>(node.counts >> 4); ++c) {
    const std::size_t count = node.leaf[c], filled = (count + tree.block - 1) / tree.block;
    for (std::size_t i = 0; i < filled * tree.block; ++i)
      out.order.push_back(i < count ? tree.boxes[found.leaf_begin[c] + i].index : none);
    node.leaf[c] = static_cast<std::uint8_t>(blocks << 4 | count);
    blocks += filled;
  }
  out.nodes[at] = node;
  out.nodes.resize(out.nodes.size() + found.children.size());
  for (std::size_t c = 0; c < found.children.size(); ++c)
    write_node(tree, found.children[c], node.first_child + c, out);
  found.children = {};
}

// Over all slots of the quads; empty ones hold NaN, which changes neither minimum nor maximum.
Box box_of_leaf(const TriangleQuad* quads, int triangles) {
  float lower[3][quad_width], upper[3][quad_width];
  for (int a = 0; a < 3; ++a)
    for (int k = 0; k < quad_width; ++k) lower[a][k] = infinity, upper[a][k] = -infinity;
  for (int t = 0; t < triangles; t += quad_width)
    for (const auto& vertex : quads[t / quad_width].corner)
      for (int a = 0; a < 3; ++a)
        for (int k = 0; k < quad_width; ++k) {
          const float x = vertex[a][k];
          lower[a][k] = x < lower[a][k] ? x : lower[a][k];
          upper[a][k] = x > upper[a][k] ? x : upper[a][k];
        }
  Box box;
  for (int a = 0; a < 3; ++a) {
    box.lower[a] = *std::min_element(lower[a], lower[a] + quad_width);
    box.upper[a] = *std::max_element(upper[a], upper[a] + quad_width);
  }
  return box;
}

}  // namespace

BuildBox refit_tree(std::span<WideNode> nodes, std::uint32_t first, const TriangleQuad* blocks) {
  std::vector<Box> boxes(nodes.size());
  for (std::size_t n = nodes.size(); n-- > 0;) {
    WideNode& node = nodes[n];
    const int children = node.counts >> 4, inner = node.counts & 15;
    std::array<Box, node_width> child;
    Box& own = boxes[n];
    for (int c = 0; c < children; ++c) {
      Box& box = child[static_cast<std::size_t>(c)];
      box = c < inner
                ? boxes[node.first_child - first + static_cast<std::uint32_t>(c)]
                : box_of_leaf(blocks + node.first_leaf + (node.leaf[c] >> 4), node.leaf[c] & 15);
      own.include(box);
    }
    // An empty child shrinks to a corner of its parent.
    if (!(own.lower[0] <= own.upper[0])) continue;
    for (Box& box : child)
      if (!(box.lower[0] <= box.upper[0])) {
        box = {};
        box.include(own.lower, own.lower);
      }
    compress_boxes(own, {child.data(), static_cast<std::size_t>(children)}, node);
  }
  BuildBox all{};
  for (int a = 0; a < 3; ++a) {
    all.lower[a] = boxes[0].lower[a];
    all.upper[a] = boxes[0].upper[a];
  }
  return all;
}

BuiltTree build_tree(std::vector<BuildBox>& boxes, const TreeShape& shape) {
  BuiltTree out;
  if (boxes.empty()) return out;
  const Tree tree{boxes, static_cast<std::size_t>(shape.most_in_leaf),
                  static_cast<std::size_t>(shape.block)};
  const std::uint64_t most =
      std::min((std::uint64_t{1} << visit_index_bits) - 1, tree.capacity(shape.most_depth));
  if (boxes.size() > most)
    throw Error("portable: a hierarchy over at most " + std::to_string(most) +
                " triangles or instances is possible, found " + std::to_string(boxes.size()));
  Range all{0, boxes.size(), {}};
  all.box = sum_over<SumOfBoxes>(all, [&](SumOfBoxes& sum, std::size_t begin, std::size_t end) {
              sum.box.include(box_of(tree, begin, end));
            }).box;
  FoundNode root;
  build_node(tree, all, shape.most_depth, root);
  out.nodes.resize(1);
  write_node(tree, root, 0, out);
  return out;
}

}  // namespace omma
