// Nearest directions by k-d tree. Distances are chords in double precision, so the order is that of
// the angles; ties are settled by index so that the answer does not depend on the tree.
#include "model/nearest_axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

namespace omma {
namespace {

struct AxisCloud {
  std::vector<Vec3d> axes;

  // What nanoflann asks of a data set.
  std::size_t kdtree_get_point_count() const { return axes.size(); }
  double kdtree_get_pt(std::size_t index, std::size_t dimension) const {
    const Vec3d& axis = axes[index];
    return dimension == 0 ? axis.x : dimension == 1 ? axis.y : axis.z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, AxisCloud>,
                                                 AxisCloud, 3, std::uint32_t>;

// A result set for nanoflann that orders by distance, then index. nanoflann's own drops a later
// point at exactly the worst distance, whatever its index.
struct OrderedResults {
  using DistanceType = double;
  using IndexType = std::uint32_t;

  NearestAxes found;
  int capacity = 1;

  std::size_t size() const { return static_cast<std::size_t>(found.count); }
  bool empty() const { return found.count == 0; }
  bool full() const { return found.count == capacity; }
  void sort() {}

  // A little more than the worst distance kept, so that points at exactly that distance are offered
  // too, also where the tree's running lower bound of a branch has rounded upwards.
  double worstDist() const {
    if (!full()) return std::numeric_limits<double>::max();
    return found.chord_squared[static_cast<std::size_t>(capacity - 1)] * (1 + 1e-12) + 1e-14;
  }

  bool addPoint(double chord_squared, std::uint32_t unsigned_index) {
    const auto index = static_cast<std::int32_t>(unsigned_index);
    int place = found.count;
    while (place > 0) {
      const auto before = static_cast<std::size_t>(place - 1);
      if (std::pair(found.chord_squared[before], found.index[before]) <=
          std::pair(chord_squared, index))
        break;
      --place;
    }
    // The first guess is found again in the tree.
    if (place > 0 && found.index[static_cast<std::size_t>(place - 1)] == index) return true;
    if (place == capacity) return true;
    if (!full()) ++found.count;
    for (int i = found.count - 1; i > place; --i) {
      found.chord_squared[static_cast<std::size_t>(i)] =
          found.chord_squared[static_cast<std::size_t>(i - 1)];
      found.index[static_cast<std::size_t>(i)] = found.index[static_cast<std::size_t>(i - 1)];
    }
    found.chord_squared[static_cast<std::size_t>(place)] = chord_squared;
    found.index[static_cast<std::size_t>(place)] = index;
    return true;
  }
};

}  // namespace

struct AxisTree::Impl {
  AxisCloud cloud;
  Tree tree;

  explicit Impl(std::vector<Vec3d> axes)
      : cloud{std::move(axes)}, tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(8)) {
    tree.buildIndex();
  }

  void search(OrderedResults& results, Vec3d direction) const {
    const double query[3] = {direction.x, direction.y, direction.z};
    tree.findNeighbors(results, query, {});
  }
};

AxisTree::AxisTree(std::vector<Vec3d> axes) : impl_(std::make_unique<Impl>(std::move(axes))) {}
AxisTree::AxisTree(AxisTree&&) noexcept = default;
AxisTree& AxisTree::operator=(AxisTree&&) noexcept = default;
AxisTree::~AxisTree() = default;

NearestAxes AxisTree::nearest(Vec3d direction, int count) const {
  OrderedResults results;
  results.capacity = std::clamp(count, 1, NearestAxes::most);
  impl_->search(results, direction);
  return results.found;
}

std::int32_t AxisTree::nearest(Vec3d direction, std::int32_t guess, double& chord_squared) const {
  OrderedResults results;
  const Vec3d apart = direction - impl_->cloud.axes[static_cast<std::size_t>(guess)];
  results.addPoint(dot(apart, apart), static_cast<std::uint32_t>(guess));
  impl_->search(results, direction);
  chord_squared = results.found.chord_squared[0];
  return results.found.index[0];
}

double angle_from_chord_squared(double chord_squared) {
  return 2 * std::asin(std::min(1.0, std::sqrt(chord_squared) / 2));
}

}  // namespace omma
