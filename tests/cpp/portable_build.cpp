// What the builder promises besides right hits: the same tree whatever the number of threads, no
// tree deeper than the search has room for, building that can be cancelled.
#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "backend/build_tree.h"
#include "omma/error.h"
#include "portable_rays.h"
#include "threads/parallel.h"

namespace omma::test {
namespace {

constexpr TreeShape of_triangles{quad_width, quad_width, most_tree_depth};

std::vector<BuildBox> random_boxes(Random& random, std::uint32_t count) {
  std::vector<BuildBox> boxes(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    boxes[i].index = i;
    for (int a = 0; a < 3; ++a) {
      boxes[i].lower[a] = static_cast<float>(random.uniform(-1, 1));
      boxes[i].upper[a] = boxes[i].lower[a] + static_cast<float>(random.uniform(0, 0.02));
    }
  }
  return boxes;
}

int depth_of(const std::vector<WideNode>& nodes, std::size_t root = 0) {
  int deepest = 0;
  for (std::size_t c = 0; c < (nodes[root].counts & 15u); ++c)
    deepest = std::max(deepest, depth_of(nodes, nodes[root].first_child + c));
  return deepest + 1;
}

// Every box is in one leaf, and in the box of each node above it, decoded as the search does.
void expect_holds_all(const BuiltTree& tree, const std::vector<BuildBox>& boxes) {
  std::vector<int> found(boxes.size(), 0);
  std::size_t outside = 0;
  for (const WideNode& node : tree.nodes)
    for (std::size_t c = node.counts & 15u; c < static_cast<std::size_t>(node.counts >> 4); ++c)
      for (std::size_t k = 0; k < (node.leaf[c] & 15u); ++k) {
        const std::uint32_t index =
            tree.order[(node.first_leaf + (node.leaf[c] >> 4)) * quad_width + k];
        ++found[index];
        for (int a = 0; a < 3; ++a) {
          const double step = std::ldexp(1.0, node.exponent[a] - 127);
          const double origin = static_cast<double>(node.origin[a]);
          outside += origin + node.lower[a][c] * step > static_cast<double>(boxes[index].lower[a]);
          outside += origin + node.upper[a][c] * step < static_cast<double>(boxes[index].upper[a]);
        }
      }
  EXPECT_EQ(outside, 0u);
  EXPECT_EQ(std::count(found.begin(), found.end(), 1), static_cast<std::ptrdiff_t>(found.size()));
}

TEST(PortableBuild, IsTheSameWhateverTheThreads) {
  Random random{1};
  const std::vector<BuildBox> boxes = random_boxes(random, 300000);
  BuiltTree trees[2];
  for (int k = 0; k < 2; ++k) {
    oneapi::tbb::task_arena arena(k == 0 ? 1 : 2);
    run_in_arena(arena, [&] {
      std::vector<BuildBox> own = boxes;
      trees[k] = build_tree(own, of_triangles);
    });
  }
  expect_holds_all(trees[0], boxes);
  ASSERT_EQ(trees[0].nodes.size(), trees[1].nodes.size());
  EXPECT_EQ(std::memcmp(trees[0].nodes.data(), trees[1].nodes.data(),
                        trees[0].nodes.size() * sizeof(WideNode)),
            0);
  EXPECT_EQ(trees[0].order, trees[1].order);
}

// Sizes that grow so fast that every split by surface cuts off one box: without a bound the tree is
// as deep as there are boxes, one level in seven.
std::vector<BuildBox> growing_boxes() {
  std::vector<BuildBox> boxes(6000);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    boxes[i].index = i;
    const float size = std::exp2(0.03f * static_cast<float>(i) - 90);
    for (int a = 0; a < 3; ++a) {
      boxes[i].lower[a] = a == 0 ? size : 0;
      boxes[i].upper[a] = (a == 0 ? 1.01f : 0.01f) * size;
    }
  }
  return boxes;
}

TEST(PortableBuild, IsNeverTooDeep) {
  const std::vector<BuildBox> boxes = growing_boxes();
  // From what room there is for 6,000 boxes, 4 in a leaf, on.
  for (const int most_depth : {4, 5, 7, most_tree_depth, 1000}) {
    SCOPED_TRACE(most_depth);
    std::vector<BuildBox> own = boxes;
    const BuiltTree tree = build_tree(own, {quad_width, quad_width, most_depth});
    expect_holds_all(tree, boxes);
    if (most_depth < 1000)
      EXPECT_LE(depth_of(tree.nodes), most_depth);
    else
      EXPECT_GT(depth_of(tree.nodes), 2 * most_tree_depth);
  }
  std::vector<BuildBox> own = boxes;
  EXPECT_THROW(build_tree(own, {quad_width, quad_width, 3}), Error);
}

// Where boxes are as even as in most scenes the bound changes nothing: all is split by surface.
TEST(PortableBuild, IsSplitBySurfaceWhereItIsNotTooDeep) {
  Random random{3};
  const std::vector<BuildBox> boxes = random_boxes(random, 300000);
  const auto order_of = [&](int most_depth) {
    std::vector<BuildBox> own = boxes;
    return build_tree(own, {quad_width, quad_width, most_depth}).order;
  };
  const std::vector<std::uint32_t> free = order_of(1000);
  EXPECT_EQ(order_of(most_tree_depth), free);
  EXPECT_NE(order_of(6), free);  // as deep as there must be
}

TEST(PortableBuild, CanBeCancelled) {
  Random random{2};
  std::vector<BuildBox> boxes = random_boxes(random, 100000);
  const std::atomic<bool> cancelled{true};
  const TakingPart part(&cancelled);
  EXPECT_THROW(build_tree(boxes, of_triangles), Cancelled);
}

}  // namespace
}  // namespace omma::test
